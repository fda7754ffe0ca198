"""The traffic as known now: the latest of every ship, as a scenario that pilots understand."""

import itertools
import math
from datetime import datetime

import jax.numpy as jnp
import numpy as np

from glasshelm.ais.limits import LOST_AFTER_S, is_plausible, is_vessel_mmsi
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.own_echo import OwnIdentities, compare_with_own, is_echo
from glasshelm.ais.reports import MOTION_FIELDS, Counts, RejectReason, Report
from glasshelm.ais.timestamps import as_utc, format_duration, from_epoch
from glasshelm.ais.traffic_time import BACKWARD_S, TOLERANCE_S, TrafficTime
from glasshelm.ais.vessel import Vessel
from glasshelm.core.geometry import Vector
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.types import Encounter, Scenario, with_dimensions
from glasshelm.live.scenario_builder import (
    OwnPosition,
    own_position,
    target_info,
    target_tracks,
    to_plane,
)
from glasshelm.live.slot_allocator import SlotAllocator
from glasshelm.live.vessel_store import MAX_SHIPS, VesselStore
from glasshelm.live.waypoint_tracker import AHEAD_M, WaypointTracker
from glasshelm.ship.nomoto import NAUTICAL_MILE_M, ShipParams

#: Ships farther off are known and not shown [m]: AIS by VHF seldom reaches so far.
SHOWN_M = 100_000.0
#: Ships shown at most, the nearest.
SLOTS = 256
#: The plane's origin is set anew when own ship is so far from it [m].
RECENTRE_M = 30_000.0
#: Older positions of own ship [s] are noted, and a picture with them is not called live.
OWN_STALE_S = 30.0
#: A jump of the time is noted for so long [s].
JUMP_NOTED_S = 60.0
#: Own ship as a source of the time, under whichever number.
_OWN = "own ship"


