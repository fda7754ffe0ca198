"""How fast does DDPG learn here, and how much of it is matrix products?

    python benchmarks/training.py [--seconds 20] [--sb3]

One run measures, side by side: a large float32 matrix product (the peak), the
environments under an actor, and DDPG's cycle with the ``paper`` preset's networks and
batch (100 environment steps and one update). FLOPs are XLA's own count of the
compiled program. ``--sb3`` adds Stable-Baselines3's DDPG on the gymnasium
adapter with the same layers, batch and ratio of updates to steps.
Compile time is reported apart. Prints a Markdown table.
"""

import argparse
import itertools
import platform
import time
from collections.abc import Callable

import jax
import jax.numpy as jnp

from glasshelm.encounters.random_encounters import validation_encounters
from glasshelm.networks.actors import ActorSizes, make_actor
from glasshelm.networks.critics import CriticSizes, SubTaskCritic
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.rollout import plain_cases, rollout
from glasshelm.training.ddpg import DdpgSettings, encounter_pool, init_ddpg, run_cycle
from glasshelm.training.validation import Memoryless

SHIP = SHIPS["paper"]
SETTINGS = DdpgSettings(replay_size=100_000)


def per_call(function: Callable[[], object], seconds: float) -> float:
    """Seconds per call, the best of as many as fit."""
    jax.block_until_ready(function())
    best, end = float("inf"), time.perf_counter() + seconds
    while time.perf_counter() < end:
        started = time.perf_counter()
        jax.block_until_ready(function())
        best = min(best, time.perf_counter() - started)
    return best


def peak_flops(seconds: float, size: int = 2048) -> float:
    """FLOP/s of a plain large matrix product."""
    a = jax.random.normal(jax.random.key(0), (size, size))
    product = jax.jit(jnp.matmul)
    return 2 * size**3 / per_call(lambda: product(a, a), seconds)


def actor_steps_per_s(seconds: float) -> float:
    """Environment steps per second of 512 environments under the paper's sum actor."""
    encounters = validation_encounters(SHIP, 512)
    actor = make_actor("sum", ActorSizes(), jax.random.key(1))
    policy, cases = Memoryless(actor), plain_cases(encounters, SHIP, 60)
    return 512 * 60 / per_call(lambda: rollout(policy, cases, 60), seconds)


class Ddpg:
    """The jitted cycle, with and without learning."""

    def __init__(self, kind: str):
        actor = make_actor(kind, ActorSizes(), jax.random.key(1))
        critic = SubTaskCritic(CriticSizes(), jax.random.key(2))
        self.pool = encounter_pool(0, 0, SHIP, SETTINGS)
        state = init_ddpg(actor, critic, self.pool, SETTINGS)
        started = time.perf_counter()
        self.fill, self.learn = self._compiled(state, False), self._compiled(state, True)
        self.compile_s = time.perf_counter() - started
        for _ in range(40):
            state, _ = self.fill(state, self.pool)
        self.state = state

    def _compiled(self, state, learn: bool):
        def run(state, pool):
            return run_cycle(state, pool, learn, learn, 0, SHIP, SETTINGS, "sum")

        return jax.jit(run, donate_argnums=0).lower(state, self.pool).compile()

    def seconds(self, program, seconds: float) -> float:
        def once():
            self.state, report = program(self.state, self.pool)
            return report

        return per_call(once, seconds)

    @property
    def update_flops(self) -> float:
        """FLOPs that learning adds to a cycle."""
        counts = [p.cost_analysis()["flops"] for p in (self.learn, self.fill)]
        return counts[0] - counts[1]


def sb3_steps_per_s(steps: int) -> float:
    """Environment steps per second of Stable-Baselines3's DDPG, one update per hundred steps.

    Its networks have the layers of ours (an encoder for each target, their sum, a head);
    targets are padded to six, as it has no other way.
    """
    import gymnasium
    import torch
    from stable_baselines3 import DDPG
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

    import glasshelm.env.gymnasium_env  # noqa: F401

    def mlp(inputs: int) -> torch.nn.Sequential:
        widths = (inputs, *ActorSizes().encoder)
        layers = [
            part
            for a, b in itertools.pairwise(widths)
            for part in (torch.nn.Linear(a, b), torch.nn.LeakyReLU())
        ]
        return torch.nn.Sequential(*layers)

    class Encoder(BaseFeaturesExtractor):
        def __init__(self, space: gymnasium.Space):
            super().__init__(space, ActorSizes().encoder[-1])
            self.waypoint, self.target = mlp(15), mlp(50)

        def forward(self, flat: torch.Tensor) -> torch.Tensor:
            ships = (flat.shape[-1] - 15) // 51
            waypoint, targets, present = flat.split([15, 50 * ships, ships], dim=-1)
            traffic = self.target(targets.reshape(-1, ships, 50)) * present[..., None]
            return torch.nn.functional.softsign(self.waypoint(waypoint) + traffic.sum(1))

    model = DDPG(
        "MlpPolicy",
        gymnasium.make("glasshelm/Encounter-v0", flat=True),
        batch_size=1024,
        learning_starts=1024,
        train_freq=(100, "step"),
        gradient_steps=1,
        policy_kwargs={
            "net_arch": list(ActorSizes().head),
            "features_extractor_class": Encoder,
        },
        device="cpu",
    )
    model.learn(1100)
    started = time.perf_counter()
    model.learn(steps, reset_num_timesteps=False)
    return steps / (time.perf_counter() - started)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0, help="for each measurement")
    parser.add_argument("--sb3", action="store_true")
    arguments = parser.parse_args()
    rows = []
    for kind in ("sum", "attention"):
        ddpg = Ddpg(kind)
        peak = peak_flops(arguments.seconds / 4)
        fill = ddpg.seconds(ddpg.fill, arguments.seconds / 4)
        whole = ddpg.seconds(ddpg.learn, arguments.seconds)
        peak = max(peak, peak_flops(arguments.seconds / 4))
        update = whole - fill
        rows += [
            (f"peak matrix product (beside {kind})", f"{peak / 1e9:.1f} GFLOP/s"),
            (f"{kind}: compile", f"{ddpg.compile_s:.0f} s"),
            (f"{kind}: environment steps with training", f"{100 / whole:,.0f} /s"),
            (f"{kind}: updates", f"{1 / whole:.2f} /s"),
            (f"{kind}: FLOPs of an update", f"{ddpg.update_flops / 1e9:.2f} GFLOP"),
            (f"{kind}: update / peak", f"{100 * ddpg.update_flops / update / peak:.0f} %"),
            (f"{kind}: program around the update", f"{100 * fill / whole:.1f} % of the time"),
        ]
    rows.append(
        ("environments under the sum actor", f"{actor_steps_per_s(arguments.seconds):,.0f} /s")
    )
    if arguments.sb3:
        rows.append(
            (
                "Stable-Baselines3 DDPG (sum), steps with training",
                f"{sb3_steps_per_s(3000):,.0f} /s",
            )
        )
    machine = platform.processor() or platform.machine()
    print(f"| {machine}, jax {jax.__version__} | measured |\n|---|---|")
    for name, value in rows:
        print(f"| {name} | {value} |")


if __name__ == "__main__":
    main()
