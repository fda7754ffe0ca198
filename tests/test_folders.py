import subprocess
import sys

import pytest

from glasshelm.errors import InputError
from glasshelm.folders import claimed
from glasshelm.learning.loop import LoopSettings, train
from glasshelm.learning.presets import preset_named
from glasshelm.learning.progress import Display
from glasshelm.terminal import Terminal

HOLD = """
import sys, pathlib, time
from glasshelm.folders import claimed
with claimed(pathlib.Path(sys.argv[1])):
    print("claimed", flush=True)
    time.sleep(600)
"""


def test_a_folder_has_one_owner_at_a_time(tmp_path):
    with claimed(tmp_path / "a"):
        with (
            pytest.raises(InputError, match="another process is at work there"),
            claimed(tmp_path / "a"),
        ):
            pass
        with claimed(tmp_path / "b"):
            pass
    with claimed(tmp_path / "a"):
        pass


def test_the_claim_of_a_process_that_was_killed_is_gone(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "claimed\n"
        config, loop = preset_named("tiny"), LoopSettings(tensorboard=False)
        with pytest.raises(InputError, match="another process"):
            train(config, tmp_path, loop, False, Display(Terminal(quiet=True)))
        assert [path.name for path in tmp_path.iterdir()] == [".lock"]
    finally:
        process.kill()
        process.wait()
    with claimed(tmp_path):
        pass
