"""Scenarios of different sizes as one batch of cases."""

import dataclasses
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Encounter, Scenario, Track
from glasshelm.evaluation.types import Suite
from glasshelm.simulation.rollout import SETTINGS, Case


def scenario_suite(
    name: str, note: str, scenarios: Sequence[Scenario], least_s: float = 0.0
) -> Suite:
    """A suite of scenarios, each on the ship and for the time that it says itself.

    At least ``least_s``. Slots and legs are filled up with nobody, routes with
    their last waypoint.
    """
    slots = max(s.encounter.present.shape[-1] for s in scenarios)
    legs = max(s.encounter.targets.start_s.shape[-1] for s in scenarios)
    points = max(s.encounter.route.x.shape[-1] for s in scenarios)
    cases = [_case(s, slots, legs, points, least_s) for s in scenarios]
    return Suite(
        name,
        note,
        jax.tree.map(lambda *leaves: np.stack(leaves), *cases),
        tuple(s.source for s in scenarios),
        tuple(s.targets for s in scenarios),
    )


def _case(scenario: Scenario, slots: int, legs: int, points: int, least_s: float) -> Case:
    encounter, ship = scenario.encounter, scenario.ship
    count, own_legs = encounter.targets.start_s.shape
    extra = ((0, slots - count), (0, legs - own_legs))

    def padded(field: str) -> Array:
        empty = np.inf if field in ("start_s", "end_s") else 0.0
        values = np.asarray(getattr(encounter.targets, field), np.float32)
        return jnp.asarray(np.pad(values, extra, constant_values=empty))

    def route(values: Array) -> Array:
        return jnp.pad(values, (0, points - values.shape[0]), mode="edge")

    loa, beam = float(ship.loa_m), float(ship.beam_m)
    known = [info.length_m or loa for info in scenario.targets]
    length = np.array(known + [loa] * (slots - len(known)), np.float32)
    case = Case(
        Encounter(
            encounter.own,
            Vector(route(encounter.route.x), route(encounter.route.y)),
            Track(**{field.name: padded(field.name) for field in dataclasses.fields(Track)}),
            jnp.pad(encounter.present, (0, slots - count)),
        ),
        jax.tree.map(jnp.float32, ship),
        jnp.asarray(round(max(scenario.duration_s, least_s) / SETTINGS.step_s), jnp.int32),
        length,
        length * np.float32(beam / loa),
    )
    return jax.tree.map(np.asarray, case)
