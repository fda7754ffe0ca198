"""How accurate are the critics, and how accurate could any predictor of the returns be?

    python benchmarks/critics.py [--pilots NAME ...] [--encounters 512]

Prints a Markdown table: for each head the critic's correlation with single
returns (exploration included, where the critic learned that), the ceiling that
chance leaves to any predictor, slope, bias and spread, and the value of a far
target, which costs nothing (mean over the rudders).

The ceiling: where exploration goes on after the action
(:mod:`glasshelm.training.exploration`), part of a return is chance. Two returns
G₁ and G₂ that follow independently from the same state and action share all that can
be known there, and nothing else: with ρ their correlation, no predictor correlates
better with one of them than √ρ.
"""

import argparse
import sys
from functools import partial
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from glasshelm.encounters.random_encounters import PAPER, VALIDATION_SEED, random_encounters
from glasshelm.encounters.types import Encounter
from glasshelm.env.rewards import Reward
from glasshelm.env.step import EnvState
from glasshelm.explanation.danger_zero import far_value
from glasshelm.networks.actors import Policy
from glasshelm.networks.checkpoint import read_header
from glasshelm.networks.ship_batch import Padded
from glasshelm.pilots.learned import LearnedPilot, read_pilot
from glasshelm.pilots.registry import SUFFIX, WEIGHTS, guardable_pilots
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.config import config_from_dict
from glasshelm.training.exploration import Noise, NoiseSettings, explore, no_noise
from glasshelm.training.losses import CriticFn
from glasshelm.training.vector_env import reset_batch, step_batch

SEED = 7_100_000  # never a training's or a validation set's
RUDDERS = jnp.linspace(-1.0, 1.0, 21)
NO_EXPLORATION = NoiseSettings("bursts", burst_begin=0.0)
#: The correlation with what is constant is 0.
LEAST = 1e-9
#: What the figures of :class:`CriticCeiling` are of, in their order.
HEADS = ("waypoint", "collision", "collision, target by target")


class CriticCeiling(eqx.Module):
    """Values compared with returns that followed from the states that were branched.

    Each field holds three figures (:data:`HEADS`): of the waypoint's head, of the
    collision heads' sum, and of the collision head target by target, each against
    that target's own return. ``ceiling`` is √ρ of two independent returns,
    ``correlation`` that of the critic with single returns, ``slope`` the change of the
    return for one of the value (1 is right), ``bias`` the mean of value − return,
    ``spread`` the standard deviation of the returns.
    """

    ceiling: Float[np.ndarray, "3"]
    correlation: Float[np.ndarray, "3"]
    slope: Float[np.ndarray, "3"]
    bias: Float[np.ndarray, "3"]
    spread: Float[np.ndarray, "3"]


def critic_ceiling(
    actor: Policy,
    critic: CriticFn,
    encounters: Encounter,
    ship: ShipParams,
    discount: float,
    exploration: NoiseSettings,
    instants: int = 12,
    every: int = 20,
    long: int = 480,
) -> CriticCeiling:
    """Branch every voyage twice at several instants, and compare the two returns and the value.

    Args:
        actor: What steers.
        critic: The critics Q.
        encounters: A batch of encounters.
        ship: Own ship.
        discount: γ.
        exploration: What is added to the actor's rudder.
        instants: How often every voyage is branched.
        every: Steps between two branches.
        long: Returns end after so many steps from the start of the voyage.
    """
    branches = jax.device_get(
        _branches(actor, critic, encounters, ship, discount, exploration, instants, every, long)
    )
    present = np.broadcast_to(encounters.present, branches[0].by_ship.shape)
    heads = (
        [x.waypoint for x in branches],
        [x.by_ship.sum(-1) for x in branches],
        [x.by_ship[present] for x in branches],
    )
    return CriticCeiling(*np.array([_compare(*(np.ravel(x) for x in head)) for head in heads]).T)


def _compare(
    value: Float[np.ndarray, " s"],
    first: Float[np.ndarray, " s"],
    second: Float[np.ndarray, " s"],
) -> tuple[float, ...]:
    """The figures of one head, in the order of :class:`CriticCeiling`; NaN without targets."""
    if not value.size:
        return (np.nan,) * 5
    covariance = np.cov([value, first, second], bias=True)
    spread = np.sqrt((covariance[1, 1] + covariance[2, 2]) / 2)
    shared = (covariance[0, 1] + covariance[0, 2]) / 2
    return (
        np.sqrt(max(covariance[1, 2], 0.0)) / max(spread, LEAST),
        shared / max(np.sqrt(covariance[0, 0]) * spread, LEAST),
        shared / max(covariance[0, 0], LEAST),
        value.mean() - (first.mean() + second.mean()) / 2,
        spread,
    )


