"""What the page and the server say to each other: JSON objects, each with its ``type``.

docs/bridge.md holds the same as a table. Frames travel as the bytes that stand
in the log: they are encoded once, however many look on.
"""

from typing import Annotated, Any, Literal

import msgspec

from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Band

#: Longer messages of a viewer are refused [bytes].
MAX_REQUEST_BYTES = 64 * 1024

ShortText = Annotated[str, msgspec.Meta(max_length=200)]
SourceKind = Literal["simulated", "recorded", "live"]
Mode = Literal["simulated", "recorded", "live", "replay"]
#: An owner may change what all see; a viewer looks on, and may ask what-if.
Role = Literal["owner", "viewer"]


class _Request(msgspec.Struct, frozen=True, tag_field="type", tag=str.lower):
    """A request of a viewer."""


class Open(_Request, frozen=True):
    """Begin a session. ``own`` and ``at`` are of recorded traffic only."""

    source: ShortText
    pilot: ShortText | None = None
    ship: ShortText | None = None
    own: ShortText | None = None
    at: ShortText | None = None


class Replay(_Request, frozen=True):
    """Show a log again, by its name in the catalogue."""

    log: ShortText


class SetPilot(_Request, frozen=True, tag="pilot"):
    """From now on another pilot decides."""

    name: ShortText


class Compare(_Request, frozen=True):
    """Show beside it how another pilot sails the same; null: no longer."""

    name: ShortText | None = None


class Play(_Request, frozen=True):
    pass


class Pause(_Request, frozen=True):
    pass


class SetRate(_Request, frozen=True, tag="rate"):
    """Seconds of the voyage a second."""

    rate: Annotated[float, msgspec.Meta(ge=1, le=60)]


class Seek(_Request, frozen=True):
    time_s: Annotated[float, msgspec.Meta(ge=0, le=1e7)]


class Acknowledge(_Request, frozen=True):
    """An alarm has been seen: for all viewers at once."""

    id: ShortText


class SetLimits(_Request, frozen=True, tag="limits"):
    """An alarm is raised where DCPA and TCPA are both below these."""

    dcpa_m: Annotated[float, msgspec.Meta(ge=0, le=50_000)] = 1852.0
    tcpa_s: Annotated[float, msgspec.Meta(ge=0, le=3600)] = 600.0


class AskWhatIf(_Request, frozen=True, tag="whatif"):
    """How own ship would go on from the frame shown if something were different.

    ``ship`` is deleted, hidden from the pilot, or keeps her course (null: own ship);
    ``degrees`` is the rudder to hold for a minute, starboard positive.
    """

    change: Literal["deleted", "blind", "kept", "rudder"]
    ship: ShortText | None = None
    degrees: Annotated[float, msgspec.Meta(ge=-90, le=90)] | None = None


class Ping(_Request, frozen=True):
    pass


Request = (
    Open
    | Replay
    | SetPilot
    | Compare
    | Play
    | Pause
    | SetRate
    | Seek
    | Acknowledge
    | SetLimits
    | AskWhatIf
    | Ping
)
#: What changes nothing that others see.
ViewerRequest = Ping | AskWhatIf
_decoder = msgspec.json.Decoder(Request)


def decode_request(text: str | bytes) -> Request:
    """A viewer's message. InputError, in one line, if it is none."""
    try:
        text = text.encode() if isinstance(text, str) else text
        if len(text) > MAX_REQUEST_BYTES:
            raise InputError(
                f"a message of {len(text)} bytes: at most {MAX_REQUEST_BYTES} are read"
            )
        return _decoder.decode(text)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise InputError(f"not a message of this protocol: {_line(error)}") from None


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__


class ServerMessage(msgspec.Struct, frozen=True, tag_field="type", tag=str.lower):
    """A message of the server."""


class SourceEntry(msgspec.Struct, frozen=True):
    source: str
    title: str
    kind: SourceKind


