"""From the numbers of a moment to the frame that people and files get (host side)."""

from datetime import timedelta
from typing import Any

import jax
import numpy as np

from glasshelm.core.errors import InputError
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.types import Scenario
from glasshelm.env.rewards import Reward
from glasshelm.env.training_envelope import check_observation, outside_training
from glasshelm.explanation.step_explanation import (
    ALTERNATIVES,
    Explanation,
    ManoeuvreExplanation,
)
from glasshelm.frames.schema import (
    Alternative,
    BySubTask,
    Decision,
    Frame,
    Guard,
    Manoeuvre,
    Own,
    Ship,
    Sweep,
    Target,
    Waypoint,
)
from glasshelm.networks.critics import QValues
from glasshelm.pilots.protocols import Pilot
from glasshelm.ship.nomoto import ShipParams
from glasshelm.simulation.explained_step import ExplainedStep

#: Numbers are written to so many decimals: a micrometre, a microradian.
DECIMALS = 6
#: Two ships that move the rudder together by less are not named.
PAIR_RAD = float(np.radians(0.1))

Columns = dict[str, list[Any]]


class FrameBuilder:
    """Makes the frames of one scenario sailed by one pilot.

    ``applied`` is false where the pilot only advises; own ship's rudder is then
    absent, unless a sensor tells it (``Scenario.own_rudder``). Moments are given on
    the host (NumPy leaves).
    """

    def __init__(self, scenario: Scenario, pilot: Pilot, applied: bool):
        self._scenario, self._pilot, self._applied = scenario, pilot, applied
        self._limit = float(scenario.ship.rudder_limit_rad)
        self._ship = ship_part(scenario.ship)
        self._plane = None if scenario.origin is None else LocalProjection(*scenario.origin)
        tracks = scenario.encounter.targets
        reports = np.isfinite(np.asarray(tracks.start_s)) & np.isfinite(np.asarray(tracks.end_s))
        #: Slots of ships known from reports that expire: for these the age means something.
        self._reported = np.asarray(reports.any(-1))

    def frame(self, moment: ExplainedStep, time_s: float, reward: Reward | None) -> Frame:
        """The frame of a moment. InputError if the pilot was shown or decides no number."""
        self._check(moment)
        why = moment.decision.why
        return Frame(
            time_s=time_s,
            pilot=self._pilot.name,
            source=self._scenario.source,
            ship=self._ship,
            own=self._own(moment),
            waypoint=Waypoint(*_plain(np.stack(moment.waypoint))),
            targets=self._targets(moment),
            decision=self._decision(moment),
            weights_sha256=getattr(self._pilot, "weights_sha256", None),
            time_utc=self._utc(time_s),
            reward=None if reward is None else _by_sub_task(reward),
            value=_by_sub_task(why.value) if why and why.value else None,
            priority=_by_sub_task(why.priority) if why and why.priority else None,
            sweep=self._sweep(moment),
            outside_training=self._outside(moment),
            guard=self._guard(moment),
            **self._manoeuvre(moment),
        )

    def _check(self, moment: ExplainedStep) -> None:
        infos = self._scenario.targets
        check_observation(
            moment.observation, [infos[i].name for i in moment.slots if i < len(infos)]
        )
        if not np.isfinite(moment.decision.rudder):
            has_weights = getattr(self._pilot, "weights_sha256", None) is not None
            why = "its weights are damaged" if has_weights else "a number in [-1, 1] is needed"
            raise InputError(
                f"pilot {self._pilot.name} decides {moment.decision.rudder}, which is no rudder: "
                f"{why}"
            )

    def _own(self, moment: ExplainedStep) -> Own:
        own = moment.own
        latitude, longitude = self._places(own.east_m[None], own.north_m[None])
        known = self._applied or self._scenario.own_rudder
        return Own(
            east_m=_plain(own.east_m),
            north_m=_plain(own.north_m),
            heading_rad=_plain((own.heading_rad + np.pi) % (2 * np.pi) - np.pi),
            speed_m_s=_plain(own.speed_m_s),
            rate_of_turn_rad_s=_plain(own.rate_of_turn_rad_s),
            rudder_rad=_plain(own.rudder_rad) if known else None,
            latitude_deg=latitude[0],
            longitude_deg=longitude[0],
        )

    def _sweep(self, moment: ExplainedStep) -> Sweep | None:
        why = moment.decision.why
        if why is None or why.sweep is None:
            return None
        sweep = why.sweep
        return Sweep(
            _plain(sweep.action * self._limit),
            _plain(sweep.value.waypoint),
            _plain(sweep.value.by_ship.sum(-1)),
        )

    def _decision(self, moment: ExplainedStep) -> Decision:
        decision, why, own, alone = moment.decision, moment.decision.why, None, None
        if decision.overruled is not None and decision.overruled.active:
            own = _plain(decision.overruled.pilot_rudder * self._limit)
        if why is not None and not decision.is_ordered:
            alone = _plain(why.rudder_shapley.none * self._limit)
        return Decision(_plain(decision.rudder * self._limit), self._applied, alone, own)

    def _guard(self, moment: ExplainedStep) -> Guard | None:
        guard = moment.decision.guard
        if guard is None:
            return None
        steers, ahead = bool(guard.steers), guard.lookahead
        if not np.isfinite(ahead.within_s):
            return Guard(steers)
        who = self._scenario.targets[int(moment.slots[int(ahead.slot)])]
        return Guard(steers, who.id, _plain(ahead.within_s), _plain(ahead.depth))

    def _manoeuvre(self, moment: ExplainedStep) -> dict[str, Any]:
        """What a pilot that chooses manoeuvres compared, as fields of the frame."""
        why = moment.decision.why
        if why is None or (m := why.manoeuvre) is None:
            return {}
        heading, ids = moment.own.heading_rad, self._ids(moment)
        alone = float(m.then_duration_s) == 0.0
        return {
            "manoeuvre": Manoeuvre(
                _true_course(m.course_rad, heading),
                _plain(m.duration_s),
                None if alone else _true_course(m.then_course_rad, heading),
                None if alone else _plain(m.then_duration_s),
            ),
            "alternatives": _alternatives(m, heading, ids),
            "needed": [name for name, is_needed in zip(ids, m.needed, strict=True) if is_needed],
            "last_safe_s": _plain(m.last_safe_s) if np.isfinite(m.last_safe_s) else None,
        }

    def _ids(self, moment: ExplainedStep) -> list[str]:
        """The target that each slot of the observation shows; empty where there is none."""
        shown = zip(moment.slots, moment.observation.present, strict=True)
        return [self._scenario.targets[i].id if present else "" for i, present in shown]

    def _outside(self, moment: ExplainedStep) -> list[str] | None:
        trained = getattr(self._pilot, "trained", None)
        if trained is None:
            return None
        selected = np.zeros(len(moment.traffic.lost), bool)
        selected[moment.slots[moment.observation.present]] = True
        motion, ship = moment.traffic.motion, self._scenario.ship
        said = outside_training(moment.own, ship, moment.waypoint, motion, selected, trained)
        return said or None

    def _targets(self, moment: ExplainedStep) -> list[Target]:
        shown = np.flatnonzero(moment.traffic.motion.present)
        infos = [self._scenario.targets[i] for i in shown]
        who: Columns = {
            "id": [info.id for info in infos],
            "name": [info.name for info in infos],
            "length_m": [info.length_m for info in infos],
        }
        columns = who | self._situation(moment, shown) | _reasons(moment, shown, self._limit)
        rows = zip(*columns.values(), strict=True)
        return [Target(**dict(zip(columns, row, strict=True))) for row in rows]

    def _situation(self, moment: ExplainedStep, shown: np.ndarray) -> Columns:
        traffic, motion = moment.traffic, moment.traffic.motion
        latitude, longitude = self._places(motion.east_m[shown], motion.north_m[shown])
        ages = zip(_plain(motion.age_s[shown]), self._reported[shown], strict=True)
        return {
            "east_m": _plain(motion.east_m[shown]),
            "north_m": _plain(motion.north_m[shown]),
            "course_rad": _plain(motion.course_rad[shown]),
            "speed_m_s": _plain(motion.speed_m_s[shown]),
            "range_m": _plain(traffic.range_m[shown]),
            "bearing_rad": _plain(traffic.bearing_rad[shown]),
            "dcpa_m": _plain(traffic.cpa.dcpa_m[shown]),
            "tcpa_s": _plain(traffic.cpa.tcpa_s[shown]),
            "danger": _plain(traffic.danger[shown]),
            "lost": traffic.lost[shown].tolist(),
            "age_s": [age if reported else None for age, reported in ages],
            "latitude_deg": latitude,
            "longitude_deg": longitude,
        }

    def _places(self, east_m: Any, north_m: Any) -> tuple[list[Any], list[Any]]:
        """Latitudes and longitudes [deg]; all absent where the origin is not known."""
        if self._plane is None or len(east_m) == 0:
            return [None] * len(east_m), [None] * len(east_m)
        latitude, longitude = self._plane.to_globe(
            np.asarray(east_m, np.float64), np.asarray(north_m, np.float64)
        )
        return latitude.round(7).tolist(), longitude.round(7).tolist()

    def _utc(self, time_s: float) -> str | None:
        start = self._scenario.start
        if start is None:
            return None
        return (start + timedelta(seconds=time_s)).isoformat().replace("+00:00", "Z")


