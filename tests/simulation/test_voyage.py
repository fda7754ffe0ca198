import dataclasses
import math
import os
import signal
import subprocess
import sys
import time
from datetime import UTC, datetime

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import untrained, write_weights

from glasshelm.cli import main
from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.random_encounters import random_scenario
from glasshelm.encounters.tracks import TrackColumns, single_track, stack_tracks
from glasshelm.encounters.types import Encounter, Scenario, TargetInfo
from glasshelm.env.step import EnvSettings, reset, step
from glasshelm.frames import frame_log
from glasshelm.frames.summary import Summary
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import SHIPS, ShipState
from glasshelm.simulation.voyage import Voyage, padded_encounter, simulate

SHIP = SHIPS["paper"]
V = SHIP.speed_m_s


def scenario(*rows: TrackColumns, waypoint: float = 20_000.0, **more) -> Scenario:
    """Own ship northward from the origin."""
    return Scenario(
        source="made",
        title="made",
        encounter=Encounter(
            ShipState.steady(0.0, 0.0, 0.0, V),
            Vector(jnp.zeros(1), jnp.full(1, waypoint)),
            stack_tracks(rows),
            jnp.ones(len(rows), bool),
        ),
        targets=tuple(TargetInfo(str(i), f"ship {i}") for i in range(len(rows))),
        ship=SHIP,
        duration_s=100.0,
        **more,
    )


def straight(east: float, north: float, course_deg: float, speed: float = V) -> TrackColumns:
    return TrackColumns.of([0.0], [east], [north], [math.radians(course_deg)], [speed])


def test_frames_are_the_worlds_own_states():
    made = random_scenario(5, SHIP)
    frames = list(simulate(made, untrained(), steps=20))
    state = reset(made.encounter, SHIP)
    go = jax.jit(lambda s, a: step(made.encounter, s, a * SHIP.rudder_limit_rad, SHIP))
    steer = jax.jit(lambda observation: untrained().decide(observation, ())[0].rudder)
    values = eqx.filter_jit(untrained().critic)
    reward = None
    for frame in frames:
        close = {"rtol": 1e-4, "atol": 2e-5}
        action = steer(state.observation)
        np.testing.assert_allclose(frame.own.north_m, state.own.north_m, **close)
        np.testing.assert_allclose(frame.own.heading_rad, state.own.heading_rad, **close)
        np.testing.assert_allclose(
            frame.decision.rudder_rad, action * SHIP.rudder_limit_rad, **close
        )
        np.testing.assert_allclose([t.danger for t in frame.targets], state.danger, **close)
        value = values(state.observation, action)
        np.testing.assert_allclose([t.q for t in frame.targets], value.by_ship, **close)
        assert (frame.reward is None) == (reward is None)
        if reward is not None:
            np.testing.assert_allclose(frame.reward.waypoint, reward.waypoint, **close)
            np.testing.assert_allclose(frame.reward.collision, reward.by_ship.sum(), **close)
        outcome = go(state, action)
        state, reward = outcome.state, outcome.reward
    assert [f.time_s for f in frames] == [5.0 * k for k in range(21)]


def test_parts_of_a_frame_add_up():
    frame = list(simulate(random_scenario(5, SHIP), untrained(), steps=4))[-1]
    assert len(frame.targets) > 1
    for part, field in ((frame.value, "q"), (frame.priority, "priority")):
        ships = sum(getattr(t, field) for t in frame.targets)
        assert part.collision == pytest.approx(ships, abs=1e-5)
        assert part.total == pytest.approx(part.waypoint + part.collision, abs=2e-6)
    assert sum(t.attention for t in frame.targets) == pytest.approx(1.0, abs=1e-5)
    for k in range(21):
        rows = sum(t.q_sweep[k] for t in frame.targets)
        assert frame.sweep.collision[k] == pytest.approx(rows, abs=5e-5)
    assert frame.sweep.rudder_rad[0] == pytest.approx(-SHIP.rudder_limit_rad, abs=1e-6)


def test_what_straight_lacks_is_absent():
    frames = list(simulate(scenario(straight(0.0, 9000.0, 180.0)), StraightPilot(), steps=3))
    for frame in frames:
        assert frame.decision.rudder_rad == 0.0
        assert frame.value is frame.priority is frame.sweep is frame.weights_sha256 is None
        target = frame.targets[0]
        assert target.q is target.attention is target.intention is target.age_s is None
    assert frames[-1].targets[0].tcpa_s == pytest.approx(9000 / (2 * V) - 15, rel=1e-3)
    assert frames[-1].own.north_m == pytest.approx(15 * V, rel=1e-5)


def test_a_voyage_ends_at_the_waypoint_or_when_the_source_does():
    near = scenario(straight(9e3, 9e3, 0.0), waypoint=500.0 + 7.5 * 5 * V)
    frames = list(simulate(near, StraightPilot()))
    assert len(frames) == 9
    assert frames[-1].own.north_m > 7.5 * 5 * V
    assert len(list(simulate(scenario(), StraightPilot()))) == 21
    assert len(list(simulate(scenario(), StraightPilot(), steps=0))) == 1
    with pytest.raises(InputError, match="-1 steps"):
        simulate(scenario(), StraightPilot(), steps=-1)


