"""How wide certified rudder bands are, and whether any error leads out of them.

    python benchmarks/certify.py [--pilots NAME ...] [--scenes 64] [--samples 512] [--cells 17]
    python benchmarks/certify.py --pilots paper-glassbox large-ship-glassbox   # manoeuvres
    python benchmarks/certify.py --alone [--scenes 20]    # single bands, as on the bridge

Scenes are drawn from the pilots' own voyages (2400 s, fixed random encounters). At each noise
level a scene is searched for the widest rudders: errors drawn evenly and from the corners,
and projected gradient ascent and descent. Prints rows of a Markdown table. Errors of own ship
and of targets are equally large; a scene counts as certified if the band lies on one side
of the dead zone of 0.25°, as possible if everything that the search found does.

Of a pilot that chooses manoeuvres the bands are of values. Each sample goes through the whole
critic: the value of every manoeuvre, of every part of it, and its difference to the chosen one must
lie between their bounds, and the manoeuvre that is then the best among those that can be. The
value of the chosen one is searched by gradients as well.
"""

import argparse
import os
import time
from collections.abc import Callable
from functools import partial

os.environ["JAX_PLATFORMS"] = "cpu"

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.certify.manoeuvre_band import ManoeuvreBand, certified_choice
from glasshelm.certify.measurements import (
    N_OWN_ERRORS,
    N_TARGET_ERRORS,
    RawPlots,
    SensorErrors,
    observe_plots,
    with_errors,
)
from glasshelm.certify.rudder_band import (
    DEAD_ZONE_RAD,
    action_bounds,
    certified_band,
    require_sum_actor,
)
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.core.geometry import Vector
from glasshelm.encounters.random_encounters import validation_encounters
from glasshelm.encounters.types import Encounter, Motion
from glasshelm.env.observe import FRAMES, Observation, in_front
from glasshelm.env.step import EnvSettings, reset, step, targets_at, waypoint_of
from glasshelm.explanation.manoeuvre_explanation import SAME_COURSE_RAD, choose
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import QValues
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.registry import load, pilot_named
from glasshelm.planning.situation import rudder_towards, situation_of
from glasshelm.ship.nomoto import KNOT_M_S, ShipParams, ShipState

#: Largest errors: positions [m], heading and courses [deg], speeds [kn].
LEVELS = ((5, 0.2, 0.05), (10, 0.5, 0.1), (30, 1.0, 0.2), (100, 3.0, 0.5))
ENCOUNTERS, INSTANTS, EVERY = 64, 24, 20
#: A pilot that tries manoeuvres is slower: fewer voyages.
GLASSBOX_ENCOUNTERS = 6
HEAD = (
    "| pilot | errors: m, °, kn | samples | outside | median band [°] | median range found [°] "
    "| median of their ratio | turn certified | turn possible | ms of CPU a band |\n"
    + "|---" * 10
    + "|"
)
#: The same of pilots that choose manoeuvres; medians of one situation each, values in points.
CHOICES = (
    "| pilot | errors: m, °, kn | samples | outside | median band of the value "
    "| median range found | median of their ratio | course certified | one course found "
    "| median rudder band [°] | kept clear, certified | ms of CPU a band |\n" + "|---" * 12 + "|"
)


def plots_of(
    own: ShipState, waypoint: Vector, motion: Motion
) -> tuple[Float[Array, "6"], Float[Array, "n 6"]]:
    """The plots of one frame: the waypoint's and every target's."""

    def plot(east: Array, north: Array, course: Array, speed: Array) -> Array:
        return jnp.stack(
            [east - own.east_m, north - own.north_m, own.heading_rad, own.speed_m_s, course, speed]
        )

    still = jnp.zeros_like(own.heading_rad)
    to_waypoint = plot(waypoint.x, waypoint.y, still, still)
    return to_waypoint, jax.vmap(plot)(
        motion.east_m, motion.north_m, motion.course_rad, motion.speed_m_s
    )


def empty_plots(slots: int) -> RawPlots:
    """The history before the first frame."""
    return RawPlots(jnp.zeros((FRAMES, 6)), jnp.zeros((slots, FRAMES, 6)), jnp.zeros(slots, bool))


def push_plots(
    history: RawPlots,
    own: ShipState,
    waypoint: Vector,
    motion: Motion,
    present: Bool[Array, " n"],
    first: Bool[Array, ""] | bool,
) -> RawPlots:
    """The history with a new frame in front: :func:`glasshelm.env.observe.push_frame` of plots."""
    ahead, targets = plots_of(own, waypoint, motion)
    new = jnp.logical_not(history.present) | first
    return RawPlots(
        in_front(ahead, history.waypoint, jnp.asarray(first)),
        in_front(targets, history.targets, new),
        present,
    )


