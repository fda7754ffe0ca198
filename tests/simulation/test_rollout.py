"""The compiled voyage measures what happened."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.evaluation.cases import ABEAM, HEAD_ON, SPEED, cases, encounter

from glasshelm.colregs.classification import EncounterType
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.protocols import Decision
from glasshelm.simulation.rollout import rollout, rollout_tracks


class Weaves(eqx.Module):
    """Weaves, and gives no number where the waypoint is nearer than 20 km."""

    @property
    def name(self):
        return "weaves"

    def start(self):
        return jnp.zeros(())

    def decide(self, observation, memory):
        rudder = jnp.sin(memory / 40.0) * 0.4 + 0.5 * observation.targets[:, 0, 0].sum()
        near = observation.waypoint[0, 1] < 1.0
        return Decision(jnp.where(near, jnp.nan, jnp.clip(rudder, -1, 1))), memory + 1


class Sees(eqx.Module):
    @property
    def name(self):
        return "sees"

    def start(self):
        return ()

    def decide(self, observation, memory):
        return Decision(jnp.clip(0.4 + 3.0 * observation.targets[:, 0, 0].sum(), -1, 1)), memory


CASES = [encounter(HEAD_ON), encounter(ABEAM), encounter(HEAD_ON, ABEAM), encounter()]
STEPS = 300


@pytest.fixture(scope="module")
def straight():
    return jax.device_get(rollout(BatchedPilot(_Amidships()), cases(*CASES, steps=STEPS), STEPS))


class _Amidships(eqx.Module):
    @property
    def name(self):
        return "amidships"

    def start(self):
        return ()

    def decide(self, observation, memory):
        return Decision(jnp.zeros(())), memory


@pytest.mark.slow
def test_collision_and_distance_of_a_ship_that_does_nothing(straight):
    assert straight.range_m[:, 1] == pytest.approx([0, 2000, 0, np.inf], abs=30)
    assert straight.hull_gap_m[0] < -50  # end on: as deep as the beam, less what a step skips
    assert straight.hull_gap_m[1] == pytest.approx(2000 - 60, abs=1)
    # 1200 s are 240 steps: the head-on ship is met after 200, within them.
    assert straight.range_m[0, 0] < 340
    assert straight.margin[0, 1] == pytest.approx(1, abs=0.02)
    assert straight.dcpa_m[:3] == pytest.approx([0, 2000, 0], abs=1)


def test_time_inside_the_domain(straight):
    """From 6.4 LOA ahead to 1.6 LOA astern at 20 kn."""
    assert straight.inside_s[0] == pytest.approx(8 * 340 / (2 * SPEED), abs=10)
    assert straight.inside_s[1] == 0


def test_way_and_helm_of_a_ship_that_does_nothing(straight):
    run = STEPS * 5 * SPEED
    assert straight.sailed_m == pytest.approx([run] * 4, rel=1e-4)
    assert straight.left_at_start_m - straight.left_m == pytest.approx([run] * 4, rel=1e-4)
    assert straight.turned_rad.tolist() == [0] * 4
    assert straight.rudder.tolist() == [0] * 4
    assert straight.return_by_task[3, 0] == pytest.approx(0.2 * 240, rel=1e-3)  # Eq. 17
    assert straight.finite.all()


def test_meetings_are_counted_by_ship(straight):
    kinds = straight.meetings.kind
    assert kinds[0].tolist() == [EncounterType.HEAD_ON, EncounterType.NONE]
    assert kinds[3].tolist() == [EncounterType.NONE, EncounterType.NONE]


@pytest.mark.slow
def test_a_case_ends_at_its_own_step():
    """A batch goes on for its longest case; the others' measures stand still."""
    alone = cases(*CASES, steps=100)
    found = jax.device_get(rollout(BatchedPilot(Sees()), alone, 100))
    longer = jax.device_get(rollout(BatchedPilot(Sees()), alone, STEPS))
    jax.tree.map(np.testing.assert_array_equal, found, longer)
    assert found.time_s.tolist() == [500.0] * 4


@pytest.mark.slow
def test_a_rudder_that_is_no_number_is_told():
    batch = cases(*CASES, steps=20)
    near = eqx.tree_at(lambda c: c.encounter.route.y, batch, np.full((4, 1), 15_000.0, np.float32))
    assert jax.device_get(rollout(BatchedPilot(Weaves()), batch, 20)).finite.all()
    assert not jax.device_get(rollout(BatchedPilot(Weaves()), near, 20)).finite.any()


@pytest.mark.slow
def test_a_voyage_ends_at_its_last_waypoint():
    batch = cases(encounter(), steps=STEPS)
    near = eqx.tree_at(lambda c: c.encounter.route.y, batch, np.full((1, 1), 3000.0, np.float32))
    found = jax.device_get(rollout(BatchedPilot(_Amidships()), near, STEPS))
    assert found.arrived.all()
    assert found.left_m.tolist() == [0.0]
    assert found.time_s[0] == pytest.approx(2500 / SPEED, abs=5)


def test_the_track_drawn_is_the_voyage_measured():
    batch = cases(*CASES, steps=STEPS)
    places = jax.device_get(rollout_tracks(BatchedPilot(Sees()), batch, STEPS))
    found = jax.device_get(rollout(BatchedPilot(Sees()), batch, STEPS))
    assert places.own.east_m.shape == (STEPS + 1, 4)
    away = np.hypot(
        places.east_m - places.own.east_m[..., None], places.north_m - places.own.north_m[..., None]
    )
    nearest = np.where(places.present, away, np.inf)[1:].min((0, 2))
    np.testing.assert_allclose(nearest, found.range_m[:, 1], rtol=1e-4)
