"""The traffic as known now: the latest of every ship, as a scenario that pilots understand."""

import itertools
import math
from datetime import UTC, datetime, timedelta

import jax.numpy as jnp
import numpy as np

from glasshelm.ais.limits import is_vessel_mmsi
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.own_echo import OwnIdentities, compare_with_own, is_echo
from glasshelm.ais.plausibility import is_plausible
from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.traffic_time import BACKWARD_S, TOLERANCE_S, TrafficTime, format_duration
from glasshelm.ais.vessel import CourseSpeed, Vessel
from glasshelm.core.geometry import Vector
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.recorded_traffic import LOST_AFTER_S
from glasshelm.encounters.types import Encounter, Scenario
from glasshelm.live.fleet import MAX_SHIPS, VesselStore
from glasshelm.live.scenario_builder import (
    DRIFTING_M_S,
    OwnPosition,
    own_position,
    target_info,
    target_tracks,
    to_plane,
    with_own_dimensions,
)
from glasshelm.live.slot_allocator import SlotAllocator
from glasshelm.live.waypoint_tracker import AHEAD_M, WaypointTracker
from glasshelm.ship.nomoto import NAUTICAL_MILE_M, ShipParams

#: Ships farther off are known and not shown [m]: AIS by VHF seldom reaches so far.
SHOWN_M = 100_000.0
#: Ships shown at most, the nearest.
SLOTS = 256
#: The plane's origin is set anew when own ship is so far from it [m].
RECENTRE_M = 30_000.0
#: Older positions of own ship [s] are remarked on, and a picture with them is not called live.
OWN_STALE_S = 30.0
#: A jump of the time is remarked on for so long [s].
JUMP_TOLD_S = 60.0
#: The witness that own ship is, under whichever number.
_OWN = "own ship"
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class TrafficPicture:
    """Takes reports, one by one, and makes scenarios of them.

    ``counts`` counts reports: those that were believed, and why others were
    not. Memory is bounded: at most ``fleet.MOST_SHIPS`` ships and a tenth, each forgotten
    ``fleet.FORGOTTEN_S`` after her last report.
    """

    def __init__(self, title: str = "live", slots: int = SLOTS, lost_after_s: float = LOST_AFTER_S):
        self.counts = Counts("reports")
        self._title, self._lost_after_s = title, lost_after_s
        self._time = TrafficTime()
        self._jump: tuple[str, float] | None = None
        self._slots = SlotAllocator(slots)
        self._clear()

    def _clear(self) -> None:
        self._own = Vessel("own")
        self._numbers = OwnIdentities()
        self._fleet = VesselStore()
        self._plane: LocalProjection | None = None
        self._destination = WaypointTracker()
        self._slots.clear()

    def __len__(self) -> int:
        """How many ships are known, own ship not counted."""
        return len(self._fleet)

    @property
    def latest_time(self) -> datetime | None:
        """The latest time (of the stream, UTC) that most ships agree on."""
        latest = self._time.latest_s
        return None if latest is None else _EPOCH + timedelta(seconds=latest)

    def now(self) -> datetime | None:
        """The time of the stream at this instant: ``heard`` and what passed since it was heard.

        This is the ``now`` for :meth:`scenario`, whatever the year of the stream.
        """
        now_s = self._time.now_s
        try:
            return None if now_s is None else _EPOCH + timedelta(seconds=now_s)
        except OverflowError:  # heard in the last second of the year 9999
            return self.latest_time

    def own_age_s(self) -> float | None:
        """How old own ship's own position is at this instant [s]; None where there is none."""
        now, fix = self.now(), self._own.fix
        return None if now is None or fix is None else max(_seconds(now) - fix.time_s, 0.0)

    def distance_m(self, report: Report) -> float:
        """Roughly how far from own ship a report is [m]; infinitely, if that is not known."""
        return self._fleet.distance_m(report, self._own.fix)

    def update(self, report: Report) -> RejectReason | None:
        """Take a report; says why if it is not believed. Never raises."""
        self.counts.received += 1
        refused = self._take(report)
        if refused is None:
            self.counts.accepted += 1
        else:
            self.counts.reject(refused)
        return refused

    def scenario(self, now: datetime, ship: ShipParams) -> Scenario | None:
        """The traffic at ``now`` as an encounter; None until own ship's motion is known.

        t = 0 is now. One leg a ship: dead-reckoned from her latest report, and
        not there any more ``lost_after_s`` after it. There is always the same
        number of slots, and a ship keeps hers; ``encounter.present`` tells which
        slots hold a ship at all (a lost one too). Own ship's numbers are arrays,
        so that no program is compiled anew as they change; her length and beam are
        taken from the reports once these tell them. ``origin`` stays where it is
        until own ship is 30 km from it: what is remembered in the plane, or by slot,
        is void when it changes. Own ship's heading is her course over ground, as
        in recorded traffic.
        """
        now_s = _seconds(now)
        self._fleet.forget(now_s)
        self._numbers.forget(now_s)
        here = self._here(now_s)
        if here is None or self._plane is None:
            return None
        vessels = self._shown(now_s)
        way = self._destination.waypoint(
            self._plane, here.east_m, here.north_m, here.course_rad, now_s
        )
        name = self._own_name()
        return Scenario(
            source=self._title,
            title=f"{name} in live traffic",
            encounter=Encounter(
                here.state(),
                Vector(jnp.full(1, way[0], jnp.float32), jnp.full(1, way[1], jnp.float32)),
                target_tracks(vessels, self._plane, now_s, self._lost_after_s),
                jnp.asarray(np.array([v is not None for v in vessels], bool)),
            ),
            targets=tuple(target_info(vessel) for vessel in vessels),
            ship=with_own_dimensions(ship, self._own, here.speed_m_s),
            duration_s=self._lost_after_s,
            own_name=name,
            own_track=here.track(self._lost_after_s),
            own_rudder=here.rudder_rad is not None,
            origin=self._plane.origin,
            start=now,
            notes=self._notes(here, now_s),
        )

    def status(self, now: datetime) -> str:
        """One line for people: what is known of own ship and how many ships there are."""
        wrong = self._time.rejected_clocks()
        return self._state(_seconds(now)) + (f"; {wrong}" if wrong else "")

    def _state(self, now_s: float) -> str:
        own = self._own
        if own.fix is None:
            if self._time.latest_s is None:
                return "nothing heard yet"
            return f"no position of own ship yet ({len(self)} other ships heard)"
        if now_s - own.fix.time_s > self._lost_after_s:
            return f"own ship was last heard {now_s - own.fix.time_s:.0f} s ago: she is lost"
        motion = own.course_speed()
        if motion is None:
            return "own ship's speed is not known yet"
        if _goes_anywhere(motion):
            return "own ship's course is not known yet"
        ships = sum(1 for v in self._fleet.ships.values() if self._is_target(v))
        return f"own ship and {ships} other {'ship' if ships == 1 else 'ships'}"

    def _take(self, r: Report) -> RejectReason | None:
        if r.previous_id is not None and is_number(r.id) and not is_vessel_mmsi(int(r.id)):
            self._fleet.ships.pop(r.previous_id, None)  # what was taken for a ship is a buoy
            return RejectReason.NO_SHIP
        if r.previous_id is not None and self._fleet.rename(r.previous_id, r.id):
            self._slots.rename(r.previous_id, r.id)
        if not is_plausible(r):
            return RejectReason.IMPLAUSIBLE
        time_s = _seconds(r.time)
        placed = r.latitude_deg is not None
        moves = placed or not _identity_alone(r)
        before_s = self._time.latest_s
        if moves:
            believed = self._time.update(time_s, _OWN if r.is_own else r.id)
            latest_s = self._time.latest_s or time_s
            if not believed:
                return RejectReason.TIME_JUMP if time_s > latest_s else RejectReason.LATE
            if before_s is not None:
                self._follow(latest_s - before_s, latest_s)
            time_s = min(time_s, self._time.now_s or time_s)
        else:
            # A time of identity alone may be any (that of the server's start): it moves nothing.
            time_s = min(time_s, before_s or time_s)
        vessel = self._own if r.is_own else self._fleet.find(r)
        if vessel is None:
            vessel = self._fleet.add(r, self._own.fix)
        if vessel is None:
            return RejectReason.TOO_FAR
        vessel.update_static(r, time_s)
        vessel.clear_fields(r.cleared)
        refused = vessel.update(r, time_s) if moves else None
        if r.is_own:
            self._numbers.add(r.id, time_s)
            self._route(r, time_s)
        elif vessel.twin_fix is not None:
            self._fleet.split(vessel)
        if refused is None and placed and not r.is_own:
            compare_with_own(vessel, self._own.fix, self._own.course_speed())
        return refused

    def _follow(self, step_s: float, latest_s: float) -> None:
        """Go with a jump of the time of the traffic."""
        if step_s < -BACKWARD_S:
            self._clear()
            back = format_duration(step_s)
            told = f"the time of the traffic went back by {back}: the picture began anew"
        elif step_s > TOLERANCE_S:
            told = f"a gap of {format_duration(step_s)} in the time of the traffic was passed over"
        else:
            return
        self._jump = (told, latest_s)

    def _route(self, r: Report, now_s: float) -> None:
        """Take what own ship says of her route."""
        if r.waypoint_latitude_deg is not None and r.waypoint_longitude_deg is not None:
            self._destination.set_route_waypoint(
                r.waypoint_latitude_deg, r.waypoint_longitude_deg, now_s
            )
        elif r.route_ended:
            self._destination.end_route()

    def _is_target(self, vessel: Vessel) -> bool:
        if vessel.fix is None or self._numbers.is_own(vessel):
            return False
        return self._numbers.mmsi is not None or not is_echo(vessel)

    def _here(self, now_s: float) -> OwnPosition | None:
        """Own ship now; None if she is not known, or lost. Keeps the plane near her."""
        fix, motion = self._own.fix, self._own.course_speed()
        if fix is None or motion is None or now_s - fix.time_s > self._lost_after_s:
            return None
        if _goes_anywhere(motion):
            return None
        # Written so that a distance that is no number (the far side of the globe) also counts.
        if self._plane is None or not math.hypot(*to_plane(fix, self._plane)) <= RECENTRE_M:
            self._plane = LocalProjection(fix.latitude_deg, fix.longitude_deg)
            self._slots.clear()
        return own_position(self._own, fix, motion, self._plane, now_s)

    def _shown(self, now_s: float) -> list[Vessel | None]:
        """The ships in their slots: the nearest of those within ``SHOWN_M``, lost ones last."""
        assert self._own.fix is not None
        near = self._fleet.nearest(self._own.fix, SHOWN_M, now_s, self._lost_after_s)
        shown = (v.id for v in near if self._is_target(v) and v.course_speed())
        placed = self._slots.allocate(list(itertools.islice(shown, len(self._slots))))
        return [None if number is None else self._fleet.ships[number] for number in placed]

    def _own_name(self) -> str:
        told = self._numbers.mmsi
        return self._own.name or ("own ship" if told is None else f"MMSI {told}")

    def _notes(self, here: OwnPosition, now_s: float) -> tuple[str, ...]:
        notes = []
        if not self._destination.is_from_route:
            why = "her route has ended" if self._destination.route_ended else "no route is known"
            notes.append(
                f"{why}: the waypoint is assumed "
                f"{AHEAD_M / NAUTICAL_MILE_M:.0f} NM ahead on the course she steers"
            )
        if here.age_s > OWN_STALE_S:
            notes.append(f"own ship's position is {here.age_s:.0f} s old: dead-reckoned since")
        motion = self._own.course_speed()
        if motion is not None and motion.course_rad is None:
            notes.append("own ship's heading is not known: she is shown heading north")
        if self._own.length_m is None:
            notes.append("own ship's length is not told: that of the chosen ship is assumed")
        if self._jump is not None and now_s - self._jump[1] <= JUMP_TOLD_S:
            notes.append(self._jump[0])
        wrong = self._time.rejected_clocks()
        if wrong is not None:
            notes.append(wrong)
        shared = self._fleet.shared()
        if shared:
            notes.append(f"two ships use one number, both are shown: MMSI {', '.join(shared[:3])}")
        if self._fleet.full:
            notes.append(f"more ships are heard than are kept: the nearest {MAX_SHIPS:,} are")
        return tuple(notes)


def _seconds(when: datetime) -> float:
    """Seconds since 1970; a time without a zone is UTC."""
    return ((when if when.tzinfo else when.replace(tzinfo=UTC)) - _EPOCH).total_seconds()


def _goes_anywhere(motion: CourseSpeed) -> bool:
    """Whether she makes way on a course that nothing tells."""
    return motion.course_rad is None and motion.speed_m_s >= DRIFTING_M_S


def _identity_alone(r: Report) -> bool:
    motion = (r.course_rad, r.speed_m_s, r.heading_rad, r.rate_of_turn_rad_s, r.rudder_rad)
    return all(value is None for value in motion)
