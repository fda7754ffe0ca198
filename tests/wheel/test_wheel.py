"""What someone has who installed the wheel: no source tree, no test tools but pytest."""

import json
import subprocess
import sys
from importlib.metadata import files, version
from importlib.resources import files as resources
from pathlib import Path

import pytest

import glasshelm

pytestmark = pytest.mark.slow

PLACE = Path(glasshelm.__file__).parent


def test_version_is_the_installed_one():
    assert version("glasshelm") == glasshelm.__version__
    done = subprocess.run(
        [sys.executable, "-m", "glasshelm", "--version"], capture_output=True, text=True, timeout=60
    )
    assert done.stdout.strip() == f"glasshelm {version('glasshelm')}"


@pytest.mark.skipif(PLACE.parent.name != "site-packages", reason="not installed from a wheel")
def test_wheel_carries_the_package_and_nothing_else():
    names = [str(file) for file in files("glasshelm") or []]
    tops = {name.split("/")[0] for name in names}
    allowed = {"glasshelm", f"glasshelm-{version('glasshelm')}.dist-info", "..", "__pycache__"}
    assert tops <= allowed
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert any(name.endswith("licenses/NOTICE") for name in names)


def test_data_are_inside():
    assert json.loads((resources("glasshelm") / "data" / "imazu.json").read_text())
    assert (resources("glasshelm") / "py.typed").is_file()


def test_every_bundled_pilot_steers():
    from glasshelm.encounters.scenario_factory import scenario_from
    from glasshelm.env.step import reset
    from glasshelm.pilots.registry import bundled_pilots
    from glasshelm.ship.nomoto import SHIPS

    scenario = scenario_from("imazu:5", SHIPS["paper"])
    observation = reset(scenario.encounter, scenario.ship).observation
    for name in bundled_pilots():
        pilot = glasshelm.load(name)
        assert -1 <= float(glasshelm.explain(pilot, observation).rudder) <= 1


@pytest.mark.parametrize("source", ["random:1", "imazu:8b", "gulf-of-finland"])
def test_voyage_from_the_command_line(source, tmp_path):
    out = tmp_path / "frames.jsonl"
    command = ["run", source, "--pilot", "straight", "--steps", "5", "--out", str(out)]
    done = subprocess.run(
        [sys.executable, "-m", "glasshelm", *command],
        capture_output=True,
        text=True,
        timeout=300,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    frames = [json.loads(line) for line in out.read_text().splitlines()]
    frames = [frame for frame in frames if "time_s" in frame]
    assert [frame["time_s"] for frame in frames][:3] == [0.0, 5.0, 10.0]
    assert all(frame["pilot"] == "straight" for frame in frames)
