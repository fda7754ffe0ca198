"""Rollouts of a batch of encounters in one compiled program that keeps measures, not tracks.

Training selects models by them, ``glasshelm evaluate`` and the safety benchmark report them.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.colregs.compliance import MeetingFacts
from glasshelm.core.geometry import Vector, closest_approach, norm, velocity, wrap_angle
from glasshelm.encounters.types import Encounter, Motion
from glasshelm.env.observe import Observation
from glasshelm.env.step import (
    FAR_M,
    EnvSettings,
    EnvState,
    StepResult,
    observe_step,
    reset,
    targets_at,
)
from glasshelm.env.target_selection import select_targets
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.clairvoyant import OraclePilot
from glasshelm.pilots.protocols import BatchPolicy, Pilot
from glasshelm.planning.cross_entropy_search import KnownEncounter
from glasshelm.ship.course_reversals import Reversals
from glasshelm.ship.hull_overlap import hull, hull_gap_m
from glasshelm.ship.nomoto import ShipParams, ShipState, advance, with_drift
from glasshelm.simulation.sensor_model import (
    Disturbance,
    PerceivedTraffic,
    first_perception,
    next_perception,
)

SETTINGS = EnvSettings()
#: The first 1200 s, an episode of the paper's training (section 3.2), are measured apart.
EPISODE_STEPS = SETTINGS.episode_steps
#: A predicted CPA counts as shown to the navigator when it is this near in time.
DCPA_HORIZON_S = 360.0


#: Arrays of a batch stay on the host until they are simulated.
_Host = Float[Array, "..."] | Float[np.ndarray, "..."]
_Steps = Int[Array, "*b"] | Int[np.ndarray, "*b"]


class Case(eqx.Module):
    """An encounter to simulate, and own ship as it truly is; a batch has one more axis in front.

    Attributes:
        encounter: Own ship's start and route, and the targets' tracks.
        ship: Own ship's parameters; a pilot may have been trained for others.
        steps: How many steps of 5 s are measured.
        length_m: The targets' lengths, one a slot.
        beam_m: The targets' beams.
        disturbance: How the sensors err; None where the pilot sees the world as it is.
        episode_steps: How many steps are also measured apart.
    """

    encounter: Encounter
    ship: ShipParams
    steps: _Steps
    length_m: _Host
    beam_m: _Host
    disturbance: Disturbance | None = None
    episode_steps: int = eqx.field(static=True, default=EPISODE_STEPS)


class Measures(eqx.Module):
    """What is measured of a voyage. Definitions: docs/reference/suites.md.

    ``margin`` is the worst Eq. 13 (unclipped) of any target and ``range_m`` the least centre
    distance; index 0: in the first 1200 s, 1: in the whole voyage. ``hull_gap_m`` is negative
    where hulls overlapped, ``inside_s`` is the time with a target in the domain, ``dcpa_m`` the
    least DCPA that was ever 0 to 6 minutes ahead. ``return_by_task`` is undiscounted, over the
    first 1200 s.
    """

    margin: Float[Array, "*b 2"]
    range_m: Float[Array, "*b 2"]
    hull_gap_m: Float[Array, "*b"]
    inside_s: Float[Array, "*b"]
    dcpa_m: Float[Array, "*b"]
    return_by_task: Float[Array, "*b 2"]
    sailed_m: Float[Array, "*b"]
    left_at_start_m: Float[Array, "*b"]
    left_m: Float[Array, "*b"]
    turned_rad: Float[Array, "*b"]
    rudder: Float[Array, "*b"]
    rudder_moved_rad: Float[Array, "*b"]
    reversals: Reversals
    time_s: Float[Array, "*b"]
    arrived: Bool[Array, "*b"]
    finite: Bool[Array, "*b"]
    meetings: MeetingFacts


class CaseState(eqx.Module):
    """One case under way: the true world, what is perceived of it, the measures so far."""

    state: EnvState
    perceived: PerceivedTraffic | None
    measures: Measures


class Positions(eqx.Module):
    """Where all ships are at one instant, for a figure."""

    own: ShipState
    rudder_rad: Float[Array, "*b"]
    east_m: Float[Array, "*b n"]
    north_m: Float[Array, "*b n"]
    course_rad: Float[Array, "*b n"]
    speed_m_s: Float[Array, "*b n"]
    present: Bool[Array, "*b n"]


#: A batch of cases under way, and the memory of its policy.
_Carry = tuple[CaseState, Any]
Total = TypeVar("Total")


def policy_for(pilot: Pilot | OraclePilot, cases: Case) -> BatchPolicy:
    """What steers a batch of cases: a pilot from observations, an oracle from the whole case."""
    if not isinstance(pilot, OraclePilot):
        return BatchedPilot(pilot)
    still = Vector(jnp.zeros(cases.steps.shape), jnp.zeros(cases.steps.shape))
    current = still if cases.disturbance is None else cases.disturbance.current_m_s
    return pilot.policy_for(
        KnownEncounter(cases.encounter, cases.ship, jnp.asarray(cases.steps), current)
    )


def plain_cases(
    encounters: Encounter,
    ship: ShipParams,
    steps: int | _Steps,
    episode_steps: int = EPISODE_STEPS,
) -> Case:
    """Cases of a batch of encounters: targets as large as own ship, sensors without error."""
    shape = encounters.present.shape
    return Case(
        encounters,
        jax.tree.map(lambda x: jnp.full(shape[0], x, jnp.float32), ship),
        jnp.broadcast_to(jnp.asarray(steps, jnp.int32), shape[0]),
        jnp.full(shape, ship.loa_m, jnp.float32),
        jnp.full(shape, ship.beam_m, jnp.float32),
        episode_steps=episode_steps,
    )


def rollout(policy: BatchPolicy, cases: Case, steps: int) -> Measures:
    """Simulate a batch of cases under a policy.

    Args:
        policy: What steers.
        cases: The batch; each case is measured for its own number of steps.
        steps: At most so many steps are simulated. One program serves any number.
    """
    return _rollout(policy, cases, jnp.asarray(steps))


@eqx.filter_jit
def _rollout(policy: BatchPolicy, cases: Case, steps: Int[Array, ""]) -> Measures:
    start = _reset(policy, cases)
    state, _ = jax.lax.fori_loop(0, steps, lambda _, carry: _step(policy, cases, carry)[0], start)
    return state.measures


@eqx.filter_jit
def rollout_fold(
    policy: BatchPolicy,
    cases: Case,
    steps: Int[Array, ""],
    fold: Callable[[Total, Case, CaseState], Total],
    start: Total,
) -> tuple[CaseState, Total]:
    """:func:`rollout` that also folds every state into a total, e.g. of each target."""

    def go(_: Int[Array, ""], so_far: tuple[_Carry, Total]) -> tuple[_Carry, Total]:
        carry, total = so_far
        carry, _action = _step(policy, cases, carry)
        return carry, fold(total, cases, carry[0])

    (state, _), total = jax.lax.fori_loop(0, steps, go, (_reset(policy, cases), start))
    return state, total


@eqx.filter_jit
def rollout_tracks(policy: BatchPolicy, cases: Case, steps: int) -> Positions:
    """The same voyages as positions [steps + 1, cases], for drawing."""

    def go(carry: _Carry, _: None) -> tuple[_Carry, Positions]:
        following, action = _step(policy, cases, carry)
        return following, jax.vmap(positions)(cases, carry[0], action)

    (state, _), track = jax.lax.scan(go, _reset(policy, cases), length=steps)
    end = jax.vmap(positions)(cases, state, jnp.zeros(state.state.step.shape))
    return jax.tree.map(lambda a, b: jnp.concatenate([a, b[None]]), track, end)


def _reset(policy: BatchPolicy, cases: Case) -> _Carry:
    state = jax.vmap(reset_case)(cases)
    return state, policy.start(state.state.step.shape[0])


def _step(policy: BatchPolicy, cases: Case, carry: _Carry) -> tuple[_Carry, Float[Array, " w"]]:
    """One step of all cases, and the rudders decided."""
    state, memory = carry
    action, memory = policy(jax.vmap(observation)(cases, state), memory)
    return (jax.vmap(step_case)(cases, state, action), memory), action


def reset_case(case: Case) -> CaseState:
    """A case at t = 0, before anything is measured."""
    state = reset(case.encounter, case.ship, SETTINGS)
    perceived = None
    if case.disturbance is not None:
        perceived = first_perception(case.disturbance, case.encounter, case.encounter.own)
    return CaseState(state, perceived, _nothing(case, state))


def observation(case: Case, state: CaseState) -> Observation:
    """What the pilot observes: the most urgent targets, by the sensors if they err."""
    whole = state.state if state.perceived is None else state.perceived
    return select_targets(whole.observation, loa_m=case.ship.loa_m)[0]


def step_case(case: Case, state: CaseState, action: Float[Array, ""]) -> CaseState:
    """One step of a case; after its end the measures stay as they are."""
    finite = jnp.isfinite(action)
    rudder = jnp.where(finite, jnp.clip(action, -1.0, 1.0), 0.0) * case.ship.rudder_limit_rad
    own = advance(state.state.own, rudder, case.ship, SETTINGS.step_s)
    if case.disturbance is not None:
        own = with_drift(own, case.disturbance.current_m_s, SETTINGS.step_s)
    out = observe_step(case.encounter, state.state, own, case.ship, SETTINGS)
    perceived = state.perceived
    if case.disturbance is not None and perceived is not None:
        perceived = next_perception(
            case.disturbance, perceived, case.encounter, own, out.state.leg, out.state.step,
            SETTINGS.step_s,
        )  # fmt: skip
    measures = _measured(case, state, out, finite)
    goes_on = (state.state.step < case.steps) & ~state.measures.arrived
    kept = jax.tree.map(lambda new, old: jnp.where(goes_on, new, old), measures, state.measures)
    return CaseState(out.state, perceived, kept)


def positions(case: Case, state: CaseState, action: Float[Array, ""]) -> Positions:
    """Where all ships of a case are."""
    m = targets_at(case.encounter, state.state.step * SETTINGS.step_s)
    rudder = jnp.clip(action, -1.0, 1.0) * case.ship.rudder_limit_rad
    own = state.state.own
    return Positions(own, rudder, m.east_m, m.north_m, m.course_rad, m.speed_m_s, m.present)


def _nothing(case: Case, state: EnvState) -> Measures:
    """The measures before the first step; only risk of collision may exist already."""
    zero, far = jnp.zeros(()), jnp.full((), jnp.inf)
    left = _left_m(case, state)
    targets = targets_at(case.encounter, zero)
    meetings = MeetingFacts.initial(case.encounter.present.shape[-1])
    meetings = meetings.updated(state.own, _over_ground(case, state.own), zero, targets, zero)
    return Measures(
        jnp.full(2, -jnp.inf), jnp.full(2, jnp.inf), far, zero, far, jnp.zeros(2), zero, left, left,
        zero, zero, zero, Reversals.none(), zero, jnp.zeros((), bool), jnp.ones((), bool), meetings,
    )  # fmt: skip


def _measured(case: Case, state: CaseState, out: StepResult, finite: Bool[Array, ""]) -> Measures:
    """The measures with one more step in them."""
    before, m, own = state.state, state.measures, out.state.own
    time_s = out.state.step * SETTINGS.step_s
    early = out.state.step <= case.episode_steps
    counts = jnp.stack([early, jnp.ones_like(early)])
    targets = targets_at(case.encounter, time_s)
    worst = jnp.where(targets.present, out.margin, -jnp.inf).max(initial=-jnp.inf)
    nearest = jnp.where(targets.present, out.range_m, jnp.inf).min(initial=jnp.inf)
    turn = wrap_angle(own.heading_rad - before.own.heading_rad)
    moved = Vector(own.east_m - before.own.east_m, own.north_m - before.own.north_m)
    own_velocity = _over_ground(case, own)
    return Measures(
        jnp.where(counts, jnp.maximum(m.margin, worst), m.margin),
        jnp.where(counts, jnp.minimum(m.range_m, nearest), m.range_m),
        jnp.minimum(m.hull_gap_m, _hull_gap_m(case, own, targets)),
        m.inside_s + jnp.where(worst > 0, SETTINGS.step_s, 0.0),
        jnp.minimum(m.dcpa_m, _alarming_dcpa_m(own, own_velocity, targets)),
        m.return_by_task + early * out.reward.by_task,
        m.sailed_m + norm(moved),
        m.left_at_start_m,
        jnp.where(out.terminated, 0.0, _left_m(case, out.state)),
        m.turned_rad + jnp.abs(turn),
        m.rudder + jnp.abs(own.rudder_rad) / case.ship.rudder_limit_rad,
        m.rudder_moved_rad + jnp.abs(own.rudder_rad - before.own.rudder_rad),
        m.reversals.after(turn),
        time_s,
        m.arrived | out.terminated,
        m.finite & finite,
        m.meetings.updated(own, own_velocity, turn, targets, time_s),
    )


def _over_ground(case: Case, own: ShipState) -> Vector:
    """Own ship's true velocity over ground."""
    water = velocity(own.heading_rad, own.speed_m_s)
    if case.disturbance is None:
        return water
    current = case.disturbance.current_m_s
    return Vector(water.x + current.x, water.y + current.y)


