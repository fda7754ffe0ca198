"""The one session that all viewers see: who asks what of it, and when its next frame is due.

The event loop only waits, and hands out what came of it. The session shown has
a worker thread to itself, one thing at a time. What may take long (another
session, another pilot, whose programs are to be compiled first) is prepared in
a second thread while frames, alarms and answers go on; questions have a third, and
rudder bands a fourth.
"""

import asyncio
import logging
import math
import time
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar, get_args

from glasshelm import __version__
from glasshelm.bridge.annotate.band_worker import BandWorker
from glasshelm.bridge.annotate.whatif_queries import WhatIfQuery, answer
from glasshelm.bridge.server import protocol as m
from glasshelm.bridge.server.background_jobs import BackgroundJobs
from glasshelm.bridge.server.fault_log import FaultLog, run_isolated, supervise
from glasshelm.bridge.server.presenter import Presenter, Told
from glasshelm.bridge.server.request_queue import RequestQueue
from glasshelm.bridge.server.viewer_queue import ViewerQueue
from glasshelm.bridge.sessions.session import Session
from glasshelm.bridge.sessions.session_factory import open_session
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.core.errors import InputError
from glasshelm.live.signalk_writer import SignalKWriter
from glasshelm.live.traffic_picture import OWN_STALE_S
from glasshelm.pilots.protocols import Pilot

Result = TypeVar("Result")

#: Viewers at once.
MAX_VIEWERS = 100
#: Questions that wait for their answer at once; the last of them are for owners.
MAX_WAITING_QUESTIONS, RESERVED_FOR_OWNERS = 8, 2
#: What is done as soon as it is asked, whatever waits before it, once there is a session.
_AT_ONCE = m.Ping | m.Acknowledge | m.SetLimits | m.AskWhatIf
#: What needs a session or a pilot to be prepared.
_PREPARED = m.Open | m.Replay | m.SetPilot | m.Compare
_LOOK, _FEED = "the session", "the feed"
_WRITING, _CERTIFYING = "writing back what is advised", "certifying the rudder"
_AGAIN, _PAUSED = "it looks again in a moment", "it is paused; play tries it again"
_log = logging.getLogger("glasshelm.bridge")


