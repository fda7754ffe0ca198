"""The interface of all sessions: frames in order, one of which is shown."""

import dataclasses
from abc import ABC, abstractmethod
from typing import Any

import jax
import numpy as np
from jaxtyping import Float, Num

from glasshelm.bridge.server.protocol import Mode
from glasshelm.bridge.sessions.session_log import SessionLog
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.ship.nomoto import ShipState

#: The page gets a point of a track this often.
_POINT_S = 30.0


@dataclasses.dataclass(frozen=True)
class SessionInfo:
    """What a session shows; ``end_s`` is None where the end is not known."""

    source: str
    title: str
    mode: Mode
    ship: str
    end_s: float | None
    notes: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class SessionStatus:
    """The state of a session now. The defaults hold for all but live traffic.

    Attributes:
        pilot: The name of the pilot that decides from now on.
        compared: The name of the pilot compared with.
        seekable_range_s: The times between which one can seek.
        connected: Whether the source is connected.
        last_report_age_s: The age of the last position of any ship [s].
        own_position_age_s: The age of own ship's position [s].
        faults: What is going wrong, a line each.
        feed_counts: How many sentences and reports were received, used and rejected.
    """

    pilot: str
    compared: str | None
    seekable_range_s: tuple[float, float]
    connected: bool = True
    last_report_age_s: float | None = None
    own_position_age_s: float | None = None
    faults: tuple[str, ...] = ()
    feed_counts: dict[str, Any] | None = None


@dataclasses.dataclass(frozen=True)
class PredictedTrack:
    """Own ship's predicted track, one row a step: east, north [m], heading [rad]."""

    step_s: float
    rows: Float[np.ndarray, "steps 3"]

    @staticmethod
    def of(own: ShipState, step_s: float) -> "PredictedTrack":
        own = jax.device_get(own)
        return PredictedTrack(step_s, np.stack([own.east_m, own.north_m, own.heading_rad], axis=-1))


def track_points(rows: Num[np.ndarray, "steps columns"], step_s: float) -> list[list[float]]:
    """Return east and north [m] of a track every 30 s, as the page gets them."""
    return rows[:: max(round(_POINT_S / step_s), 1), :2].astype(float).round(1).tolist()


class Session(ABC):
    """Frames that are shown one after the other.

    Used by one thread at a time, except for :meth:`warm_up`. ``index`` is the number of the frame
    shown, −1 before the first. Methods raise InputError, in one line, for what this kind of
    session cannot do.
    """

    info: SessionInfo
    index: int

    @property
    @abstractmethod
    def log(self) -> SessionLog: ...

    @property
    @abstractmethod
    def step_s(self) -> float:
        """Seconds of the voyage until the next frame."""
        ...

    @property
    def endless(self) -> bool:
        """Whether the source never ends: where :meth:`listen` fails it is started again."""
        return False

    @abstractmethod
    def status(self) -> SessionStatus: ...

    def warm_up(self, pilot: Pilot, predict: bool = True) -> None:  # noqa: B027
        """Compile what this pilot needs, so that frames do not stop when it takes over.

        May run beside the worker thread: it only reads what no other method changes.

        Args:
            pilot: The pilot.
            predict: Also compile its predicted track.
        """

    async def listen(self) -> None:  # noqa: B027
        """Receive from the source, in the event loop, until cancelled."""

    @abstractmethod
    def next_frame(self) -> Frame | None:
        """Show the next frame; None if there is none (yet). If it fails nothing has changed."""
        ...

    @abstractmethod
    def seek(self, time_s: float) -> None:
        """Show the last frame that is not later than this."""
        ...

    @abstractmethod
    def set_pilot(self, pilot: Pilot) -> None:
        """Let another pilot decide from the frame shown on."""
        ...

    @abstractmethod
    def compare(self, pilot: Pilot | None) -> None:
        """Compare with another pilot, or no longer."""
        ...

    def compared_history(self) -> list[bytes]:
        """Return the compared pilot's frames before the one shown, as lines of its log."""
        return []

    def compared_line(self) -> bytes | None:
        """Return the compared pilot's frame at the time shown, if its voyage has not ended."""
        return None

    def predicted_track(self) -> PredictedTrack | None:
        """Return own ship's track under the pilot from the frame shown on."""
        return None

    def close(self) -> None:
        self.log.close()
