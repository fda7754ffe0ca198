"""The guard leaves the helm to a pilot whose way keeps clear, and takes it where it does not."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import colliding, meeting
from tests.untrained import untrained, write_weights

import glasshelm
from glasshelm.core.errors import InputError
from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.env.step import reset, step
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.guarded import GuardedPilot
from glasshelm.pilots.protocols import Pilot, TrainedPilot
from glasshelm.pilots.registry import guardable_pilots, load, pilot_named, pilot_names
from glasshelm.pilots.straight import StraightPilot
from glasshelm.report.narrative import narrate
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.voyage import simulate

pytestmark = pytest.mark.slow

SHIP = SHIPS["paper"]


def reckless():
    """A learned pilot who holds the rudder amidships whoever comes."""
    pilot = untrained("sum")
    return eqx.tree_at(
        lambda p: p.actor,
        pilot,
        jax.tree.map(lambda x: 0 * x if eqx.is_array(x) else x, pilot.actor),
    )


@eqx.filter_jit
def sailed(pilot, encounter, steps):
    """Worst Eq. 13 on the way, the rudders, and who had the helm (of a guarded pilot)."""

    def go(carry, _):
        state, memory = carry
        decision, memory = pilot.decide(state.observation, memory)
        action = decision.rudder
        out = step(encounter, state, action * SHIP.rudder_limit_rad, SHIP)
        guards = getattr(memory, "engaged", jnp.zeros((), bool))
        margin = jnp.where(encounter.present, out.margin, -1.0).max()
        return (out.state, memory), (margin, action, guards)

    begun = reset(encounter, SHIP), pilot.start()
    _, (margin, action, guards) = jax.lax.scan(go, begun, length=steps)
    return margin.max(), action, guards


def test_its_names(tmp_path):
    write_weights(tmp_path / "mine.safetensors")
    mine = pilot_named(f"{tmp_path / 'mine.safetensors'}-guarded")
    assert isinstance(mine, GuardedPilot)
    assert isinstance(mine, Pilot)
    assert mine.name == "mine-guarded"
    assert mine.weights_sha256 == glasshelm.load(tmp_path / "mine.safetensors").weights_sha256
    assert {f"{name}-guarded" for name in guardable_pilots()} <= set(pilot_names())
    with pytest.raises(InputError, match=r"unknown pilot 'nobody': .*paper-sum"):
        pilot_named("nobody-guarded")
    with pytest.raises(InputError, match="'paper-cpa' is no learned one"):
        pilot_named("paper-cpa-guarded")


def test_which_pilots_can_explain_any_rudder():
    pilot = untrained()
    assert isinstance(pilot, TrainedPilot)
    assert isinstance(GuardedPilot(pilot), TrainedPilot)
    assert not isinstance(StraightPilot(), TrainedPilot)


def test_a_way_that_keeps_clear_is_the_pilots_own():
    """Nothing is changed but the last bits: it is another program."""
    pilot = load("paper-sum")
    encounter = meeting(colliding(180, tcpa_s=1200))
    alone, guarded = (sailed(p, encounter, 360) for p in (pilot, GuardedPilot(pilot)))
    assert float(alone[0]) < -0.05
    assert not guarded[2].any()
    np.testing.assert_allclose(guarded[1], alone[1], atol=1e-5)


def test_it_keeps_a_reckless_pilot_clear():
    encounter = meeting(colliding(180, tcpa_s=900), colliding(270, tcpa_s=1000))
    alone, guarded = (sailed(p, encounter, 300) for p in (reckless(), GuardedPilot(reckless())))
    assert float(alone[0]) > 0.9
    assert float(guarded[0]) <= 0
    # Once they are past, the helm is the pilot's again.
    assert guarded[2][0]
    assert not guarded[2][-1]
    np.testing.assert_array_equal(guarded[1][-1], 0.0)


def test_it_looks_once_a_minute():
    encounter = meeting(colliding(180, tcpa_s=900), colliding(270, tcpa_s=1000))
    guards = np.asarray(sailed(GuardedPilot(reckless()), encounter, 300)[2])
    changed = np.flatnonzero(guards[1:] != guards[:-1]) + 1
    assert changed.size
    assert not (changed % 12).any()


def test_one_world_and_many_are_steered_alike():
    pilot = GuardedPilot(reckless())
    encounters = [meeting(colliding(c, tcpa_s=900)) for c in (180, 270)]
    observed = [reset(e, SHIP).observation for e in encounters]
    batch = jax.tree.map(lambda *x: jnp.stack(x), *observed)
    policy = BatchedPilot(pilot)
    together, memory = eqx.filter_jit(policy)(batch, policy.start(2))
    decide = eqx.filter_jit(lambda pilot, *given: pilot.decide(*given))
    for k, one in enumerate(observed):
        alone, own = decide(pilot, one, pilot.start())
        np.testing.assert_allclose(together[k], alone.rudder, atol=1e-5)
        assert bool(memory.engaged[k]) == bool(own.engaged)


@pytest.fixture(scope="module")
def voyage():
    """Imazu 21, where the pilot of the large ship is guarded for many minutes."""
    scenario = scenario_from("imazu:21", SHIPS["large_ship"])
    return list(simulate(scenario, pilot_named("large-ship-sum-guarded"), 300))


def test_frames_say_who_has_the_helm_and_what_the_guard_sees(voyage):
    guarded = [f for f in voyage if f.guard.steers]
    own = [f for f in voyage if not f.guard.steers]
    assert guarded
    assert own
    assert all(f.pilot == "large-ship-sum-guarded" and f.weights_sha256 for f in voyage)
    leading = next(f for f in guarded if f.guard.target is not None)
    assert leading.guard.target in {t.id for t in leading.targets}
    assert leading.guard.within_s >= 0
    assert -0.05 < leading.guard.depth <= 1
    assert all(f.decision.pilot_rudder_rad is not None for f in guarded)
    assert all(f.decision.pilot_rudder_rad is None for f in own)


def test_a_guard_that_steers_explains_itself_as_a_glassbox_pilot_does(voyage):
    for frame in voyage:
        shares = frame.decision.base_rad + sum(t.shapley_rad for t in frame.targets)
        assert shares == pytest.approx(frame.decision.rudder_rad, abs=1e-4)
        by_guard = frame.guard.steers
        assert (frame.manoeuvre is not None) == by_guard
        assert (frame.alternatives is not None) == (frame.needed is not None) == by_guard
        assert (frame.value.helm is not None) == by_guard
        assert (frame.sweep is None) == by_guard
        assert all((t.q_sweep is None) == by_guard for t in frame.targets)
        assert all((t.course_shapley_rad is not None) == by_guard for t in frame.targets)
        for other in frame.alternatives or ():
            assert other.value.total <= frame.value.total + 1e-4
            assert sum(other.by_target.values()) == pytest.approx(other.value.collision, abs=1e-4)


def test_what_is_compared_is_what_steers(voyage):
    """The manoeuvre of a frame is chosen for its own instant, and its course is steered."""
    turned = [f for f in voyage if f.guard.steers and abs(f.own.rate_of_turn_rad_s) < 1e-3]
    assert turned
    for frame in turned:
        error = frame.manoeuvre.course_rad - frame.own.heading_rad
        error = (error + np.pi) % (2 * np.pi) - np.pi
        assert np.sign(frame.decision.rudder_rad) == np.sign(error) or abs(error) < 0.05


def test_one_may_ask_why_not_of_a_guard_that_steers(voyage):
    pilot = pilot_named("large-ship-sum-guarded")
    number = next(k for k, f in enumerate(voyage) if k and f.guard.steers)
    contrast = glasshelm.why_not(voyage, number, pilot, voyage[number].own.heading_rad + 0.5)
    manoeuvre = voyage[number].manoeuvre
    assert contrast.chosen_rad == pytest.approx(manoeuvre.course_rad % (2 * np.pi), abs=1e-3)
    idle = next(k for k, f in enumerate(voyage) if not f.guard.steers)
    with pytest.raises(InputError, match="only while its guard steers"):
        glasshelm.why_not(voyage, idle, pilot, 0.0)


def test_one_observation_is_explained_by_whoever_steers():
    threatened = reset(meeting(colliding(180, tcpa_s=900)), SHIP).observation
    clear = reset(meeting((9000.0, 9000.0, 0.0, 5.0)), SHIP).observation
    pilot = GuardedPilot(reckless())
    engaged, idle = (glasshelm.explain(pilot, seen) for seen in (threatened, clear))
    assert engaged.guard.steers
    assert engaged.explanation.manoeuvre is not None
    assert engaged.explanation.priority.by_ship.sum() > 100.0
    assert not idle.guard.steers
    assert idle.explanation.manoeuvre is None


def test_the_story_says_that_the_guard_steers_and_why(voyage):
    told = " ".join(str(s) for s in narrate(voyage))
    assert "the guard steers: the pilot's own way (rudder " in told
    assert " into the domain in " in told
