"""Plays the session shown: shows the next frame when it is due, listens, and survives faults.

The event loop only waits and sends out results. The session shown has a worker thread to itself,
which does one thing at a time; rudder bands have another.
"""

import asyncio
import math
import time
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from glasshelm.bridge.annotate.band_worker import BandWorker
from glasshelm.bridge.server import protocol as m
from glasshelm.bridge.server.fault_log import FaultLog, run_isolated, supervise
from glasshelm.bridge.server.presenter import Presenter
from glasshelm.bridge.server.protocol import Outgoing, encode
from glasshelm.bridge.sessions.session import Session
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.core.errors import InputError
from glasshelm.live.signalk_writer import SignalKWriter
from glasshelm.live.traffic_picture import OWN_STALE_S
from glasshelm.pilots.protocols import Pilot

Result = TypeVar("Result")

# Parts of the work in the fault log.
_SESSION, _FEED = "the session", "the feed"
_WRITING_BACK, _REQUESTING_BAND = "writing back", "requesting the rudder band"


class SessionPlayer:
    """The session shown, its clock and its faults.

    Args:
        broadcast: Sends messages to all viewers.
        pilot_named: Returns a pilot by its name.
        writer: Gets every frame of live traffic, and falls silent when there is no current one.
        errors: The largest sensor errors that rudder bands allow for; None: no bands.
    """

    def __init__(
        self,
        broadcast: Callable[[list[Outgoing]], None],
        pilot_named: Callable[[str], Pilot],
        writer: SignalKWriter | None = None,
        errors: SensorErrorBounds | None = None,
    ):
        self.writer = writer
        self.presenter: Presenter | None = None
        self.playing, self.rate = False, 1.0
        self.limits = m.DEFAULT_ALARM_LIMITS
        #: Held by whoever uses the session shown, or replaces it.
        self.lock = asyncio.Lock()
        #: Faults of the session, of writing back, and of the tasks that run for ever.
        self.fault_log = FaultLog()
        self.bands = BandWorker(errors, pilot_named, broadcast)
        self._broadcast = broadcast
        self._wake = asyncio.Event()
        self._listening: asyncio.Task[None] | None = None
        self._changes: set[asyncio.Task[None]] = set()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="voyage")

    @property
    def faults(self) -> list[str]:
        """What is going wrong, a line each."""
        presenter = self.presenter
        own = [] if presenter is None else [*self._writer_fault(presenter), *presenter.faults]
        return list(dict.fromkeys((*self.fault_log.messages, *own)))

    def require_presenter(self) -> Presenter:
        if self.presenter is None:
            raise InputError("nothing is open yet: open a source first")
        return self.presenter

    async def run(self) -> None:
        """Run everything that runs as long as the server; what fails is restarted.

        On cancellation, what was written back is withdrawn first.
        """
        parts = {"keeping time": self.play, "computing bands": self.bands.run}
        if self.writer is not None:
            parts["writing back"] = self.writer.run
        tasks = [
            asyncio.create_task(supervise(part, run, self.fault_log)) for part, run in parts.items()
        ]
        try:
            await asyncio.gather(*tasks)
        finally:
            await self.withdraw()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def withdraw(self) -> None:
        """Withdraw for good what was written to Signal K: the server is about to stop."""
        if self.writer is not None:
            await self.writer.close()

    def close(self) -> None:
        """Close the session. Jobs that are still running are not waited for, except its own."""
        for task in (self._listening, *self._changes):
            if task is not None:
                task.cancel()
        self.bands.close()
        self._worker.shutdown(wait=True, cancel_futures=True)
        if self.presenter is not None:
            self.presenter.close()

    async def play(self) -> None:
        """Show the next frame whenever it is due, for ever."""
        last = time.monotonic()
        while True:
            if self.presenter is None or not self.playing:
                await self._wake.wait()
                self._wake.clear()
                last = time.monotonic()
                continue
            interval = self.presenter.session.step_s / self.rate
            left = last + interval - time.monotonic()
            if left > 0 and await self._woken(left):
                continue  # something has changed: perhaps the rate
            # A frame that took too long delays the next ones; they do not catch up.
            late = -left >= interval
            last = time.monotonic() if late else last + interval
            async with self.lock:
                await self.advance()

    async def advance(self) -> None:
        """Show the next frame; a simulated or replayed session that cannot is paused."""
        presenter = self.presenter
        if presenter is None or not self.playing:
            return
        live, messages = presenter.session.info.mode == "live", None
        try:
            messages = await self.in_worker(presenter.advance)
        except Exception as error:
            is_new = _SESSION not in self.fault_log
            action = "retrying" if live else "paused; press play to retry"
            message = self.fault_log.record(_SESSION, error, action)
            if is_new or not live:
                self._broadcast([_notice(message)])
        else:
            self.fault_log.clear(_SESSION)
        # First of all: what is shown on other displays is current, or goes.
        with self.fault_log.contain(_WRITING_BACK):
            self.write_back(presenter if messages else None)
        self.playing = live or messages is not None
        with self.fault_log.contain(_REQUESTING_BAND):
            self._request_band()
        with self.fault_log.contain("reporting the session"):
            if live or messages is None:
                self._broadcast([self.session_message(presenter)])
        self._broadcast(messages or [])

    async def exclusively(
        self,
        change: Callable[[], Awaitable[None]],
        discard: Callable[[], object] | None = None,
    ) -> None:
        """Change what is shown; once begun this is finished even if the caller is cancelled.

        If the caller is cancelled before that, ``discard`` is called in the worker thread.
        """

        async def run() -> None:
            try:
                await change()
            finally:
                self.lock.release()
                self._wake.set()

        try:
            await self.lock.acquire()
        except asyncio.CancelledError:
            if discard is not None:
                self._worker.submit(discard)
            raise
        task = asyncio.create_task(run())
        self._changes.add(task)
        task.add_done_callback(self._changes.discard)
        await asyncio.shield(task)

    async def apply(self, request: m.Request) -> None:
        """Do what a request asks of the session shown. The caller holds the lock."""
        presenter = self.require_presenter()
        match request:
            case m.Pause() | m.SetRate() if presenter.session.info.mode == "live":
                raise InputError("live traffic is shown as it comes: it has no pause and no rate")
            case m.Play():
                self._set_playback(presenter, True, self.rate)
            case m.Pause():
                self._set_playback(presenter, False, self.rate)
            case m.SetRate(rate):
                self._set_playback(presenter, self.playing, rate)
            case m.Seek(time_s):
                await self.jump(lambda: presenter.seek(time_s))
            case m.Compare(None):
                await self.jump(lambda: presenter.compare(None))
            case m.Acknowledge(id):
                messages = await self.in_worker(lambda: presenter.acknowledge(id))
                if messages is None:
                    raise InputError("no such alarm: its cause is gone")
                self._broadcast(messages)
            case m.SetLimits():
                self.limits = request
                self._broadcast(await self.in_worker(lambda: presenter.set_limits(request)))

    async def jump(self, change: Callable[[], list[Outgoing]]) -> None:
        """Make a change after which the page starts again from the history."""
        messages = await self.in_worker(change)
        self._broadcast([self.session_message(self.require_presenter()), *messages])
        self._request_band()

    async def replace(self, presenter: Presenter, first_error: Exception | None) -> None:
        """Show another session; ``first_error`` is why its first frame failed. Holds the lock."""

        def present() -> list[Outgoing]:
            presenter.set_limits(self.limits)  # they may have changed meanwhile
            return presenter.snapshot()

        messages = await self.in_worker(present)
        # Nothing is awaited while one takes the other's place.
        if self._listening is not None:
            self._listening.cancel()
        self.fault_log.clear(_FEED)
        self.fault_log.clear(_SESSION)
        if first_error is not None:
            self.fault_log.record(_SESSION, first_error)
        old, self.presenter = self.presenter, presenter
        self.playing, self.rate = True, 1.0
        self._listening = asyncio.create_task(self.listen(presenter.session))
        with self.fault_log.contain(_WRITING_BACK):
            self.write_back(presenter)
        self._broadcast([self.session_message(presenter), *messages])
        with self.fault_log.contain(_REQUESTING_BAND):
            self._request_band()
        if old is not None:
            with self.fault_log.contain("closing the session before"):
                await self.in_worker(old.close)

    async def listen(self, session: Session) -> None:
        """Listen to a session's source; only a file comes to an end."""

        def notify(message: str) -> None:
            self._broadcast([_notice(message)])

        if session.endless:
            await supervise(_FEED, session.listen, self.fault_log, notify)
            return
        try:
            await session.listen()
        except Exception as error:
            notify(self.fault_log.record(_FEED, error, "nothing more is received"))

    async def snapshot(self) -> list[Outgoing]:
        """Return what a new viewer is sent. The caller holds the lock."""
        messages: list[Outgoing] = []
        if self.presenter is not None:
            with self.fault_log.contain("telling what was shown"):
                session = self.session_message(self.presenter)
                present = await self.in_worker(self.presenter.snapshot)
                messages = [session, *present, *self.bands.snapshot]
        return messages

    def write_back(self, presenter: Presenter | None) -> None:
        """Write a current frame of live traffic; without one, withdraw what was written."""
        if self.writer is None:
            return
        try:
            frame = None if presenter is None else presenter.frame
            current = presenter is not None and _is_current(presenter.session)
            if (
                presenter is None
                or frame is None
                or not current
                or not presenter.alarms_are_current
            ):
                self.writer.withdraw()
            else:
                self.writer.publish(frame, presenter.alarms)
        except BaseException:
            self.writer.withdraw()
            raise

    def session_message(self, presenter: Presenter) -> Outgoing:
        notes = [*self.fault_log.messages, *self._writer_fault(presenter)]
        return presenter.session_message(self.playing, self.rate, *notes)

    async def in_worker(self, job: Callable[[], Result]) -> Result:
        return await asyncio.get_running_loop().run_in_executor(self._worker, run_isolated, job)

    def discard(self, presenter: Presenter) -> None:
        """Close a session that nobody will see, in the worker thread."""
        self._worker.submit(presenter.close)

    def _set_playback(self, presenter: Presenter, playing: bool, rate: float) -> None:
        self.playing, self.rate = playing, rate
        self._broadcast([self.session_message(presenter)])
        self._request_band()

    def _request_band(self) -> None:
        """Ask for the band of the frame shown, which stays until the next one is due."""
        presenter = self.presenter
        if presenter is not None:
            shown_for_s = presenter.session.step_s / self.rate if self.playing else math.inf
            self.bands.request(presenter.recent, shown_for_s)

    def _writer_fault(self, presenter: Presenter) -> list[str]:
        live = presenter.session.info.mode == "live"
        fault = self.writer.last_error if self.writer is not None and live else None
        return [] if fault is None else [fault]

    async def _woken(self, seconds: float) -> bool:
        try:
            async with asyncio.timeout(seconds):
                await self._wake.wait()
        except TimeoutError:
            return False
        self._wake.clear()
        return True


def _is_current(session: Session) -> bool:
    """Whether this is live traffic, and own ship is where it is shown."""
    status = session.status()
    age_s = status.own_position_age_s
    return status.connected and age_s is not None and age_s <= OWN_STALE_S


def _notice(text: str) -> Outgoing:
    return encode(m.Notice(text))