def test_a_target_comes_goes_and_is_shown_as_lost_for_a_while():
    heard = TrackColumns.of([12.0, 30.0], [5000.0] * 2, [0.0, 180.0], [0.0] * 2, [10.0] * 2, 20.0)
    frames = list(simulate(scenario(heard), StraightPilot(), steps=20, lost_shown_s=30.0))
    there = {f.time_s: f.targets[0] for f in frames if f.targets}
    assert min(there) == 15.0
    assert not there[45.0].lost
    assert there[45.0].age_s == pytest.approx(15.0)
    for time_s in (50.0, 65.0, 75.0):
        target = there[time_s]
        assert target.lost
        assert not target.selected
        assert target.north_m == pytest.approx(there[45.0].north_m)
        assert target.age_s == pytest.approx(time_s - 30.0)
    assert max(there) == 75.0


def test_forty_ships_are_shown_and_twenty_selected():
    rows = [straight(400.0 * k - 8000.0, 6000.0, 180.0) for k in range(40)]
    frame = list(simulate(scenario(*rows), untrained(), steps=2))[-1]
    selected = [t for t in frame.targets if t.selected]
    assert (len(frame.targets), len(selected)) == (40, 20)
    assert all((t.q is not None) == t.selected for t in frame.targets)
    assert any("20 ships selected" in phrase for phrase in frame.outside_training)
    assert frame.value.collision == pytest.approx(sum(t.q for t in selected), abs=1e-4)


def test_eighteen_ships_are_all_fed_however_far():
    rows = [straight(25_000.0, 500.0 * k, 0.0) for k in range(18)]
    frame = next(simulate(scenario(*rows), StraightPilot(), steps=0))
    assert all(t.selected for t in frame.targets)


def test_padding_an_encounter_changes_nothing():
    made = random_scenario(5, SHIP).encounter
    wide = padded_encounter(made)
    slots = made.present.shape[0]
    assert wide.present.shape[0] == 8
    a, b = (jax.jit(reset, static_argnums=1)(e, SHIP).observation for e in (made, wide))
    np.testing.assert_array_equal(a.targets, b.targets[:slots])
    assert not b.present[slots:].any()


def test_advice_keeps_the_recorded_track():
    # Northward for 30 s, then east; reports every 10 s, one missing.
    times = [0.0, 10.0, 30.0, 40.0]
    track = single_track(
        TrackColumns.of(
            times,
            [0, 0, 0, 50],
            [0, 50, 150, 150],
            [0, 0, math.pi / 2, math.pi / 2],
            [5.0] * 4,
            12.0,
        )
    )
    made = scenario(
        straight(3000.0, 3000.0, 200.0),
        own_track=track,
        origin=(59.0, 24.0),
        start=datetime(2014, 8, 15, 19, tzinfo=UTC),
    )
    frames = list(simulate(made, StraightPilot(), steps=12, advise=True))
    assert all(not f.decision.applied and f.own.rudder_rad is None for f in frames)
    place = {f.time_s: (f.own.east_m, f.own.north_m) for f in frames}
    assert place[25.0] == pytest.approx((0.0, 125.0))
    assert place[35.0] == pytest.approx((25.0, 150.0))
    assert place[60.0] == pytest.approx((150.0, 150.0))  # dead-reckoned past the last report
    turns = {f.time_s: f.own.rate_of_turn_rad_s for f in frames}
    assert turns[30.0] == pytest.approx(math.pi / 2 / 5, abs=1e-5)
    assert turns[25.0] == turns[35.0] == 0.0
    assert frames[6].time_utc == "2014-08-15T19:00:30Z"
    latitude, longitude = LocalProjection(59.0, 24.0).to_globe(np.array([25.0]), np.array([150.0]))
    assert frames[7].own.latitude_deg == pytest.approx(latitude[0], abs=1e-7)
    assert frames[7].own.longitude_deg == pytest.approx(longitude[0], abs=1e-7)
    assert frames[0].targets[0].latitude_deg == pytest.approx(59.027, abs=1e-3)
    free = list(simulate(made, StraightPilot(), steps=12))
    assert free[-1].decision.applied
    assert free[-1].own.rudder_rad is not None


def test_advice_needs_a_track():
    with pytest.raises(InputError, match="--advise needs a recorded own ship"):
        simulate(scenario(), untrained(), advise=True)


def test_what_is_no_number_ends_the_voyage():
    lost = scenario(straight(math.nan, 5000.0, 180.0))
    with pytest.raises(InputError, match="ship 0 is seen with no finite"):
        list(simulate(lost, StraightPilot(), steps=1))
    broken = eqx.tree_at(
        lambda p: p.actor.head.biases[0],
        untrained(),
        jnp.full_like(untrained().actor.head.biases[0], jnp.nan),
    )
    with pytest.raises(InputError, match=r"untrained-attention decides nan"):
        list(simulate(random_scenario(5, SHIP), broken, steps=1))


