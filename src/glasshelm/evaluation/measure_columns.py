"""Measures as columns: one row an encounter and pilot, and one row a meeting."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from glasshelm.colregs.classification import EncounterType
from glasshelm.core.errors import InputError
from glasshelm.evaluation.contenders import Contender
from glasshelm.evaluation.result_cache import Columns, Job
from glasshelm.evaluation.types import Suite
from glasshelm.ship.course_reversals import WEAVING
from glasshelm.ship.nomoto import NAUTICAL_MILE_M
from glasshelm.simulation.rollout import SETTINGS


@dataclasses.dataclass(frozen=True)
class SuiteResult:
    """A suite simulated with one seed of a contender: columns by name, in the suite's order.

    ``meetings`` has one row a target with which there was risk of collision;
    its ``case`` is the row of the encounter.
    """

    suite: Suite
    contender: Contender
    seed: int
    columns: Columns
    meetings: Columns

    @property
    def weights(self) -> str:
        return self.contender.weights[self.seed]


def assemble(
    suite: Suite, contender: Contender, seed: int, parts: list[tuple[Job, Columns]]
) -> SuiteResult:
    """The parts of one seed put together. InputError if the pilot gave no number somewhere."""
    order = np.concatenate([job.indices for job, _ in parts])
    back = np.argsort(order)
    measures = {
        name: np.concatenate([part[name] for _, part in parts])[back] for name in parts[0][1]
    }
    if not measures["finite"].all():
        label = suite.labels[int(np.argmin(measures["finite"]))]
        raise InputError(
            f"pilot {contender.name!r} gave a rudder that is no number, "
            f"first in {suite.name} {label}"
        )
    return SuiteResult(suite, contender, seed, _columns(suite, measures), _meetings(measures))


def _columns(suite: Suite, measures: Mapping[str, np.ndarray]) -> Columns:
    """The measures of docs/reference/suites.md, by their names there."""
    ship, encounter = suite.cases.ship, suite.cases.encounter
    loa = np.asarray(ship.loa_m)[:, None]
    ships = np.asarray(encounter.present).sum(-1)
    margin, range_m = measures["margin"], measures["range_m"]
    steps = np.maximum(measures["time_s"] / SETTINGS.step_s, 1.0)
    minutes = steps * SETTINGS.step_s / 60.0
    progress = measures["left_at_start_m"] - measures["left_m"]
    collided, intruded = range_m < loa, margin > 0
    return {
        "ships": ships.astype(np.int32),
        "time_s": measures["time_s"],
        "arrived": measures["arrived"],
        "collided": collided[:, 1],
        "collided_1200s": collided[:, 0],
        "hulls_touched": measures["hull_gap_m"] < 0,
        "intruded": intruded[:, 1],
        "intruded_1200s": intruded[:, 0],
        "depth": np.maximum(margin[:, 1], 0.0),
        "margin": margin[:, 1],
        "inside_s": measures["inside_s"],
        "nearest_m": range_m[:, 1],
        "within_1nm": range_m[:, 1] < NAUTICAL_MILE_M,
        "within_half_nm": range_m[:, 1] < 0.5 * NAUTICAL_MILE_M,
        "dcpa_m": measures["dcpa_m"],
        "return_waypoint": measures["return_by_task"][:, 0],
        "return_collision": measures["return_by_task"][:, 1],
        "return_total": measures["return_by_task"].sum(-1),
        "progress_m": progress,
        "sailed_m": measures["sailed_m"],
        "detour_m": measures["sailed_m"] - progress,
        "turned_deg": np.degrees(measures["turned_rad"]),
        "rudder": measures["rudder"] / steps,
        "rudder_moved_deg_min": np.degrees(measures["rudder_moved_rad"]) / minutes,
        "reversals": measures["reversals.count"],
        "weaving": measures["reversals.count"] >= WEAVING,
    }


def _meetings(measures: Mapping[str, np.ndarray]) -> Columns:
    """The facts of every meeting, flat."""
    prefix = "meetings."
    facts = {n.removeprefix(prefix): v for n, v in measures.items() if n.startswith(prefix)}
    case, slot = np.nonzero(facts["kind"] != EncounterType.NONE)
    left_out = ("turned_rad", "across_m")
    flat = {name: v[case, slot] for name, v in facts.items() if name not in left_out}
    together = np.bincount(case, minlength=len(facts["kind"]))[case]
    return {"case": case, "slot": slot, "meetings_of_voyage": together, **flat}
