"""Every pilot decides in one way, and explanations cost nothing where nobody reads them."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import observation, untrained

import glasshelm
from glasshelm.env.target_selection import select_targets
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.decide import decide_on
from glasshelm.pilots.guarded import GuardedPilot
from glasshelm.pilots.protocols import Decision, Pilot, override
from glasshelm.pilots.registry import WITHOUT_WEIGHTS, pilot_named
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import SHIPS

CLOSE = {"rtol": 1e-5, "atol": 1e-5}


@pytest.mark.parametrize("name", ["straight", "paper-cpa", "large-ship-vo-colregs", "paper-sum"])
def test_a_decision_is_a_rudder_and_what_the_pilot_can_say(name):
    pilot = pilot_named(name)
    assert isinstance(pilot, Pilot)
    decision = glasshelm.explain(pilot, observation(3))
    assert isinstance(decision, Decision)
    assert -1 <= decision.rudder <= 1
    assert (decision.explanation is None) == (name in WITHOUT_WEIGHTS)
    assert decision.overruled is decision.guard is None


def test_from_many_targets_those_are_decided_on_that_a_frame_decides_on():
    pilot, everybody = untrained("attention"), observation(40)
    selected, slots = select_targets(everybody)
    there = slots[np.asarray(selected.present)]
    decision = glasshelm.explain(pilot, everybody)
    expected, _, _ = eqx.filter_jit(decide_on)(pilot, everybody, (), SHIPS["paper"])
    np.testing.assert_allclose(decision.rudder, expected.rudder, **CLOSE)
    for found, some in (
        (decision.explanation.attention, expected.explanation.attention),
        (decision.explanation.value.by_ship, expected.explanation.value.by_ship),
        (decision.explanation.sweep.value.by_ship.T, expected.explanation.sweep.value.by_ship.T),
    ):
        assert found.shape[0] == 40
        np.testing.assert_allclose(found[there], some[np.asarray(selected.present)], **CLOSE)
        assert not np.delete(found, there, axis=0).any()
    assert decision.explanation.rudder_shapley.pairs.shape == (40, 40)


@pytest.mark.parametrize("guarded", [False, True])
def test_only_the_rudder_is_computed_where_only_the_rudder_is_used(guarded):
    pilot = untrained("sum")
    batch = jax.tree.map(lambda x: jnp.stack([x, x]), observation(6))

    def cost(steer) -> float:
        arrays = eqx.filter_jit(steer).lower(pilot, batch).compile()
        return arrays.compiled.cost_analysis()["flops"]

    def decided(pilot, batch):
        policy = BatchedPilot(GuardedPilot(pilot) if guarded else pilot)
        return policy(batch, policy.start(2))[0]

    if guarded:
        text = str(jax.make_jaxpr(lambda b: decided(pilot, b))(batch))
        assert "cond[" in text
        assert cost(decided) < cost(lambda p, b: explained(GuardedPilot(p), b)) / 1.5
    else:
        assert cost(decided) == pytest.approx(cost(lambda p, b: jax.vmap(p.actor)(b)), rel=0.01)
        assert cost(decided) < cost(explained) / 20


def explained(pilot, batch):
    """Decisions with all that can be said of them."""
    memory = BatchedPilot(pilot).start(2)
    return eqx.filter(jax.vmap(pilot.decide)(batch, memory)[0], eqx.is_array)


def test_an_order_is_explained_in_the_pilots_place():
    pilot, seen = untrained("attention"), observation(3)
    own, _ = pilot.decide(seen, ())
    for active in (True, False):
        found = override(pilot, seen, own, jnp.asarray(0.7), jnp.asarray(active))
        assert bool(found.overruled.active) == active
        assert float(found.rudder) == pytest.approx(0.7 if active else float(own.rudder))
        assert found.overruled.pilot_rudder == own.rudder
        why = pilot.explain(seen, found.rudder)
        np.testing.assert_allclose(found.explanation.value.by_ship, why.value.by_ship, **CLOSE)
    other = override(
        StraightPilot(), seen, Decision(jnp.zeros(())), jnp.asarray(1.0), jnp.asarray(True)
    )
    assert other.explanation is None
