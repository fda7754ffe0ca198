"""Glasshelm: explainable AI for ship collision avoidance.

The names below are the public interface; everything else may change. A name is loaded when it
is first used: importing the package imports no JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from glasshelm.api import evaluate, pilot, scenario, train
    from glasshelm.core.errors import InputError
    from glasshelm.encounters.random_encounters import RandomEncounters, random_encounter
    from glasshelm.encounters.types import Encounter, Motion, Scenario, TargetInfo, Track
    from glasshelm.env.observe import Observation, observe
    from glasshelm.env.rewards import Reward
    from glasshelm.env.step import EnvSettings, EnvState, StepResult, reset, step
    from glasshelm.env.target_selection import select_targets
    from glasshelm.explanation.coalitions import ShapleyValues
    from glasshelm.explanation.step_explanation import Explanation
    from glasshelm.frames.frame_log import read_log, write_log
    from glasshelm.frames.frame_parquet import to_parquet
    from glasshelm.frames.schema import Frame
    from glasshelm.networks.checkpoint import CheckpointError
    from glasshelm.networks.critics import QValues
    from glasshelm.pilots.batched import BatchedPilot
    from glasshelm.pilots.decide import explain
    from glasshelm.pilots.guarded import GuardedPilot
    from glasshelm.pilots.learned import LearnedPilot
    from glasshelm.pilots.protocols import Decision, Pilot
    from glasshelm.pilots.registry import load, pilot_names
    from glasshelm.ship.nomoto import SHIPS, ShipParams, ShipState
    from glasshelm.simulation.voyage import simulate
    from glasshelm.whatif.ask import WhatIfAnswer, what_if
    from glasshelm.whatif.changes import Deleted, Hidden, KeptCourse, Rudder
    from glasshelm.whatif.contrast import Contrast, why_not

#: Where each public name is defined.
_MODULES = {
    "api": ("evaluate", "pilot", "scenario", "train"),
    "core.errors": ("InputError",),
    "encounters.random_encounters": ("RandomEncounters", "random_encounter"),
    "encounters.types": ("Encounter", "Motion", "Scenario", "TargetInfo", "Track"),
    "env.observe": ("Observation", "observe"),
    "env.rewards": ("Reward",),
    "env.step": ("EnvSettings", "EnvState", "StepResult", "reset", "step"),
    "env.target_selection": ("select_targets",),
    "explanation.coalitions": ("ShapleyValues",),
    "explanation.step_explanation": ("Explanation",),
    "frames.frame_log": ("read_log", "write_log"),
    "frames.frame_parquet": ("to_parquet",),
    "frames.schema": ("Frame",),
    "networks.checkpoint": ("CheckpointError",),
    "networks.critics": ("QValues",),
    "pilots.batched": ("BatchedPilot",),
    "pilots.decide": ("explain",),
    "pilots.guarded": ("GuardedPilot",),
    "pilots.learned": ("LearnedPilot",),
    "pilots.protocols": ("Decision", "Pilot"),
    "pilots.registry": ("load", "pilot_names"),
    "ship.nomoto": ("SHIPS", "ShipParams", "ShipState"),
    "simulation.voyage": ("simulate",),
    "whatif.ask": ("WhatIfAnswer", "what_if"),
    "whatif.contrast": ("Contrast", "why_not"),
    "whatif.changes": ("Deleted", "Hidden", "KeptCourse", "Rudder"),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = ["__version__", *sorted(_HOME)]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    """A public name, loaded on first use and kept."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