@partial(jax.jit, static_argnames=("exploration", "instants", "every", "long"))
def _branches(
    actor: Policy,
    critic: CriticFn,
    encounters: Encounter,
    ship: ShipParams,
    discount: float | Float[Array, ""],
    exploration: NoiseSettings,
    instants: int,
    every: int,
    long: int,
) -> tuple[Reward, Reward, Reward]:
    """Values and two independent returns at every instant [instant, episode]."""

    def act(state: EnvState, noise: Noise, key: PRNGKeyArray):
        return explore(noise, actor(state.observation), jnp.zeros(()), exploration, key)

    def follow(
        state: EnvState,
        action: Float[Array, " w"],
        noise: Noise,
        steps: Int[Array, ""],
        key: PRNGKeyArray,
    ) -> Reward:
        """The discounted return of one future of so many steps that starts with this action."""

        def go(carry, number: Int[Array, ""]):
            state, action, noise, total, weight = carry
            result = step_batch(encounters, state, action, ship)
            counts = jnp.where(number < steps, weight, 0.0)
            total = jax.tree.map(lambda t, r: t + counts * r, total, result.reward)
            action, noise = act(result.state, noise, jax.random.fold_in(key, number))
            return (result.state, action, noise, total, weight * discount), None

        present = encounters.present
        nothing = Reward(jnp.zeros(present.shape[0]), jnp.zeros(present.shape))
        start = (state, action, noise, nothing, jnp.ones(()))
        return jax.lax.scan(go, start, jnp.arange(long))[0][3]

    def instant(carry: tuple[EnvState, Noise], number: Int[Array, ""]):
        state, noise = carry
        key = jax.random.fold_in(jax.random.key(VALIDATION_SEED), number)
        now, first, second, later = jax.random.split(key, 4)
        action, noise = act(state, noise, now)
        value = critic(state.observation, action, Padded(state.observation.present))
        steps = long - number * every
        one, two = (follow(state, action, noise, steps, k) for k in (first, second))

        def onward(carry: tuple[EnvState, Noise], key: PRNGKeyArray):
            action, noise = act(*carry, key)
            return (step_batch(encounters, carry[0], action, ship).state, noise), None

        moved = step_batch(encounters, state, action, ship).state
        carry, _ = jax.lax.scan(onward, (moved, noise), jax.random.split(later, every - 1))
        return carry, (Reward(value.waypoint, value.by_ship), one, two)

    start = (reset_batch(encounters, ship), no_noise(encounters.present.shape[0]))
    return jax.lax.scan(instant, start, jnp.arange(instants))[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pilots", nargs="*", default=None)
    parser.add_argument("--encounters", type=int, default=512)
    arguments = parser.parse_args()
    print("| pilot | head | r | ceiling of r | slope | bias | spread of returns | far target |")
    print("|---|---|---|---|---|---|---|---|")
    for name in arguments.pilots or guardable_pilots():
        path = Path(name) if name.endswith(SUFFIX) else WEIGHTS / f"{name}{SUFFIX}"
        pilot = read_pilot(path, name)
        learning = config_from_dict(read_header(path)["config"]).ddpg
        if not isinstance(pilot, LearnedPilot) or pilot.critic is None:
            sys.exit(f"{name} has no critic: train one with --set ddpg.env_steps=2000000")
        ship = pilot.trained.ship
        batch = random_encounters(jax.random.key(SEED), arguments.encounters, ship, PAPER)
        noise = learning.noise if learning.target == "sarsa" else NO_EXPLORATION
        result = critic_ceiling(pilot.actor, pilot.critic, batch, ship, learning.discount, noise)
        zero = float(jax.vmap(lambda a, c=pilot.critic: far_value(c, a))(RUDDERS).mean())
        for index, head in enumerate(HEADS):
            print(
                f"| {name} | {head} | {result.correlation[index]:.2f} | "
                f"{result.ceiling[index]:.2f} | {result.slope[index]:.2f} | "
                f"{result.bias[index]:+.2f} | {result.spread[index]:.2f} | "
                f"{'–' if head == 'waypoint' else f'{zero:+.2f}'} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