def test_summary_adds_up():
    made = scenario(straight(0.0, 1500.0, 180.0), straight(9000.0, 0.0, 90.0))
    frames = list(simulate(made, StraightPilot(), EnvSettings().episode_steps // 12))
    summary = Summary()
    for frame in frames:
        summary.add(frame)
    assert summary.intruders == {"0": "ship 0"}
    assert summary.nearest_m == pytest.approx(abs(1500 - 2 * V * 100 - 0), abs=600)
    assert summary.collision_return == pytest.approx(sum(f.reward.collision for f in frames[1:]))
    assert "in the domain     1 (ship 0)" in summary.text()


def test_run_writes_frames_and_a_summary(tmp_path, capsys):
    weights, out = tmp_path / "w.safetensors", tmp_path / "frames.jsonl"
    sha = write_weights(weights)
    args = ["run", "random:3", "--pilot", str(weights), "--steps", "6", "--out", str(out)]
    assert main([*args, "--parquet", str(tmp_path / "f.parquet")]) == 0
    frames = list(frame_log.read_log(out))
    assert len(frames) == 7
    assert frames[0].weights_sha256 == sha
    assert frames[0].source == "random:3"
    assert "nearest ship" in capsys.readouterr().out
    assert main(["run", "random:3", "--pilot", "nobody", "--out", str(out)]) == 2
    assert main(["run", "nowhere", "--pilot", "straight", "--out", str(out)]) == 2
    assert main(["run", "random:3", "--pilot", "straight", "--advise", "--out", str(out)]) == 2
    errors = capsys.readouterr().err.strip().splitlines()
    assert sum(line.startswith("glasshelm: ") for line in errors) == 3
    assert len(list(frame_log.read_log(out))) == 7  # nothing was written over


def test_interrupted_run_keeps_its_frames(tmp_path):
    out = tmp_path / "frames.jsonl"
    # She sails circles and never arrives: however late the signal, there is a voyage to interrupt.
    (tmp_path / "circles.py").write_text("def steer(seen):\n    return 1.0\n")
    args = [sys.executable, "-m", "glasshelm", "run", "random:1:6", "--pilot", "circles:steer"]
    # As in a terminal: the background jobs of a shell are deaf to Ctrl-C, and so are theirs.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    run = subprocess.Popen(
        [*args, "--steps", "10000000", "--out", str(out)],
        stderr=subprocess.PIPE,
        env={**os.environ, "JAX_PLATFORMS": "cpu", "PYTHONPATH": str(tmp_path)},
    )
    signal.signal(signal.SIGINT, before)
    try:
        until = time.monotonic() + 300
        while not (out.exists() and out.stat().st_size > 10_000) and run.poll() is None:
            assert time.monotonic() < until, "she does not sail"
            time.sleep(0.05)
        run.send_signal(signal.SIGINT)
        _, errors = run.communicate(timeout=300)
    finally:
        run.kill()  # not a voyage without end beside the other tests
    assert run.returncode == 130
    count = len(list(frame_log.read_log(out)))
    assert count > 5
    assert f"interrupted: {count} frames are in" in errors.decode().replace("\n", " ")


def test_frames_name_scenario_ship_and_waypoint():
    made = dataclasses.replace(scenario(straight(0.0, 9e3, 180.0)), ship=SHIPS["large_ship"])
    frame = next(simulate(made, StraightPilot(), steps=0))
    assert frame.ship.K_1_s == 0.035
    assert frame.ship.T_s == 141.0
    assert frame.ship.rudder_rate_rad_s == pytest.approx(math.radians(65 / 28))
    assert (frame.waypoint.east_m, frame.waypoint.north_m) == (0.0, 20_000.0)
    paper = next(simulate(scenario(), StraightPilot(), steps=0))
    assert paper.ship.rudder_rate_rad_s is None
    assert paper.targets == []


def test_a_voyage_gone_back_to_sails_the_same_again_and_another_pilot_another_way():
    voyage = Voyage(random_scenario(5, SHIP), untrained(), 60)
    voyage.advance(8)
    kept = voyage.place
    first = voyage.advance(8)
    voyage.place = kept
    assert voyage.advance(8) == first
    voyage.place = kept
    voyage.change_pilot(StraightPilot())
    other = voyage.advance(8)
    assert [f.pilot for f in other] == ["straight"] * 8
    assert other[0].own == first[0].own
    assert other[0].targets[0].range_m == first[0].targets[0].range_m
    assert all(f.decision.rudder_rad == 0.0 for f in other)
    assert other[-1].own != first[-1].own


def test_frames_are_the_same_one_by_one_as_many_at_once():
    made = random_scenario(5, SHIP)
    voyage, one_by_one = Voyage(made, untrained(), 20), []
    while frames := voyage.advance():
        one_by_one += frames
    at_once = list(simulate(made, untrained(), steps=20))
    assert len(one_by_one) == len(at_once) == 21
    for a, b in zip(one_by_one, at_once, strict=True):
        assert a.own.north_m == pytest.approx(b.own.north_m, rel=1e-5)
        assert a.decision.rudder_rad == pytest.approx(b.decision.rudder_rad, abs=1e-4)
        assert a.reward == b.reward or a.reward.total == pytest.approx(b.reward.total, abs=1e-4)