class TrafficPicture:
    """Takes reports, one by one, and makes scenarios of them.

    ``counts`` counts the reports: accepted ones, and why others were
    rejected. Memory is bounded: at most ``vessel_store.MAX_SHIPS`` ships and a tenth, each
    forgotten ``limits.FORGOTTEN_S`` after its last report.
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
        self._identities = OwnIdentities()
        self._others = VesselStore()
        self._plane: LocalProjection | None = None
        self._waypoints = WaypointTracker()
        self._slots.clear()

    def __len__(self) -> int:
        """How many ships are known, own ship not counted."""
        return len(self._others)

    @property
    def latest_time(self) -> datetime | None:
        """The latest time (of the stream, UTC) that most ships agree on."""
        latest_s = self._time.latest_s
        return None if latest_s is None else from_epoch(latest_s)

    def now(self) -> datetime | None:
        """The time of the stream now: ``latest_time`` and what passed since it was received.

        This is the ``now`` for :meth:`scenario`, whatever the year of the stream.
        """
        now_s = self._time.now_s
        # None of the last second of the year 9999.
        return None if now_s is None else from_epoch(now_s) or self.latest_time

    def own_age_s(self) -> float | None:
        """The age of own ship's position now [s]; None where there is none."""
        now, fix = self.now(), self._own.fix
        return None if now is None or fix is None else max(_seconds(now) - fix.time_s, 0.0)

    def distance_m(self, report: Report) -> float:
        """Roughly how far from own ship a report is [m]; infinite if that is not known."""
        return self._others.distance_m(report, self._own.fix)

    def update(self, report: Report) -> RejectReason | None:
        """Take a report; says why if it is not believed. Never raises."""
        self.counts.received += 1
        rejected = self._update(report)
        if rejected is None:
            self.counts.accepted += 1
        else:
            self.counts.reject(rejected)
        return rejected

    def scenario(self, now: datetime, ship: ShipParams) -> Scenario | None:
        """The traffic at ``now`` as an encounter.

        t = 0 is now. Each ship has one leg: dead-reckoned from its latest report, and
        ending ``lost_after_s`` after it. There is always the same
        number of slots, and a ship keeps its slot; ``encounter.present`` tells which
        slots hold a ship at all (a lost one too). Own ship's numbers are arrays,
        so that no program is compiled anew as they change. ``origin`` stays
        until own ship is 30 km from it: what is remembered in the plane, or by slot,
        is void when it changes. Own ship's heading is its course over ground, as
        in recorded traffic.

        Args:
            now: A time of the stream, usually :meth:`now`.
            ship: Own ship; its length and beam are taken from the reports once these have them.

        Returns:
            None until own ship's motion is known.
        """
        now_s = _seconds(now)
        self._others.forget(now_s)
        self._identities.forget(now_s)
        own = self._own_position(now_s)
        if own is None or self._plane is None:
            return None
        vessels = self._shown(now_s)
        east, north = self._waypoints.waypoint(
            self._plane, own.east_m, own.north_m, own.course_rad, now_s
        )
        name, static = self._own_name(), self._own.static
        return Scenario(
            source=self._title,
            title=f"{name} in live traffic",
            encounter=Encounter(
                own.state(),
                Vector(jnp.full(1, east, jnp.float32), jnp.full(1, north, jnp.float32)),
                target_tracks(vessels, self._plane, now_s, self._lost_after_s),
                jnp.asarray(np.array([v is not None for v in vessels], bool)),
            ),
            targets=tuple(target_info(vessel) for vessel in vessels),
            ship=with_dimensions(
                ship, static.length_m, static.beam_m, jnp.asarray(own.speed_m_s, jnp.float32)
            ),
            duration_s=self._lost_after_s,
            own_name=name,
            own_track=own.track(self._lost_after_s),
            own_rudder=own.rudder_rad is not None,
            origin=self._plane.origin,
            start=now,
            notes=self._notes(own, now_s),
        )

    def status(self, now: datetime) -> str:
        """One line for people: what is known of own ship and how many ships there are."""
        clocks = self._time.rejected_clocks()
        return self._status(_seconds(now)) + (f"; {clocks}" if clocks else "")

    def _status(self, now_s: float) -> str:
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
        if motion.lacks_course:
            return "own ship's course is not known yet"
        ships = sum(1 for v in self._others.ships.values() if self._is_target(v))
        return f"own ship and {ships} other {'ship' if ships == 1 else 'ships'}"

    def _update(self, r: Report) -> RejectReason | None:
        if r.previous_id is not None and is_number(r.id) and not is_vessel_mmsi(int(r.id)):
            self._others.ships.pop(r.previous_id, None)  # what was taken for a ship is a buoy
            return RejectReason.NO_SHIP
        if r.previous_id is not None and self._others.rename(r.previous_id, r.id):
            self._slots.rename(r.previous_id, r.id)
        if not is_plausible(r):
            return RejectReason.IMPLAUSIBLE
        time_s = _seconds(r.time)
        has_position = r.latitude_deg is not None
        is_dynamic = has_position or _has_motion(r)
        before_s = self._time.latest_s
        if is_dynamic:
            believed = self._time.update(time_s, _OWN if r.is_own else r.id)
            latest_s = self._time.latest_s or time_s
            if not believed:
                return RejectReason.TIME_JUMP if time_s > latest_s else RejectReason.LATE
            if before_s is not None:
                self._follow_jump(latest_s - before_s, latest_s)
            time_s = min(time_s, self._time.now_s or time_s)
        else:
            # The time of static data may be any (the server's start): it moves nothing.
            time_s = min(time_s, before_s or time_s)
        vessel = self._own if r.is_own else self._others.find(r)
        if vessel is None:
            vessel = self._others.add(r, self._own.fix)
        if vessel is None:
            return RejectReason.TOO_FAR
        vessel.update_static(r, time_s)
        vessel.clear_fields(r.cleared)
        rejected = vessel.update(r, time_s) if is_dynamic else None
        if r.is_own:
            self._identities.add(r.id, time_s)
            self._update_route(r, time_s)
        elif vessel.twin_fix is not None:
            self._others.split(vessel)
        if rejected is None and has_position and not r.is_own:
            compare_with_own(vessel, self._own.fix, self._own.course_speed())
        return rejected

    def _follow_jump(self, step_s: float, latest_s: float) -> None:
        """Follow the time of the traffic where it jumps."""
        step = format_duration(step_s)
        if step_s < -BACKWARD_S:
            self._clear()
            note = f"the time of the traffic went back by {step}: the picture began anew"
        elif step_s > TOLERANCE_S:
            note = f"a gap of {step} in the time of the traffic was passed over"
        else:
            return
        self._jump = (note, latest_s)

    def _update_route(self, r: Report, now_s: float) -> None:
        if r.waypoint_latitude_deg is not None and r.waypoint_longitude_deg is not None:
            waypoint = r.waypoint_latitude_deg, r.waypoint_longitude_deg
            self._waypoints.set_route_waypoint(*waypoint, now_s)
        elif r.route_ended:
            self._waypoints.end_route()

    def _is_target(self, vessel: Vessel) -> bool:
        if vessel.fix is None or self._identities.is_own(vessel):
            return False
        return self._identities.mmsi is not None or not is_echo(vessel)

    def _own_position(self, now_s: float) -> OwnPosition | None:
        """Own ship now; None if it is not known, or lost. Keeps the plane near it."""
        fix, motion = self._own.fix, self._own.course_speed()
        if fix is None or motion is None or now_s - fix.time_s > self._lost_after_s:
            return None
        if motion.lacks_course:
            return None
        # Written so that a NaN (the far side of the globe) also counts.
        if self._plane is None or not math.hypot(*to_plane(fix, self._plane)) <= RECENTRE_M:
            self._plane = LocalProjection(fix.latitude_deg, fix.longitude_deg)
            self._slots.clear()
        return own_position(self._own, fix, motion, self._plane, now_s)

    def _shown(self, now_s: float) -> list[Vessel | None]:
        """The ships in their slots: the nearest of those within ``SHOWN_M``, lost ones last."""
        assert self._own.fix is not None
        near = self._others.nearest(self._own.fix, SHOWN_M, now_s, self._lost_after_s)
        shown = (v.id for v in near if self._is_target(v) and v.course_speed())
        ids = self._slots.allocate(list(itertools.islice(shown, len(self._slots))))
        return [None if number is None else self._others.ships[number] for number in ids]

    def _own_name(self) -> str:
        mmsi = self._identities.mmsi
        return self._own.static.name or ("own ship" if mmsi is None else f"MMSI {mmsi}")

    def _notes(self, own: OwnPosition, now_s: float) -> tuple[str, ...]:
        notes = []
        if not self._waypoints.is_from_route:
            ended = self._waypoints.route_ended
            notes.append(
                f"{'her route has ended' if ended else 'no route is known'}: the waypoint is "
                f"assumed {AHEAD_M / NAUTICAL_MILE_M:.0f} NM ahead on the course she steers"
            )
        if own.age_s > OWN_STALE_S:
            notes.append(f"own ship's position is {own.age_s:.0f} s old: dead-reckoned since")
        motion = self._own.course_speed()
        if motion is not None and motion.course_rad is None:
            notes.append("own ship's heading is not known: she is shown heading north")
        if self._own.static.length_m is None:
            notes.append("own ship's length is not told: that of the chosen ship is assumed")
        if self._jump is not None and now_s - self._jump[1] <= JUMP_NOTED_S:
            notes.append(self._jump[0])
        clocks = self._time.rejected_clocks()
        if clocks is not None:
            notes.append(clocks)
        shared = self._others.shared_ids()
        if shared:
            notes.append(f"two ships use one number, both are shown: MMSI {', '.join(shared[:3])}")
        if self._others.full:
            notes.append(f"more ships are heard than are kept: the nearest {MAX_SHIPS:,} are")
        return tuple(notes)


def _seconds(when: datetime) -> float:
    """Seconds since 1970; a time without a zone is UTC."""
    return as_utc(when).timestamp()


def _has_motion(r: Report) -> bool:
    return any(getattr(r, name) is not None for name in MOTION_FIELDS)
