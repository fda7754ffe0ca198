"""Certified rudder bands beside the frames: a thread of their own, never in a frame's way.

A band is computed for the newest frame alone, one at a time. At most a share of the time is spent
on it, and only where it is done while most of its frame's time is still to come: of frames that
follow each other too fast there is none, not a late one.
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

from glasshelm.bridge.server import protocol as m
from glasshelm.bridge.server.fault_log import one_line
from glasshelm.certify.logged_measurements import MAX_CELLS, band_of_frames
from glasshelm.certify.rudder_band import SINGLE_SCENE_CHUNK, require_sum_actor
from glasshelm.certify.sensor_error_bounds import SensorErrorBounds
from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.report.band_text import full_band_text, short_band_text
from glasshelm.whatif.logged_world import pilot_of

#: Of one core's time, and of the time that a frame stands, at most this share is spent on bands.
SHARE = 0.25
#: Seconds that a batch of bounds takes, until some have been measured.
_GUESS_S = 0.1
#: The median of so many counts: one that had to compile is none of them.
_LAST = 5
#: A frame without time for a band makes what was measured count so much less: a machine that was
#: busy may be free again.
_FORGET = 0.97
_log = logging.getLogger("glasshelm.bridge")


class Bands:
    """Tells the band of the frame shown, or in words why there is none.

    ``want`` and ``told`` belong to the event loop. Without ``errors`` nothing is ever told.
    """

    def __init__(
        self,
        errors: SensorErrorBounds | None,
        named: Callable[[str], Pilot],
        tell: Callable[[list[tuple[str, bytes]]], None],
    ):
        self._errors, self._named, self._tell = errors, named, tell
        #: What a viewer who comes now has to be told.
        self.told: list[tuple[str, bytes]] = []
        self._wanted: tuple[Sequence[Frame], float] | None = None
        self._done: tuple[Frame, int] | None = None
        self._batch_s = deque([_GUESS_S] * (_LAST // 2 + 1), maxlen=_LAST)
        self._wake = asyncio.Event()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="band")

    def want(self, frames: Sequence[Frame], stands_s: float) -> None:
        """The last of these frames is shown, for so long; the others came before it."""
        if self._errors is None or not frames:
            return
        if self._wanted is None or self._wanted[0][-1] is not frames[-1]:
            self.told = []
        self._wanted = frames, stands_s
        self._wake.set()

    async def run(self) -> None:
        """Compute what is wanted; runs as long as the server does."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            assert self._wanted is not None
            assert self._errors is not None
            (frames, stands_s), errors = self._wanted, self._errors
            cells = self._cells(stands_s)
            if self._done is not None and self._done[0] is frames[-1] and cells <= self._done[1]:
                continue
            begun = time.monotonic()
            loop = asyncio.get_running_loop()
            job = loop.run_in_executor(self._thread, told, frames, self._named, errors, cells)
            try:
                message = await job
            except Exception as error:
                _log.exception("a band failed")
                message = banded(frames[-1], f"no certified band: it failed ({one_line(error)})")
            took_s = time.monotonic() - begun
            if self._wanted[0][-1] is frames[-1]:
                self._done = frames[-1], cells
                self.told = [("band", m.written(message))]
                self._tell(self.told)
            if message.band is not None and frames[-1].band is None:
                self._batch_s.append(took_s / _batches(cells))
                await asyncio.sleep((1 / SHARE - 1) * self._usual_s * _batches(cells))
            elif cells == 0:
                self._batch_s.append(max(_FORGET * self._usual_s, min(_GUESS_S, self._usual_s)))

    @property
    def _usual_s(self) -> float:
        """What a batch of bounds takes."""
        return median(self._batch_s)

    def close(self) -> None:
        self._thread.shutdown(wait=False, cancel_futures=True)

    def _cells(self, stands_s: float) -> int:
        """As many bounds as there is time for; 0 if not even one."""
        batches = min(SHARE * stands_s / self._usual_s, _batches(MAX_CELLS))
        return 0 if batches < 1 else 1 + SINGLE_SCENE_CHUNK * (int(batches) - 1)


def _batches(cells: int) -> int:
    return 1 + math.ceil((cells - 1) / SINGLE_SCENE_CHUNK)


def told(
    frames: Sequence[Frame], named: Callable[[str], Pilot], errors: SensorErrorBounds, cells: int
) -> m.Banded:
    """The band of the last of these frames, with at most so many bounds, or why there is none.

    A frame that carries its band keeps the logged one.
    """
    frame = frames[-1]
    found, why = frame, ""
    if frame.band is None:
        try:
            pilot = pilot_of(frame, named)
            require_sum_actor(pilot)
            if cells < 1:
                raise InputError("the frames follow each other too fast")
            band = band_of_frames(frames, pilot, errors, cells)
            found = msgspec.structs.replace(frame, band=band)
        except InputError as error:
            why = f"no certified band: {error}"
    return banded(found, why)


def banded(frame: Frame, why: str = "") -> m.Banded:
    """The band that a frame carries, in words; or why it has none."""
    rudder = None if frame.decision is None else frame.decision.rudder_rad
    return m.Banded(
        frame.time_s,
        frame.pilot,
        rudder,
        frame.band,
        short_band_text(frame),
        why or full_band_text(frame),
    )
