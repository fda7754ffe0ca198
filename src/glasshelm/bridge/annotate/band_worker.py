"""Certified bands, computed beside the frames in a thread of their own.

A band is computed for the newest frame only, one at a time. It takes at most a share of the time,
and only if it will be done while most of its frame's time is still to come: frames that follow
each other too fast have no band, not a late one.
"""

import asyncio
import logging
import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from statistics import median

import msgspec

from glasshelm.bridge.server.fault_log import describe_error
from glasshelm.bridge.server.protocol import BandMessage, Outgoing, encode
from glasshelm.certify.logged_measurements import (
    MAX_CELLS,
    band_of_frames,
    require_certifiable,
)
from glasshelm.certify.rudder_band import SINGLE_SCENE_CHUNK
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.report.band_text import full_band_text, short_band_text
from glasshelm.whatif.logged_world import pilot_of

#: At most this share of a core's time, and of the time a frame is shown, is spent on bands.
CPU_SHARE = 0.25
#: Seconds that a batch of bounds takes, until some have been measured.
_INITIAL_BATCH_S = 0.1
#: The median of so many times counts, so that one that had to compile does not.
_N_TIMES = 5
#: Factor on the expected time after each frame without time for a band: a machine that was busy may
#: be free again.
_DECAY = 0.97
_log = logging.getLogger("glasshelm.bridge")


class BandWorker:
    """Sends the band of the frame shown, or why there is none.

    ``request`` and ``snapshot`` belong to the event loop. Without ``errors`` nothing is sent.

    Args:
        errors: The largest sensor errors that a band allows for.
        pilot_named: Returns a pilot by its name.
        broadcast: Sends messages to all viewers.
    """

    def __init__(
        self,
        errors: SensorErrorBounds | None,
        pilot_named: Callable[[str], Pilot],
        broadcast: Callable[[list[Outgoing]], None],
    ):
        self._errors, self._pilot_named, self._broadcast = errors, pilot_named, broadcast
        #: What a viewer who joins now is sent.
        self.snapshot: list[Outgoing] = []
        self._wanted: tuple[Sequence[Frame], float] | None = None
        self._done: tuple[Frame, int] | None = None
        self._batch_times_s = deque([_INITIAL_BATCH_S] * (_N_TIMES // 2 + 1), maxlen=_N_TIMES)
        self._wake = asyncio.Event()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="band")

    def request(self, frames: Sequence[Frame], shown_for_s: float) -> None:
        """Ask for the band of the last of these frames, which is shown for so long."""
        if self._errors is None or not frames:
            return
        if self._wanted is None or self._wanted[0][-1] is not frames[-1]:
            self.snapshot = []
        self._wanted = frames, shown_for_s
        self._wake.set()

    async def run(self) -> None:
        """Compute what is requested, as long as the server runs."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            assert self._wanted is not None
            assert self._errors is not None
            frames, shown_for_s = self._wanted
            frame, cells = frames[-1], self._affordable_cells(shown_for_s)
            if self._done is not None and self._done[0] is frame and cells <= self._done[1]:
                continue
            start = time.monotonic()
            loop, args = asyncio.get_running_loop(), (self._pilot_named, self._errors, cells)
            try:
                message = await loop.run_in_executor(self._thread, band_message, frames, *args)
            except Exception as error:
                _log.exception("a band failed")
                reason = describe_error(error)
                message = to_message(frame, f"no certified band: it failed ({reason})")
            took_s = time.monotonic() - start
            if self._wanted[0][-1] is frame:
                self._done = frame, cells
                self.snapshot = [encode(message)]
                self._broadcast(self.snapshot)
            if message.band is not None and frame.band is None:
                self._batch_times_s.append(took_s / _batches(cells))
                await asyncio.sleep((1 / CPU_SHARE - 1) * self._batch_s * _batches(cells))
            elif cells == 0:
                faster = max(_DECAY * self._batch_s, min(_INITIAL_BATCH_S, self._batch_s))
                self._batch_times_s.append(faster)

    @property
    def _batch_s(self) -> float:
        """The expected time of a batch of bounds."""
        return median(self._batch_times_s)

    def close(self) -> None:
        self._thread.shutdown(wait=False, cancel_futures=True)

    def _affordable_cells(self, shown_for_s: float) -> int:
        """Return for how many bounds there is time; 0 if not even for one."""
        batches = min(CPU_SHARE * shown_for_s / self._batch_s, _batches(MAX_CELLS))
        return 0 if batches < 1 else 1 + SINGLE_SCENE_CHUNK * (int(batches) - 1)


def _batches(cells: int) -> int:
    return 1 + math.ceil((cells - 1) / SINGLE_SCENE_CHUNK)


def band_message(
    frames: Sequence[Frame],
    pilot_named: Callable[[str], Pilot],
    errors: SensorErrorBounds,
    cells: int,
) -> BandMessage:
    """Compute the band of the last frame with at most ``cells`` bounds, or say why it has none.

    A frame that was logged with its band is sent with that.
    """
    frame, reason = frames[-1], ""
    if frame.band is None:
        try:
            pilot = pilot_of(frame, pilot_named)
            require_certifiable(pilot)
            if cells < 1:
                raise InputError("the frames follow each other too fast")
            band = band_of_frames(frames, pilot, errors, cells)
            frame = msgspec.structs.replace(frame, band=band)
        except InputError as error:
            reason = f"no certified band: {error}"
    return to_message(frame, reason)


def to_message(frame: Frame, reason: str = "") -> BandMessage:
    """Return the band of a frame as a message, or the reason why it has none."""
    rudder = None if frame.decision is None else frame.decision.rudder_rad
    short, full = short_band_text(frame), reason or full_band_text(frame)
    return BandMessage(frame.time_s, frame.pilot, rudder, frame.band, short, full)
