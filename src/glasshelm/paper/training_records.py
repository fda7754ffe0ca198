"""What is known of how a pilot was trained: its configuration and its log."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from glasshelm.core.errors import InputError
from glasshelm.figures.learning_curves import LearningCurve
from glasshelm.networks.checkpoint import read_header
from glasshelm.pilots.registry import SUFFIX, WEIGHTS
from glasshelm.training.config import TrainConfig, config_from_dict
from glasshelm.training.metrics_log import read_metrics


def weights_path(name: str) -> Path:
    """The weights file of a learned pilot, by its bundled name or path."""
    return Path(name) if name.endswith(SUFFIX) else WEIGHTS / f"{name}{SUFFIX}"


def train_config(path: Path) -> TrainConfig | None:
    """The configuration in the header of a weights file; None if it has none of this version."""
    try:
        return config_from_dict(read_header(path)["config"])
    except (KeyError, InputError):
        return None


def learning_curve(path: Path, name: str) -> LearningCurve | None:
    """The validations of a training, from the record or the log beside its weights.

    Steps of trainings that went on from one another are counted together; those of critics
    alone, in which the pilot does not change, are left out. None if there is no record.
    """
    lines, before = [], 0.0
    for part in _curves(path):
        kept = [line for line in part if "intrusions" in line and line.get("stage") != "critic"]
        lines += [(before + line["env_steps"], line) for line in kept]
        before = lines[-1][0] if kept else before
    if len(lines) < 2:
        return None
    returns = [line["return_waypoint"] + line["return_collision"] for _, line in lines]
    return LearningCurve(
        name,
        np.array([steps for steps, _ in lines], float),
        np.array([line["intrusions"] for _, line in lines], float),
        np.array(returns, float),
    )


def _curves(path: Path) -> list[list[dict[str, Any]]]:
    record = path.with_suffix(".json")
    if not record.is_file():
        return [read_metrics(path.parent)]
    try:
        return [part["curve"] for part in json.loads(record.read_text(encoding="utf-8"))["parts"]]
    except (ValueError, KeyError, TypeError):
        return []
