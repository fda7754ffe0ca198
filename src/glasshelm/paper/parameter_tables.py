"""Tables A.1-A.6: the paper's values beside those of the presets and of trained pilots."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax

from glasshelm.figures.network_diagrams import activation_name
from glasshelm.networks.actors import AttentionActor, SumActor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.networks.mlp import LEAK, Mlp
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.training.config import TrainConfig, preset_named

#: Layers of Tables A.1-A.5 as printed.
_CRITIC = ("256", "ReLU", "256", "ReLU", "128", "ReLU", "1")
_ENCODER = ("256", "leaky ReLU", "256", "leaky ReLU", "128")
_HEAD = ("256", "leaky ReLU", "256", "leaky ReLU", "128", "leaky ReLU", "1", "softsign")
_SMALLER = "smaller, so that it trains on a CPU"
_NORM = "LayerNorm before every activation: without it the critic's values ran away"


@dataclasses.dataclass(frozen=True)
class ParameterRow:
    """A row: the paper's value, and a value for each column with why it differs, or nothing."""

    name: str
    paper: str
    values: tuple[str, ...]
    reasons: tuple[str, ...]


@dataclasses.dataclass(frozen=True)
class ParameterTable:
    """A table of the paper beside ours, of which ``columns`` names each."""

    number: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[ParameterRow, ...]


def parameter_tables(trained: Sequence[tuple[LearnedPilot, TrainConfig]]) -> list[ParameterTable]:
    """Tables A.1 to A.6.

    Args:
        trained: Pilots with the configuration that they were trained with; a column each, beside
            that of the preset ``paper``.
    """
    preset = preset_named("paper")
    columns = ("preset paper", *(pilot.name for pilot, _ in trained))
    critics = [_shape(SubTaskCritic, preset.critic_sizes), *(pilot.critic for pilot, _ in trained)]
    actors = [_shape(SumActor, preset.actor_sizes), *(pilot.actor for pilot, _ in trained)]
    attention = _shape(AttentionActor, preset.actor_sizes)
    table = [
        _layers("A.1", "Q_wp", _CRITIC, columns, [c and c.of_waypoint for c in critics]),
        _layers("A.2", "Q_ca", _CRITIC, columns, [c and c.of_target for c in critics]),
        _layers("A.3", "E_wp", _ENCODER, columns, [a.encode_waypoint for a in actors]),
        _layers("A.4", "E_oth", _ENCODER, columns, [a.encode_target for a in actors]),
        _layers("A.5", "A", _HEAD, columns, [a.head for a in actors], last="softsign"),
    ]
    scores = [attention.score, *(getattr(a, "score", None) for a in actors[1:])]
    settings = [preset, *(config for _, config in trained)]
    return [*table, _settings(columns, settings, scores)]


def _shape(kind: Any, sizes: Any) -> Any:
    """A network of these sizes, of which only the shapes are there."""
    return eqx.filter_eval_shape(kind, sizes, jax.random.key(0))


def _layers(
    number: str,
    name: str,
    paper: Sequence[str],
    columns: tuple[str, ...],
    networks: Sequence[Mlp | None],
    last: str = "",
) -> ParameterTable:
    ours = [[] if mlp is None else [*_layer_names(mlp), *([last] if last else [])]
            for mlp in networks]  # fmt: skip
    rows = []
    for place, layer in enumerate(paper):
        values = [layers[place] if place < len(layers) else "none" for layers in ours]
        kind = "fully connected" if layer.isdigit() else "activation"
        rows.append(_row(kind, layer, values, [_SMALLER if v.isdigit() else _NORM for v in values]))
    return ParameterTable(number, f"Layers of {name}", columns, tuple(rows))


def _layer_names(mlp: Mlp) -> list[str]:
    between = f"LayerNorm, {activation_name(mlp)}" if mlp.norm else activation_name(mlp)
    widths = [str(weight.shape[1]) for weight in mlp.weights]
    names = [part for width in widths[:-1] for part in (width, between)]
    return [*names, widths[-1]]


def _row(name: str, paper: str, values: Sequence[str], reasons: Sequence[str]) -> ParameterRow:
    marks = tuple(
        "" if value == paper else reason for value, reason in zip(values, reasons, strict=True)
    )
    return ParameterRow(name, paper, tuple(values), marks)


def _settings(
    columns: tuple[str, ...], configs: Sequence[TrainConfig], scores: Sequence[Mlp | None]
) -> ParameterTable:
    """Table A.6, and below it what the paper leaves open."""
    less = "fewer, so that it trains on a CPU"
    faster = "with fewer updates, 0.001 would still lag behind at their end"
    imitated = "the actor imitates a planner; only its critics are trained so"
    d = [config.ddpg for config in configs]
    rows = [
        ("learning steps", "10,000,000", [f"{s.env_steps:,}" for s in d], less),
        ("train interval", "100", [str(s.train_interval) for s in d], ""),
        ("learning rate", "0.001", [_rate(s) for s in d], "falls along a cosine"),
        ("target update rate", "0.001", [f"{s.tau:g}" for s in d], faster),
        ("batch size", "1024", [str(s.batch_size) for s in d], _SMALLER),
        ("optimizer", "Adam", ["Adam"] * len(d), ""),
        ("discount", "0.98", [f"{s.discount:g}" for s in d],
         "an early manoeuvre needs a longer view"),
        ("λ_reg", "0.001", [f"{s.actor_loss.regularisation:g}" for s in d], imitated),
        ("λ_s", "0.005", [f"{s.actor_loss.smoothing:g}" for s in d], imitated),
        ("λ_a", "0.0001", [f"{s.actor_loss.action_size:g}" for s in d], imitated),
        ("leak of the leaky ReLU", "0.1", [f"{LEAK:g}"] * len(d), ""),
        ("how the actor learns", "ddpg", [c.algorithm for c in configs], imitated),
        ("loss of the critic", "sum", [c.critic for c in configs],
         "one error a sub-task: a sum alone mixes them"),
        ("input", "flat", [c.actor_sizes.lens for c in configs],
         "the same frames through a fixed change of variables, differences magnified"),
        ("steps of an episode", "240", [str(s.env.episode_steps) for s in d],
         "half of the planned conflicts come after 1200 s"),
        ("replay buffer", "not given", [f"{s.replay_size:,}" for s in d], ""),
        ("exploration", "not given", [_noise(c) for c in configs], ""),
        ("attention", "not given", ["none" if m is None else " → ".join(
            str(w.shape[1]) for w in m.weights) for m in scores], ""),
    ]  # fmt: skip
    done = []
    for name, paper, values, reason in rows:
        reasons = [reason if paper != "not given" else "the paper does not say"] * len(values)
        done.append(_row(name, paper, values, reasons))
    return ParameterTable("A.6", "Hyperparameters", columns, tuple(done))


def _rate(settings: Any) -> str:
    falls = settings.learning_rate_end != 1.0
    end = f" → {settings.learning_rate * settings.learning_rate_end:g}" if falls else ""
    return f"{settings.learning_rate:g}{end}"


def _noise(config: TrainConfig) -> str:
    noise = config.ddpg.noise
    if noise.kind == "ou":
        return f"OU, σ {noise.sigma:g} → {noise.sigma_end:g}"
    return f"a random rudder held, begun in {noise.burst_begin:.0%} to {noise.burst_end:.0%}"
