"""The messages between the page and the server: JSON objects, each with a ``type``.

docs/reference/bridge.md lists them in a table. A frame travels as the bytes of its line in the
log, so it is encoded once however many viewers there are.
"""

from typing import Annotated, Literal, NamedTuple

import msgspec

from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Band

#: Longer requests are refused [bytes].
MAX_REQUEST_BYTES = 64 * 1024

ShortText = Annotated[str, msgspec.Meta(max_length=200)]
SourceKind = Literal["simulated", "recorded", "live"]
Mode = Literal["simulated", "recorded", "live", "replay"]
#: An owner may change what everybody sees; a viewer may only watch, and ask what-if questions.
Role = Literal["owner", "viewer"]
#: What a what-if question changes.
Change = Literal["delete", "hide", "keep_course", "rudder"]
#: A frame as its line in the log, encoded once.
EncodedFrame = Annotated[msgspec.Raw, msgspec.Meta(extra_json_schema={"$ref": "#/$defs/Frame"})]
#: East and north [m].
Point = Annotated[list[float], msgspec.Meta(min_length=2, max_length=2)]


class AlarmLimits(msgspec.Struct, frozen=True):
    """An alarm is raised where DCPA and TCPA are both below these limits."""

    dcpa_m: Annotated[float, msgspec.Meta(ge=0, le=50_000)]
    tcpa_s: Annotated[float, msgspec.Meta(ge=0, le=3600)]


DEFAULT_ALARM_LIMITS = AlarmLimits(dcpa_m=1852.0, tcpa_s=600.0)


class _Request(msgspec.Struct, frozen=True, tag_field="type", tag=str.lower):
    """A request of a viewer."""


class Open(_Request, frozen=True):
    """Open a session. ``own`` and ``at`` apply to recorded traffic only."""

    source: ShortText
    pilot: ShortText | None = None
    ship: ShortText | None = None
    own: ShortText | None = None
    at: ShortText | None = None


class Replay(_Request, frozen=True):
    """Replay a log, by its name in the catalogue."""

    log: ShortText


class SetPilot(_Request, frozen=True, tag="pilot"):
    """Let another pilot decide from now on."""

    name: ShortText


class Compare(_Request, frozen=True):
    """Also show how another pilot handles the same encounter; null ends it."""

    name: ShortText | None = None


class Play(_Request, frozen=True):
    pass


class Pause(_Request, frozen=True):
    pass


class SetRate(_Request, frozen=True, tag="rate"):
    """Set how many seconds of the voyage pass in a second."""

    rate: Annotated[float, msgspec.Meta(ge=1, le=60)]


class Seek(_Request, frozen=True):
    time_s: Annotated[float, msgspec.Meta(ge=0, le=1e7)]


class Acknowledge(_Request, frozen=True):
    """Acknowledge an alarm, for all viewers."""

    id: ShortText


class SetLimits(_Request, AlarmLimits, frozen=True, tag="limits"):
    """Set the limits of the alarms, for all viewers."""


class AskWhatIf(_Request, frozen=True, tag="whatif"):
    """Ask how own ship would go on from the frame shown if something were different.

    ``ship`` is deleted, hidden from the pilot, or keeps its course (null: own ship);
    ``rudder_deg`` is held for a minute, starboard positive.
    """

    change: Change
    ship: ShortText | None = None
    rudder_deg: Annotated[float, msgspec.Meta(ge=-90, le=90)] | None = None


class Ping(_Request, frozen=True):
    pass


#: Requests for which a session or a pilot is prepared.
SlowRequest = Open | Replay | SetPilot | Compare
#: Requests that are done at once, whatever waits before them, when a session is open.
ImmediateRequest = Ping | Acknowledge | SetLimits | AskWhatIf
#: Requests that change nothing others see.
ViewerRequest = Ping | AskWhatIf
Request = SlowRequest | ImmediateRequest | Play | Pause | SetRate | Seek
_decoder = msgspec.json.Decoder(Request)


