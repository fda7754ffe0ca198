import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.env.observe import Observation
from glasshelm.env.rewards import Reward
from glasshelm.networks.actors import ActorSizes, make_actor
from glasshelm.networks.critics import CriticSizes, QValues, SubTaskCritic
from glasshelm.networks.ship_batch import Packed, Padded
from glasshelm.training.losses import (
    ActorLossSettings,
    actor_loss,
    critic_loss,
    perturb,
    td_target,
)
from glasshelm.training.replay_buffer import TransitionBatch


def states_observed(states, ships=1):
    """Observations that carry a state's number in the waypoint's first column."""
    states = jnp.asarray(states, jnp.float32)
    waypoint = jnp.broadcast_to(states[:, None, None], (len(states), 5, 3))
    targets = jnp.zeros((len(states), ships, 5, 10))
    return Observation(waypoint, targets, jnp.ones((len(states), ships), bool))


class Table(eqx.Module):
    """A critic that looks its values up by the state's number; the action does not matter."""

    waypoint: jax.Array
    by_ship: jax.Array

    def __call__(self, observation, action, fleet=None):
        state = observation.waypoint[:, 0, 0].astype(int)
        return QValues(self.waypoint[state], self.by_ship[state][:, None])


class Steer(eqx.Module):
    rudder: jax.Array

    def __call__(self, observation, fleet=None):
        return jnp.broadcast_to(self.rudder, observation.present.shape[:-1])


class Pull(eqx.Module):
    """A critic to which starboard rudder is worth ``slope`` a unit."""

    slope: float

    def __call__(self, observation, action, fleet=None):
        return QValues(self.slope * action, jnp.zeros_like(observation.present, jnp.float32))


def random_batch(key, size=32, ships=6):
    keys = jax.random.split(key, 8)
    present = jnp.arange(ships) < jax.random.randint(keys[0], (size, 1), 0, ships + 1)

    def random_observation(k):
        a, b = jax.random.split(k)
        targets = jax.random.normal(b, (size, ships, 5, 10)) * present[..., None, None]
        return Observation(jax.random.normal(a, (size, 5, 3)), targets, present)

    return TransitionBatch(
        random_observation(keys[1]),
        jax.random.uniform(keys[2], (size,), minval=-1),
        Reward(
            jax.random.normal(keys[3], (size,)),
            jax.random.normal(keys[4], (size, ships)) * present,
        ),
        random_observation(keys[5]),
        jax.random.uniform(keys[7], (size,), minval=-1),
        jax.random.bernoulli(keys[6], 0.3, (size,)),
        jnp.ones(size),
    )


def test_targets_solve_a_three_state_mdp():
    # 0 -> 1 (rewards 1, -2), 1 -> end (3, -1; terminated), 2 -> 2 (1, -3; truncated each time).
    batch = TransitionBatch(
        states_observed([0, 1, 2]),
        jnp.zeros(3),
        Reward(jnp.array([1.0, 3.0, 1.0]), jnp.array([[-2.0], [-1.0], [-3.0]])),
        states_observed([1, 2, 2]),
        jnp.zeros(3),
        jnp.array([False, True, False]),
        jnp.ones(3),
    )
    table = Table(jnp.zeros(3), jnp.zeros(3))
    for _ in range(60):
        y = td_target(table, Steer(jnp.zeros(())), batch, 0.5, Padded(batch.observation.present))
        table = Table(y.waypoint, y.by_ship[:, 0])
    # By hand: Q(1) = r; Q(0) = r + Q(1)/2; Q(2) = r / (1 - 1/2).
    np.testing.assert_allclose(table.waypoint, [2.5, 3.0, 2.0], rtol=1e-6)
    np.testing.assert_allclose(table.by_ship, [-2.5, -1.0, -6.0], rtol=1e-6)


@pytest.mark.slow
def test_targets_of_the_heads_sum_to_the_target_of_the_total():
    key = jax.random.key(0)
    batch = random_batch(key)
    critic = SubTaskCritic(CriticSizes((8,)), key)
    actor = make_actor("sum", ActorSizes((8,), (8,)), key)
    fleet = Packed(batch.observation.present, 200)
    y = td_target(critic, actor, batch, 0.98, fleet)
    after = critic(batch.next_observation, actor(batch.next_observation))
    expected = batch.reward.total + 0.98 * jnp.where(batch.terminated, 0.0, after.total)
    np.testing.assert_allclose(y.total, expected, rtol=1e-4, atol=1e-5)


