"""A file is there whole or not at all, whatever fails while it is written."""

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import pytest
from tests.bridge.frames import Other, frame
from tests.broken_disk import BrokenDisk

from glasshelm.core.errors import InputError
from glasshelm.core.output_dir import atomic_write, locked_folder, writable_folder
from glasshelm.core.terminal import Terminal
from glasshelm.evaluation.result_cache import ResultCache
from glasshelm.figures import style
from glasshelm.frames import frame_log, frame_parquet
from glasshelm.networks.checkpoint import load_tree, save_tree
from glasshelm.training.config import preset_named
from glasshelm.training.metrics_log import MetricsLog, read_metrics
from glasshelm.training.trainer import TrainerSettings, train
from glasshelm.training.training_progress import TrainingProgress

HOLD = """
import sys, pathlib, time
from glasshelm.core.output_dir import locked_folder
with locked_folder(pathlib.Path(sys.argv[1])):
    print("claimed", flush=True)
    time.sleep(600)
"""


def text(path: Path, number: int) -> None:
    with atomic_write(path) as partial, open(partial, "w") as file:
        for _ in range(10):
            file.write(f"{number}\n")


def job(path: Path, number: int) -> None:
    ResultCache(path.parent).write(path.stem, {"a": np.full(100, number)})


def weights(path: Path, number: int) -> None:
    save_tree(path, {"a": jnp.full(100, float(number))}, {"number": number})


def log(path: Path, number: int) -> None:
    frame_log.write_log(path, [frame(5 * k + number, Other()) for k in range(5)])


WRITERS = {"a.txt": text, "b.npz": job, "c.safetensors": weights, "d.jsonl": log}


def at(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO, errno.EACCES], ids=os.strerror)
@pytest.mark.parametrize("name", WRITERS)
def test_every_call_fails_in_turn(tmp_path, monkeypatch, name, code):
    write = WRITERS[name]
    write(tmp_path / name, 1)
    before = at(tmp_path)
    disk = BrokenDisk(monkeypatch, tmp_path, code)
    for first in range(1, 200):
        disk.fail(first)
        told = failure(lambda: write(tmp_path / name, 2))
        disk.heal()
        if told is None:
            if not disk.failed:
                break
            before = at(tmp_path)  # it could do without that call
            continue
        assert told.startswith(f"{tmp_path / name}: cannot write ")
        assert os.strerror(code) in told
        assert "\n" not in told
        kept = at(tmp_path)
        hidden = [one for one in kept if one.startswith(".")]
        assert not hidden, f"{hidden} is left behind"
        assert kept == before, f"call {first} ({disk.failed})"
    assert first > 3
    assert set(at(tmp_path)) == {name}


def failure(write: Callable[[], None]) -> str | None:
    """What is told where something cannot be written."""
    try:
        write()
    except InputError as error:
        return str(error)
    return None


def interrupted(path: Path) -> None:
    with atomic_write(path) as partial:
        partial.write_text("half")
        raise KeyboardInterrupt


def test_an_interrupted_one_leaves_what_was_there(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("before")
    with pytest.raises(KeyboardInterrupt):
        interrupted(path)
    assert at(tmp_path) == {"a.txt": b"before"}


def test_what_a_library_writes_is_whole_too(tmp_path, monkeypatch):
    """Figures and tables: the last step fails, as on a full disk."""
    figure, _ = plt.subplots()
    style.save(figure, tmp_path / "figure")
    frame_parquet.to_parquet([frame(0.0)], tmp_path / "table.parquet")
    before = at(tmp_path)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match=r"figure\.pdf: cannot write it \(No space left"):
        style.save(figure, tmp_path / "figure")
    with pytest.raises(InputError, match=r"table\.parquet: cannot write it \(No space left"):
        frame_parquet.to_parquet([frame(0.0), frame(5.0)], tmp_path / "table.parquet")
    plt.close(figure)
    assert at(tmp_path) == before


def test_the_log_of_a_training_that_cannot_be_written_is_one_line(tmp_path, monkeypatch):
    log = MetricsLog(tmp_path, None, tensorboard=False)
    log.add({"number": 1})
    really = Path.open

    def full(path: Path, *args: object, **more: object) -> object:
        if path.suffix == ".jsonl":
            raise OSError(errno.ENOSPC, "No space left on device")
        return really(path, *args, **more)  # type: ignore[arg-type]

    with monkeypatch.context() as broken:
        broken.setattr(Path, "open", full)
        with pytest.raises(InputError, match=r"log\.jsonl: cannot write it \(No space left"):
            log.add({"number": 2})
    assert read_metrics(tmp_path) == [{"number": 1}]
    disk = BrokenDisk(monkeypatch, tmp_path)
    disk.fail(1, 1_000)
    with pytest.raises(InputError, match="No space left"):
        MetricsLog(tmp_path, 1, tensorboard=False)
    disk.heal()
    assert read_metrics(tmp_path) == [{"number": 1}], "what was kept is kept"


def test_the_weights_are_those_written(tmp_path):
    weights(tmp_path / "a.safetensors", 3)
    read = load_tree(tmp_path / "a.safetensors", {"a": jnp.zeros(100)})
    assert (read["a"] == 3).all()


def test_a_folder_is_tried(tmp_path):
    assert writable_folder(tmp_path / "new" / "one").is_dir()
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="a folder is needed"):
        writable_folder(tmp_path / "file" / "x")


def test_a_folder_has_one_owner_at_a_time(tmp_path):
    with locked_folder(tmp_path / "a"):
        with (
            pytest.raises(InputError, match="another process is at work there"),
            locked_folder(tmp_path / "a"),
        ):
            pass
        with locked_folder(tmp_path / "b"):
            pass
    with locked_folder(tmp_path / "a"):
        pass


def test_the_claim_of_a_process_that_was_killed_is_gone(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "claimed\n"
        config, settings = preset_named("tiny"), TrainerSettings(tensorboard=False)
        with pytest.raises(InputError, match="another process"):
            train(config, tmp_path, settings, False, TrainingProgress(Terminal(quiet=True)))
        assert [path.name for path in tmp_path.iterdir()] == [".lock"]
    finally:
        process.kill()
        process.wait()
    with locked_folder(tmp_path):
        pass
