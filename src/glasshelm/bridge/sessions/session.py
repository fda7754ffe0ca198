"""What every session of the bridge has: frames in order, one of which is shown."""

import dataclasses
from abc import abstractmethod
from typing import Any, Protocol, runtime_checkable

import jax
import numpy as np
from jaxtyping import Float

from glasshelm.bridge.server.protocol import Mode
from glasshelm.bridge.sessions.session_log import FrameLines
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.ship.nomoto import ShipState


@dataclasses.dataclass(frozen=True)
class SessionInfo:
    """What a session is; ``end_s`` is absent where nobody knows the end."""

    source: str
    title: str
    mode: Mode
    ship: str
    end_s: float | None
    notes: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class PredictedTrack:
    """Own ship's predicted track, one row a step: east, north [m], heading [rad]."""

    step_s: float
    rows: Float[np.ndarray, "steps 3"]


def to_track(own: ShipState, step_s: float) -> PredictedTrack:
    """From predicted states to a track."""
    own = jax.device_get(own)
    return PredictedTrack(step_s, np.stack([own.east_m, own.north_m, own.heading_rad], axis=-1))


@runtime_checkable
class Session(Protocol):
    """Frames that can be shown one after the other. Used by one thread at a time, but ``ready``.

    ``at`` is the number of the frame shown, −1 before the first. Every method
    raises InputError, in one line, for what this kind of session cannot do.
    What has a body here is so for all sessions but live traffic.
    """

    info: SessionInfo
    index: int

    @property
    def log(self) -> FrameLines: ...

    @property
    def pilot_name(self) -> str:
        """The name of the pilot who decides from now on."""
        ...

    @property
    def compared_name(self) -> str | None:
        """The name of the pilot compared with."""
        ...

    @property
    def seekable_range_s(self) -> tuple[float, float]:
        """The times between which can be sought."""
        ...

    @property
    def step_s(self) -> float:
        """Seconds of the voyage until the next frame."""
        ...

    @property
    def connected(self) -> bool:
        """Whether the source is there."""
        return True

    @property
    def last_report_age_s(self) -> float | None:
        """The age of the last position heard, of any ship [s]."""
        return None

    @property
    def own_position_age_s(self) -> float | None:
        """The age of own ship's own position [s]: what is shown is of now while that is."""
        return None

    @property
    def faults(self) -> list[str]:
        """What goes wrong now, one line each; the notes tell it too."""
        return []

    @property
    def endless(self) -> bool:
        """Whether its source never comes to an end: where ``listen`` fails it is begun again."""
        return False

    @property
    def feed_counts(self) -> dict[str, Any] | None:
        """How much of what was heard became of use, in numbers."""
        return None

    def warm_up(self, pilot: Pilot, ahead: bool = True) -> None:
        """Compile what this pilot needs here, so that frames go on when it takes over.

        Without ``ahead``, all but its predicted track. May run beside the worker:
        it only reads what no other method changes.
        """

    async def listen(self) -> None:
        """Hear what the source says, in the event loop, until cancelled."""

    @abstractmethod
    def next_frame(self) -> Frame | None:
        """Show the next frame; None where there is none (yet). Where it fails nothing has moved."""
        ...

    @abstractmethod
    def seek(self, time_s: float) -> None:
        """Show the last frame that is not later than this."""
        ...

    @abstractmethod
    def set_pilot(self, pilot: Pilot) -> None:
        """From the frame shown on another pilot decides."""
        ...

    @abstractmethod
    def compare(self, pilot: Pilot | None) -> None:
        """Show another pilot beside, or no longer."""
        ...

    @abstractmethod
    def compared_history(self) -> list[bytes]:
        """The compared pilot's frames before the one shown, as they stand in her log."""
        ...

    @abstractmethod
    def compared_line(self) -> bytes | None:
        """The compared pilot's frame of the instant shown, if she has not ended before."""
        ...

    @abstractmethod
    def predicted_track(self) -> PredictedTrack | None:
        """Own ship's track under the pilot from the frame shown on."""
        ...

    @abstractmethod
    def close(self) -> None: ...
