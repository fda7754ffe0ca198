"""A session of live traffic: own ship goes her own way and the pilot advises; no time is sought."""

import asyncio
import dataclasses
import time
from collections import deque
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from glasshelm.bridge.logs import new_log
from glasshelm.bridge.record import Record
from glasshelm.bridge.session import Card, Predicted, Session, track_of
from glasshelm.encounters.types import Scenario
from glasshelm.errors import InputError
from glasshelm.feeds.picture import Picture
from glasshelm.feeds.types import Feed, Report
from glasshelm.frames import Frame
from glasshelm.pilots.types import Pilot
from glasshelm.ships import ShipParams, ship_named
from glasshelm.watch import Watch

#: Reports that wait for the next look at most; then no more are read for the moment.
MOST_WAITING = 20_000
#: A look takes what waits for at most so long [s]; the rest waits for the next.
TAKE_S = 0.5
#: While nothing more can be put aside, that is tried again after so long [s].
AGAIN_S = 0.05
#: Seconds between two looks while there is nothing to see yet.
FIRST_LOOK_S = 1.0


class _Helm:
    """One pilot on watch, and the log of what it decides."""

    def __init__(self, pilot: Pilot, path: Path):
        self.watch, self.record = Watch(pilot), Record(path, fresh=True)
        self.line: bytes | None = None

    def look(self, scenario: Scenario, time_s: float) -> Frame:
        frame = self.watch.look(scenario, time_s)
        self.line = self.record.append(frame)
        return frame


class Live(Session):
    """Makes a frame of the picture whenever it is asked for one.

    ``listen`` runs in the event loop and only puts reports aside; all else runs
    in the worker. The clock is that of the stream. Where it jumps back, or the
    plane is centred anew, a new log begins.
    """

    def __init__(
        self, source: str, feed: Feed, picture: Picture, pilot: Pilot, ship: str, logs: Path
    ):
        self._feed, self._picture, self._logs = feed, picture, logs
        self._params = ship_named(ship)
        self._waiting: deque[Report] = deque()
        #: Whether more comes than a look can take.
        self._behind = False
        #: Why the feed has ended for good, if it has.
        self._over: str | None = None
        self.at = -1
        self.card = Card(source, feed.title, "live", ship, None)
        self._helm = _Helm(pilot, self._log(pilot))
        self._other: _Helm | None = None
        self._begun: Scenario | None = None

    async def listen(self) -> None:
        """Put reports aside until cancelled; only a file comes to an end.

        While too many wait no more are read: a server then waits as well, and datagrams
        are counted and dropped. What ends it otherwise stays in the notes, for whoever looks
        on later.
        """
        try:
            async for report in self._feed.reports():
                while len(self._waiting) >= MOST_WAITING:
                    await asyncio.sleep(AGAIN_S)
                self._waiting.append(report)
        except InputError as error:
            self._over = str(error)
            raise
        except Exception:
            self._over = "the feed failed: nothing more is heard"
            raise

    @property
    def record(self) -> Record:
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
        now, heard = self._picture.now(), self._picture.heard
        return None if now is None or heard is None else (now - heard).total_seconds()

    @property
    def own_s(self) -> float | None:
        return self._picture.own_age_s()

    @property
    def counted(self) -> dict[str, Any]:
        return {c.what: c.told() for c in (self._feed.counts, self._picture.counts)}

    def ready(self, pilot: Pilot, ahead: bool = True) -> None:
        watch = Watch(pilot)
        watch.look(_alone(self._params), 0.0)
        if ahead:
            watch.predicted()

    def forward(self) -> Frame | None:
        self._take_waiting()
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
        told = dataclasses.replace(scenario, source=self.card.source, start=begun.start)
        self.card = dataclasses.replace(self.card, title=told.title)
        self._note(*told.notes)
        frame = self._helm.look(told, time_s)
        if self._other is not None:
            self._other.look(told, time_s)
        self.at += 1
        return frame

    def _take_waiting(self) -> None:
        """Take what waits now, for as long as a look can spare; what comes meanwhile waits."""
        until = time.monotonic() + TAKE_S
        for left in reversed(range(len(self._waiting))):
            self._picture.take(self._waiting.popleft())
            if time.monotonic() > until:
                self._behind = left > 0
                return
        self._behind = False

    def seek(self, time_s: float) -> None:
        raise InputError("live traffic is shown as it is now: replay its log to look back")

    def hand_over(self, pilot: Pilot) -> None:
        """From the next look on; the log goes on."""
        self._helm.watch = Watch(pilot)

    def compare(self, pilot: Pilot | None) -> None:
        if self._other is not None:
            self._other.record.close()
        self._other = None if pilot is None else _Helm(pilot, self._log(pilot))

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

    def _begin_anew(self) -> None:
        self.close()
        pilot, other = self._helm.watch.pilot, self._other
        self._helm = _Helm(pilot, self._log(pilot))
        self._other = (
            None if other is None else _Helm(other.watch.pilot, self._log(other.watch.pilot))
        )
        self._begun, self.at = None, -1

    def _log(self, pilot: Pilot) -> Path:
        return new_log(self._logs, self.card.source, pilot.name)

    def _note(self, *known: str) -> None:
        """Note what is known, what is wrong with the feed, and what of it was of no use."""
        trouble = self._over or (None if self.connected else self._feed.trouble or "no connection")
        notes = [*([] if trouble is None else [trouble]), *known]
        said, believed = self._feed.counts, self._picture.counts
        if said.faulty or said.useless:
            notes.append(said.sentence())
        if believed.useless:
            notes.append(believed.sentence())
        if self._behind:
            notes.append("more is heard than can be taken: the picture is some seconds behind")
        self.card = dataclasses.replace(self.card, notes=tuple(notes))


def _alone(ship: ShipParams) -> Scenario:
    """Own ship with nobody in sight, somewhere: of the same shapes as every picture."""
    picture, now = Picture("nobody"), datetime.now(UTC)
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
