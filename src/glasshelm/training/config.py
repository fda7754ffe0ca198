"""Everything that can be set in a training, and the presets."""

import dataclasses
import json
from typing import Any, Literal

import msgspec

from glasshelm.core.errors import InputError
from glasshelm.encounters.random_encounters import RandomEncounters
from glasshelm.env.step import EnvSettings
from glasshelm.networks.actors import ActorSizes
from glasshelm.networks.critics import CriticSizes
from glasshelm.planning.course_critic import CourseCriticSizes
from glasshelm.planning.learned_critic import ManoeuvreCriticSizes
from glasshelm.planning.manoeuvres import ManoeuvreTable
from glasshelm.planning.simulated_critic import ManoeuvreCosts
from glasshelm.training.course_learning import CourseLearningSettings
from glasshelm.training.dagger import DaggerSettings
from glasshelm.training.ddpg import DdpgSettings
from glasshelm.training.encounter_mix import EncounterMix
from glasshelm.training.exploration import NoiseSettings
from glasshelm.training.losses import ActorLossSettings, TdError
from glasshelm.training.manoeuvre_regression import RegressionSettings


@dataclasses.dataclass(frozen=True)
class TrainConfig:
    """One training, resolved; saved in every weights file that it writes.

    ``algorithm`` is ``ddpg`` (actor and critics by DDPG, as in the paper),
    ``dagger`` (the actor by DAgger, then critics evaluated on it with DDPG's
    program in which ``ddpg.actor_update`` is false) or ``regression`` (a critic of
    manoeuvres, which steers by its argmax: no actor). Or ``course``: the same, by its
    own experience alone.
    """

    preset: str
    algorithm: Literal["ddpg", "dagger", "regression", "course"]
    actor: Literal["sum", "attention"] = "sum"
    critic: TdError = "sum"
    ship: str = "paper"
    seed: int = 0
    #: Path of a weights file whose actor, or critic that steers, the training starts from; of
    #: several actors, separated by commas, their mean (:mod:`glasshelm.training.init_actor`);
    #: none: a new one.
    init_from: str | None = None
    actor_sizes: ActorSizes = dataclasses.field(default_factory=ActorSizes)
    critic_sizes: CriticSizes = dataclasses.field(default_factory=CriticSizes)
    ddpg: DdpgSettings = dataclasses.field(default_factory=DdpgSettings)
    dagger: DaggerSettings = dataclasses.field(default_factory=DaggerSettings)
    regression: RegressionSettings = dataclasses.field(default_factory=RegressionSettings)
    manoeuvre_critic: ManoeuvreCriticSizes = dataclasses.field(default_factory=ManoeuvreCriticSizes)
    course: CourseLearningSettings = dataclasses.field(default_factory=CourseLearningSettings)
    course_sizes: CourseCriticSizes = dataclasses.field(default_factory=CourseCriticSizes)
    #: Share of a time budget after which DAgger ends.
    dagger_time_share: float = 0.45
    #: Iterations of DAgger, regression or courses and cycles of DDPG between two validations.
    iterations_between: int = 10
    cycles_between: int = 1000
    #: Episodes of the fixed validation set; steps in which critics are compared, and of all.
    validation_episodes: int = 256
    validation_steps: tuple[int, int] = (240, 480)

    @property
    def encounters(self) -> RandomEncounters:
        """The distribution of encounters that the actor is trained on."""
        if self.algorithm == "ddpg":
            return self.ddpg.encounters
        mixes = {"regression": self.regression.mix, "course": self.course.mix}
        mix = mixes.get(self.algorithm, self.dagger.mix)
        return mix.with_targets(mix.distributions[0])

    @property
    def env(self) -> EnvSettings:
        """The decision process that it is trained in."""
        if self.algorithm == "regression":
            steps = self.regression.decisions * self.regression.hold_steps
            return dataclasses.replace(self.ddpg.env, episode_steps=steps)
        if self.algorithm == "course":
            steps = self.course.decisions * self.course.hold_steps
            return dataclasses.replace(self.ddpg.env, episode_steps=steps)
        return self.ddpg.env


_FINE_ACTOR = ActorSizes((128, 128, 64), (128, 128, 64), (64, 64), "fine")
_FINE_CRITIC = CriticSizes((128, 128, 64), norm=True, lens="fine")
_TINY = TrainConfig(
    "tiny",
    "ddpg",
    actor_sizes=ActorSizes((8, 8), (8,), (4,)),
    critic_sizes=CriticSizes((8,), norm=True),
    ddpg=DdpgSettings(
        env_steps=1000,
        train_interval=10,
        batch_size=16,
        replay_size=1000,
        critic_starts=200,
        actor_starts=200,
        num_envs=10,
        env=EnvSettings(episode_steps=24),
        pool_size=16,
        pool_cycles=20,
    ),
    cycles_between=20,
    validation_episodes=16,
    validation_steps=(12, 24),
)

