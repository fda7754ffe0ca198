"""Telling Signal K what the pilot would do: rudder target, closest approaches, notifications.

Only on request and with a token: other instruments on board may act on what is written.
"""

import asyncio
import contextlib
import logging
import time
from asyncio import FIRST_COMPLETED
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

import msgspec
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import WebSocketException

from glasshelm.ais.mmsi import is_number
from glasshelm.feeds.backoff import Backoff
from glasshelm.feeds.connection_errors import reason
from glasshelm.feeds.signalk_client import SignalK
from glasshelm.frames.schema import Frame, Target

RUDDER = "steering.rudderAngleTarget"
CLOSEST = "navigation.closestApproach"
SELF = "vessels.self"
#: What is told must be told again within so long [s]: it is no longer of now otherwise.
STALE_S = 15.0
#: What is written while closing must be written within [s].
_FAREWELL_S = 2.0
#: Values that no other equals: of what may or may not be on the server, and of what is not.
_UNKNOWN, _NOTHING = object(), object()
#: A context and a path of Signal K.
Key = tuple[str, str]
_log = logging.getLogger("glasshelm.bridge")


@runtime_checkable
class Alarm(Protocol):
    """What is written about an alarm: the ship, the reason, whether it is acknowledged."""

    @property
    def target(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def cause(self) -> str: ...


class SignalKWriter:
    """Writes to one server.

    ``tell`` never waits: the newest values are written when ``run``, a task of its own, can write.
    After ``fall_silent``, when nothing new came for ``STALE_S``, and when ``run`` ends, everything
    written is withdrawn: no advice stays behind that nobody gives any more. What a connection
    that broke may have left on the server is withdrawn, or written anew, by the next one.
    """

    def __init__(self, server: SignalK):
        self.title = f"writing to Signal K at {server.address}"
        self.connected = False
        self.trouble: str | None = None
        #: How many frames were told, and how many of them were written.
        self.told, self.written = 0, 0
        self._server = server
        #: What is to stand on the server, since when, and whether its frame is yet to be written.
        self._wanted: dict[Key, Any] = {}
        self._wanted_at = 0.0
        self._unwritten = False
        self._news = asyncio.Event()
        #: What may stand on the server: the value written last, or ``_UNKNOWN``.
        self._standing: dict[Key, Any] = {}
        #: What was withdrawn, and has not been read by the server for sure.
        self._leaving: dict[Key, object] = {}
        self._task: asyncio.Task[Any] | None = None

    def tell(self, frame: Frame, alarms: Sequence[Alarm]) -> None:
        """Have a frame and the alarms of its instant written; replaces what is not written yet.

        Where they cannot be written, everything is withdrawn, and the error raised.
        """
        try:
            said = said_of(frame, alarms)
        except Exception:
            self.fall_silent()
            raise
        self.told += 1
        self._unwritten = True
        self._say(said)

    def fall_silent(self) -> None:
        """Have everything withdrawn: there is no current picture."""
        self._unwritten = False
        self._say({})

    def _say(self, said: dict[Key, Any]) -> None:
        # One who was killed may have left a rudder there: the first word replaces or withdraws it.
        if self._wanted_at == 0.0:
            self._standing.setdefault((SELF, RUDDER), _UNKNOWN)
        self._wanted, self._wanted_at = said, time.monotonic()
        self._news.set()

    async def run(self) -> None:
        """Write the newest values until cancelled; reconnects by itself after any failure."""
        self._task, backoff = asyncio.current_task(), Backoff()
        try:
            while True:
                try:
                    socket = await self._server.connect("none")
                except Exception as error:
                    self._failed(error)
                else:
                    await self._hold(socket, backoff)
                await backoff.wait()
        finally:
            if self._standing:
                await self._withdraw_anew()

    async def end(self) -> None:
        """Withdraw everything for good; returns when that is done, or cannot be done in time."""
        if self._task is not None and not self._task.done():
            self._task.cancel()
            await asyncio.wait((self._task,), timeout=3 * _FAREWELL_S)

    async def _hold(self, socket: ClientConnection, backoff: Backoff) -> None:
        """Write for as long as the connection holds, then withdraw what it wrote."""
        self.connected, self.trouble = True, None
        try:
            await self._write_all(socket, backoff)
        except Exception as error:
            self._failed(error)
        finally:
            self.connected = False
            await self._part(socket)

    async def _write_all(self, socket: ClientConnection, backoff: Backoff) -> None:
        """Write the newest values, and read what the server says, while the connection holds.

        What it says (its hello, refusals) must be read: unread, it would fill the line.
        """
        listening = asyncio.create_task(_read(socket))
        if self._standing or self._wanted:
            self._news.set()  # what the connection before this one has left, or not written
        try:
            while not listening.done():
                news = asyncio.create_task(self._news.wait())
                await asyncio.wait(
                    (news, listening), timeout=self._patience(), return_when=FIRST_COMPLETED
                )
                news.cancel()
                if self._patience() == 0.0:
                    self.fall_silent()  # whoever told of it tells no more
                if listening.done() or not self._news.is_set():
                    continue
                self._news.clear()
                told, self._unwritten = self._unwritten, False
                await self._write(socket, self._wanted)
                self.written += told
                backoff.succeeded()
            listening.result()
        finally:
            listening.cancel()

    def _patience(self) -> float | None:
        """Seconds for which what is wanted is still of now; None where nothing is wanted."""
        if not self._wanted:
            return None
        return max(self._wanted_at + STALE_S - time.monotonic(), 0.0)

    async def _write(self, socket: ClientConnection, said: Mapping[Key, Any]) -> None:
        """Write what is new or changed, and withdraw what is no longer said."""
        changed = {key: v for key, v in said.items() if self._standing.get(key, _NOTHING) != v}
        gone = {key: _withdrawn(key[1]) for key in self._standing if key not in said}
        # Sending may fail in the middle: until all is sent, any of it may be there.
        self._standing |= dict.fromkeys(changed, _UNKNOWN)
        for delta in deltas(changed | gone):
            await socket.send(delta)
        self._standing = dict(said)
        for key in said:
            self._leaving.pop(key, None)
        if gone:
            sent = object()
            self._leaving |= dict.fromkeys(gone, sent)
            pong = asyncio.ensure_future(await socket.ping())
            pong.add_done_callback(lambda pong: self._read_by_server(pong, sent))

    def _read_by_server(self, pong: asyncio.Future[float], sent: object) -> None:
        """The server has answered, so it has read what was sent before."""
        if not pong.cancelled() and pong.exception() is None:
            self._leaving = {key: at for key, at in self._leaving.items() if at is not sent}

    async def _part(self, socket: ClientConnection) -> None:
        """Withdraw everything, and see that the server reads it; what is not sure stays known."""
        try:
            with contextlib.suppress(Exception):
                async with asyncio.timeout(_FAREWELL_S):
                    await self._write(socket, {})
                    await (await socket.ping())
                    self._leaving.clear()
            with contextlib.suppress(Exception):
                async with asyncio.timeout(_FAREWELL_S):
                    await socket.close()
        finally:
            self._standing = dict.fromkeys((*self._standing, *self._leaving), _UNKNOWN)
            self._leaving.clear()

    async def _withdraw_anew(self) -> None:
        """The last connection broke: withdraw over another one what it may have left."""
        with contextlib.suppress(Exception):
            async with asyncio.timeout(_FAREWELL_S):
                socket = await self._server.connect("none")
            await self._part(socket)
        if self._standing:
            _log.error("%s: what was written could not be withdrawn", self.title)

    def _failed(self, error: Exception) -> None:
        self.trouble = f"{self.title}: {reason(error)}"
        if not isinstance(error, OSError | WebSocketException):
            _log.error("%s failed", self.title, exc_info=error)


async def _read(socket: ClientConnection) -> None:
    while True:
        await socket.recv()


def said_of(frame: Frame, alarms: Sequence[Alarm]) -> dict[Key, Any]:
    """What a frame says to Signal K: context and path, and the value there."""
    said: dict[Key, Any] = {}
    if frame.decision is not None:
        said[SELF, RUDDER] = frame.decision.rudder_rad
    for target in frame.targets:
        if not target.lost and target.tcpa_s > 0 and target.id:
            said[_context(target), CLOSEST] = {
                "distance": target.dcpa_m,
                "timeTo": target.tcpa_s,
            }
    for alarm in alarms:
        silent = alarm.state == "acknowledged"
        said[SELF, f"notifications.{CLOSEST}.{_label(alarm.target)}"] = {
            "state": "alarm",
            "method": ["visual"] if silent else ["visual", "sound"],
            "message": f"{alarm.name}: {alarm.cause}",
        }
    return said


def deltas(said: Mapping[Key, Any]) -> list[str]:
    """Signal K deltas, one a context; the server dates them."""
    contexts: dict[str, list[dict[str, Any]]] = {}
    for (context, path), value in said.items():
        contexts.setdefault(context, []).append({"path": path, "value": value})
    return [
        msgspec.json.encode(
            {
                "context": context,
                "updates": [{"source": {"label": "glasshelm"}, "values": values}],
            }
        ).decode()
        for context, values in contexts.items()
    ]


def _withdrawn(path: str) -> Any:
    """A notification becomes normal, any other value unknown."""
    if path.startswith("notifications."):
        return {"state": "normal", "method": [], "message": "no longer within the limits"}
    return None


def _context(target: Target) -> str:
    number = target.id
    return f"vessels.{f'urn:mrn:imo:mmsi:{int(number):09d}' if is_number(number) else number}"


def _label(number: str) -> str:
    """A ship's number as one part of a path: a dot would begin another."""
    return number.replace(".", "_")
