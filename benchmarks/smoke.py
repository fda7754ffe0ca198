"""Is the world still fast? Steps per second, absolute and against this machine's matrix products.

    python benchmarks/smoke.py [--floor]

Prints rows of a Markdown table: the world alone (512 worlds of six ships under
``vmap``) and the gymnasium adapter. ``--floor`` also compares the world with a
float32 matrix product of NumPy, timed in turn with it so that a busy or a slow
machine slows both, and exits with 1 below the floor.
"""

import argparse
import os
import platform
import sys
import time
from collections.abc import Callable

os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # spinning threads suffer most on a busy machine

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np

import glasshelm.env.gymnasium_env
from glasshelm.encounters.random_encounters import PAPER, random_encounter
from glasshelm.env.step import reset, step
from glasshelm.ship.nomoto import SHIPS

WORLDS, STEPS, ROUNDS = 512, 60, 12
#: World steps per GFLOP of NumPy's product on one core. Measured on a busy two-core virtual
#: machine: 10,000 to 39,000.
FLOOR = 3000.0


def world_round() -> Callable[[], object]:
    """A compiled program of WORLDS · STEPS steps with changing rudder."""
    ship = SHIPS["paper"]
    keys = jax.random.split(jax.random.key(0), WORLDS)
    batch = jax.jit(jax.vmap(lambda k: random_encounter(k, ship, PAPER)))(keys)
    rudders = 0.08 * jnp.sin(jnp.arange(STEPS) / 7.0)

    @jax.jit
    def sail(batch):
        def go(states, rudder):
            out = jax.vmap(lambda e, s: step(e, s, rudder, ship))(batch, states)
            return out.state, out.reward.total.sum()

        # The last state is kept, or XLA leaves out what only observations need.
        return jax.lax.scan(go, jax.vmap(lambda e: reset(e, ship))(batch), rudders)

    return lambda: jax.block_until_ready(sail(batch))


def product_round(size: int = 1024) -> Callable[[], object]:
    a = np.random.default_rng(0).normal(size=(size, size)).astype(np.float32)
    return lambda: a @ a


def gym_steps_per_s(seconds: float = 2.0) -> float:
    env = gymnasium.make(glasshelm.env.gymnasium_env.ID, flat=True).unwrapped
    action = np.zeros(1, np.float32)
    env.reset(seed=0)
    env.step(action)
    count, start = 0, time.perf_counter()
    while time.perf_counter() - start < seconds:
        ended = env.step(action)[3]
        count += 1
        if ended:
            env.reset()
    return count / (time.perf_counter() - start)


def timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--floor", action="store_true", help="exit with 1 below the floor")
    options = parser.parse_args()
    world, product = world_round(), product_round()
    world(), product()  # compile, warm up
    pairs = [(timed(world), timed(product)) for _ in range(ROUNDS)]
    world_s, product_s = (min(column) for column in zip(*pairs, strict=True))
    rate = WORLDS * STEPS / world_s
    gflop_s = 2 * 1024**3 / product_s / 1e9
    machine = f"{platform.machine()}, {os.cpu_count()} cores, jax {jax.__version__}"
    print("| what | measured | machine |\n|---|---|---|")
    print(f"| world alone, {WORLDS} worlds of 6 slots | {rate:,.0f} steps/s | {machine} |")
    print(f"| gymnasium adapter, one world | {gym_steps_per_s():,.0f} steps/s | {machine} |")
    print(f"| NumPy product of 1024 x 1024, float32 | {gflop_s:.0f} GFLOP/s | {machine} |")
    if options.floor:
        ratio = rate / gflop_s
        print(f"world steps per GFLOP: {ratio:,.0f} (floor {FLOOR:,.0f})")
        return int(ratio < FLOOR)
    return 0


if __name__ == "__main__":
    sys.exit(main())
