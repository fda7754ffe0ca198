"""Everything that can be set in a training, and the presets."""

import dataclasses
import json
from typing import Any, Literal

import msgspec

from glasshelm.core.errors import InputError
from glasshelm.env.step import EnvSettings
from glasshelm.networks.actors import ActorSizes
from glasshelm.networks.critics import CriticSizes
from glasshelm.planning.course_planner import CourseSettings
from glasshelm.training.analytic_policy_gradient import AnalyticSettings
from glasshelm.training.dagger import ImitationSettings
from glasshelm.training.ddpg import DdpgSettings
from glasshelm.training.exploration import NoiseSettings
from glasshelm.training.losses import ActorLossSettings, CriticTraining


@dataclasses.dataclass(frozen=True)
class TrainConfig:
    """One training, resolved: saved in every checkpoint, enough to build the networks again.

    ``way`` is ``ddpg`` (actor and critics by DDPG, the paper's way) or
    ``analytic`` (actor by a teacher's lessons and by gradients through the
    world, then critics evaluated on it with the program of ``ddpg`` in which
    ``actor_update`` is false). The stages in order: imitation, actor, critic;
    ``ddpg`` counts as the last.
    """

    preset: str
    way: Literal["ddpg", "analytic"]
    actor: Literal["sum", "attention"] = "sum"
    critic: CriticTraining = "sum"
    ship: str = "paper"
    seed: int = 0
    #: Path of a weights file whose actor the training begins with; of several, separated by
    #: commas, the mean of their actors (:mod:`glasshelm.training.init_actor`); none: a new actor.
    start: str | None = None
    actor_sizes: ActorSizes = dataclasses.field(default_factory=ActorSizes)
    critic_sizes: CriticSizes = dataclasses.field(default_factory=CriticSizes)
    ddpg: DdpgSettings = dataclasses.field(default_factory=DdpgSettings)
    imitation: ImitationSettings = dataclasses.field(default_factory=ImitationSettings)
    analytic: AnalyticSettings = dataclasses.field(default_factory=AnalyticSettings)
    #: Share of a time budget after which each stage ends, in order of the stages.
    time_shares: tuple[float, float, float] = (0.45, 0.85, 1.0)
    #: Units between two evaluations, in order of the stages (iterations, iterations, cycles).
    units_between: tuple[int, int, int] = (10, 50, 1000)
    #: Size of the fixed evaluation set; short and long voyages in steps.
    evaluation_worlds: int = 256
    evaluation_steps: tuple[int, int] = (240, 480)


_FINE_ACTOR = ActorSizes((128, 128, 64), (128, 128, 64), (64, 64), "fine")
_FINE_CRITIC = CriticSizes((128, 128, 64), norm=True, lens="fine")
_BRIEF = EnvSettings(episode_steps=24)

