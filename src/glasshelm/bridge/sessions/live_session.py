"""A session of live traffic: own ship goes her own way and the pilot advises; no time is sought."""

import dataclasses
import functools
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import msgspec

from glasshelm.ais.reports import Feed, Report
from glasshelm.bridge.server.fault_log import FaultLog, describe_error
from glasshelm.bridge.sessions.live_record import LiveRecord
from glasshelm.bridge.sessions.log_index import new_log_path
from glasshelm.bridge.sessions.session import PredictedTrack, Session, SessionInfo, to_track
from glasshelm.core.errors import InputError
from glasshelm.encounters.types import Scenario
from glasshelm.feeds.nmea_transport import FileFeed
from glasshelm.feeds.report_queue import ReportQueue
from glasshelm.frames.schema import Frame
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.straight import StraightPilot
from glasshelm.ship.nomoto import ShipParams, ship_named
from glasshelm.simulation.live_advisor import LiveAdvisor

#: Seconds between two looks while there is nothing to see yet.
WAITING_STEP_S = 1.0


class _LoggedAdvisor:
    """One pilot on watch, and the log of what it decides."""

    def __init__(self, pilot: Pilot, record: LiveRecord):
        self.advisor, self.log = LiveAdvisor(pilot), record
        self.line: bytes | None = None

    def look(self, scenario: Scenario, time_s: float) -> Frame:
        try:
            return self.advisor.look(scenario, time_s)
        except Exception:
            self.advisor = LiveAdvisor(
                self.advisor.pilot
            )  # what it remembers may be half of a look
            raise

    def keep(self, frame: Frame) -> None:
        self.line = self.log.append(frame)


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
        self._end_reason: str | None = None
        self.index = -1
        self.info = SessionInfo(source, feed.title, "live", ship, None)
        self._main = self._helm_of(pilot)
        self._compared: _LoggedAdvisor | None = None
        #: Sees what there is when the pilot cannot.
        self._unadvised = LiveAdvisor(StraightPilot())
        self._faults = FaultLog()
        self._begun: Scenario | None = None

    async def listen(self) -> None:
        """Put reports aside until cancelled; only a file comes to an end.

        What ends it otherwise stays in the notes, for whoever looks on later.
        """
        try:
            async for report in self._feed.reports():
                self._end_reason = None
                self._waiting.put(report)
        except InputError as error:
            self._end_reason = str(error)
            raise
        except Exception as error:
            self._end_reason = f"the feed failed ({describe_error(error)})"
            raise

    @property
    def endless(self) -> bool:
        return not isinstance(self._feed, FileFeed)

    @property
    def log(self) -> LiveRecord:
        return self._main.log

    @property
    def pilot_name(self) -> str:
        return self._main.advisor.pilot.name

    @property
    def compared_name(self) -> str | None:
        return None if self._compared is None else self._compared.advisor.pilot.name

    @property
    def seekable_range_s(self) -> tuple[float, float]:
        now_s = self.log.times[self.index] if self.index >= 0 else 0.0
        return now_s, now_s

    @property
    def step_s(self) -> float:
        return WAITING_STEP_S if self.index < 0 else self._main.advisor.settings.step_s

    @property
    def connected(self) -> bool:
        return self._feed.connected

    @property
    def last_report_age_s(self) -> float | None:
        now, heard = self._picture.now(), self._picture.heard
        return None if now is None or heard is None else (now - heard).total_seconds()

    @property
    def own_position_age_s(self) -> float | None:
        return self._picture.own_age_s()

    @property
    def feed_counts(self) -> dict[str, Any]:
        return {c.what: c.told() for c in (self._feed.counts, self._picture.counts)}

    @property
    def faults(self) -> list[str]:
        feed = self._end_reason or (
            None if self.connected else self._feed.trouble or "no connection"
        )
        logs = (record.trouble for record in self._records)
        return list(
            dict.fromkeys(t for t in (feed, *logs, *self._faults.messages) if t is not None)
        )

    @property
    def _records(self) -> list[LiveRecord]:
        return [helm.log for helm in (self._main, self._compared) if helm is not None]

    def warm_up(self, pilot: Pilot, ahead: bool = True) -> None:
        watch = LiveAdvisor(pilot)
        watch.look(_lone_ship(self._params), 0.0)
        if ahead:
            watch.predicted()

    def next_frame(self) -> Frame | None:
        self._waiting.take(self._picture)
        now = self._picture.now()
        if now is None:
            heard = self._feed.counts.heard > 0
            self._note("no position heard yet" if heard else "nothing heard yet")
            return None
        scenario = self._picture.scenario(now, self._params)
        if scenario is None:
            self._note(self._picture.state(now))
            return None
        if self._begun is not None and self._broken(self._begun, scenario):
            self._begin_anew()
        self._begun = begun = self._begun or scenario
        time_s = _since_s(begun, scenario)
        told = dataclasses.replace(scenario, source=self.info.source, start=begun.start)
        self.info = dataclasses.replace(self.info, title=told.title)
        frame = self._looked(told, time_s)
        self._main.keep(frame)
        self.index += 1
        if self._compared is not None:
            self._compared.line = None
            with self._faults.contain("the compared pilot"):
                self._compared.keep(self._compared.look(told, time_s))
        self._note(*told.notes)
        return frame

    def seek(self, time_s: float) -> None:
        raise InputError("live traffic is shown as it is now: replay its log to look back")

    def set_pilot(self, pilot: Pilot) -> None:
        """From the next look on; the log goes on."""
        self._main.advisor = LiveAdvisor(pilot)
        self._faults.clear("the pilot")

    def compare(self, pilot: Pilot | None) -> None:
        if self._compared is not None:
            self._compared.log.close()
        self._compared = None if pilot is None else self._helm_of(pilot)
        self._faults.clear("the compared pilot")

    def compared_history(self) -> list[bytes]:
        if self._compared is None:
            return []
        return self._compared.log.history(max(len(self._compared.log) - 1, 0))

    def compared_line(self) -> bytes | None:
        return None if self._compared is None else self._compared.line

    def predicted_track(self) -> PredictedTrack | None:
        own = self._main.advisor.predicted()
        return None if own is None else to_track(own, self._main.advisor.settings.step_s)

    def close(self) -> None:
        self._main.log.close()
        if self._compared is not None:
            self._compared.log.close()

    def _broken(self, begun: Scenario, now: Scenario) -> bool:
        """Whether what comes cannot follow what was."""
        last_s = self.log.times[-1] if len(self.log) else -1.0
        return now.origin != begun.origin or _since_s(begun, now) <= last_s

    def _looked(self, scenario: Scenario, time_s: float) -> Frame:
        """The frame of now; without advice where the pilot fails: who is near is still seen."""
        with self._faults.contain("the pilot"):
            return self._main.look(scenario, time_s)
        frame = self._unadvised.look(scenario, time_s)
        return msgspec.structs.replace(frame, pilot=self.pilot_name, decision=None)

    def _begin_anew(self) -> None:
        self.close()
        pilot, other = self._main.advisor.pilot, self._compared
        self._main = self._helm_of(pilot)
        self._compared = None if other is None else self._helm_of(other.advisor.pilot)
        self._begun, self.index = None, -1

    def _helm_of(self, pilot: Pilot) -> _LoggedAdvisor:
        new_path = functools.partial(new_log_path, self._logs, self.info.source, pilot.name)
        return _LoggedAdvisor(pilot, LiveRecord(new_path))

    def _note(self, *known: str) -> None:
        """Note what is known, what is wrong with the feed, and what of it was of no use."""
        notes = [*self.faults, *known]
        said, believed = self._feed.counts, self._picture.counts
        if said.faulty or said.useless:
            notes.append(said.sentence())
        if believed.useless:
            notes.append(believed.sentence())
        if lost := sum(record.lost for record in self._records):
            notes.append(f"{lost} frames were shown without being logged")
        if left_out := self._waiting.left_out:
            notes.append(f"{left_out} reports came faster than they could be taken")
        self.info = dataclasses.replace(self.info, notes=tuple(notes))


def _lone_ship(ship: ShipParams) -> Scenario:
    """Own ship with nobody in sight, somewhere: of the same shapes as every picture."""
    picture, now = TrafficPicture("nobody"), datetime.now(UTC)
    picture.take(
        Report(
            id="own",
            time=now,
            own=True,
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
