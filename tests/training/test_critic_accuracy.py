"""What chance leaves to know: everything without exploration, less with it."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from benchmarks.critics import critic_ceiling

from glasshelm.encounters.random_encounters import WIDE, random_encounters
from glasshelm.encounters.types import straight_track
from glasshelm.env.observe import DISTANCE_M, waypoint_bearing_rad
from glasshelm.env.rewards import course_reward
from glasshelm.networks.critics import QValues
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.critic_accuracy import correlation
from glasshelm.training.exploration import NoiseSettings

SHIP = SHIPS["paper"]
DISCOUNT = 0.9
NEVER = NoiseSettings("bursts", burst_begin=0.0)
OFTEN = NoiseSettings("bursts", burst_begin=0.2, burst_end=0.2)


class Amidships(eqx.Module):
    def __call__(self, observation, fleet=None):
        return jnp.zeros(observation.present.shape[0])


class CourseHeld(eqx.Module):
    """Eq. 17's value where the bearing of the waypoint stays as it is, times ``scale``."""

    scale: float

    def __call__(self, observation, action, fleet=None):
        reward = jax.vmap(lambda w: course_reward(waypoint_bearing_rad(w[0])))(observation.waypoint)
        return QValues(
            self.scale * reward / (1 - DISCOUNT), jnp.zeros_like(observation.targets[:, :, 0, 0])
        )


@pytest.fixture(scope="module")
def encounters():
    """Own ship up to 20° off her course, nobody else: Eq. 17 alone tells the voyages apart."""
    drawn = random_encounters(jax.random.key(3), 32, SHIP, WIDE)
    return eqx.tree_at(lambda e: e.present, drawn, jnp.zeros_like(drawn.present))


def ceiling(encounters, noise, scale=1.0):
    critic = CourseHeld(scale)
    return critic_ceiling(Amidships(), critic, encounters, SHIP, DISCOUNT, noise, 4, 10, 120)


def test_without_exploration_everything_can_be_known(encounters):
    result = ceiling(encounters, NEVER)
    assert float(result.ceiling[0]) == pytest.approx(1.0, abs=1e-3)
    assert float(result.correlation[0]) > 0.99
    assert float(result.slope[0]) == pytest.approx(1.0, abs=0.1)
    assert abs(float(result.bias[0])) < 0.1 * float(result.spread[0])


def test_exploration_lowers_the_ceiling_and_no_critic_passes_it(encounters):
    result = ceiling(encounters, OFTEN)
    assert 0.1 < float(result.ceiling[0]) < 0.97
    assert float(result.correlation[0]) < float(result.ceiling[0]) + 0.1


def test_values_twice_as_large_have_half_the_slope(encounters):
    one, two = ceiling(encounters, NEVER), ceiling(encounters, NEVER, scale=2.0)
    assert float(two.slope[0]) == pytest.approx(float(one.slope[0]) / 2, rel=1e-3)
    assert float(two.correlation[0]) == pytest.approx(float(one.correlation[0]), abs=1e-3)
    assert float(two.bias[0]) > 1.0


class CostSpreadEvenly(eqx.Module):
    """A ship within 2 km costs, but the cost is spread evenly over all ships."""

    def __call__(self, observation, action, fleet=None):
        cost = -1.0 * (observation.targets[:, :, 0, 5] * DISTANCE_M < 2000.0)
        return QValues(jnp.zeros_like(action), jnp.broadcast_to(cost.mean(-1)[:, None], cost.shape))


def test_a_cost_put_on_the_wrong_target_shows_target_by_target(encounters):
    """One ship ahead that own ship hits, one far off: the sum is right, the parts are not."""
    ahead = jnp.linspace(600.0, 6000.0, 32)
    two = jnp.stack([ahead, 20_000.0 + 0 * ahead], -1)
    none = 0.0 * two
    met = eqx.tree_at(
        lambda e: (e.targets, e.present),
        encounters,
        (jax.vmap(straight_track)(none, two, none, none), jnp.ones((32, 2), bool)),
    )
    result = critic_ceiling(Amidships(), CostSpreadEvenly(), met, SHIP, DISCOUNT, NEVER, 4, 10, 120)
    assert float(result.correlation[1]) > 0.3
    assert float(result.correlation[2]) < 0.9 * float(result.correlation[1])
    assert float(result.spread[2]) < float(result.spread[1])


def test_correlation_is_pearsons():
    rng = np.random.default_rng(0)
    a = rng.normal(size=(500, 2))
    b = np.stack([a[:, 0] + rng.normal(size=500), np.full(500, 3.0)], -1)
    expected = np.corrcoef(a[:, 0], b[:, 0])[0, 1]
    assert correlation(a[:, 0], b[:, 0]) == pytest.approx(expected, abs=1e-6)
    assert correlation(a[:, 1], b[:, 1]) == pytest.approx(0.0, abs=1e-5)