def rudder_at(
    actor: Actor, scene: RawPlots, errors: SensorErrors, fractions: Float[Array, " k"]
) -> Float[Array, ""]:
    """The rudder with these errors, as a fraction of the limit."""
    own, target = fractions[:N_OWN_ERRORS], fractions[N_OWN_ERRORS:].reshape(-1, N_TARGET_ERRORS)
    return actor(observe_plots(with_errors(scene, own * errors.own(), target * errors.target())))


def random_rudders(
    actor: Actor, scene: RawPlots, errors: SensorErrors, key: PRNGKeyArray, samples: int
) -> Float[Array, " s"]:
    """Rudders at errors drawn evenly from the box; every other one from its corners."""
    drawn = drawn_fractions(scene, key, samples)
    return jax.vmap(partial(rudder_at, actor, scene, errors))(drawn)


def drawn_fractions(scene: RawPlots, key: PRNGKeyArray, samples: int) -> Float[Array, "s k"]:
    """Errors drawn evenly from the box, every other one from its corners."""
    size = N_OWN_ERRORS + N_TARGET_ERRORS * scene.present.shape[0]
    inside = jax.random.uniform(key, (samples, size), minval=-1.0, maxval=1.0)
    corners = jnp.where(inside < 0, -1.0, 1.0)
    return jnp.where((jnp.arange(samples) % 2 == 0)[:, None], inside, corners)


def attacked_rudders(
    actor: Actor,
    scene: RawPlots,
    errors: SensorErrors,
    key: PRNGKeyArray,
    starts: int = 8,
    steps: int = 20,
) -> Float[Array, " s"]:
    """Every rudder on the way of projected gradient ascent and descent (Madry et al. 2018).

    From random starts; steps along the sign of the gradient, from 0.5 of the
    largest errors down to 0.02.
    """
    return _ways(partial(rudder_at, actor, scene, errors), scene, key, starts, steps)


def _ways(
    number: Callable[[Float[Array, " k"]], Float[Array, ""]],
    scene: RawPlots,
    key: PRNGKeyArray,
    starts: int,
    steps: int,
) -> Float[Array, " s"]:
    """A number of the errors on all ways that climb or descend its gradient."""
    size = N_OWN_ERRORS + N_TARGET_ERRORS * scene.present.shape[0]
    begin = jax.random.uniform(key, (starts, size), minval=-1.0, maxval=1.0)
    begin = begin.at[0].set(0.0)
    sizes = jnp.geomspace(0.5, 0.02, steps)
    ask = jax.value_and_grad(number)

    def way(start: Array, side: Array) -> Array:
        def go(x: Array, length: Array) -> tuple[Array, Array]:
            value, slope = ask(x)
            slope = jnp.nan_to_num(slope)
            return jnp.clip(x + side * length * jnp.sign(slope), -1.0, 1.0), value

        last, values = jax.lax.scan(go, start, sizes)
        return jnp.append(values, number(last))

    ways = jax.vmap(jax.vmap(way, (0, None)), (None, 0))(begin, jnp.array([1.0, -1.0]))
    return ways.reshape(-1)


@eqx.filter_jit
def voyages(
    policy: Callable[[Observation], Array], encounters: Encounter, ship: ShipParams
) -> RawPlots:
    """Scenes [instant, voyage] every 100 s. The policy takes one observation."""

    def first(encounter):
        state = reset(encounter, ship)
        return state, look(encounter, state, empty_plots(encounter.present.shape[-1]), True)

    def look(encounter, state, scene, new):
        motion = targets_at(encounter, state.step * EnvSettings().step_s)
        waypoint = waypoint_of(encounter, state.leg)
        return push_plots(scene, state.own, waypoint, motion, motion.present, new)

    def one(encounter, state, scene):
        action = policy(state.observation)
        state = step(encounter, state, action * ship.rudder_limit_rad, ship).state
        return state, look(encounter, state, scene, False)

    def tick(carry, _):
        state, scene = carry
        return jax.vmap(one)(encounters, state, scene), None

    def leap(carry, _):
        carry, _ = jax.lax.scan(tick, carry, None, length=EVERY)
        return carry, carry[1]

    return jax.lax.scan(leap, jax.vmap(first)(encounters), None, length=INSTANTS)[1]


def scenes_of(pilot: LearnedPilot | GlassboxPilot, count: int) -> RawPlots:
    """So many scenes, drawn from all instants of all voyages."""
    glassbox = isinstance(pilot, GlassboxPilot)
    ship = pilot.ship if glassbox else pilot.trained.ship
    policy = eqx.Partial(_steer, pilot) if glassbox else pilot.actor
    sailed = GLASSBOX_ENCOUNTERS if glassbox else ENCOUNTERS
    all_ = voyages(policy, validation_encounters(ship, sailed), ship)
    flat = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), all_)
    drawn = np.random.default_rng(0).permutation(flat.present.shape[0])[:count]
    return jax.tree.map(lambda x: x[drawn], flat)