def test_the_sarsa_target_takes_the_action_that_was_taken():
    key = jax.random.key(0)
    batch = random_batch(key)
    critic = SubTaskCritic(CriticSizes((8,)), key)
    actor = make_actor("sum", ActorSizes((8,), (8,)), key)
    fleet = Packed(batch.observation.present, 200)
    y = td_target(critic, actor, batch, 0.98, fleet, "sarsa")
    after = critic(batch.next_observation, batch.next_action)
    expected = batch.reward.total + 0.98 * jnp.where(batch.terminated, 0.0, after.total)
    np.testing.assert_allclose(y.total, expected, rtol=1e-4, atol=1e-5)
    assert not np.allclose(y.total, td_target(critic, actor, batch, 0.98, fleet).total)


def test_critic_loss_by_hand():
    batch = eqx.tree_at(lambda b: b.weight, random_batch(jax.random.key(1), 2), jnp.ones(2))
    batch = eqx.tree_at(lambda b: b.observation, batch, states_observed([0, 1]))
    table = Table(jnp.array([1.0, 2.0]), jnp.array([0.5, -1.0]))
    target = QValues(jnp.array([2.0, 2.0]), jnp.array([[0.0], [1.0]]))
    fleet = Padded(batch.observation.present)
    # Errors of the heads: (1, -0.5) and (0, 2); of the totals: 0.5 and 2.
    assert float(critic_loss(table, target, batch, "sum", fleet)) == pytest.approx(4.25 / 2)
    assert float(critic_loss(table, target, batch, "heads", fleet)) == pytest.approx(5.25 / 2)
    alone = eqx.tree_at(lambda b: b.weight, batch, jnp.array([1.0, 0.0]))
    assert float(critic_loss(table, target, alone, "sum", fleet)) == pytest.approx(0.25)


@pytest.mark.parametrize("td_error", ["sum", "heads"])
def test_a_step_against_the_gradient_lowers_the_critic_loss(td_error):
    batch = random_batch(jax.random.key(2))
    critic = SubTaskCritic(CriticSizes((8,)), jax.random.key(3))
    target = QValues(batch.reward.waypoint, batch.reward.by_ship)
    fleet = Padded(batch.observation.present)
    loss, gradient = eqx.filter_value_and_grad(critic_loss)(critic, target, batch, td_error, fleet)
    stepped = jax.tree.map(lambda w, g: w - 1e-3 * g, critic, gradient)
    assert critic_loss(stepped, target, batch, td_error, fleet) < loss


@pytest.mark.parametrize("slope", [1.0, -1.0])
def test_the_actor_climbs_the_critic(slope):
    batch = random_batch(jax.random.key(4))
    fleet = Padded(batch.observation.present)
    gradient = jax.grad(actor_loss)(
        Steer(jnp.array(0.1)), Pull(slope), batch, ActorLossSettings(), fleet, jax.random.key(5)
    )
    assert jnp.sign(gradient.rudder) == -slope


def test_actor_loss_adds_the_terms_of_eq_5_but_for_the_decay():
    batch = random_batch(jax.random.key(6))
    fleet = Padded(batch.observation.present)
    actor = make_actor("sum", ActorSizes((8,), (8,)), jax.random.key(7))
    settings = ActorLossSettings(0.3, 0.2, 0.1, 0.02)
    key = jax.random.key(8)
    action, following = actor(batch.observation), actor(batch.next_observation)
    perturbed = actor(perturb(batch.observation, settings, key))
    change = float(jnp.mean((action - perturbed) ** 2 + (action - following) ** 2))
    expected = -2.0 * float(action.mean()) + 0.2 * change**0.5 + 0.1 * float(jnp.abs(action).mean())
    loss = actor_loss(actor, Pull(2.0), batch, settings, fleet, key)
    assert float(loss) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("shared", [False, True])
def test_the_noise_of_the_observation_is_normal_with_its_deviation(shared):
    observation = states_observed(jnp.zeros(4000), ships=2)
    noisy = perturb(
        observation, ActorLossSettings(noise=0.02, noise_shared=shared), jax.random.key(9)
    )
    assert float(noisy.targets.std()) == pytest.approx(0.02, rel=0.02)
    assert float(noisy.waypoint.std()) == pytest.approx(0.02, rel=0.02)
    same_in_all_frames = bool((noisy.targets[..., :1, :] == noisy.targets).all())
    assert same_in_all_frames == shared
