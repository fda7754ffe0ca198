"""Sailing a batch of cases in one compiled program that keeps measures, not tracks."""

from collections.abc import Callable
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from glasshelm.colregs.classification import Meetings
from glasshelm.core.geometry import Vector, closest_approach, norm, velocity, wrap_angle
from glasshelm.encounters.types import Motion
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
from glasshelm.evaluation.sensor_model import Picture, first_picture, next_picture
from glasshelm.evaluation.types import Case
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.clairvoyant import OraclePilot
from glasshelm.pilots.protocols import BatchPolicy, Pilot
from glasshelm.planning.cross_entropy_search import KnownEncounter
from glasshelm.ship.course_reversals import Reversals
from glasshelm.ship.hull_overlap import hull, hull_gap_m
from glasshelm.ship.nomoto import ShipState, advance, with_drift

SETTINGS = EnvSettings()
#: The first 1200 s, an episode of the paper's training (section 3.2), are measured apart.
SHORT_STEPS = SETTINGS.episode_steps
#: A predicted CPA counts as shown to the navigator when it is this near in time.
ALARM_S = 360.0


class Measures(eqx.Module):
    """What a voyage has come to. Definitions: docs/reference/suites.md.

    Of all ships, index 0: in the first 1200 s, 1: in the whole voyage: the
    worst ``margin`` (Eq. 13, unclipped) and the least centre distance ``range_m``.
    ``hull_gap_m`` is negative where hulls overlapped; ``inside_s`` the time
    with a ship in the domain; ``dcpa_m`` the least DCPA that was ever 0 to 6
    minutes ahead; ``return_by_task`` undiscounted over the first 1200 s.
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
    meetings: Meetings


class Live(eqx.Module):
    """One case under way: the true world, the picture of it, the measures so far."""

    state: EnvState
    picture: Picture | None
    measures: Measures


class Place(eqx.Module):
    """Where everybody is at one instant, for a figure."""

    own: ShipState
    rudder_rad: Float[Array, "*b"]
    east_m: Float[Array, "*b n"]
    north_m: Float[Array, "*b n"]
    course_rad: Float[Array, "*b n"]
    speed_m_s: Float[Array, "*b n"]
    present: Bool[Array, "*b n"]


#: Batches of cases under way, and what the pilots remember.
_Carry = tuple[Live, Any]
Total = TypeVar("Total")


def helm_for(pilot: Pilot | OraclePilot, cases: Case) -> BatchPolicy:
    """What steers a batch of cases: a pilot from observations, an oracle from the whole case."""
    if not isinstance(pilot, OraclePilot):
        return BatchedPilot(pilot)
    still = Vector(jnp.zeros(cases.steps.shape), jnp.zeros(cases.steps.shape))
    current = still if cases.disturbance is None else cases.disturbance.current_m_s
    return pilot.policy_for(
        KnownEncounter(cases.encounter, cases.ship, jnp.asarray(cases.steps), current)
    )


def sail(helm: BatchPolicy, cases: Case, steps: int) -> Measures:
    """The measures of every case of a batch after its own number of steps, at most ``steps``.

    One program whatever the number of steps.
    """
    return _sail(helm, cases, jnp.asarray(steps))


@eqx.filter_jit
def _sail(helm: BatchPolicy, cases: Case, steps: Int[Array, ""]) -> Measures:
    start = _embark(helm, cases)
    live, _ = jax.lax.fori_loop(0, steps, lambda _, carry: _tick(helm, cases, carry)[0], start)
    return live.measures


@eqx.filter_jit
def watched(
    helm: BatchPolicy,
    cases: Case,
    steps: Int[Array, ""],
    look: Callable[[Total, Case, Live], Total],
    start: Total,
) -> tuple[Live, Total]:
    """The voyages at their end, and what was seen on the way: ``look`` adds an instant to it."""

    def go(_: Int[Array, ""], so_far: tuple[_Carry, Total]) -> tuple[_Carry, Total]:
        carry, total = so_far
        following, _action = _tick(helm, cases, carry)
        return following, look(total, cases, following[0])

    (live, _), total = jax.lax.fori_loop(0, steps, go, (_embark(helm, cases), start))
    return live, total


@eqx.filter_jit
def retrace(helm: BatchPolicy, cases: Case, steps: int) -> Place:
    """The same voyages as places [steps + 1, cases], for drawing."""

    def go(carry: _Carry, _: None) -> tuple[_Carry, Place]:
        following, action = _tick(helm, cases, carry)
        return following, jax.vmap(place_of)(cases, carry[0], action)

    (live, _), places = jax.lax.scan(go, _embark(helm, cases), length=steps)
    end = jax.vmap(place_of)(cases, live, jnp.zeros(live.state.step.shape))
    return jax.tree.map(lambda a, b: jnp.concatenate([a, b[None]]), places, end)


def _embark(helm: BatchPolicy, cases: Case) -> _Carry:
    live = jax.vmap(embark)(cases)
    return live, helm.start(live.state.step.shape[0])


def _tick(helm: BatchPolicy, cases: Case, carry: _Carry) -> tuple[_Carry, Float[Array, " w"]]:
    """One step of all cases, and the rudders that were given."""
    live, memory = carry
    action, memory = helm(jax.vmap(observation)(cases, live), memory)
    return (jax.vmap(proceed)(cases, live, action), memory), action


def embark(case: Case) -> Live:
    """A case at t = 0, before anything is measured."""
    state = reset(case.encounter, case.ship, SETTINGS)
    picture = None
    if case.disturbance is not None:
        picture = first_picture(case.disturbance, case.encounter, case.encounter.own)
    return Live(state, picture, _nothing(case, state))


def observation(case: Case, live: Live) -> Observation:
    """What the pilot is shown: the ships that matter most, by the instruments if there are any."""
    whole = live.state.observation if live.picture is None else live.picture.observation
    return select_targets(whole, loa_m=case.ship.loa_m)[0]


def proceed(case: Case, live: Live, action: Float[Array, ""]) -> Live:
    """One step of a case; after its end nothing changes in its measures."""
    finite = jnp.isfinite(action)
    rudder = jnp.where(finite, jnp.clip(action, -1.0, 1.0), 0.0) * case.ship.rudder_limit_rad
    own = advance(live.state.own, rudder, case.ship, SETTINGS.step_s)
    if case.disturbance is not None:
        own = with_drift(own, case.disturbance.current_m_s, SETTINGS.step_s)
    out = observe_step(case.encounter, live.state, own, case.ship, SETTINGS)
    picture = live.picture
    if case.disturbance is not None and picture is not None:
        picture = next_picture(
            case.disturbance, picture, case.encounter, own, out.state.leg, out.state.step,
            SETTINGS.step_s,
        )  # fmt: skip
    more = _measured(case, live, out, finite)
    goes_on = (live.state.step < case.steps) & ~live.measures.arrived
    kept = jax.tree.map(lambda new, old: jnp.where(goes_on, new, old), more, live.measures)
    return Live(out.state, picture, kept)


def place_of(case: Case, live: Live, action: Float[Array, ""]) -> Place:
    """Everybody's place in a live case."""
    m = targets_at(case.encounter, live.state.step * SETTINGS.step_s)
    rudder = jnp.clip(action, -1.0, 1.0) * case.ship.rudder_limit_rad
    return Place(live.state.own, rudder, m.east_m, m.north_m, m.course_rad, m.speed_m_s, m.present)