def decode_request(text: str | bytes) -> Request:
    """Decode a viewer's message. InputError, in one line, if it is not a request."""
    try:
        text = text.encode() if isinstance(text, str) else text
        if len(text) > MAX_REQUEST_BYTES:
            raise InputError(
                f"a message of {len(text)} bytes: at most {MAX_REQUEST_BYTES} are read"
            )
        return _decoder.decode(text)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(f"not a message of this protocol: {reason}") from None


class ServerMessage(msgspec.Struct, frozen=True, tag_field="type", tag=str.lower):
    """A message of the server."""


class SourceEntry(msgspec.Struct, frozen=True):
    source: str
    title: str
    kind: SourceKind


class PilotEntry(msgspec.Struct, frozen=True):
    """``ship`` is the preset the pilot was made for; null: any."""

    name: str
    title: str
    kind: Literal["learned", "glassbox", "classical"]
    ship: str | None


class LogEntry(msgspec.Struct, frozen=True, omit_defaults=True):
    """A log; ``frames`` is absent while a long log has not been counted to its end."""

    name: str
    frames: int | None = None
    time_utc: str | None = None


class Catalogue(msgspec.Struct, frozen=True):
    """Everything the page can open."""

    scenarios: list[SourceEntry]
    pilots: list[PilotEntry]
    logs: list[LogEntry]


class Hello(ServerMessage, frozen=True):
    """The first message to a viewer, sent again when it changes; ``role`` is the viewer's own."""

    version: str
    catalogue: Catalogue
    limits: AlarmLimits
    role: Role


class Preparing(ServerMessage, frozen=True):
    """What is being prepared while the session shown goes on; null: nothing."""

    task: str | None


class SessionMessage(ServerMessage, frozen=True, tag="session"):
    """The session shown. The ages, of the last position of any ship and of own ship's, are those
    of live traffic; null: none yet, or other traffic."""

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
    last_report_age_s: float | None
    own_position_age_s: float | None
    log: str | None


class History(ServerMessage, frozen=True):
    """The frames before the one shown; ``compare`` holds those of the compared pilot."""

    frames: list[EncodedFrame]
    compare: list[EncodedFrame]


class Sentence(msgspec.Struct, frozen=True):
    what: str
    why: str
    next: str


class EncounterStatus(msgspec.Struct, frozen=True):
    """Own ship's role towards a target under the COLREGs while risk of collision exists."""

    type: Literal["head-on", "crossing", "overtaking", "overtaken", "none"]
    role: Literal["give-way", "stand-on", "none"]
    rule: str | None


class FrameMessage(ServerMessage, frozen=True, tag="frame", omit_defaults=True):
    frame: EncodedFrame
    encounters: dict[str, EncounterStatus]
    sent_utc: str
    sentence: Sentence | None
    compare: EncodedFrame | None = None
    predicted_track: list[Point] | None = None


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
    """Own ship's two futures from the frame at ``time_s`` on, a point every 30 s: as things are
    (``factual``), and under the ``condition`` (``counterfactual``)."""

    time_s: float
    change: Change
    ship: str | None
    condition: str
    summary: str
    factual: list[Point]
    counterfactual: list[Point]


class BandMessage(ServerMessage, frozen=True, tag="band"):
    """The certified band of one frame, identified by time, pilot and rudder.

    ``short`` says what is certain; ``full`` between which rudders, or of which manoeuvre, and for
    which sensor errors, or why there is no band.
    """

    time_s: float
    pilot: str
    rudder_rad: float | None
    band: Band | None
    short: str
    full: str


class ErrorMessage(ServerMessage, frozen=True, tag="error"):
    message: str


class Notice(ServerMessage, frozen=True):
    message: str


class Pong(ServerMessage, frozen=True):
    pass


class Outgoing(NamedTuple):
    """An encoded message, and its type."""

    kind: str
    data: bytes


_encoder = msgspec.json.Encoder()


def encode(message: ServerMessage) -> Outgoing:
    """Encode a message once, for all viewers that get it."""
    return Outgoing(str(message.__struct_config__.tag), _encoder.encode(message))