def ship_part(ship: ShipParams) -> Ship:
    """Own ship's parameters as a frame carries them; a rudder without a rate has none there."""
    rate = float(ship.rudder_rate_rad_s)
    return Ship(
        loa_m=float(ship.loa_m),
        beam_m=float(ship.beam_m),
        K_1_s=float(ship.gain_1_s),
        T_s=float(ship.time_constant_s),
        rudder_limit_rad=float(ship.rudder_limit_rad),
        speed_m_s=float(ship.speed_m_s),
        rudder_rate_rad_s=rate if np.isfinite(rate) else None,
    )


def ship_params(part: Ship) -> ShipParams:
    """The ship of a frame."""
    rate = np.inf if part.rudder_rate_rad_s is None else part.rudder_rate_rad_s
    return ShipParams(
        part.K_1_s, part.T_s, part.rudder_limit_rad, rate, part.loa_m, part.beam_m, part.speed_m_s
    )


def _reasons(moment: ExplainedStep, shown: np.ndarray, limit_rad: float) -> Columns:
    """What the pilot makes of each ship shown; absent for those that it was not shown."""
    place = {int(i): k for k, i in enumerate(moment.slots) if moment.observation.present[k]}
    places = [place.get(int(i)) for i in shown]
    columns: Columns = {"selected": [k is not None for k in places]}
    e = moment.decision.why
    if e is None:
        return columns
    given: Columns = {}
    if e.value and e.priority and e.far is not None:
        given["q"], given["priority"] = _plain(e.value.by_ship), _plain(e.priority.by_ship)
        given["q_far"] = [_plain(e.far)] * len(moment.slots)
    if e.sweep:
        given["q_sweep"] = _plain(e.sweep.value.by_ship.T)
    if e.attention is not None:
        given["attention"] = _plain(e.attention)
    if not moment.decision.is_ordered:
        given |= _of_own_rudder(e, places, limit_rad)
    for name, values in given.items():
        columns[name] = [None if k is None else values[k] for k in places]
    return columns


