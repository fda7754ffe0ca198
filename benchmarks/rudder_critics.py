"""Do critics know which action is better, or only which state?

    python benchmarks/rudder_critics.py [--encounters 128] [--out FOLDER]

Prints a Markdown table and draws ``advantages.png``. At two instants of every encounter each of
several actions is tried for real, and what follows is compared with what the critic says:

* *states*: the correlation of Q with the return over all states and actions;
* *actions*: the same after the mean over the actions of each state is taken off both (the
  advantages), where the actions matter at all;
* *gain*: the share of the attainable gain over going straight that the action with the largest Q
  takes.

A pilot that steers rudders holds each of nine rudders for 5 or 20 s, and then steers itself; its
returns are those that it was trained on, discounted. The glassbox pilot's actions are
manoeuvres: nine courses held for 400 s are steered in the environment, and their returns are sums
of the paper's reward over 2400 s, which is not what the pilot's critic adds up.
"""

import argparse
import dataclasses
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from matplotlib.figure import Figure

from glasshelm.core.compile_cache import enable_compile_cache
from glasshelm.core.geometry import wrap_angle
from glasshelm.encounters.random_encounters import PAPER, random_encounters
from glasshelm.encounters.types import Encounter
from glasshelm.env.step import EnvSettings, EnvState
from glasshelm.figures.style import SOFT, new_figure, save, styled
from glasshelm.networks.ship_batch import Padded
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.registry import load, pilot_named
from glasshelm.planning.manoeuvres import Manoeuvres
from glasshelm.planning.situation import situation_of
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import ShipParams
from glasshelm.training.vector_env import reset_batch, step_batch

SEED = 7_200_000  # never a training's or a validation set's
RUDDERS = jnp.linspace(-1.0, 1.0, 9)
#: Steps after which actions are tried.
INSTANTS = (60, 160)
DISCOUNT = 0.98
#: Returns end after so many steps: 0.98^200 is 2 %.
STEPS = 200
#: Courses off the waypoint's bearing [rad], how long each is held, and steps to the horizon.
COURSES = jnp.radians(jnp.array([-90.0, -60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0, 90.0]))
COURSE_S, COURSE_STEPS = 400.0, 480
#: A state counts where its actions differ by as much [reward].
MATTERS = 0.02


@dataclasses.dataclass(frozen=True)
class Judged:
    """What a critic says of actions, and what they bring: [actions, states]."""

    name: str
    action: str
    value: Float[np.ndarray, "a s"]
    truth: Float[np.ndarray, "a s"]
    straight: int

    def figures(self) -> tuple[float, float, float]:
        """Correlation over states, over actions, and the share of the attainable gain."""
        gain = self.truth - self.truth[self.straight]
        taken = np.take_along_axis(gain, self.value.argmax(0)[None], 0)[0]
        advantages = self.advantages()
        return (
            float(np.corrcoef(self.value.ravel(), self.truth.ravel())[0, 1]),
            float(np.corrcoef(*advantages)[0, 1]),
            float(taken.sum() / gain.max(0).sum()),
        )

    def advantages(self) -> tuple[np.ndarray, np.ndarray]:
        """Value and truth, each less its mean over the actions, of states where they matter."""
        value, truth = (x - x.mean(0) for x in (self.value, self.truth))
        matters = np.abs(truth).max(0) > MATTERS
        return value[:, matters].ravel(), truth[:, matters].ravel()


@partial(jax.jit, static_argnames=("hold", "at"))
def _judge(
    pilot_parts: tuple, encounters: Encounter, ship: ShipParams, at: int, hold: int
) -> tuple[Float[Array, "a s"], Float[Array, "a s"]]:
    actor, critic = pilot_parts
    state = reset_batch(encounters, ship)

    def sail(state: EnvState, _: None) -> tuple[EnvState, None]:
        return step_batch(encounters, state, actor(state.observation), ship).state, None

    state, _ = jax.lax.scan(sail, state, None, length=at)
    seen = state.observation
    size = seen.present.shape[0]

    def value(rudder: Float[Array, ""]) -> Float[Array, " s"]:
        return critic(seen, jnp.full(size, rudder), Padded(seen.present)).total

    def truth(rudder: Float[Array, ""]) -> Float[Array, " s"]:
        def go(carry, number):
            state, weight, total = carry
            action = jnp.where(number < hold, rudder, actor(state.observation))
            result = step_batch(encounters, state, action, ship)
            return (result.state, weight * DISCOUNT, total + weight * result.reward.total), None

        start = (state, 1.0, jnp.zeros(size))
        (_, _, total), _ = jax.lax.scan(go, start, jnp.arange(STEPS))
        return total

    return jax.lax.map(value, RUDDERS), jax.lax.map(truth, RUDDERS)


