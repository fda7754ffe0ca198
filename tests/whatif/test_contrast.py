"""Why not another course: the difference is the whole reason."""

import math

import msgspec
import pytest

import glasshelm
from glasshelm.cli import main
from glasshelm.core.errors import InputError
from glasshelm.frames.frame_log import write_log
from glasshelm.pilots.registry import pilot_named

PILOT = pilot_named("paper-glassbox")


@pytest.fixture(scope="module")
def frames():
    return list(glasshelm.simulate(glasshelm.scenario("imazu:5"), PILOT, 60))


def test_the_parts_are_the_difference_of_two_totals(frames):
    frame = frames[20]
    for other in frame.alternatives:
        if other.name in ("keep", "to the waypoint"):
            continue  # not a course held for one of the durations
        contrast = glasshelm.why_not(frames, 20, PILOT, other.course_rad)
        assert contrast.chosen_rad == pytest.approx(frame.manoeuvre.course_rad % math.tau, abs=1e-4)
        # The best along that course may hold it for another time, or turn only once.
        assert contrast.total <= frame.value.total - other.value.total + 40.0
        assert contrast.total > -1.0


def test_against_its_own_course_nothing_speaks(frames):
    row = next(k for k, f in enumerate(frames) if f.manoeuvre.then_course_rad is None
               and f.manoeuvre.duration_s > 0)  # fmt: skip
    same = glasshelm.why_not(frames, row, PILOT, frames[row].manoeuvre.course_rad)
    assert same.total == pytest.approx(0.0, abs=1e-2)
    assert same.other_s == same.chosen_s


def test_towards_a_ship_it_is_the_ship_that_speaks(frames):
    target = frames[0].targets[0]
    towards = frames[0].own.heading_rad + target.bearing_rad
    contrast = glasshelm.why_not(frames, 0, PILOT, towards)
    assert contrast.total > 0
    assert set(contrast.by_ship) == {t.name for t in frames[0].targets}
    assert contrast.summary.endswith(".")


def test_ships_of_one_name_keep_their_own_parts(frames):
    twins = [
        msgspec.structs.replace(
            f, targets=[msgspec.structs.replace(t, name="Twin") for t in f.targets]
        )
        for f in frames[:6]
    ]
    parts = glasshelm.why_not(twins, 5, PILOT, 0.5).by_ship
    assert set(parts) == {f"Twin ({t.id})" for t in frames[0].targets}
    alone = glasshelm.why_not(frames, 5, PILOT, 0.5)
    assert sum(parts.values()) == pytest.approx(sum(alone.by_ship.values()), abs=1e-3)


def test_who_compares_no_courses_says_so(frames):
    with pytest.raises(InputError, match="compares no courses"):
        glasshelm.why_not(frames, 0, glasshelm.load("paper-sum"), 0.5)


def test_the_command_prints_every_part(tmp_path, frames, capsys):
    log = tmp_path / "log.jsonl"
    write_log(log, frames)
    assert main(["why", str(log), "--at", "100", "--course", "90"]) == 0
    said = capsys.readouterr().out
    for name in (*(t.name for t in frames[20].targets), "way to the waypoint", "total", "points"):
        assert name in said
    assert main(["why", str(log), "--at", "100", "--course", "400"]) == 2
    assert "from 0 to 360" in capsys.readouterr().err
