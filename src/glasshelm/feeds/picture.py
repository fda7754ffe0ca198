"""The traffic as known now: the latest of every ship, as a scenario that pilots understand."""

import heapq
import math
import time
from datetime import UTC, datetime, timedelta

import jax.numpy as jnp
import numpy as np

from glasshelm.encounters.projection import Plane
from glasshelm.encounters.recorded import LOST_AFTER_S
from glasshelm.encounters.types import Encounter, Scenario
from glasshelm.feeds.destination import AHEAD_M, Destination
from glasshelm.feeds.echo import is_echo, note
from glasshelm.feeds.epoch import TrafficTime
from glasshelm.feeds.possible import possible
from glasshelm.feeds.scene import (
    DRIFTING_M_S,
    Here,
    fitted,
    here_of,
    info_of,
    place_of,
    tracks_of,
)
from glasshelm.feeds.slots import Slots
from glasshelm.feeds.types import Counts, Refusal, Report
from glasshelm.feeds.vessel import Motion, Vessel
from glasshelm.geometry import Vector
from glasshelm.ships import NAUTICAL_MILE_M, ShipParams
from glasshelm.voyage import LOST_SHOWN_S

#: A ship not heard for so long [s] is forgotten: lost, shown as lost for a while, and a minute.
FORGOTTEN_S = LOST_AFTER_S + LOST_SHOWN_S + 60.0
#: Ships farther off are known and not shown [m]: AIS by VHF seldom reaches so far.
SHOWN_M = 100_000.0
#: Ships shown at most, the nearest.
SLOTS = 256
#: Ships known at most; of more, the farthest tenth is forgotten.
MOST_SHIPS = 4096
#: The plane's origin is set anew when own ship is so far from it [m].
RECENTRE_M = 30_000.0
#: Older positions of own ship [s] are remarked on, and a picture with them is not called live.
OWN_STALE_S = 30.0
#: Numbers under which own ship is known, at most.
_MOST_OWN = 8
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class Picture:
    """Takes reports, one by one, and makes scenarios of them.

    ``counts`` counts reports: those that were believed, and why others were
    not. Memory is bounded: at most ``MOST_SHIPS`` ships, each forgotten
    ``FORGOTTEN_S`` after her last report.
    """

    def __init__(self, title: str = "live", slots: int = SLOTS, lost_after_s: float = LOST_AFTER_S):
        self.counts = Counts("reports")
        self._title, self._lost_after_s = title, lost_after_s
        self._time = TrafficTime()
        self._advanced_at = 0.0
        self._slots = Slots(slots)
        self._clear()

    def _clear(self) -> None:
        self._own = Vessel("own")
        self._own_ids: set[str] = set()
        self._ships: dict[str, Vessel] = {}
        self._plane: Plane | None = None
        self._destination = Destination()
        self._slots.clear()

    def __len__(self) -> int:
        """How many ships are known, own ship not counted."""
        return len(self._ships)

    @property
    def heard(self) -> datetime | None:
        """The latest time (of the stream, UTC) that a believed position had."""
        latest = self._time.latest_s
        return None if latest is None else _EPOCH + timedelta(seconds=latest)

    def now(self) -> datetime | None:
        """The time of the stream at this instant: ``heard`` and what passed since it was heard.

        This is the ``now`` for :meth:`scenario`, whatever the year of the stream.
        """
        latest = self._time.latest_s
        if latest is None:
            return None
        return _EPOCH + timedelta(seconds=latest + time.monotonic() - self._advanced_at)

    def own_age_s(self) -> float | None:
        """How old own ship's own position is at this instant [s]; None where there is none."""
        now, fix = self.now(), self._own.fix
        return None if now is None or fix is None else max(_seconds(now) - fix.time_s, 0.0)

    def take(self, report: Report) -> Refusal | None:
        """Take a report; says why if it is not believed. Never raises."""
        self.counts.heard += 1
        refused = self._take(report)
        if refused is None:
            self.counts.understood += 1
        else:
            self.counts.refuse(refused)
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
        self._forget(now_s)
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
                tracks_of(vessels, self._plane, now_s, self._lost_after_s),
                jnp.asarray(np.array([v is not None for v in vessels], bool)),
            ),
            targets=tuple(info_of(vessel) for vessel in vessels),
            ship=fitted(ship, self._own, here.speed_m_s),
            duration_s=self._lost_after_s,
            own_name=name,
            own_track=here.track(self._lost_after_s),
            own_rudder=here.rudder_rad is not None,
            origin=self._plane.origin,
            start=now,
            notes=self._notes(here),
        )

    def state(self, now: datetime) -> str:
        """One line for people: what is known of own ship and how many ships there are."""
        now_s = _seconds(now)
        own = self._own
        if own.fix is None:
            if self._time.latest_s is None:
                return "nothing heard yet"
            return f"no position of own ship yet ({len(self._ships)} other ships heard)"
        if now_s - own.fix.time_s > self._lost_after_s:
            return f"own ship was last heard {now_s - own.fix.time_s:.0f} s ago: she is lost"
        motion = own.motion()
        if motion is None:
            return "own ship's speed is not known yet"
        if _goes_anywhere(motion):
            return "own ship's course is not known yet"
        ships = sum(1 for v in self._ships.values() if self._is_target(v))
        return f"own ship and {ships} other {'ship' if ships == 1 else 'ships'}"

    def _take(self, r: Report) -> Refusal | None:
        if not possible(r):
            return Refusal.IMPOSSIBLE
        time_s = _seconds(r.time)
        placed = r.latitude_deg is not None
        moves = placed or not _identity_alone(r)
        if moves and not self._time.believes(time_s):
            return Refusal.TIME_JUMP
        vessel = self._own if r.own else self._ships.get(r.id)
        if placed:
            before = vessel.fix.time_s if vessel and vessel.fix else None
            if self._time.began_anew(time_s, before):
                self._time.reset()
                self._clear()
                vessel = self._own if r.own else None
        latest = self._time.latest_s
        if moves and latest is not None and time_s < latest - FORGOTTEN_S:
            return Refusal.LATE
        if r.own and len(self._own_ids) < _MOST_OWN:
            self._own_ids.add(r.id)
        if vessel is None:
            vessel = self._new(r.id)
        # A time of identity alone may be any (that of the server's start): it moves nothing.
        vessel.identify(r, time_s if moves else min(time_s, latest or time_s))
        refused = vessel.take(r, time_s) if moves else None
        way = (r.waypoint_latitude_deg, r.waypoint_longitude_deg)
        if r.own and way[0] is not None and way[1] is not None:
            self._destination.tell(way[0], way[1], latest or time_s)
        if refused is None and placed:
            self._advance(time_s)
            if vessel is not self._own:
                note(vessel, self._own.fix, self._own.motion())
        return refused

    def _advance(self, time_s: float) -> None:
        if self._time.latest_s is None or time_s > self._time.latest_s:
            self._advanced_at = time.monotonic()
        self._time.advance(time_s)

    def _new(self, number: str) -> Vessel:
        """A ship not known before; if there are too many, room is made first."""
        if len(self._ships) >= MOST_SHIPS:
            self._forget(self._time.latest_s or 0.0)
        if len(self._ships) >= MOST_SHIPS:
            farthest = heapq.nlargest(MOST_SHIPS // 10, self._ships.values(), key=self._away_m)
            for vessel in farthest:
                del self._ships[vessel.id]
        vessel = self._ships[number] = Vessel(number)
        return vessel

    def _forget(self, now_s: float) -> None:
        """Drop the ships not heard for ``FORGOTTEN_S``."""
        old = [v.id for v in self._ships.values() if now_s - v.heard_s > FORGOTTEN_S]
        for number in old:
            del self._ships[number]

    def _away_m(self, vessel: Vessel) -> float:
        """Roughly how far a ship is from own ship [m]; infinitely, if that is not known."""
        own, fix = self._own.fix, vessel.fix
        if own is None or fix is None:
            return math.inf
        turn = (fix.longitude_deg - own.longitude_deg + 180.0) % 360.0 - 180.0
        east = turn * math.cos(math.radians(own.latitude_deg))
        return 60 * NAUTICAL_MILE_M * math.hypot(east, fix.latitude_deg - own.latitude_deg)

    def _is_target(self, vessel: Vessel) -> bool:
        if vessel.id in self._own_ids or vessel.fix is None:
            return False
        told = any(number.isdigit() for number in self._own_ids)
        return told or not is_echo(vessel)

    def _here(self, now_s: float) -> Here | None:
        """Own ship now; None if she is not known, or lost. Keeps the plane near her."""
        fix, motion = self._own.fix, self._own.motion()
        if fix is None or motion is None or now_s - fix.time_s > self._lost_after_s:
            return None
        if _goes_anywhere(motion):
            return None
        # Written so that a distance that is no number (the far side of the globe) also counts.
        if self._plane is None or not math.hypot(*place_of(fix, self._plane)) <= RECENTRE_M:
            self._plane = Plane(fix.latitude_deg, fix.longitude_deg)
            self._slots.clear()
        return here_of(self._own, fix, motion, self._plane, now_s)

    def _shown(self, now_s: float) -> list[Vessel | None]:
        """The ships in their slots: the nearest of those within ``SHOWN_M``, lost ones last."""
        near = sorted(
            (now_s - v.fix.time_s > self._lost_after_s, away, v.id)
            for v in self._ships.values()
            if v.fix and self._is_target(v) and v.motion() and (away := self._away_m(v)) <= SHOWN_M
        )
        placed = self._slots.place([number for _, _, number in near])
        return [None if number is None else self._ships[number] for number in placed]

    def _own_name(self) -> str:
        told = (f"MMSI {number}" for number in self._own_ids if number.isdigit())
        return self._own.name or next(told, "own ship")

    def _notes(self, here: Here) -> tuple[str, ...]:
        notes = []
        if not self._destination.told:
            notes.append(
                "no route is known: the waypoint is assumed "
                f"{AHEAD_M / NAUTICAL_MILE_M:.0f} NM ahead on the course she steers"
            )
        if here.age_s > OWN_STALE_S:
            notes.append(f"own ship's position is {here.age_s:.0f} s old: dead-reckoned since")
        motion = self._own.motion()
        if motion is not None and motion.course_rad is None:
            notes.append("own ship's heading is not known: she is shown heading north")
        if self._own.length_m is None:
            notes.append("own ship's length is not told: that of the chosen ship is assumed")
        return tuple(notes)


def _seconds(when: datetime) -> float:
    """Seconds since 1970; a time without a zone is UTC."""
    return ((when if when.tzinfo else when.replace(tzinfo=UTC)) - _EPOCH).total_seconds()


def _goes_anywhere(motion: Motion) -> bool:
    """Whether she makes way on a course that nothing tells."""
    return motion.course_rad is None and motion.speed_m_s >= DRIFTING_M_S


def _identity_alone(r: Report) -> bool:
    motion = (r.course_rad, r.speed_m_s, r.heading_rad, r.rate_of_turn_rad_s, r.rudder_rad)
    return all(value is None for value in motion)