def _steer(pilot: GlassboxPilot, observation: Observation) -> Array:
    """The rudder without its reasons."""
    manoeuvres, values = pilot.critic(observation, pilot.ship)
    return rudder_towards(manoeuvres.offset_rad[choose(values)], observation, pilot.ship)


def errors_of(position_m: float, angle_deg: float, speed_kn: float) -> SensorErrors:
    """The same largest errors for own ship and targets."""
    return SensorErrorBounds(
        position_m, np.radians(angle_deg), speed_kn * KNOT_M_S
    ).as_sensor_errors()


@partial(jax.jit, static_argnums=4)
def found_in(actor, scenes, errors, keys, samples):
    """Lowest and highest rudder of each scene that random errors and attacks find."""

    def one(scene, key):
        keys = jax.random.split(key)
        rudders = [
            random_rudders(actor, scene, errors, keys[0], samples),
            attacked_rudders(actor, scene, errors, keys[1]),
        ]
        both = jnp.concatenate(rudders)
        return both.min(), both.max(), jnp.ones_like(both).sum()

    return jax.lax.map(lambda x: one(*x), (scenes, keys))


def measure(pilot: LearnedPilot, cells: int, scenes: RawPlots, level, samples: int) -> str:
    """One row of the table."""
    actor, errors, count = require_sum_actor(pilot), errors_of(*level), scenes.present.shape[0]
    before = time.process_time()
    low, high = action_bounds(actor, scenes, errors, cells)
    took_ms = 1e3 * (time.process_time() - before) / count
    keys = jax.random.split(jax.random.key(1), count)
    found = found_in(actor, scenes, errors, keys, samples)
    least, most, tried = map(np.asarray, found)
    outside = int(((least < low) | (most > high)).sum())
    limit = float(pilot.trained.ship.rudder_limit_rad)
    zone = float(DEAD_ZONE_RAD) / limit
    degrees = np.degrees(limit)
    band, reach = high - low, most - least
    ratio = np.median(band / np.maximum(reach, 1e-9))
    certain = ((low > zone) | (high < -zone)).mean()
    possible = ((least > zone) | (most < -zone)).mean()
    return (
        f"| {pilot.name} | {level[0]}, {level[1]}, {level[2]} | {int(tried.sum()):,} | {outside} "
        f"| {degrees * np.median(band):.3f} | {degrees * np.median(reach):.3f} | {ratio:.1f} "
        f"| {100 * certain:.0f} % | {100 * possible:.0f} % | {took_ms:.0f} |"
    )


def with_fractions(scene: RawPlots, errors: SensorErrors, fractions: Float[Array, " k"]):
    """What is observed with these errors, in fractions of the largest."""
    own, target = fractions[:N_OWN_ERRORS], fractions[N_OWN_ERRORS:].reshape(-1, N_TARGET_ERRORS)
    return observe_plots(with_errors(scene, own * errors.own(), target * errors.target()))


@eqx.filter_jit
def sampled_choices(
    pilot: GlassboxPilot, scene: RawPlots, errors: SensorErrors, key: PRNGKeyArray, samples: int
) -> tuple[QValues, Int[Array, " s"]]:
    """The values of all manoeuvres at errors drawn evenly or from corners, and the best of them."""

    def one(fractions: Array) -> tuple[QValues, Array]:
        _, values = pilot.critic(with_fractions(scene, errors, fractions), pilot.ship)
        return values, choose(values)

    return jax.lax.map(one, drawn_fractions(scene, key, samples))


@eqx.filter_jit
def attacked_values(
    pilot: GlassboxPilot,
    scene: RawPlots,
    errors: SensorErrors,
    row: Int[Array, ""],
    key: PRNGKeyArray,
    starts: int = 8,
    steps: int = 20,
) -> Float[Array, " s"]:
    """Values of one manoeuvre on the way of projected gradient ascent and descent."""

    def ask(fractions: Array) -> Array:
        observation = with_fractions(scene, errors, fractions)
        rows = pilot.critic.table.at(situation_of(observation, pilot.ship).bearing_rad)
        one = jax.tree.map(lambda x: x[row][None], rows)
        return pilot.critic.value(one, observation, pilot.ship).total[0]

    return _ways(ask, scene, key, starts, steps)


