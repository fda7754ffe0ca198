"""Telling Signal K what the pilot would do: rudder target, closest approaches, notifications.

Only for who asked for it and has a token: other instruments on board may act on what is written.
"""

import asyncio
import contextlib
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

import msgspec
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import WebSocketException

from glasshelm.feeds.again import Backoff
from glasshelm.feeds.reasons import reason
from glasshelm.feeds.signalk import SignalK
from glasshelm.frames import Frame, Target

RUDDER = "steering.rudderAngleTarget"
CLOSEST = "navigation.closestApproach"
SELF = "vessels.self"
#: What is written while closing must be written within [s].
_FAREWELL_S = 2.0


@runtime_checkable
class Alarm(Protocol):
    """What is told of an alarm: the ship, the reason, whether somebody has acknowledged it."""

    @property
    def target(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def cause(self) -> str: ...


class WriteBack:
    """Writes to one server.

    ``tell`` never waits and never fails: what is told last is written when ``run``,
    a task of its own, can write. After ``fall_silent``, and when ``run`` is cancelled,
    everything written is withdrawn: no advice stays behind that nobody gives any more.
    """

    def __init__(self, server: SignalK):
        self.title = f"writing to Signal K at {server.address}"
        self.connected = False
        self.trouble: str | None = None
        #: How many frames were told, and how many of them were written.
        self.told, self.written = 0, 0
        self._server = server
        self._latest: dict[tuple[str, str], Any] | None = None
        self._news = asyncio.Event()
        self._standing: dict[tuple[str, str], Any] = {}

    def tell(self, frame: Frame, alarms: Sequence[Alarm]) -> None:
        """Have a frame and the alarms of its instant written; replaces what is not written yet."""
        self.told += 1
        self._say(said_of(frame, alarms))

    def fall_silent(self) -> None:
        """Have everything withdrawn: there is no picture of now to tell of."""
        self._say({})

    def _say(self, said: dict[tuple[str, str], Any]) -> None:
        self._latest = said
        self._news.set()

    async def run(self) -> None:
        """Write what is told until cancelled; connects again by itself."""
        backoff = Backoff()
        while True:
            try:
                socket = await self._server.connect("none")
            except (OSError, WebSocketException) as error:
                self.trouble = f"{self.title}: {reason(error)}"
                await backoff.wait()
                continue
            self.connected, self.trouble = True, None
            try:
                await self._write_all(socket, backoff)
            except (OSError, WebSocketException) as error:
                self.trouble = f"{self.title}: {reason(error)}"
            finally:
                self.connected = False
                await self._withdraw(socket)
            await backoff.wait()

    async def _write_all(self, socket: ClientConnection, backoff: Backoff) -> None:
        """Write what is told, and read what the server says, for as long as the connection holds.

        What it says (its hello, refusals) must be read: unread, it would fill the line.
        """
        listening = asyncio.create_task(_read(socket))
        try:
            while not listening.done():
                news = asyncio.create_task(self._news.wait())
                await asyncio.wait((news, listening), return_when=asyncio.FIRST_COMPLETED)
                news.cancel()
                if self._latest is None:
                    continue
                said, self._latest = self._latest, None
                self._news.clear()
                await self._write(socket, said)
                self.written += 1
                backoff.succeeded()
            listening.result()
        finally:
            listening.cancel()

    async def _write(self, socket: ClientConnection, said: Mapping[tuple[str, str], Any]) -> None:
        """Write what is new or changed, and withdraw what is no longer said."""
        changed = {key: v for key, v in said.items() if self._standing.get(key) != v}
        gone = {key: _withdrawn(key[1]) for key in self._standing if key not in said}
        for delta in deltas(changed | gone):
            await socket.send(delta)
        self._standing = dict(said)

    async def _withdraw(self, socket: ClientConnection) -> None:
        with contextlib.suppress(OSError, WebSocketException):
            async with asyncio.timeout(_FAREWELL_S):
                await self._write(socket, {})
                await socket.close()
        # What is still there on the server nobody knows now: next time all of it is written again.
        self._standing = dict.fromkeys(self._standing)


async def _read(socket: ClientConnection) -> None:
    while True:
        await socket.recv()


def said_of(frame: Frame, alarms: Sequence[Alarm]) -> dict[tuple[str, str], Any]:
    """What a frame says to Signal K: context and path, and the value there."""
    said: dict[tuple[str, str], Any] = {}
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


def deltas(said: Mapping[tuple[str, str], Any]) -> list[str]:
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
    return f"vessels.{f'urn:mrn:imo:mmsi:{int(number):09d}' if number.isdigit() else number}"


def _label(number: str) -> str:
    """A ship's number as one part of a path: a dot would begin another."""
    return number.replace(".", "_")
