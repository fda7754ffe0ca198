"""The viewers and their requests: all viewers share one session.

Whatever may take long (another session, another pilot, whose programs are compiled first) is
prepared in a background thread while frames, alarms and answers go on. What-if questions have a
thread of their own.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, get_args

from glasshelm import __version__
from glasshelm.bridge.annotate.whatif_queries import WhatIfQuery, answer
from glasshelm.bridge.server import protocol as m
from glasshelm.bridge.server.background_jobs import BackgroundJobs
from glasshelm.bridge.server.presenter import Presenter
from glasshelm.bridge.server.protocol import Outgoing, encode
from glasshelm.bridge.server.request_queue import RequestQueue, Tasks
from glasshelm.bridge.server.session_player import SessionPlayer
from glasshelm.bridge.server.viewer_queue import ViewerQueue
from glasshelm.bridge.sessions.session import Session
from glasshelm.bridge.sessions.session_factory import open_session
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.core.errors import InputError
from glasshelm.live.signalk_writer import SignalKWriter
from glasshelm.pilots.protocols import Pilot

#: Viewers at once.
MAX_VIEWERS = 100
#: Questions that wait for an answer at once; the last of them are reserved for owners.
MAX_WAITING_QUESTIONS, RESERVED_FOR_OWNERS = 8, 2
_log = logging.getLogger("glasshelm.bridge")


class SessionHub:
    """Serves one session to its viewers. No failure ends it: :meth:`health` reports them.

    Args:
        sources: What can be opened.
        log_dir: Folder for the logs of the sessions.
        writer: Writes advice in live traffic back to Signal K.
        errors: The largest sensor errors that rudder bands allow for; None: no bands.
    """

    def __init__(
        self,
        sources: SourceList,
        log_dir: Path,
        writer: SignalKWriter | None = None,
        errors: SensorErrorBounds | None = None,
    ):
        self.sources, self.log_dir = sources, log_dir
        self.viewers: set[ViewerQueue] = set()
        self.n_messages = self.n_invalid = self.n_failed = 0
        self.player = SessionPlayer(self._broadcast, sources.pilot, writer, errors)
        self.jobs = BackgroundJobs(self._broadcast)
        #: Frames that viewers who have left were too slow for.
        self._n_dropped = 0
        self._catalogue = m.Catalogue([], [], [])
        self._questions: Tasks = set()
        self._requests: Tasks = set()
        self._queues: dict[ViewerQueue, RequestQueue] = {}
        self._whatif_thread = ThreadPoolExecutor(1, thread_name_prefix="whatif")

    def health(self) -> dict[str, Any]:
        """Return faults and counts for ``/api/health``."""
        faults, presenter = self.player.faults, self.player.presenter
        return {
            "status": "failing" if faults else "ok",
            "faults": faults,
            "viewers": len(self.viewers),
            "messages": self.n_messages,
            "invalid_messages": self.n_invalid,
            "failed_messages": self.n_failed,
            "dropped_frames": self._n_dropped + sum(viewer.dropped for viewer in self.viewers),
            "feed_counts": None if presenter is None else presenter.session.status().feed_counts,
        }

    async def run(self) -> None:
        """Play sessions as long as the server runs."""
        await self.player.run()

    def close(self) -> None:
        """Close the session and its log. Compiling jobs are not waited for."""
        for task in (*self._requests, *self._questions):
            task.cancel()
        self.jobs.close()
        self._whatif_thread.shutdown(wait=False, cancel_futures=True)
        self.player.close()

    async def join(self, viewer: ViewerQueue) -> None:
        """Add a viewer: it gets what is shown now, then what comes."""
        self._queues[viewer] = RequestQueue(self._requests, self._questions)
        await self._update_catalogue()  # reads the folder of logs: nobody waits for that
        async with self.player.lock:
            messages = await self.player.snapshot()
            # Nothing is awaited from here on, so the viewer misses nothing that is broadcast.
            viewer.put(self._hello(viewer.role))
            for message in [*self.jobs.snapshot, *messages]:
                viewer.put(message)
            self.viewers.add(viewer)

    def leave(self, viewer: ViewerQueue) -> None:
        """Remove a viewer: nothing more is begun for it."""
        self.viewers.discard(viewer)
        queue = self._queues.pop(viewer, None)
        if queue is not None:
            queue.cancel()
        self._n_dropped += viewer.dropped

    async def handle_message(self, viewer: ViewerQueue, text: str | bytes) -> None:
        """Handle a viewer's message; an error goes only to that viewer.

        Returns before a slow request is done.
        """
        self.n_messages += 1
        try:
            request = m.decode_request(text)
        except InputError as error:
            self.n_invalid += 1
            viewer.put(encode(m.ErrorMessage(str(error))))
            return
        await self._attempt(self._dispatch(request, viewer), viewer, "request")

    async def _dispatch(self, request: m.Request, viewer: ViewerQueue) -> None:
        if viewer.role == "viewer" and not isinstance(request, m.ViewerRequest):
            kind = request.__struct_config__.tag
            raise InputError(f"you are a viewer: {kind!r} is for the owner of this bridge")
        is_open = self.player.presenter is not None
        if isinstance(request, m.Ping) or (is_open and isinstance(request, m.ImmediateRequest)):
            await self.execute(request, viewer)
        else:
            await self._queues[viewer].submit(
                lambda: self._attempt(self.execute(request, viewer), viewer, "request"),
                slow=isinstance(request, m.SlowRequest),
            )

    async def _attempt(self, work: Awaitable[None], viewer: ViewerQueue, what: str) -> None:
        """Do what a viewer asked for; the reason of a failure goes only to that viewer."""
        try:
            await work
        except Exception as error:
            self.n_failed += 1
            message = str(error)
            if not isinstance(error, InputError):
                _log.exception("a %s failed", what)
                message = f"the server failed at this {what}"
            viewer.put(encode(m.ErrorMessage(message)))

    async def execute(self, request: m.Request, viewer: ViewerQueue | None = None) -> None:
        """Execute a request, of a viewer if it has an answer. InputError if it cannot be done."""
        match request:
            case m.Ping():
                if viewer is not None:
                    viewer.put(encode(m.Pong()))
            case m.AskWhatIf():
                if viewer is not None:
                    self._ask(request, viewer)
            case m.Open() | m.Replay():
                name = request.source if isinstance(request, m.Open) else request.log
                progress = self.jobs.report_progress
                await self.show(
                    lambda: open_session(request, self.sources, self.log_dir, progress), name
                )
            case m.SetPilot(name) | m.Compare(str(name)):
                async with self.jobs.announce(name):
                    await self._use_pilot(request, name)
            case _:
                if self.player.presenter is None:
                    await self.jobs.wait_idle()  # perhaps the first session is being prepared
                await self.player.exclusively(lambda: self.player.apply(request))
                if isinstance(request, m.SetLimits):
                    self._broadcast_hello()

    async def show(self, open_session: Callable[[], Session], name: str = "the session") -> None:
        """Open a session and show it in place of the present one, playing from its start."""
        limits = self.player.limits

        def prepare() -> tuple[Presenter, Exception | None]:
            presenter = Presenter(open_session(), limits)
            try:
                presenter.advance()
            except Exception as error:
                if presenter.session.info.mode == "live":
                    return presenter, error
                presenter.close()
                raise
            return presenter, None

        async with self.jobs.announce(name):
            presenter, error = await self.jobs.run(prepare, lambda result: result[0].close())
            try:
                await self._update_catalogue()  # there is one more log
            except asyncio.CancelledError:
                self.player.discard(presenter)
                raise

            async def replace() -> None:
                self._broadcast_hello()  # before the session that the new log is of
                await self.player.replace(presenter, error)

            await self.player.exclusively(replace, presenter.close)

    async def _use_pilot(self, request: m.SetPilot | m.Compare, name: str) -> None:
        """Prepare a pilot for the session shown, then let it decide or compare with it."""
        session, sets = self.player.require_presenter().session, isinstance(request, m.SetPilot)

        def prepare() -> Pilot:
            pilot = self.sources.pilot(name)
            session.warm_up(pilot, predict=sets)
            return pilot

        pilot = await self.jobs.run(prepare)

        async def use() -> None:
            presenter = self.player.require_presenter()
            change = presenter.set_pilot if sets else presenter.compare
            await self.player.jump(lambda: change(pilot))

        await self.player.exclusively(use)

    def _ask(self, request: m.AskWhatIf, viewer: ViewerQueue) -> None:
        """Start to answer a question; the session goes on meanwhile."""
        reserved = RESERVED_FOR_OWNERS if viewer.role == "viewer" else 0
        if len(self._questions) >= MAX_WAITING_QUESTIONS - reserved:
            raise InputError("too many questions at once: wait for the answers")
        self._queues[viewer].submit_question(
            lambda: self._attempt(self._answer(request, viewer), viewer, "question")
        )

    async def _answer(self, request: m.AskWhatIf, viewer: ViewerQueue) -> None:
        async with self.player.lock:
            session = self.player.require_presenter().session
            query = await self.player.in_worker(
                lambda: WhatIfQuery.from_request(request, session, self.sources.pilot)
            )
        loop = asyncio.get_running_loop()
        viewer.put(encode(await loop.run_in_executor(self._whatif_thread, answer, query)))

    async def _update_catalogue(self) -> None:
        """List what can be opened now; if that fails the last list stays."""
        with self.player.fault_log.contain("listing what can be opened"):
            self._catalogue = await asyncio.to_thread(self.sources.catalogue)

    def _hello(self, role: m.Role) -> Outgoing:
        limits = m.AlarmLimits(self.player.limits.dcpa_m, self.player.limits.tcpa_s)
        return encode(m.Hello(__version__, self._catalogue, limits, role))

    def _broadcast_hello(self) -> None:
        hello = {role: self._hello(role) for role in get_args(m.Role)}
        for viewer in self.viewers:
            viewer.put(hello[viewer.role])

    def _broadcast(self, messages: list[Outgoing]) -> None:
        for viewer in self.viewers:
            for message in messages:
                viewer.put(message)
