"""The 22 Imazu cases and the variants 8b and 12b, at 10 and at 12 knots."""

import dataclasses

import numpy as np

from glasshelm.encounters.imazu import imazu_cases, imazu_scenario
from glasshelm.evaluation.suites.batching import scenario_suite
from glasshelm.evaluation.types import Suite
from glasshelm.ship.nomoto import KNOT_M_S, ShipParams

SPEEDS_KN = (10.0, 12.0)
#: Every conflict is at 1800 s; as much again to get clear and come back.
DURATION_S = 3600.0


def imazu_suites(ship: ShipParams) -> list[Suite]:
    """Every case at each speed; all ships' speeds scale with own ship's."""
    suites = []
    for speed_kn in SPEEDS_KN:
        faster = dataclasses.replace(ship, speed_m_s=float(np.float32(speed_kn * KNOT_M_S)))
        scenarios = [
            dataclasses.replace(imazu_scenario(case, faster), duration_s=DURATION_S)
            for case in imazu_cases()
        ]
        note = f"The Imazu cases at {speed_kn:g} kn, TCPA 1800 s (8b, 12b: disputed variants)"
        suites.append(scenario_suite(f"imazu-{speed_kn:g}kn", note, scenarios))
    return suites
