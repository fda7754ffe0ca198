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

from glasshelm.certify.adversarial import attacked_rudders, random_rudders
from glasshelm.certify.measurements import RawPlots, SensorErrors, no_scene, recall
from glasshelm.certify.rudder_band import DEAD_ZONE_RAD, action_bounds, certifiable, certified_band
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.encounters.random_encounters import validation_encounters
from glasshelm.encounters.types import Encounter
from glasshelm.env.step import EnvSettings, reset, step, targets_at, waypoint_of
from glasshelm.networks.actors import Actor
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.registry import load
from glasshelm.ship.nomoto import KNOT_M_S, ShipParams

#: Largest errors: positions [m], heading and courses [deg], speeds [kn].
LEVELS = ((5, 0.2, 0.05), (10, 0.5, 0.1), (30, 1.0, 0.2), (100, 3.0, 0.5))
ENCOUNTERS, INSTANTS, EVERY = 64, 24, 20
HEAD = (
    "| pilot | errors: m, °, kn | samples | outside | median band [°] | median range found [°] "
    "| median of their ratio | turn certified | turn possible | ms of CPU a band |\n"
    + "|---" * 10
    + "|"
)


@jax.jit
def voyages(actor: Actor, encounters: Encounter, ship: ShipParams) -> RawPlots:
    """Scenes [instant, voyage] every 100 s."""

    def first(encounter):
        state = reset(encounter, ship)
        return state, look(encounter, state, no_scene(encounter.present.shape[-1]), True)

    def look(encounter, state, scene, new):
        motion = targets_at(encounter, state.step * EnvSettings().step_s)
        waypoint = waypoint_of(encounter, state.leg)
        return recall(scene, state.own, waypoint, motion, motion.present, new)

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
    return SensorErrorBounds(position_m, np.radians(angle_deg), speed_kn * KNOT_M_S).of_sensors()


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
    actor, errors, count = certifiable(pilot), errors_of(*level), scenes.present.shape[0]
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
        action_bounds(certifiable(steersman), drawn, errors_of(*LEVELS[0]))  # compiles
        for level in LEVELS:
            print(measure(steersman, args.cells, drawn, level, args.samples), flush=True)