class PilotEntry(msgspec.Struct, frozen=True):
    """``ship`` is the preset that the pilot was made for; null: any."""

    name: str
    title: str
    kind: Literal["learned", "classical", "planner"]
    ship: str | None


class LogEntry(msgspec.Struct, frozen=True, omit_defaults=True):
    """A log; of a long one how many frames it has may not be known yet."""

    name: str
    frames: int | None = None
    time_utc: str | None = None


class Catalogue(msgspec.Struct, frozen=True):
    """All that may be opened from the page."""

    scenarios: list[SourceEntry]
    pilots: list[PilotEntry]
    logs: list[LogEntry]


class AlarmLimits(msgspec.Struct, frozen=True):
    """The limits of the alarms."""

    dcpa_m: float
    tcpa_s: float


class Hello(ServerMessage, frozen=True):
    """``role`` is that of who is told."""

    version: str
    catalogue: Catalogue
    limits: AlarmLimits
    role: Role


class Preparing(ServerMessage, frozen=True):
    """What is being made ready while the session shown goes on; null: no more."""

    what: str | None


class SessionMessage(ServerMessage, frozen=True, tag="session"):
    """What is being shown, and how. In live traffic ``heard_s`` is the age of the last position
    heard of any ship, ``own_s`` that of own ship's own."""

    source: str
    title: str
    mode: Mode
    pilot: str
    compare: str | None
    ship: str
    playing: bool
    rate: float
    time_s: float
    end_s: float | None
    seekable_from_s: float
    seekable_to_s: float
    notes: list[str]
    connected: bool
    heard_s: float | None
    own_s: float | None
    log: str | None


class History(ServerMessage, frozen=True):
    """All frames that the page is to hold; ``compare`` those of the compared pilot."""

    frames: list[msgspec.Raw]
    compare: list[msgspec.Raw]


class Sentence(msgspec.Struct, frozen=True):
    what: str
    why: str
    next: str


class EncounterStatus(msgspec.Struct, frozen=True):
    """What own ship is to a target under the COLREGs, while there is risk of collision."""

    type: Literal["head-on", "crossing", "overtaking", "overtaken", "none"]
    role: Literal["give-way", "stand-on", "none"]
    rule: str | None


class FrameMessage(ServerMessage, frozen=True, tag="frame", omit_defaults=True):
    frame: msgspec.Raw
    encounters: dict[str, EncounterStatus]
    sent_utc: str
    sentence: Sentence | None
    compare: msgspec.Raw | None = None
    path: list[Any] | None = None


class Alarm(msgspec.Struct, frozen=True):
    id: str
    target: str
    name: str
    dcpa_m: float
    tcpa_s: float
    since_s: float
    state: Literal["unacknowledged", "acknowledged"]
    cause: str


class Alarms(ServerMessage, frozen=True):
    alarms: list[Alarm]


class WhatIfMessage(ServerMessage, frozen=True, tag="whatif"):
    """Own ship's two futures from the frame of ``time_s`` on, a point every 30 s: as things are
    (``fact``), and under the ``condition`` (``other``)."""

    time_s: float
    change: str
    ship: str | None
    condition: str
    sentence: str
    fact: list[list[float]]
    other: list[list[float]]


class BandMessage(ServerMessage, frozen=True, tag="band"):
    """The certified rudder band of one frame: of that time, pilot and rudder, and of no other.

    ``short`` says what is certain, ``full`` between which rudders and for which errors, or why
    there is no band.
    """

    time_s: float
    pilot: str
    rudder_rad: float | None
    band: Band | None
    short: str
    full: str


class ErrorMessage(ServerMessage, frozen=True, tag="failure"):
    message: str


class Notice(ServerMessage, frozen=True):
    message: str


class Pong(ServerMessage, frozen=True):
    pass


_encoder = msgspec.json.Encoder()


def encode(message: ServerMessage) -> bytes:
    """The message as it is sent."""
    return _encoder.encode(message)
