"""How wide certified rudder bands are, and whether any error leads out of them.

    python benchmarks/certify.py [--pilots NAME ...] [--scenes 64] [--samples 512] [--cells 17]
    python benchmarks/certify.py --alone [--scenes 20]    # single bands, as on the bridge

Scenes are drawn from the pilots' own voyages (2400 s, fixed random encounters). At each noise
level a scene is searched for the widest rudders: errors drawn evenly and from the corners,
and projected gradient ascent and descent. Prints rows of a Markdown table. Errors of own ship
and of targets are equally large; a scene counts as certified if the band lies on one side
of the dead zone of 0.25°, as possible if everything that the search found does.
"""

import argparse
import os
import time
from functools import partial

os.environ["JAX_PLATFORMS"] = "cpu"

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

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
from glasshelm.env.observe import FRAMES, in_front
from glasshelm.env.step import EnvSettings, reset, step, targets_at, waypoint_of
from glasshelm.networks.actors import Actor
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.registry import load
from glasshelm.ship.nomoto import KNOT_M_S, ShipParams, ShipState

#: Largest errors: positions [m], heading and courses [deg], speeds [kn].
LEVELS = ((5, 0.2, 0.05), (10, 0.5, 0.1), (30, 1.0, 0.2), (100, 3.0, 0.5))
ENCOUNTERS, INSTANTS, EVERY = 64, 24, 20
HEAD = (
    "| pilot | errors: m, °, kn | samples | outside | median band [°] | median range found [°] "
    "| median of their ratio | turn certified | turn possible | ms of CPU a band |\n"
    + "|---" * 10
    + "|"
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
    size = N_OWN_ERRORS + N_TARGET_ERRORS * scene.present.shape[0]
    inside = jax.random.uniform(key, (samples, size), minval=-1.0, maxval=1.0)
    corners = jnp.where(inside < 0, -1.0, 1.0)
    drawn = jnp.where((jnp.arange(samples) % 2 == 0)[:, None], inside, corners)
    return jax.vmap(partial(rudder_at, actor, scene, errors))(drawn)


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
    size = N_OWN_ERRORS + N_TARGET_ERRORS * scene.present.shape[0]
    begin = jax.random.uniform(key, (starts, size), minval=-1.0, maxval=1.0)
    begin = begin.at[0].set(0.0)
    sizes = jnp.geomspace(0.5, 0.02, steps)
    ask = jax.value_and_grad(lambda x: rudder_at(actor, scene, errors, x))

    def way(start: Array, side: Array) -> Array:
        def go(x: Array, length: Array) -> tuple[Array, Array]:
            rudder, slope = ask(x)
            slope = jnp.nan_to_num(slope)
            return jnp.clip(x + side * length * jnp.sign(slope), -1.0, 1.0), rudder

        last, rudders = jax.lax.scan(go, start, sizes)
        return jnp.append(rudders, rudder_at(actor, scene, errors, last))

    ways = jax.vmap(jax.vmap(way, (0, None)), (None, 0))(begin, jnp.array([1.0, -1.0]))
    return ways.reshape(-1)


@jax.jit
def voyages(actor: Actor, encounters: Encounter, ship: ShipParams) -> RawPlots:
    """Scenes [instant, voyage] every 100 s."""

    def first(encounter):
        state = reset(encounter, ship)
        return state, look(encounter, state, empty_plots(encounter.present.shape[-1]), True)

    def look(encounter, state, scene, new):
        motion = targets_at(encounter, state.step * EnvSettings().step_s)
        waypoint = waypoint_of(encounter, state.leg)
        return push_plots(scene, state.own, waypoint, motion, motion.present, new)

    def one(encounter, state, scene, action):
        state = step(encounter, state, action * ship.rudder_limit_rad, ship).state
        return state, look(encounter, state, scene, False)

    def tick(carry, _):
        state, scene = carry
        return jax.vmap(one)(encounters, state, scene, actor(state.observation)), None

    def leap(carry, _):
        carry, _ = jax.lax.scan(tick, carry, None, length=EVERY)
        return carry, carry[1]

    return jax.lax.scan(leap, jax.vmap(first)(encounters), None, length=INSTANTS)[1]


def scenes_of(pilot: LearnedPilot, count: int) -> RawPlots:
    """So many scenes, drawn from all instants of all voyages."""
    ship = pilot.trained.ship
    all_ = voyages(pilot.actor, validation_encounters(ship, ENCOUNTERS), ship)
    flat = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), all_)
    drawn = np.random.default_rng(0).permutation(flat.present.shape[0])[:count]
    return jax.tree.map(lambda x: x[drawn], flat)


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
    print(HEAD, flush=True)
    for name in args.pilots:
        steersman = load(name)
        drawn = scenes_of(steersman, args.scenes)
        action_bounds(require_sum_actor(steersman), drawn, errors_of(*LEVELS[0]))  # compiles
        for level in LEVELS:
            print(measure(steersman, args.cells, drawn, level, args.samples), flush=True)
