"""Bands of logged frames: of the plots that the pilot decided on, or none."""

import math

import msgspec
import numpy as np
import pytest
from tests.untrained import untrained

from glasshelm.certify.logged_measurements import (
    SAME,
    band_of_frames,
    plots_from_frames,
    with_bands,
)
from glasshelm.certify.measurements import observe_plots
from glasshelm.certify.sensor_error_bounds import parse_error_bounds
from glasshelm.core.errors import InputError
from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.frames import frame_log
from glasshelm.frames.frame_parquet import columns, rows, to_parquet
from glasshelm.pilots.registry import load, pilot_named
from glasshelm.ship.nomoto import KNOT_M_S, ship_named
from glasshelm.simulation.voyage import Voyage, steps_of

ERRORS = parse_error_bounds("10,0.5,0.1")
STEPS = 24


@pytest.fixture(scope="module")
def pilot():
    return load("paper-sum")


@pytest.fixture(scope="module")
def sailed(pilot):
    """Frames, and what the pilot really saw before each."""
    scenario = scenario_from("random:35", ship_named("paper"))
    voyage = Voyage(scenario, pilot, steps_of(scenario, STEPS))
    frames, observation = [], []
    for _ in range(STEPS):
        observation.append(voyage.place.carry.state.observation)
        frames += voyage.advance()
    return frames, observation


@pytest.fixture(scope="module")
def banded(sailed, pilot):
    return list(with_bands(sailed[0][:3], pilot, ERRORS, cells=5))


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 1, 3, 4, STEPS - 1])
def test_the_plots_are_those_that_the_pilot_saw(sailed, number):
    frames, observation = sailed
    found = observe_plots(plots_from_frames(frames[max(number - 7, 0) : number + 1]))
    ships = int(np.sum(found.present))
    assert ships == len(frames[number].targets) > 1
    there = np.asarray(observation[number].targets)[np.asarray(observation[number].present)]
    np.testing.assert_allclose(found.waypoint, observation[number].waypoint, atol=3e-6)
    np.testing.assert_allclose(np.asarray(found.targets)[:ships], there, atol=2e-5)


def test_a_watch_that_begins_within_the_log_remembers_nothing_before(sailed):
    frames = list(sailed[0][:6])
    frames[4] = msgspec.structs.replace(frames[4], reward=None)
    plots = np.asarray(plots_from_frames(frames).waypoint)
    assert np.all(plots[1:] == plots[1])
    assert np.any(plots[0] != plots[1])


def test_who_was_away_is_remembered_since_she_is_back_and_who_is_lost_is_not_seen(sailed):
    frames = list(sailed[0][:6])
    ids = [t.id for t in frames[-1].targets]

    def with_lost(number, id):
        targets = [msgspec.structs.replace(t, lost=t.id == id) for t in frames[number].targets]
        frames[number] = msgspec.structs.replace(frames[number], targets=targets)

    with_lost(3, ids[0])
    plots = np.asarray(plots_from_frames(frames).targets)
    assert np.all(plots[0, 2:] == plots[0, 1])
    assert np.any(plots[1, 2] != plots[1, 1])
    with_lost(5, ids[0])
    assert int(plots_from_frames(frames).present.sum()) == len(ids) - 1


@pytest.mark.slow
def test_the_band_holds_the_rudder_and_travels_in_log_and_table(banded, tmp_path):
    for frame in banded:
        assert frame.band.low_rad <= frame.decision.rudder_rad <= frame.band.high_rad
        assert frame.band.position_m == 10.0
        assert frame.band.course_rad == pytest.approx(math.radians(0.5))
        assert frame.band.speed_m_s == pytest.approx(0.1 * KNOT_M_S)
    assert frame_log.write_log(tmp_path / "log.jsonl", banded) == len(banded)
    assert list(frame_log.read_log(tmp_path / "log.jsonl")) == banded
    assert {"band_low_rad", "band_high_rad", "band_turn"} <= set(columns())
    first = next(rows(banded))
    assert first["band_low_rad"] == banded[0].band.low_rad


def test_a_frame_without_a_band_says_nothing_of_it(sailed):
    assert b"band" not in msgspec.json.encode(sailed[0][0])


def test_without_errors_it_is_the_rudder(sailed, pilot):
    frames = sailed[0][:5]
    band = band_of_frames(frames, pilot, parse_error_bounds("0,0,0"), cells=1)
    limit = frames[-1].ship.rudder_limit_rad
    assert band.low_rad == pytest.approx(frames[-1].decision.rudder_rad, abs=SAME * limit)
    assert band.high_rad == pytest.approx(frames[-1].decision.rudder_rad, abs=SAME * limit)


def test_there_is_no_band_for_a_rudder_that_is_not_hers(sailed, pilot):
    frames = list(sailed[0][:6])
    other = msgspec.structs.replace(frames[-1].decision, rudder_rad=0.08)
    frames[-1] = msgspec.structs.replace(frames[-1], decision=other)
    with pytest.raises(InputError, match="did not decide this rudder"):
        band_of_frames(frames, pilot, ERRORS, cells=1)


def test_only_a_sum_has_bands(sailed):
    with pytest.raises(InputError, match="attention actor; only a sum"):
        with_bands(sailed[0], untrained("attention"), ERRORS)


@pytest.mark.parametrize(
    "text", ["", "10", "10,0.5", "a,b,c", "10,-1,0.1", "10,nan,0.1", "1,2,inf"]
)
def test_errors_that_are_none_are_refused_in_one_line(text):
    with pytest.raises(InputError, match="metres, degrees and knots") as raised:
        parse_error_bounds(text)
    assert "\n" not in str(raised.value)


@pytest.mark.slow
def test_a_manoeuvre_has_its_band_in_log_and_table(tmp_path):
    scenario = scenario_from("random:35", ship_named("paper"))
    chooser = pilot_named("paper-glassbox")
    frames = list(Voyage(scenario, chooser, steps_of(scenario, 5)).advance())
    (frame,) = list(with_bands(frames[-1:], chooser, ERRORS))
    band = frame.band.manoeuvre
    assert band.low.total <= frame.value.total <= band.high.total
    assert frame.band.low_rad <= frame.decision.rudder_rad <= frame.band.high_rad
    assert [t.id for t in band.targets] == [t.id for t in frame.targets]
    for bound, target in zip(band.targets, frame.targets, strict=True):
        assert bound.q_low <= target.q <= bound.q_high
        assert bound.range_m <= target.range_m
    assert band.keeps_clear == all(t.depth <= 0 for t in band.targets)
    gains = {a.name: frame.value.total - a.value.total for a in frame.alternatives}
    assert [a.name for a in band.alternatives] == list(gains)
    for other in band.alternatives:
        assert other.gain_low - 1e-3 <= gains[other.name] <= other.gain_high + 1e-3
    assert min(abs(np.array(band.courses_rad) - frame.manoeuvre.course_rad)) < 1e-5
    assert frame_log.write_log(tmp_path / "log.jsonl", [frame]) == 1
    assert list(frame_log.read_log(tmp_path / "log.jsonl")) == [frame]
    assert to_parquet([frame], tmp_path / "log.parquet") == len(frame.targets)
    other = msgspec.structs.replace(frame.decision, rudder_rad=-frame.decision.rudder_rad + 0.02)
    with pytest.raises(InputError, match="did not decide this rudder"):
        band_of_frames([msgspec.structs.replace(frame, decision=other)], chooser, ERRORS)