def choice_is_within(
    band: ManoeuvreBand, values: QValues, best: Int[Array, " s"]
) -> Bool[np.ndarray, " s"]:
    """Which samples lie between the bounds: all values, parts, differences, and the best course."""

    def between(x: Array, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        x = np.asarray(x)
        fits = (x >= low) & (x <= high)
        return fits.reshape(len(x), -1).all(-1)

    total = np.asarray(values.total)
    gain = total[:, [int(band.chosen)]] - total
    parts = ("waypoint", "by_ship", "helm", "total")
    inside = [
        between(getattr(values, part), getattr(band.low, part), getattr(band.high, part))
        for part in parts
    ]
    inside.append(between(gain, band.gain_low, band.gain_high))
    inside.append(np.asarray(band.possible)[np.asarray(best)])
    return np.all(inside, axis=0)


def measure_choices(pilot: GlassboxPilot, scenes: RawPlots, level, samples: int) -> str:
    """One row of the table of manoeuvres."""
    errors, count, took_ms = errors_of(*level), scenes.present.shape[0], []
    rows, outside, tried = [], 0, 0
    for number in range(count):
        scene = jax.tree.map(lambda x, k=number: x[k], scenes)
        before = time.process_time()
        band = jax.device_get(certified_choice(pilot, scene, errors))
        took_ms.append(1e3 * (time.process_time() - before))
        keys = jax.random.split(jax.random.key(number))
        values, best = sampled_choices(pilot, scene, errors, keys[0], samples)
        attacked = np.asarray(attacked_values(pilot, scene, errors, band.chosen, keys[1]))
        row = int(band.chosen)
        low, high = float(band.low.total[row]), float(band.high.total[row])
        outside += int((~choice_is_within(band, values, best)).sum())
        outside += int(((attacked < low) | (attacked > high)).sum())
        tried += len(best) + len(attacked)
        best = np.asarray(best)
        found = np.append(values.total[:, row], attacked)
        off = np.abs(np.angle(np.exp(1j * (band.course_rad[best] - band.course_rad[row]))))
        courses = np.array(band.possible_courses_rad) - band.course_rad[row]
        rows.append(
            (high - low, np.ptp(found), len(courses) == 1, off.max() <= SAME_COURSE_RAD,
             band.rudder_high - band.rudder_low, (band.margin[row] <= 0).all())
        )  # fmt: skip
    width, reach, certain, possible, rudder, clear = map(np.array, zip(*rows, strict=True))
    degrees = np.degrees(pilot.ship.rudder_limit_rad)
    return (
        f"| {pilot.name} | {level[0]}, {level[1]}, {level[2]} | {tried:,} | {outside} "
        f"| {np.median(width):.2f} | {np.median(reach):.2f} "
        f"| {np.median(width / np.maximum(reach, 1e-3)):.2f} "
        f"| {100 * certain.mean():.0f} % | {100 * possible.mean():.0f} % "
        f"| {degrees * np.median(rudder):.2f} | {100 * clear.mean():.0f} % "
        f"| {np.median(took_ms):.0f} |"
    )


def alone(pilot: LearnedPilot, scenes: RawPlots, cells: int) -> str:
    """How long the band of one scene takes, one after the other."""
    errors = errors_of(10, 0.5, 0.1)
    wall, cpu = [], []
    for k in range(scenes.present.shape[0]):
        scene = jax.tree.map(lambda x, k=k: x[k], scenes)
        began, used = time.perf_counter(), time.process_time()
        certified_band(pilot, scene, errors, cells)
        wall.append(time.perf_counter() - began)
        cpu.append(time.process_time() - used)
    p50, most = 1e3 * np.median(wall), 1e3 * max(wall)
    return (
        f"{pilot.name}, {cells} bounds: p50 {p50:.0f} ms, longest {most:.0f} ms; "
        f"{1e3 * np.median(cpu):.0f} ms of CPU"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pilots", nargs="+", default=["paper-sum", "large-ship-sum"])
    parser.add_argument("--scenes", type=int, default=64)
    parser.add_argument("--samples", type=int, default=512, help="random errors a scene")
    parser.add_argument("--cells", type=int, default=17, help="bounds a band")
    parser.add_argument("--alone", action="store_true", help="time single bands")
    args = parser.parse_args()

    if args.alone:
        for name in args.pilots:
            steersman = load(name)
            drawn = scenes_of(steersman, args.scenes)
            alone(steersman, drawn, 1)  # compiles
            for cells in (1, 5, args.cells):
                print(alone(steersman, drawn, cells), flush=True)
        raise SystemExit
    for name in args.pilots:
        steersman = pilot_named(name)
        if isinstance(steersman, GlassboxPilot):
            drawn = scenes_of(steersman, args.scenes)
            certified_choice(steersman, jax.tree.map(lambda x: x[0], drawn), errors_of(*LEVELS[0]))
            print(CHOICES, flush=True)
            for level in LEVELS:
                print(measure_choices(steersman, drawn, level, args.samples), flush=True)
            continue
        print(HEAD, flush=True)
        drawn = scenes_of(steersman, args.scenes)
        action_bounds(require_sum_actor(steersman), drawn, errors_of(*LEVELS[0]))  # compiles
        for level in LEVELS:
            print(measure(steersman, args.cells, drawn, level, args.samples), flush=True)