def _nothing(case: Case, state: EnvState) -> Measures:
    """The measures before the first step; only risk of collision may exist already."""
    zero, far = jnp.zeros(()), jnp.full((), jnp.inf)
    left = _left_m(case, state)
    targets = targets_at(case.encounter, zero)
    meetings = Meetings.none(case.encounter.present.shape[-1])
    meetings = meetings.after(state.own, _over_ground(case, state.own), zero, targets, zero)
    return Measures(
        jnp.full(2, -jnp.inf), jnp.full(2, jnp.inf), far, zero, far, jnp.zeros(2), zero, left, left,
        zero, zero, zero, Reversals.none(), zero, jnp.zeros((), bool), jnp.ones((), bool), meetings,
    )  # fmt: skip


def _measured(case: Case, live: Live, out: StepResult, finite: Bool[Array, ""]) -> Measures:
    """The measures with one more step in them."""
    before, m, own = live.state, live.measures, out.state.own
    time_s = out.state.step * SETTINGS.step_s
    early = out.state.step <= SHORT_STEPS
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
        m.meetings.after(own, own_velocity, turn, targets, time_s),
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
    soon = targets.present & (cpa.tcpa_s > 0) & (cpa.tcpa_s <= ALARM_S)
    return jnp.where(soon, cpa.dcpa_m, jnp.inf).min(initial=jnp.inf)


def _left_m(case: Case, state: EnvState) -> Float[Array, ""]:
    """The way left along the route: to the waypoint steered for, and on to the last."""
    x, y = case.encounter.route
    here = Vector(x[state.leg] - state.own.east_m, y[state.leg] - state.own.north_m)
    legs = norm(Vector(jnp.diff(x), jnp.diff(y)))
    return norm(here) + jnp.where(jnp.arange(legs.shape[0]) >= state.leg, legs, 0.0).sum()
