"""A session of live traffic: own ship goes her own way and the pilot advises; no time is sought."""

import dataclasses
import functools
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import msgspec

from glasshelm.ais.reports import Feed, Report
from glasshelm.bridge.server.fault_log import Faults, one_line
from glasshelm.bridge.sessions.live_record import LiveRecord
from glasshelm.bridge.sessions.log_index import new_log
from glasshelm.bridge.sessions.session import Predicted, Session, SessionInfo, track_of
from glasshelm.core.errors import InputError
from glasshelm.encounters.types import Scenario
from glasshelm.feeds.nmea_transport import FileFeed
from glasshelm.frames.schema import Frame
from glasshelm.live.report_queue import ReportQueue
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import ShipParams, ship_named
from glasshelm.simulation.live_advisor import LiveAdvisor

#: Seconds between two looks while there is nothing to see yet.
FIRST_LOOK_S = 1.0


class _Helm:
    """One pilot on watch, and the log of what it decides."""

    def __init__(self, pilot: Pilot, record: LiveRecord):
        self.watch, self.record = LiveAdvisor(pilot), record
        self.line: bytes | None = None

    def look(self, scenario: Scenario, time_s: float) -> Frame:
        try:
            return self.watch.look(scenario, time_s)
        except Exception:
            self.watch = LiveAdvisor(self.watch.pilot)  # what it remembers may be half of a look
            raise

    def keep(self, frame: Frame) -> None:
        self.line = self.record.append(frame)