class SessionHub:
    """Plays a session to its viewers. Nothing that fails ends it: ``troubles`` tells what does.

    ``asked`` counts all messages of viewers, ``refused`` those of them that were
    none, ``failed`` those that asked for what cannot be done; ``dropped`` the
    frames that viewers who have left were too slow for. ``writer`` is told of every
    frame of live traffic, and falls silent where there is none of now. Rudder bands are
    for these ``errors`` of the sensors, and there are none without them.
    """

    def __init__(
        self,
        sources: SourceList,
        logs: Path,
        writer: SignalKWriter | None = None,
        errors: SensorErrorBounds | None = None,
    ):
        self.catalogue, self.logs = sources, logs
        self.writer = writer
        self.viewers: set[ViewerQueue] = set()
        self.asked = self.refused = self.failed = 0
        self.dropped = 0
        self._presenter: Presenter | None = None
        self._listed = m.Catalogue([], [], [])
        self._limits = m.SetLimits()
        self._playing, self._rate = False, 1.0
        #: Held by who uses the session shown, and by who puts another in its place.
        self._lock = asyncio.Lock()
        self._wake = asyncio.Event()
        self._listening: asyncio.Task[None] | None = None
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="voyage")
        self._thinker = ThreadPoolExecutor(1, thread_name_prefix="whatif")
        self._questions: set[asyncio.Task[None]] = set()
        self._requests: set[asyncio.Task[None]] = set()
        self._changes: set[asyncio.Task[None]] = set()
        self._turns: dict[ViewerQueue, RequestQueue] = {}
        #: What fails of the look, of writing back, and of the tasks that run for ever.
        self.fault_log = FaultLog()
        self.jobs = BackgroundJobs(self._tell)
        self.bands = BandWorker(errors, sources.pilot, self._tell)

    @property
    def feed_counts(self) -> dict[str, Any] | None:
        """How much of what the live session heard became of use."""
        return None if self._presenter is None else self._presenter.session.feed_counts

    @property
    def faults(self) -> list[str]:
        """What goes wrong now, one line each."""
        presenter = self._presenter
        there = (
            [] if presenter is None else [*self._trouble_of_writing(presenter), *presenter.faults]
        )
        return list(dict.fromkeys((*self.fault_log.messages, *there)))

    async def join(self, viewer: ViewerQueue) -> None:
        """A viewer begins to look on: she gets what is, then what comes."""
        self._turns[viewer] = RequestQueue(self._requests, self._questions)
        await self._look_up()  # reads the folder of logs: nobody waits for that
        async with self._lock:
            hello, there = self._hello(), []
            if self._presenter is not None:
                with self.fault_log.contain("telling what was shown"):
                    now = "session", self._session_now(self._presenter)
                    there = [now, *await self._work(self._presenter.snapshot), *self.bands.snapshot]
            # Nothing is awaited from here on: she misses nothing of what all are told.
            viewer.put("hello", hello[viewer.role])
            for kind, message in [*self.jobs.snapshot, *there]:
                viewer.put(kind, message)
            self.viewers.add(viewer)

    def leave(self, viewer: ViewerQueue) -> None:
        """A viewer is gone: nothing more is begun for her."""
        self.viewers.discard(viewer)
        turns = self._turns.pop(viewer, None)
        if turns is not None:
            turns.cancel()
        self.dropped += viewer.dropped

    async def handle_message(self, viewer: ViewerQueue, text: str | bytes) -> None:
        """A viewer's message; what is wrong with it is told to her alone.

        Returns before it is done where it may take long.
        """
        self.asked += 1
        try:
            n_messages = m.decode_request(text)
        except InputError as error:
            self.refused += 1
            viewer.put(*_failure(str(error)))
            return
        await self._try(self._take_up(n_messages, viewer), viewer, "request")

    async def _take_up(self, asked: m.Request, viewer: ViewerQueue) -> None:
        if viewer.role == "viewer" and not isinstance(asked, m.ViewerRequest):
            kind = asked.__struct_config__.tag
            raise InputError(f"you are here to look on: {kind!r} is for the owner of this bridge")
        urgent = isinstance(asked, _AT_ONCE) and self._presenter is not None
        if urgent or isinstance(asked, m.Ping):
            await self.execute(asked, viewer)
        else:
            await self._turns[viewer].submit(
                lambda: self._try(self.execute(asked, viewer), viewer, "request"),
                prepared=isinstance(asked, _PREPARED),
            )

    async def _try(self, work: Awaitable[None], viewer: ViewerQueue, what: str) -> None:
        """Do what a viewer asked for; why it cannot be done is told to her alone."""
        try:
            await work
        except InputError as error:
            self.failed += 1
            viewer.put(*_failure(str(error)))
        except Exception:
            self.failed += 1
            _log.exception("a %s failed", what)
            viewer.put(*_failure(f"the server failed at this {what}"))

    async def execute(self, asked: m.Request, viewer: ViewerQueue | None = None) -> None:
        """Do what is asked. InputError if it cannot be done."""
        match asked:
            case m.Ping():
                if viewer is not None:
                    viewer.put("pong", m.encode(m.Pong()))
                return
            case m.AskWhatIf():
                if viewer is not None:
                    self._ask(asked, viewer)
                return
            case m.Open() | m.Replay():
                name = asked.source if isinstance(asked, m.Open) else asked.log
                async with self.jobs.announce(name):
                    share = self.jobs.report_progress
                    await self._begin(lambda: open_session(asked, self.catalogue, self.logs, share))
            case m.SetPilot(name) | m.Compare(str(name)):
                async with self.jobs.announce(name):
                    pilot = await self._ready(name, ahead=isinstance(asked, m.SetPilot))
                    await self._change(asked, pilot)
            case _:
                await self._first_is_there()
                await self._whole(lambda: self._do(asked, self._require_presenter()))

    async def show(self, open_session: Callable[[], Session]) -> None:
        """Begin a session in place of the present one, playing from its start."""
        async with self.jobs.announce("the session"):
            await self._begin(open_session)

    async def play(self) -> None:
        """Show the next frame whenever it is due; runs as long as the server does."""
        last = time.monotonic()
        while True:
            if self._presenter is None or not self._playing:
                await self._wake.wait()
                self._wake.clear()
                last = time.monotonic()
                continue
            every = self._presenter.session.step_s / self._rate
            left = last + every - time.monotonic()
            if left > 0 and await self._woken(left):
                continue  # asked for something meanwhile: perhaps another rate
            # A frame that took too long delays the next ones; they do not rush after it.
            late = -left >= every
            last = time.monotonic() if late else last + every
            async with self._lock:
                await self._advance()

    async def run(self) -> None:
        """All that runs as long as the server does; what fails of it is begun again.

        When it is cancelled, what was written back is withdrawn first.
        """
        running = {
            "keeping time": self.play,
            "computing bands": self.bands.run,
        }
        if self.writer is not None:
            running["writing back"] = self.writer.run
        tasks = [
            asyncio.create_task(supervise(part, run, self.fault_log))
            for part, run in running.items()
        ]
        try:
            await asyncio.gather(*tasks)
        finally:
            await self.withdraw()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def withdraw(self) -> None:
        """Take back for good what was written to Signal K: the server is about to end."""
        if self.writer is not None:
            await self.writer.end()

    def close(self) -> None:
        """Close the log; called when no more is asked. What is still compiled is not waited for."""
        for task in (self._listening, *self._requests, *self._questions, *self._changes):
            if task is not None:
                task.cancel()
        self.jobs.close()
        self.bands.close()
        self._thinker.shutdown(wait=False, cancel_futures=True)
        self._worker.shutdown(wait=True, cancel_futures=True)
        if self._presenter is not None:
            self._presenter.close()

    async def _do(self, asked: m.Request, presenter: Presenter) -> None:
        match asked:
            case m.Pause() | m.SetRate() if presenter.session.info.mode == "live":
                raise InputError("live traffic is shown as it comes: it has no pause and no rate")
            case m.Play():
                self._set(presenter, True, self._rate)
            case m.Pause():
                self._set(presenter, False, self._rate)
            case m.SetRate(rate):
                self._set(presenter, self._playing, rate)
            case m.Seek(time_s):
                await self._jump(lambda: presenter.seek(time_s))
            case m.Compare(None):
                await self._jump(lambda: presenter.compare(None))
            case m.Acknowledge(id):
                told = await self._work(lambda: presenter.acknowledge(id))
                if told is None:
                    raise InputError("no such alarm: its cause is gone")
                self._tell(told)
            case m.SetLimits():
                self._limits = asked
                told = await self._work(lambda: presenter.set_limits(asked))
                self._tell(told, self._hello())

    async def _whole(
        self,
        change: Callable[[], Awaitable[None]],
        unwanted: Callable[[], object] | None = None,
    ) -> None:
        """Change what is shown: once begun it is done to the end, even if who asked for it leaves.

        If she leaves before that, what was prepared for it is ``unwanted``.
        """

        async def changed() -> None:
            try:
                await change()
            finally:
                self._lock.release()
                self._wake.set()

        try:
            await self._lock.acquire()
        except asyncio.CancelledError:
            if unwanted is not None:
                self._worker.submit(unwanted)
            raise
        task = asyncio.create_task(changed())
        self._changes.add(task)
        task.add_done_callback(self._changes.discard)
        await asyncio.shield(task)

    def _ask(self, asked: m.AskWhatIf, viewer: ViewerQueue) -> None:
        """Take up a question; the voyage goes on, and the viewer goes on asking, meanwhile."""
        if len(self._questions) >= MAX_WAITING_QUESTIONS - RESERVED_FOR_OWNERS * (
            viewer.role == "viewer"
        ):
            raise InputError("too many questions at once: wait for the answers")
        self._turns[viewer].submit_question(lambda: self._reply(asked, viewer))

    async def _reply(self, asked: m.AskWhatIf, viewer: ViewerQueue) -> None:
        await self._try(self._answer(asked, viewer), viewer, "question")

    async def _answer(self, asked: m.AskWhatIf, viewer: ViewerQueue) -> None:
        async with self._lock:
            presenter = self._require_presenter()
            question = await self._work(
                lambda: WhatIfQuery.from_request(asked, presenter.session, self.catalogue.pilot)
            )
        think = asyncio.get_running_loop().run_in_executor(self._thinker, answer, question)
        viewer.put("whatif", m.encode(await think))

    async def _first_is_there(self) -> None:
        """Wait for the first session, if it is being prepared."""
        if self._presenter is None:
            await self.jobs.wait_idle()

    async def _ready(self, name: str, ahead: bool) -> Pilot:
        """A pilot with whom the session shown could go on at once."""
        session = self._require_presenter().session

        def ready() -> Pilot:
            pilot = self.catalogue.pilot(name)
            session.warm_up(pilot, ahead)
            return pilot

        return await self.jobs.run(ready)

    async def _change(self, asked: m.SetPilot | m.Compare, pilot: Pilot) -> None:
        async def change() -> None:
            presenter = self._require_presenter()
            hands_over = isinstance(asked, m.SetPilot)
            await self._jump(
                lambda: presenter.set_pilot(pilot) if hands_over else presenter.compare(pilot)
            )

        await self._whole(change)

    async def _begin(self, open_session: Callable[[], Session]) -> None:
        """Prepare a session, and put it in place of the one shown."""
        limits = self._limits

        def begin() -> tuple[Presenter, Exception | None]:
            presenter = Presenter(open_session(), limits)
            try:
                presenter.advance()
            except Exception as error:
                if presenter.session.info.mode == "live":
                    return presenter, error
                presenter.close()
                raise
            return presenter, None

        presenter, failed = await self.jobs.run(begin, lambda made: made[0].close())
        try:
            await self._look_up()  # there is one log more
        except asyncio.CancelledError:
            self._worker.submit(presenter.close)
            raise
        await self._whole(lambda: self._replace(presenter, failed), presenter.close)

    async def _replace(self, presenter: Presenter, failed: Exception | None) -> None:
        """Show it in place of the present one; ``failed``: its first look has."""

        def present() -> list[Told]:
            presenter.set_limits(self._limits)  # perhaps others by now
            return presenter.snapshot()

        told = await self._work(present)
        # Nothing is awaited while one takes the other's place.
        if self._listening is not None:
            self._listening.cancel()
        self.fault_log.clear(_FEED)
        self.fault_log.clear(_LOOK)
        if failed is not None:
            self.fault_log.record(_LOOK, failed, _AGAIN)
        old, self._presenter = self._presenter, presenter
        self._playing, self._rate = True, 1.0
        self._listening = asyncio.create_task(self._listen(presenter.session))
        with self.fault_log.contain(_WRITING):
            self._write_back(presenter)
        self._tell([("session", self._session_now(presenter)), *told], self._hello())
        with self.fault_log.contain(_CERTIFYING):
            self._certify()
        if old is not None:
            with self.fault_log.contain("closing the session before"):
                await self._work(old.close)

    async def _listen(self, session: Session) -> None:
        """Hear what its source says; only a file comes to an end."""

        def told(why: str) -> None:
            self._tell([_notice(why)])

        if session.endless:
            await supervise(_FEED, session.listen, self.fault_log, told)
            return
        try:
            await session.listen()
        except Exception as error:
            told(self.fault_log.record(_FEED, error, "nothing more is heard"))

    async def _jump(self, jump: Callable[[], list[Told]]) -> None:
        """A request after which the page begins anew."""
        told = await self._work(jump)
        self._tell([("session", self._session_now(self._require_presenter())), *told])
        self._certify()

    async def _advance(self) -> None:
        presenter = self._presenter
        if presenter is None or not self._playing:
            return
        live, told = presenter.session.info.mode == "live", None
        try:
            told = await self._work(presenter.advance)
        except Exception as error:
            new = _LOOK not in self.fault_log
            why = self.fault_log.record(_LOOK, error, _AGAIN if live else _PAUSED)
            if new or not live:
                self._tell([_notice(why)])
        else:
            self.fault_log.clear(_LOOK)
        # First of all: what stands elsewhere is of a frame of now, or goes.
        with self.fault_log.contain(_WRITING):
            self._write_back(presenter if told else None)
        self._playing = live or told is not None
        with self.fault_log.contain(_CERTIFYING):
            self._certify()
        with self.fault_log.contain("telling the session"):
            if live or told is None:
                self._tell([("session", self._session_now(presenter))])
        self._tell(told or [])

    def _write_back(self, presenter: Presenter | None) -> None:
        """Tell what a frame of now says; what was told before is withdrawn if there is none."""
        if self.writer is None:
            return
        try:
            frame = None if presenter is None else presenter.frame
            if (
                presenter is None
                or frame is None
                or not (_of_now(presenter.session) and presenter.alarms_are_current)
            ):
                self.writer.fall_silent()
            else:
                self.writer.tell(frame, presenter.alarms)
        except BaseException:
            self.writer.fall_silent()
            raise

    def _set(self, presenter: Presenter, playing: bool, rate: float) -> None:
        self._playing, self._rate = playing, rate
        self._tell([("session", self._session_now(presenter))])
        self._certify()

    def _certify(self) -> None:
        """The frame shown stands until the next one is due: is there time for its band?"""
        presenter = self._presenter
        if presenter is None:
            return
        every = presenter.session.step_s / self._rate if self._playing else math.inf
        self.bands.request(presenter.recent, every)

    async def _look_up(self) -> None:
        """See what there is to open now; what was there before is told where that fails."""
        with self.fault_log.contain("listing what may be opened"):
            self._listed = await asyncio.to_thread(self.catalogue.catalogue)

    def _hello(self) -> dict[m.Role, bytes]:
        """What there is to open, and the limits of the alarms; for each role."""
        bounds = m.AlarmLimits(self._limits.dcpa_m, self._limits.tcpa_s)
        roles: tuple[m.Role, ...] = get_args(m.Role)
        listed = self._listed
        return {role: m.encode(m.Hello(__version__, listed, bounds, role)) for role in roles}

    def _require_presenter(self) -> Presenter:
        if self._presenter is None:
            raise InputError("nothing is open yet: open a source first")
        return self._presenter

    def _session_now(self, presenter: Presenter) -> bytes:
        notes = [*self.fault_log.messages, *self._trouble_of_writing(presenter)]
        return presenter.session_message(self._playing, self._rate, *notes)

    def _trouble_of_writing(self, presenter: Presenter) -> list[str]:
        live = presenter.session.info.mode == "live"
        trouble = self.writer.trouble if self.writer is not None and live else None
        return [] if trouble is None else [trouble]

    def _tell(self, told: list[Told], hello: dict[m.Role, bytes] | None = None) -> None:
        for viewer in self.viewers:
            if hello is not None:
                viewer.put("hello", hello[viewer.role])
            for kind, message in told:
                viewer.put(kind, message)

    async def _work(self, job: Callable[[], Result]) -> Result:
        return await asyncio.get_running_loop().run_in_executor(self._worker, run_isolated, job)

    async def _woken(self, seconds: float) -> bool:
        try:
            async with asyncio.timeout(seconds):
                await self._wake.wait()
        except TimeoutError:
            return False
        self._wake.clear()
        return True


def _of_now(session: Session) -> bool:
    """Whether this is live traffic, and own ship is where it shows her: a page does not call it
    live otherwise, whoever else is heard."""
    own_s = session.own_position_age_s
    return session.connected and own_s is not None and own_s <= OWN_STALE_S


def _notice(text: str) -> Told:
    return "notice", m.encode(m.Notice(text))


def _failure(text: str) -> Told:
    return "failure", m.encode(m.ErrorMessage(text))