PRESETS: dict[str, TrainConfig] = {
    # Table A.6 to the letter.
    "paper": TrainConfig("paper", "ddpg"),
    # A pilot with 1.8 % of intrusions (five seeds), in half an hour of one free core
    # (docs/explanation/training.md).
    "fast": TrainConfig(
        "fast",
        "dagger",
        actor_sizes=_FINE_ACTOR,
        critic_sizes=_FINE_CRITIC,
        critic="heads",
        dagger=DaggerSettings(
            # Farther off than the glassbox pilot keeps: the actor will lose some of it.
            costs=ManoeuvreCosts(danger_margin=0.4),
            iterations=100,
            updates=200,
            dataset_iterations=16,
        ),
        ddpg=DdpgSettings(
            env_steps=2_000_000,
            batch_size=256,
            # The pilot acts 10 to 20 minutes before a meeting: its critics must see as far.
            discount=0.995,
            env=EnvSettings(episode_steps=480),
            # With γ = 0.995 the mean value approaches at τ·(1 − γ) per update: 0.005 is too slow.
            tau=0.05,
            learning_rate_end=0.05,
            replay_size=500_000,
            actor_update=False,
            # Every four minutes or so a rudder drawn at random is held for about a minute.
            target="sarsa",
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
            batch_size=256,
            # A quarter of the paper's updates: its 0.001 would still lag behind at their end.
            tau=0.005,
            replay_size=500_000,
            # σ 0.30 wanders beyond ± 2: the rudder would be hard over most of the time.
            noise=NoiseSettings(sigma=0.1),
            actor_loss=ActorLossSettings(noise_shared=True),
        ),
    ),
    # Sub-task critics of manoeuvres, whose argmax steers (docs/explanation/glassbox.md).
    "glassbox": TrainConfig("glassbox", "regression", iterations_between=20),
    # No teacher, no model, no actor: a critic of courses steers by its argmax
    # (docs/explanation/training.md).
    "course": TrainConfig("course", "course", iterations_between=30),
    # Seconds: for tests of the machinery, not for pilots.
    "tiny": _TINY,
    "tiny-glassbox": dataclasses.replace(
        _TINY,
        preset="tiny-glassbox",
        algorithm="regression",
        manoeuvre_critic=ManoeuvreCriticSizes(
            (8,),
            table=ManoeuvreTable((-60.0, 60.0), (300.0,), (), (), keep_s=(300.0,)),
            costs=ManoeuvreCosts(horizon_s=600.0),
        ),
        regression=RegressionSettings(
            EncounterMix((1, 1, 1)),
            decisions=4,
            explore_decisions=2,
            stride=2,
            dataset_iterations=2,
            iterations=3,
            updates=4,
            batch_rows=16,
        ),
        iterations_between=1,
    ),
    "tiny-course": dataclasses.replace(
        _TINY,
        preset="tiny-course",
        algorithm="course",
        course=CourseLearningSettings(
            EncounterMix((1, 1, 1)),
            decisions=4,
            labelled=3,
            begins_before=2,
            dataset_iterations=2,
            iterations=3,
            updates=4,
            batch_rows=16,
        ),
        course_sizes=CourseCriticSizes(
            (8,), (8,), table=ManoeuvreTable((-60.0, 60.0), (300.0,), (), (), keep_s=(300.0,))
        ),
        iterations_between=1,
    ),
    "tiny-fast": dataclasses.replace(
        _TINY,
        preset="tiny-fast",
        algorithm="dagger",
        actor_sizes=dataclasses.replace(_TINY.actor_sizes, lens="fine"),
        critic_sizes=dataclasses.replace(_TINY.critic_sizes, lens="fine"),
        ddpg=dataclasses.replace(
            _TINY.ddpg, env_steps=600, actor_update=False, noise=NoiseSettings("bursts")
        ),
        dagger=DaggerSettings(
            ManoeuvreTable((-60.0, 60.0), (300.0,), (), (), keep_s=()),
            ManoeuvreCosts(horizon_s=600.0),
            EncounterMix((1, 1, 1, 1, 1, 1, 1)),
            segments=3,
            iterations=3,
            updates=4,
            dataset_iterations=2,
        ),
        iterations_between=1,
        cycles_between=10,
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


def with_settings(config: TrainConfig, settings: tuple[str, ...]) -> TrainConfig:
    """The configuration with fields replaced.

    Args:
        config: The configuration to start from.
        settings: ``FIELD=VALUE`` each: ``ddpg.tau=0.01``, ``actor_sizes.head=[64,64]``.

    Raises:
        InputError: A field is not there (the message names those that are), or a value is bad.
    """
    values = config_to_dict(config)
    for setting in settings:
        name, equals, text = setting.partition("=")
        if not equals:
            raise InputError(f"bad setting {setting!r}: write FIELD=VALUE, as in ddpg.tau=0.01")
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