class LiveSession(Session):
    """Makes a frame of the picture whenever it is asked for one.

    ``listen`` runs in the event loop and only puts reports aside; all else runs
    in the worker. The clock is that of the stream. Where it jumps back, or the
    plane is centred anew, a new log begins. A pilot who fails leaves a frame without advice,
    a log that cannot be written one that is shown all the same.
    """

    def __init__(
        self, source: str, feed: Feed, picture: TrafficPicture, pilot: Pilot, ship: str, logs: Path
    ):
        self._feed, self._picture, self._logs = feed, picture, logs
        self._params = ship_named(ship)
        self._waiting = ReportQueue()
        #: Why the feed has ended for good, if it has.
        self._over: str | None = None
        self.at = -1
        self.card = SessionInfo(source, feed.title, "live", ship, None)
        self._helm = self._helm_of(pilot)
        self._other: _Helm | None = None
        #: Sees what there is when the pilot cannot.
        self._unadvised = LiveAdvisor(StraightPilot())
        self._faults = Faults()
        self._begun: Scenario | None = None

    async def listen(self) -> None:
        """Put reports aside until cancelled; only a file comes to an end.

        What ends it otherwise stays in the notes, for whoever looks on later.
        """
        try:
            async for report in self._feed.reports():
                self._over = None
                self._waiting.put(report)
        except InputError as error:
            self._over = str(error)
            raise
        except Exception as error:
            self._over = f"the feed failed ({one_line(error)})"
            raise

    @property
    def endless(self) -> bool:
        return not isinstance(self._feed, FileFeed)

    @property
    def record(self) -> LiveRecord:
        return self._helm.record

    @property
    def pilot(self) -> str:
        return self._helm.watch.pilot.name

    @property
    def compared(self) -> str | None:
        return None if self._other is None else self._other.watch.pilot.name

    @property
    def reach_s(self) -> tuple[float, float]:
        now_s = self.record.times[self.at] if self.at >= 0 else 0.0
        return now_s, now_s

    @property
    def step_s(self) -> float:
        return FIRST_LOOK_S if self.at < 0 else self._helm.watch.settings.step_s

    @property
    def connected(self) -> bool:
        return self._feed.connected

    @property
    def heard_s(self) -> float | None:
        now, heard = self._picture.now(), self._picture.latest_time
        return None if now is None or heard is None else (now - heard).total_seconds()

    @property
    def own_s(self) -> float | None:
        return self._picture.own_age_s()

    @property
    def counted(self) -> dict[str, Any]:
        return {c.unit: c.as_dict() for c in (self._feed.counts, self._picture.counts)}

    @property
    def troubles(self) -> list[str]:
        feed = self._over or (None if self.connected else self._feed.last_error or "no connection")
        logs = (record.trouble for record in self._records)
        return list(dict.fromkeys(t for t in (feed, *logs, *self._faults.told) if t is not None))

    @property
    def _records(self) -> list[LiveRecord]:
        return [helm.record for helm in (self._helm, self._other) if helm is not None]

    def ready(self, pilot: Pilot, ahead: bool = True) -> None:
        watch = LiveAdvisor(pilot)
        watch.look(_alone(self._params), 0.0)
        if ahead:
            watch.predicted()

    def forward(self) -> Frame | None:
        self._waiting.drain_into(self._picture)
        now = self._picture.now()
        if now is None:
            heard = self._feed.counts.received > 0
            self._note("no position heard yet" if heard else "nothing heard yet")
            return None
        scenario = self._picture.scenario(now, self._params)
        if scenario is None:
            self._note(self._picture.status(now))
            return None
        if self._begun is not None and self._broken(self._begun, scenario):
            self._begin_anew()
        self._begun = begun = self._begun or scenario
        time_s = _since_s(begun, scenario)
        told = dataclasses.replace(scenario, source=self.card.source, start=begun.start)
        self.card = dataclasses.replace(self.card, title=told.title)
        frame = self._looked(told, time_s)
        self._helm.keep(frame)
        self.at += 1
        if self._other is not None:
            self._other.line = None
            with self._faults.contained("the compared pilot"):
                self._other.keep(self._other.look(told, time_s))
        self._note(*told.notes)
        return frame

    def seek(self, time_s: float) -> None:
        raise InputError("live traffic is shown as it is now: replay its log to look back")

    def hand_over(self, pilot: Pilot) -> None:
        """From the next look on; the log goes on."""
        self._helm.watch = LiveAdvisor(pilot)
        self._faults.heals("the pilot")

    def compare(self, pilot: Pilot | None) -> None:
        if self._other is not None:
            self._other.record.close()
        self._other = None if pilot is None else self._helm_of(pilot)
        self._faults.heals("the compared pilot")

    def beside(self) -> list[bytes]:
        if self._other is None:
            return []
        return self._other.record.history(max(len(self._other.record) - 1, 0))

    def beside_now(self) -> bytes | None:
        return None if self._other is None else self._other.line

    def predicted(self) -> Predicted | None:
        own = self._helm.watch.predicted()
        return None if own is None else track_of(own, self._helm.watch.settings.step_s)

    def close(self) -> None:
        self._helm.record.close()
        if self._other is not None:
            self._other.record.close()

    def _broken(self, begun: Scenario, now: Scenario) -> bool:
        """Whether what comes cannot follow what was."""
        last_s = self.record.times[-1] if len(self.record) else -1.0
        return now.origin != begun.origin or _since_s(begun, now) <= last_s

    def _looked(self, scenario: Scenario, time_s: float) -> Frame:
        """The frame of now; without advice where the pilot fails: who is near is still seen."""
        with self._faults.contained("the pilot"):
            return self._helm.look(scenario, time_s)
        frame = self._unadvised.look(scenario, time_s)
        return msgspec.structs.replace(frame, pilot=self.pilot, decision=None)

    def _begin_anew(self) -> None:
        self.close()
        pilot, other = self._helm.watch.pilot, self._other
        self._helm = self._helm_of(pilot)
        self._other = None if other is None else self._helm_of(other.watch.pilot)
        self._begun, self.at = None, -1

    def _helm_of(self, pilot: Pilot) -> _Helm:
        new_path = functools.partial(new_log, self._logs, self.card.source, pilot.name)
        return _Helm(pilot, LiveRecord(new_path))

    def _note(self, *known: str) -> None:
        """Note what is known, what is wrong with the feed, and what of it was of no use."""
        notes = [*self.troubles, *known]
        said, believed = self._feed.counts, self._picture.counts
        if said.has_faults or said.all_rejected:
            notes.append(said.summary())
        if believed.all_rejected:
            notes.append(believed.summary())
        if lost := sum(record.lost for record in self._records):
            notes.append(f"{lost} frames were shown without being logged")
        if left_out := self._waiting.n_dropped:
            notes.append(f"{left_out} reports came faster than they could be taken")
        self.card = dataclasses.replace(self.card, notes=tuple(notes))


def _alone(ship: ShipParams) -> Scenario:
    """Own ship with nobody in sight, somewhere: of the same shapes as every picture."""
    picture, now = TrafficPicture("nobody"), datetime.now(UTC)
    picture.update(
        Report(
            id="own",
            time=now,
            is_own=True,
            latitude_deg=1.0,
            longitude_deg=1.0,
            course_rad=0.0,
            speed_m_s=5.0,
        )
    )
    scenario = picture.scenario(now, ship)
    assert scenario is not None
    return scenario


def _since_s(begun: Scenario, now: Scenario) -> float:
    """Seconds of the stream from one picture to another."""
    if begun.start is None or now.start is None:
        raise InputError(f"{now.source}: live traffic has no time")
    return round((now.start - begun.start).total_seconds(), 3)
