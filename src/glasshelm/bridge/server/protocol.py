"""What the page and the server say to each other: JSON objects, each with its ``type``.

docs/reference/bridge.md holds the same as a table. Frames travel as the bytes that stand
in the log: they are encoded once, however many look on.
"""

from typing import Annotated, Literal

import msgspec

from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Band

#: Longer messages of a viewer are refused [bytes].
LARGEST = 64 * 1024

Word = Annotated[str, msgspec.Meta(max_length=200)]
Kind = Literal["simulated", "recorded", "live"]
Mode = Literal["simulated", "recorded", "live", "replay"]
#: An owner may change what all see; a viewer looks on, and may ask what-if.
Role = Literal["owner", "viewer"]
#: A frame as it stands in the log, encoded once.
EncodedFrame = Annotated[msgspec.Raw, msgspec.Meta(extra_json_schema={"$ref": "#/$defs/Frame"})]
#: East and north [m].
Point = Annotated[list[float], msgspec.Meta(min_length=2, max_length=2)]


class _Asked(msgspec.Struct, frozen=True, tag_field="type", tag=str.lower):
    """A request of a viewer."""


class Open(_Asked, frozen=True):
    """Begin a session. ``own`` and ``at`` are of recorded traffic only."""

    source: Word
    pilot: Word | None = None
    ship: Word | None = None
    own: Word | None = None
    at: Word | None = None


class Replay(_Asked, frozen=True):
    """Show a log again, by its name in the catalogue."""

    log: Word


class Pilot(_Asked, frozen=True):
    """From now on another pilot decides."""

    name: Word


class Compare(_Asked, frozen=True):
    """Show beside it how another pilot sails the same; null: no longer."""

    name: Word | None = None


class Play(_Asked, frozen=True):
    pass


class Pause(_Asked, frozen=True):
    pass


class Rate(_Asked, frozen=True):
    """Seconds of the voyage a second."""

    rate: Annotated[float, msgspec.Meta(ge=1, le=60)]


class Seek(_Asked, frozen=True):
    time_s: Annotated[float, msgspec.Meta(ge=0, le=1e7)]


class Acknowledge(_Asked, frozen=True):
    """An alarm has been seen: for all viewers at once."""

    id: Word


class Limits(_Asked, frozen=True):
    """An alarm is raised where DCPA and TCPA are both below these."""

    dcpa_m: Annotated[float, msgspec.Meta(ge=0, le=50_000)] = 1852.0
    tcpa_s: Annotated[float, msgspec.Meta(ge=0, le=3600)] = 600.0


class WhatIf(_Asked, frozen=True):
    """How own ship would go on from the frame shown if something were different.

    ``ship`` is deleted, hidden from the pilot, or keeps her course (null: own ship);
    ``degrees`` is the rudder to hold for a minute, starboard positive.
    """

    change: Literal["deleted", "blind", "kept", "rudder"]
    ship: Word | None = None
    degrees: Annotated[float, msgspec.Meta(ge=-90, le=90)] | None = None


class Ping(_Asked, frozen=True):
    pass


Asked = (
    Open
    | Replay
    | Pilot
    | Compare
    | Play
    | Pause
    | Rate
    | Seek
    | Acknowledge
    | Limits
    | WhatIf
    | Ping
)
#: What changes nothing that others see.
FOR_VIEWERS = Ping | WhatIf
_asked = msgspec.json.Decoder(Asked)


def read(text: str | bytes) -> Asked:
    """A viewer's message. InputError, in one line, if it is none."""
    try:
        text = text.encode() if isinstance(text, str) else text
        if len(text) > LARGEST:
            raise InputError(f"a message of {len(text)} bytes: at most {LARGEST} are read")
        return _asked.decode(text)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise InputError(f"not a message of this protocol: {_line(error)}") from None


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__


class _Said(msgspec.Struct, frozen=True, tag_field="type", tag=str.lower):
    """A message of the server."""


class Source(msgspec.Struct, frozen=True):
    source: str
    title: str
    kind: Kind


class PilotCard(msgspec.Struct, frozen=True):
    """``ship`` is the preset that the pilot was made for; null: any."""

    name: str
    title: str
    kind: Literal["learned", "classical", "planner"]
    ship: str | None


class LogCard(msgspec.Struct, frozen=True, omit_defaults=True):
    """A log; of a long one how many frames it has may not be known yet."""

    name: str
    frames: int | None = None
    time_utc: str | None = None


class Catalogue(msgspec.Struct, frozen=True):
    """All that may be opened from the page."""

    scenarios: list[Source]
    pilots: list[PilotCard]
    logs: list[LogCard]


class Bounds(msgspec.Struct, frozen=True):
    """The limits of the alarms."""

    dcpa_m: float
    tcpa_s: float


class Hello(_Said, frozen=True):
    """``role`` is that of the receiver."""

    version: str
    catalogue: Catalogue
    limits: Bounds
    role: Role


class Preparing(_Said, frozen=True):
    """What is being made ready while the session shown goes on; null: no more."""

    what: str | None


class Session(_Said, frozen=True):
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


class History(_Said, frozen=True):
    """All frames that the page is to hold; ``compare`` those of the compared pilot."""

    frames: list[EncodedFrame]
    compare: list[EncodedFrame]


class Sentence(msgspec.Struct, frozen=True):
    what: str
    why: str
    next: str


class Meeting(msgspec.Struct, frozen=True):
    """What own ship is to a target under the COLREGs, while there is risk of collision."""

    type: Literal["head-on", "crossing", "overtaking", "overtaken", "none"]
    role: Literal["give-way", "stand-on", "none"]
    rule: str | None


class FrameNow(_Said, frozen=True, tag="frame", omit_defaults=True):
    frame: EncodedFrame
    encounters: dict[str, Meeting]
    sent_utc: str
    sentence: Sentence | None
    compare: EncodedFrame | None = None
    path: list[Point] | None = None


class Alarm(msgspec.Struct, frozen=True):
    id: str
    target: str
    name: str
    dcpa_m: float
    tcpa_s: float
    since_s: float
    state: Literal["unacknowledged", "acknowledged"]
    cause: str


class Alarms(_Said, frozen=True):
    alarms: list[Alarm]


class Answer(_Said, frozen=True, tag="whatif"):
    """Own ship's two futures from the frame of ``time_s`` on, a point every 30 s: as things are
    (``fact``), and under the ``condition`` (``other``)."""

    time_s: float
    change: str
    ship: str | None
    condition: str
    sentence: str
    fact: list[Point]
    other: list[Point]


class Banded(_Said, frozen=True, tag="band"):
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


class Failure(_Said, frozen=True):
    message: str


class Notice(_Said, frozen=True):
    message: str


class Pong(_Said, frozen=True):
    pass


_encoder = msgspec.json.Encoder()


def written(message: _Said) -> bytes:
    """The message as it is sent."""
    return _encoder.encode(message)
