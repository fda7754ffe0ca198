"""How true are the critics? Values against returns, and against what could be known.

    python benchmarks/critics.py [--pilots NAME ...] [--encounters 512]

Prints a Markdown table: for each sub-task the critic's correlation with single
returns (of the pilot who may lapse, where that is what the critic learned), the
ceiling that chance leaves to any predictor (learning/attainable.py), slope,
bias and spread.
"""

import argparse
import sys
from pathlib import Path

import jax

from glasshelm.encounters.random import PAPER, random_encounter
from glasshelm.learning.attainable import foretold
from glasshelm.learning.checkpoint import read_header
from glasshelm.learning.noise import NoiseSettings
from glasshelm.learning.presets import config_from_dict
from glasshelm.pilots.catalogue import SUFFIX, WEIGHTS, bundled
from glasshelm.pilots.learned import read_pilot
from glasshelm.world.rewards import SUB_TASKS

SEED = 7_100_000  # never a training's or an evaluation set's
FAITHFUL = NoiseSettings("bursts", burst_begin=0.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pilots", nargs="*", default=None)
    parser.add_argument("--encounters", type=int, default=512)
    arguments = parser.parse_args()
    print("| pilot | sub-task | r | ceiling of r | slope | bias | spread of returns |")
    print("|---|---|---|---|---|---|---|")
    for name in arguments.pilots or bundled():
        path = Path(name) if name.endswith(SUFFIX) else WEIGHTS / f"{name}{SUFFIX}"
        pilot, learning = read_pilot(path, name), config_from_dict(read_header(path)["config"]).ddpg
        if pilot.critic is None:
            sys.exit(f"{name} has no critic: train one with --set ddpg.env_steps=2000000")
        ship = pilot.trained.ship
        keys = jax.random.split(jax.random.key(SEED), arguments.encounters)
        batch = jax.jit(jax.vmap(lambda k, s=ship: random_encounter(k, s, PAPER)))(keys)
        lapses = learning.noise if learning.follows == "lapses" else FAITHFUL
        found = foretold(pilot.actor, pilot.critic, batch, ship, learning.discount, lapses)
        for task in SUB_TASKS:
            print(
                f"| {name} | {task.name.lower()} | {found.correlation[task]:.2f} | "
                f"{found.ceiling[task]:.2f} | {found.slope[task]:.2f} | "
                f"{found.bias[task]:+.2f} | {found.spread[task]:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