def _of_own_rudder(e: Explanation, places: list[int | None], limit_rad: float) -> Columns:
    """What is true only of a rudder that pilot or guard decided: whose it is."""
    given: Columns = {}
    if e.intention is not None:
        given["intention"] = _plain(e.intention.increment)
        given["intention_level"] = _plain(e.intention.level)
    given["shapley_rad"] = _plain(e.rudder_shapley.by_ship * limit_rad)
    given["leave_one_out_rad"] = _plain(e.leave_one_out * limit_rad)
    if np.any(e.rudder_shapley.error):
        given["shapley_error_rad"] = _plain(e.rudder_shapley.error * limit_rad)
    if e.value_shapley is not None and np.isfinite(e.value_shapley.all):
        given["shapley_value"] = _plain(e.value_shapley.by_ship)
    if e.manoeuvre is not None:
        given["course_shapley_rad"] = _plain(e.manoeuvre.course_shapley.by_ship)
        given["course_leave_one_out_rad"] = _plain(e.manoeuvre.course_leave_one_out)
    together = e.rudder_shapley.pairs * limit_rad
    if np.any(np.abs(together) >= PAIR_RAD):
        # Slot by slot -> target by target of the frame; who was not shown has no part in it.
        wide = np.pad(together, ((0, 0), (0, 1)))
        at = [together.shape[1] if k is None else k for k in places]
        given["shapley_pairs_rad"] = _plain(wide[:, at])
    return given


def _by_sub_task(parts: QValues | Reward) -> BySubTask:
    helm = getattr(parts, "helm", None)
    waypoint, collision = float(parts.waypoint), float(np.sum(parts.by_ship, dtype=np.float64))
    total = waypoint + collision + float(helm or 0.0)
    return BySubTask(
        _plain(waypoint), _plain(collision), _plain(total), None if helm is None else _plain(helm)
    )


def _alternatives(m: ManoeuvreExplanation, heading_rad: Any, ids: list[str]) -> list[Alternative]:
    """What the manoeuvre was compared with: those that there are."""
    found = []
    for row, name in enumerate(ALTERNATIVES):
        value = jax.tree.map(lambda x, row=row: x[row], m.alternatives)
        if np.isfinite(value.waypoint):
            course = _true_course(m.alternative_course_rad[row], heading_rad)
            costs = zip(ids, value.by_ship, strict=True)
            by_target = {id: _plain(q) for id, q in costs if id}
            found.append(Alternative(name, course, _by_sub_task(value), by_target))
    return found


def _true_course(relative_rad: Any, heading_rad: Any) -> float:
    """A course off own heading as a true one in [−π, π)."""
    return _plain((heading_rad + relative_rad + np.pi) % (2 * np.pi) - np.pi)


def _plain(x: Any) -> Any:
    """A number or nested lists of numbers, rounded."""
    return np.round(np.asarray(x, np.float64), DECIMALS).tolist()
