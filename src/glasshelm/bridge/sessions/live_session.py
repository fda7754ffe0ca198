"""A session of live traffic: own ship goes its own way, the pilot advises, and nobody can seek."""

import dataclasses
import functools
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from glasshelm.ais.reports import Feed, Report
from glasshelm.bridge.server.fault_log import FaultLog, describe_error
from glasshelm.bridge.sessions.live_log import LiveLog
from glasshelm.bridge.sessions.log_index import new_log_path
from glasshelm.bridge.sessions.session import PredictedTrack, Session, SessionInfo, SessionStatus
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

#: Seconds between two looks while there is no frame yet.
WAITING_STEP_S = 1.0


class _LoggedAdvisor:
    """One advising pilot, and the log of its frames."""

    def __init__(self, pilot: Pilot, log: LiveLog):
        self.advisor, self.log = LiveAdvisor(pilot), log
        #: The newest frame as its line in the log.
        self.line: bytes | None = None

    @property
    def pilot(self) -> Pilot:
        return self.advisor.pilot

    def look(self, scenario: Scenario, time_s: float) -> Frame:
        try:
            return self.advisor.look(scenario, time_s)
        except Exception:
            self.advisor = LiveAdvisor(self.pilot)  # its memory may be of half a look
            raise


class LiveSession(Session):
    """Makes a frame of the traffic picture whenever it is asked for one.

    :meth:`listen` runs in the event loop and only queues reports; everything else runs in the
    worker thread. The clock is that of the stream. Where it jumps back, or the picture is centred
    anew, a new log begins. If the pilot fails the frame has no advice; if the log cannot be written
    the frame is shown all the same.
    """

    def __init__(
        self,
        source: str,
        feed: Feed,
        picture: TrafficPicture,
        pilot: Pilot,
        ship: str,
        log_dir: Path,
    ):
        self._feed, self._picture, self._log_dir = feed, picture, log_dir
        self._params = ship_named(ship)
        self._reports = ReportQueue()
        #: Why the feed has ended for good, if it has.
        self._end_reason: str | None = None
        self.index = -1
        self.info = SessionInfo(source, feed.title, "live", ship, None)
        self._main = self._logged(pilot)
        self._compared: _LoggedAdvisor | None = None
        #: Makes the frame if the pilot fails.
        self._unadvised = LiveAdvisor(StraightPilot())
        self._fault_log = FaultLog()
        self._first: Scenario | None = None

    async def listen(self) -> None:
        """Queue reports until cancelled; only a file comes to an end.

        Why it ended otherwise stays in the notes, for viewers who join later.
        """
        try:
            async for report in self._feed.reports():
                self._end_reason = None
                self._reports.put(report)
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
    def log(self) -> LiveLog:
        return self._main.log

    @property
    def step_s(self) -> float:
        return WAITING_STEP_S if self.index < 0 else self._main.advisor.settings.step_s

    def status(self) -> SessionStatus:
        now, heard = self._picture.now(), self._picture.latest_time
        age_s = None if now is None or heard is None else (now - heard).total_seconds()
        now_s = self.log.times[self.index] if self.index >= 0 else 0.0
        return SessionStatus(
            pilot=self._main.pilot.name,
            compared=None if self._compared is None else self._compared.pilot.name,
            seekable_range_s=(now_s, now_s),
            connected=self._feed.connected,
            last_report_age_s=age_s,
            own_position_age_s=self._picture.own_age_s(),
            faults=self._faults(),
            feed_counts={c.unit: c.as_dict() for c in (self._feed.counts, self._picture.counts)},
        )

    def warm_up(self, pilot: Pilot, predict: bool = True) -> None:
        advisor = LiveAdvisor(pilot)
        advisor.look(_lone_ship(self._params), 0.0)
        if predict:
            advisor.predicted()

    def next_frame(self) -> Frame | None:
        self._reports.drain_into(self._picture)
        now = self._picture.now()
        if now is None:
            heard = self._feed.counts.received > 0
            self._set_notes("no position heard yet" if heard else "nothing heard yet")
            return None
        scenario = self._picture.scenario(now, self._params)
        if scenario is None:
            self._set_notes(self._picture.status(now))
            return None
        if self._first is not None and not self._continues(self._first, scenario):
            self._restart()
        self._first = first = self._first or scenario
        time_s = _elapsed_s(first, scenario)
        scenario = dataclasses.replace(scenario, source=self.info.source, start=first.start)
        self.info = dataclasses.replace(self.info, title=scenario.title)
        frame = self._advised_frame(scenario, time_s)
        self._main.line = self.log.append(frame)
        self.index += 1
        if self._compared is not None:
            self._compared.line = None
            with self._fault_log.contain("the compared pilot"):
                other = self._compared.look(scenario, time_s)
                self._compared.line = self._compared.log.append(other)
        self._set_notes(*scenario.notes)
        return frame

    def seek(self, time_s: float) -> None:
        raise InputError("live traffic is shown as it is now: replay its log to look back")

    def set_pilot(self, pilot: Pilot) -> None:
        """From the next frame on; the log goes on."""
        self._main.advisor = LiveAdvisor(pilot)
        self._fault_log.clear("the pilot")

    def compare(self, pilot: Pilot | None) -> None:
        if self._compared is not None:
            self._compared.log.close()
        self._compared = None if pilot is None else self._logged(pilot)
        self._fault_log.clear("the compared pilot")

    def compared_history(self) -> list[bytes]:
        if self._compared is None:
            return []
        return self._compared.log.history(max(len(self._compared.log) - 1, 0))

    def compared_line(self) -> bytes | None:
        return None if self._compared is None else self._compared.line

    def predicted_track(self) -> PredictedTrack | None:
        own = self._main.advisor.predicted()
        return None if own is None else PredictedTrack.of(own, self._main.advisor.settings.step_s)

    def close(self) -> None:
        for log in self._logs:
            log.close()

    @property
    def _logs(self) -> list[LiveLog]:
        return [each.log for each in (self._main, self._compared) if each is not None]

    def _faults(self) -> tuple[str, ...]:
        feed = self._end_reason
        if feed is None and not self._feed.connected:
            feed = self._feed.last_error or "no connection"
        faults = feed, *(log.error for log in self._logs), *self._fault_log.messages
        return tuple(dict.fromkeys(fault for fault in faults if fault is not None))

    def _continues(self, first: Scenario, now: Scenario) -> bool:
        """Whether this picture can follow those before it."""
        last_s = self.log.times[-1] if len(self.log) else -1.0
        return now.origin == first.origin and _elapsed_s(first, now) > last_s

    def _advised_frame(self, scenario: Scenario, time_s: float) -> Frame:
        """The frame of now; if the pilot fails, without advice but with all targets."""
        with self._fault_log.contain("the pilot"):
            return self._main.look(scenario, time_s)
        frame = self._unadvised.look(scenario, time_s)
        return msgspec.structs.replace(frame, pilot=self._main.pilot.name, decision=None)

    def _restart(self) -> None:
        """Begin new logs."""
        self.close()
        self._main = self._logged(self._main.pilot)
        self._compared = None if self._compared is None else self._logged(self._compared.pilot)
        self._first, self.index = None, -1

    def _logged(self, pilot: Pilot) -> _LoggedAdvisor:
        new_path = functools.partial(new_log_path, self._log_dir, self.info.source, pilot.name)
        return _LoggedAdvisor(pilot, LiveLog(new_path))

    def _set_notes(self, *notes: str) -> None:
        """Note what is going wrong, what is known, and how much of the feed was of no use."""
        all_notes = [*self._faults(), *notes]
        feed, picture = self._feed.counts, self._picture.counts
        if feed.has_faults or feed.all_rejected:
            all_notes.append(feed.summary())
        if picture.all_rejected:
            all_notes.append(picture.summary())
        if n_lost := sum(log.n_lost for log in self._logs):
            all_notes.append(f"{n_lost} frames were shown without being logged")
        if n_dropped := self._reports.n_dropped:
            all_notes.append(f"{n_dropped} reports came faster than they could be taken")
        self.info = dataclasses.replace(self.info, notes=tuple(all_notes))


def _lone_ship(ship: ShipParams) -> Scenario:
    """Own ship with no target, somewhere: of the same shapes as every picture."""
    picture, now = TrafficPicture("nobody"), datetime.now(UTC)
    own = Report(
        id="own",
        time=now,
        is_own=True,
        latitude_deg=1.0,
        longitude_deg=1.0,
        course_rad=0.0,
        speed_m_s=5.0,
    )
    picture.update(own)
    scenario = picture.scenario(now, ship)
    assert scenario is not None
    return scenario


def _elapsed_s(first: Scenario, now: Scenario) -> float:
    """Seconds of the stream from one picture to another."""
    if first.start is None or now.start is None:
        raise InputError(f"{now.source}: live traffic has no time")
    return round((now.start - first.start).total_seconds(), 3)