PRESETS: dict[str, TrainConfig] = {
    # Table A.6 to the letter.
    "paper": TrainConfig("paper", "ddpg"),
    # A pilot with 1.8 % of intrusions (five seeds), in half an hour of one free core
    # (docs/explanation/training.md).
    "fast": TrainConfig(
        "fast",
        "analytic",
        actor_sizes=_FINE_ACTOR,
        critic_sizes=_FINE_CRITIC,
        critic="heads",
        imitation=ImitationSettings(
            # Farther off than the planner itself keeps: the actor will lose some of it.
            CourseSettings(danger_margin=0.4),
            iterations=100,
            updates=200,
            kept=16,
        ),
        # Gradients after lessons did harm (docs/results/training-choices.md, L8).
        analytic=AnalyticSettings(iterations=0),
        ddpg=DdpgSettings(
            env_steps=2_000_000,
            batch=256,
            # The pilot acts 10 to 20 minutes before a meeting: its critics must see as far.
            discount=0.995,
            world=EnvSettings(episode_steps=480),
            # With γ = 0.995 the mean value approaches at rate·(1 − γ) an update: 0.005 is too slow.
            target_rate=0.05,
            learning_rate_end=0.05,
            replay=500_000,
            actor_update=False,
            # Every four minutes or so a rudder drawn at random is held for about a minute.
            follows="lapses",
            noise=NoiseSettings("bursts", burst_begin=0.02, burst_end=0.08),
        ),
    ),
    # The paper's algorithm at a size that a CPU trains in half an hour.
    "ddpg": TrainConfig(
        "ddpg",
        "ddpg",
        actor_sizes=_FINE_ACTOR,
        critic_sizes=_FINE_CRITIC,
        ddpg=DdpgSettings(
            env_steps=2_500_000,
            batch=256,
            # A quarter of the paper's updates: its 0.001 would still lag behind at their end.
            target_rate=0.005,
            replay=500_000,
            # σ 0.30 wanders beyond ± 2: the rudder would be hard over most of the time.
            noise=NoiseSettings(sigma=0.1),
            actor_loss=ActorLossSettings(noise_shared=True),
        ),
    ),
    # Seconds: for tests of the machinery, not for pilots.
    "tiny": TrainConfig(
        "tiny",
        "ddpg",
        actor_sizes=ActorSizes((8, 8), (8,), (4,)),
        critic_sizes=CriticSizes((8,), norm=True),
        ddpg=DdpgSettings(
            env_steps=1000,
            train_interval=10,
            batch=16,
            replay=1000,
            critic_from=200,
            actor_from=200,
            worlds=10,
            world=_BRIEF,
            pool=16,
            pool_cycles=20,
        ),
        units_between=(1, 10, 20),
        evaluation_worlds=16,
        evaluation_steps=(12, 24),
    ),
    "tiny-fast": TrainConfig(
        "tiny-fast",
        "analytic",
        actor_sizes=ActorSizes((8, 8), (8,), (4,), "fine"),
        critic_sizes=CriticSizes((8,), norm=True, lens="fine"),
        ddpg=DdpgSettings(
            env_steps=600,
            train_interval=10,
            batch=16,
            replay=1000,
            critic_from=200,
            worlds=10,
            world=_BRIEF,
            pool=16,
            pool_cycles=20,
            actor_update=False,
            noise=NoiseSettings("bursts"),
        ),
        imitation=ImitationSettings(
            CourseSettings(
                (-60.0, 60.0), (300.0,), (), (), keep_s=(), horizon_s=600.0, step_s=20.0
            ),
            stretches=3,
            iterations=3,
            updates=4,
            kept=2,
        ),
        analytic=AnalyticSettings((1, 1, 1, 1, 1, 1, 1), decisions=6, iterations=30),
        units_between=(1, 10, 10),
        evaluation_worlds=16,
        evaluation_steps=(12, 24),
    ),
}


def preset_named(name: str) -> TrainConfig:
    """The preset of that name; InputError names the presets if there is none."""
    if name not in PRESETS:
        raise InputError(f"unknown preset {name!r}: choose one of {', '.join(PRESETS)}")
    return PRESETS[name]


def config_to_dict(config: TrainConfig) -> dict[str, Any]:
    """The configuration as plain JSON values."""
    return msgspec.to_builtins(config)


def config_from_dict(values: dict[str, Any]) -> TrainConfig:
    """The configuration that :func:`config_to_dict` wrote; InputError if it is not one."""
    try:
        return msgspec.convert(values, TrainConfig, strict=False)
    except msgspec.ValidationError as error:
        raise InputError(f"bad training configuration: {error}") from None


def override(config: TrainConfig, settings: tuple[str, ...]) -> TrainConfig:
    """The configuration with fields replaced: ``ddpg.batch=512``, ``actor_sizes.head=[64,64]``.

    InputError names the field that is not there, with those that are.
    """
    values = config_to_dict(config)
    for setting in settings:
        name, equals, text = setting.partition("=")
        if not equals:
            raise InputError(f"bad setting {setting!r}: write FIELD=VALUE, as in ddpg.batch=512")
        at: Any = values
        owner: dict[str, Any] = values
        last = name.split(".")[-1]
        for part in name.split("."):
            if not isinstance(at, dict) or part not in at:
                known = ", ".join(at) if isinstance(at, dict) else "no field here"
                raise InputError(f"unknown setting {name!r}: {part!r} is none of: {known}")
            owner, at = at, at[part]
        owner[last] = _value(text)
    return config_from_dict(values)


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text