def _hull_gap_m(case: Case, own: ShipState, targets: Motion) -> Float[Array, ""]:
    """The least gap between own hull and any other."""
    mine = hull(case.ship.loa_m, case.ship.beam_m)
    gaps = jax.vmap(
        lambda east, north, course, length, beam: hull_gap_m(
            mine,
            own.heading_rad,
            hull(length, beam),
            Vector(east - own.east_m, north - own.north_m),
            course,
        )
    )(targets.east_m, targets.north_m, targets.course_rad, case.length_m, case.beam_m)
    return jnp.where(targets.present, gaps, FAR_M).min(initial=FAR_M)


def _alarming_dcpa_m(own: ShipState, own_velocity: Vector, targets: Motion) -> Float[Array, ""]:
    """The least DCPA of the ships whose CPA is at most six minutes ahead."""
    theirs = velocity(targets.course_rad, targets.speed_m_s)
    cpa = closest_approach(
        Vector(targets.east_m - own.east_m, targets.north_m - own.north_m),
        Vector(theirs.x - own_velocity.x, theirs.y - own_velocity.y),
    )
    soon = targets.present & (cpa.tcpa_s > 0) & (cpa.tcpa_s <= DCPA_HORIZON_S)
    return jnp.where(soon, cpa.dcpa_m, jnp.inf).min(initial=jnp.inf)


def _left_m(case: Case, state: EnvState) -> Float[Array, ""]:
    """The way left along the route: to the waypoint steered for, and on to the last."""
    x, y = case.encounter.route
    ahead = Vector(x[state.leg] - state.own.east_m, y[state.leg] - state.own.north_m)
    legs = norm(Vector(jnp.diff(x), jnp.diff(y)))
    return norm(ahead) + jnp.where(jnp.arange(legs.shape[0]) >= state.leg, legs, 0.0).sum()
