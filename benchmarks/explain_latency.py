"""How long a decision with its whole explanation takes, on one core.

    python benchmarks/explain_latency.py [--pilot NAME] [--calls 1000]

Times ``glasshelm.explain(pilot, observation)`` as a user calls it: checks, padding, decision,
everything that a frame says of it, result ready. Of a learned pilot then the Shapley values
alone, with all pairs' interactions (``shapley_by_ship``).
Without a pilot the networks have the paper's sizes (Tables A.1-A.5, attention
actor) and random weights, which cost the same. Prints rows of a Markdown table.
"""

import argparse
import os
import platform
import time
from pathlib import Path

if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
os.environ["JAX_PLATFORMS"] = "cpu"

import jax
import numpy as np

import glasshelm
from glasshelm.encounters.random_encounters import RandomEncounters, random_encounter
from glasshelm.env.observe import Observation
from glasshelm.env.step import reset
from glasshelm.env.training_envelope import TrainingEnvelope
from glasshelm.explanation.shapley import Game, shapley_by_ship
from glasshelm.networks.actors import ActorSizes, AttentionActor
from glasshelm.networks.critics import CriticSizes, SubTaskCritic
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import pilot_named
from glasshelm.ship.nomoto import SHIPS, ShipParams

HEAD = (
    "| pilot | what | ships | p50 [ms] | p95 [ms] | p99 [ms] | calls |\n"
    "|---|---|---|---|---|---|---|"
)

GAMES: dict[str, Game] = {"Shapley, rudder": "rudder", "Shapley, worth": "decision"}


def paper_sized() -> LearnedPilot:
    """Networks of the paper's sizes with random weights."""
    actor_key, critic_key = jax.random.split(jax.random.key(0))
    return LearnedPilot(
        AttentionActor(ActorSizes(), actor_key),
        SubTaskCritic(CriticSizes(), critic_key),
        TrainingEnvelope(),
        "paper sizes",
    )


def observation(ship: ShipParams, ships: int) -> Observation:
    """A random encounter of so many ships at its start, held by the host as a feed would."""
    settings = RandomEncounters(targets=(ships, ships))
    state = reset(random_encounter(jax.random.key(1), ship, settings), ship)
    return jax.device_get(state.observation)


def measure(what: str, pilot: Pilot, ships: int, calls: int) -> str:
    """One row of the table: ``what`` is ``decision``, or a game of Shapley values."""
    ship: ShipParams = getattr(pilot, "ship", SHIPS["paper"])
    seen, limit = observation(ship, ships), ship.rudder_limit_rad

    def once() -> None:
        if isinstance(pilot, LearnedPilot) and what in GAMES:
            found = shapley_by_ship(GAMES[what], pilot.actor, pilot.critic, seen, limit)
        else:
            found = glasshelm.explain(pilot, seen)
        jax.block_until_ready(found)

    for _ in range(20):
        once()
    took = np.empty(calls)
    for i in range(calls):
        before = time.perf_counter()
        once()
        took[i] = time.perf_counter() - before
    p50, p95, p99 = 1e3 * np.percentile(took, [50, 95, 99])
    return f"| {pilot.name} | {what} | {ships} | {p50:.2f} | {p95:.2f} | {p99:.2f} | {calls} |"


def machine() -> str:
    """The processor's name."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pilot", help="any pilot")
    parser.add_argument("--calls", type=int, default=1000)
    args = parser.parse_args()
    chosen = pilot_named(args.pilot) if args.pilot else paper_sized()
    print(f"{machine()}, one core\n\n{HEAD}")
    for count in (6, 20):
        print(measure("decision", chosen, count, args.calls))
    for game in GAMES if isinstance(chosen, LearnedPilot) else ():
        for count in (6, 10):
            print(measure(game, chosen, count, args.calls))
