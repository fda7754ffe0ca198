import jax
import jax.numpy as jnp
import pytest

from glasshelm.training.exploration import (
    NoiseSettings,
    explore,
    no_noise,
    ornstein_uhlenbeck,
    sigma_at,
)


@pytest.mark.parametrize(
    ("progress", "sigma"), [(0.0, 0.30), (0.2, 0.30), (0.5, 0.155), (0.8, 0.01), (1.0, 0.01)]
)
def test_sigma_is_constant_then_linear_then_constant(progress, sigma):
    assert float(sigma_at(jnp.array(progress), NoiseSettings())) == pytest.approx(sigma, abs=1e-6)


def test_ornstein_uhlenbeck_has_its_variance():
    theta, sigma, steps = 0.01, 0.3, 100
    value = jnp.zeros(20_000)

    def go(value, key):
        return ornstein_uhlenbeck(value, jnp.array(sigma), theta, key), None

    value, _ = jax.lax.scan(go, value, jax.random.split(jax.random.key(0), steps))
    keep = (1 - theta) ** 2
    variance = sigma**2 * (1 - keep**steps) / (1 - keep)
    assert float(value.var()) == pytest.approx(variance, rel=0.03)
    assert abs(float(value.mean())) < 0.05


def test_exploration_does_not_wind_up_while_the_rudder_is_hard_over():
    """As soon as the actor wants the other side, the ship has the rudder there within a step."""
    settings = NoiseSettings(sigma=0.3)

    def go(noise, key):
        rudder, after = explore(noise, jnp.full(4000, 1.0), jnp.zeros(()), settings, key)
        return after, (rudder, after.value)

    keys = jax.random.split(jax.random.key(2), 200)
    noise, (rudder, value) = jax.lax.scan(go, no_noise(4000), keys)
    assert float(jnp.abs(rudder).max()) <= 1.0
    assert float(value.max()) <= 0.0  # nothing is added to a rudder that is hard over
    assert float(value.min()) >= -2.0
    assert float(rudder.min()) == -1.0  # every rudder is tried
    back, _ = explore(noise, jnp.full(4000, -1.0), jnp.zeros(()), settings, jax.random.key(3))
    assert float((back < -0.2).mean()) > 0.99


@pytest.mark.slow
def test_bursts_hold_a_rudder_and_leave_the_pilot_alone_otherwise():
    settings = NoiseSettings("bursts", burst_begin=0.1, burst_end=0.4)
    rudder = jnp.full(4000, 0.5)

    def go(noise, key):
        action, after = explore(noise, rudder, jnp.zeros(()), settings, key)
        return after, (action, after.active, after.value)

    keys = jax.random.split(jax.random.key(1), 60)
    _, (action, active, value) = jax.lax.scan(go, no_noise(4000), keys)
    assert bool((action[~active] == 0.5).all())
    assert bool((action[active] == value[active]).all())
    # Of two states with these chances a share begin / (begin + end) is active.
    assert float(active[20:].mean()) == pytest.approx(0.1 / 0.5, rel=0.05)
    held = active[1:] & active[:-1]
    assert bool((value[1:][held] == value[:-1][held]).all())
    assert float(action[active].min()) < -0.95
    assert float(action[active].max()) > 0.95
