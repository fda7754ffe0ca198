"""How true are the critics? Values against returns, and against what could be known.

    python benchmarks/critics.py [--pilots NAME ...] [--encounters 512]

Prints a Markdown table: for each head the critic's correlation with single
returns (of the pilot who may lapse, where that is what the critic learned), the
ceiling that chance leaves to any predictor (learning/attainable.py), slope,
bias and spread, and what it says of a far ship, who costs nothing (mean over the rudders).
"""

import argparse
import sys
from pathlib import Path

import jax
import jax.numpy as jnp

from glasshelm.encounters.random_encounters import PAPER, random_encounter
from glasshelm.explain.danger_zero import far_value
from glasshelm.networks.checkpoint import read_header
from glasshelm.pilots.learned import read_pilot
from glasshelm.pilots.registry import SUFFIX, WEIGHTS, bundled
from glasshelm.training.config import config_from_dict
from glasshelm.training.critic_ceiling import HEADS, foretold
from glasshelm.training.exploration import NoiseSettings

SEED = 7_100_000  # never a training's or an evaluation set's
RUDDERS = jnp.linspace(-1.0, 1.0, 21)
FAITHFUL = NoiseSettings("bursts", burst_begin=0.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pilots", nargs="*", default=None)
    parser.add_argument("--encounters", type=int, default=512)
    arguments = parser.parse_args()
    print("| pilot | head | r | ceiling of r | slope | bias | spread of returns | far ship |")
    print("|---|---|---|---|---|---|---|---|")
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
        zero = float(jax.vmap(lambda a, c=pilot.critic: far_value(c, a))(RUDDERS).mean())
        for place, head in enumerate(HEADS):
            print(
                f"| {name} | {head} | {found.correlation[place]:.2f} | "
                f"{found.ceiling[place]:.2f} | {found.slope[place]:.2f} | "
                f"{found.bias[place]:+.2f} | {found.spread[place]:.2f} | "
                f"{'–' if head == 'waypoint' else f'{zero:+.2f}'} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