def judge_rudders(pilot: LearnedPilot, encounters: Encounter, hold: int) -> Judged:
    """A learned pilot's critic, of nine rudders held for so many steps."""
    pairs = [
        jax.device_get(_judge((pilot.actor, pilot.critic), encounters, pilot.ship, at, hold))
        for at in INSTANTS
    ]
    value, truth = (np.concatenate(x, axis=1) for x in zip(*pairs, strict=True))
    return Judged(pilot.name, f"rudder held {5 * hold} s", value, truth, len(RUDDERS) // 2)


@eqx.filter_jit
def _judge_courses(
    pilot: GlassboxPilot, encounters: Encounter, ship: ShipParams, at: int
) -> tuple[Float[Array, "a s"], Float[Array, "a s"]]:
    """Own ship has kept straight on for ``at`` steps."""
    autopilot = autopilot_for(ship)
    start = reset_batch(encounters, ship)

    def bearing_of(state: EnvState) -> Float[Array, " s"]:
        return jax.vmap(lambda seen: situation_of(seen, ship).bearing_rad)(state.observation)

    def straight(state: EnvState, _: None) -> tuple[EnvState, None]:
        rudders = jnp.zeros(state.own.heading_rad.shape)
        return step_batch(encounters, state, rudders, ship).state, None

    start, _ = jax.lax.scan(straight, start, None, length=at)
    zero = jnp.zeros_like(COURSES)
    plans = Manoeuvres(COURSES, zero + COURSE_S, zero, zero)
    values = jax.vmap(lambda seen: pilot.critic.value(plans, seen, ship).total)(start.observation)

    def truth(offset: Float[Array, ""]) -> Float[Array, " s"]:
        course = start.own.heading_rad + bearing_of(start) + offset

        def go(carry, number):
            state, total = carry
            own, held = state.own, number * EnvSettings().step_s < COURSE_S
            error = jnp.where(held, wrap_angle(course - own.heading_rad), bearing_of(state))
            rudder = autopilot.rudder_rad(error, own.rate_of_turn_rad_s) / ship.rudder_limit_rad
            result = step_batch(encounters, state, rudder, ship)
            return (result.state, total + result.reward.total), None

        (_, total), _ = jax.lax.scan(go, (start, jnp.zeros_like(course)), jnp.arange(COURSE_STEPS))
        return total

    return values.T, jax.lax.map(truth, COURSES)


def judge_courses(pilot: GlassboxPilot, encounters: Encounter) -> Judged:
    """The glassbox pilot's critic, of nine courses held for a time, then the way to the waypoint.

    They are steered in the environment to the horizon, and what they bring is the paper's reward.
    """
    pairs = [jax.device_get(_judge_courses(pilot, encounters, pilot.ship, at)) for at in (1, 60)]
    value, truth = (np.concatenate(x, axis=1) for x in zip(*pairs, strict=True))
    return Judged(pilot.name, f"course held {COURSE_S:g} s", value, truth, len(COURSES) // 2)


@styled
def draw(judged: Sequence[Judged]) -> Figure:
    """What each critic says of an action over what the action brings, less each state's mean."""
    figure = new_figure(2.9 * len(judged), 3.1)
    for ax, one in zip(figure.subplots(1, len(judged)), judged, strict=True):
        value, truth = one.advantages()
        ax.plot(truth, value, ls="", marker=".", ms=2.2, color="#0072B2", alpha=0.5)
        ax.set_xlim(*np.quantile(truth, (0.005, 0.995)))
        ax.set_ylim(*np.quantile(value, (0.005, 0.995)))
        ax.axhline(0, color=SOFT, lw=0.6)
        ax.axvline(0, color=SOFT, lw=0.6)
        ax.set_title(f"{one.name}\n{one.action}, r = {one.figures()[1]:.2f}")
        ax.set_xlabel("advantage that it has")
    figure.axes[0].set_ylabel("advantage by the critic")
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--encounters", type=int, default=128)
    parser.add_argument("--out", type=Path, help="folder for advantages.png")
    args = parser.parse_args()
    enable_compile_cache()
    sums, glassbox = load("paper-sum-ddpg"), pilot_named("paper-glassbox")
    encounters = random_encounters(jax.random.key(SEED), args.encounters, sums.ship, PAPER)
    judged = [
        judge_rudders(sums, encounters, 1),
        judge_rudders(sums, encounters, 4),
        judge_rudders(load("paper-attention-ddpg"), encounters, 1),
        judge_courses(glassbox, encounters),
    ]
    print("| critic | action | r over states | r over actions | share of the gain |")
    print("|---|---|---|---|---|")
    for one in judged:
        states, actions, gain = one.figures()
        print(f"| {one.name} | {one.action} | {states:.2f} | {actions:.2f} | {gain:.0%} |")
    if args.out is not None:
        save(draw(judged), args.out / "advantages")


if __name__ == "__main__":
    main()
