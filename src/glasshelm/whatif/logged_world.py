"""From a log and what a person says to a frame of it and the pilot who made it."""

import math
from collections.abc import Callable, Sequence
from datetime import datetime, time

from glasshelm.core.errors import InputError
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import pilot_named, pilot_names


def pilot_of(frame: Frame, named: Callable[[str], Pilot] | None = None) -> Pilot:
    """The pilot who decided a logged frame.

    A log names its pilot and the hash of its weights, and holds neither: ``named``
    finds it by its name, by default among those that are bundled. InputError if it
    is not there, or had other weights.
    """
    name, made = frame.pilot, frame.weights_sha256
    pilot = _bundled(name) if named is None else named(name)
    has = getattr(pilot, "weights_sha256", None)
    if has != made:
        there, here = (x[:8] if x else "none" for x in (made, has))
        raise InputError(
            f"the log was made by a {name[:100]} with other weights "
            f"(SHA-256 {there}, here {here}): name the pilot who is to sail on"
        )
    return pilot


def _bundled(name: str) -> Pilot:
    """Never more than that: a log is no reason to open a file or to import a module."""
    if name not in pilot_names():
        raise InputError(
            f"the log's pilot {name[:100]!r} is not bundled: name the pilot who is to sail on"
        )
    return pilot_named(name)


def frame_at(frames: Sequence[Frame], at: str) -> int:
    """The number of the last frame that is not later than an instant in words.

    Seconds of the log (``300``), ``frame:60``, or where the log has a clock a time
    of day or date and time (UTC). InputError if it is none, or outside the log.
    """
    if at.startswith("frame:"):
        number = at.removeprefix("frame:")
        if not number.isdecimal() or int(number) >= len(frames):
            raise InputError(f"--at {at}: the log has frames 0 to {len(frames) - 1}")
        return int(number)
    first, last = frames[0].time_s, frames[-1].time_s
    wanted = _seconds(frames[0], at)
    if not first - 1e-6 <= wanted <= last + 1e-6:
        raise InputError(f"--at {at}: outside the log, which holds {_span(frames)}")
    return max(k for k, frame in enumerate(frames) if frame.time_s <= wanted + 1e-6)


def _seconds(first: Frame, at: str) -> float:
    """The time of the log that is meant."""
    try:
        wanted = float(at)
    except ValueError:
        return first.time_s + _since(first, at)
    if not math.isfinite(wanted):
        raise InputError(f"--at {at}: no time")
    return wanted


def _since(first: Frame, at: str) -> float:
    """Seconds from a frame to a clock time; a time of day is the next one."""
    if first.time_utc is None:
        raise InputError(f"--at {at}: the log has no clock; give its seconds, or frame:NUMBER")
    begun = datetime.fromisoformat(first.time_utc)
    try:
        if "-" in at:
            given = datetime.fromisoformat(at)
            when = given if given.tzinfo else given.replace(tzinfo=begun.tzinfo)
            return (when - begun).total_seconds()
        day = time.fromisoformat(at)
    except ValueError:
        raise InputError(
            f"--at {at}: seconds, frame:NUMBER, HH:MM[:SS] or ISO 8601 (UTC)"
        ) from None
    if day.tzinfo is not None:
        day = day.replace(tzinfo=None)
    since = (datetime.combine(begun.date(), day, begun.tzinfo) - begun).total_seconds()
    # A log may begin within the minute that is named, or go on after midnight.
    return max(since, 0.0) if since > -60 else since + 86_400


def _span(frames: Sequence[Frame]) -> str:
    first, last = frames[0], frames[-1]
    seconds = f"{first.time_s:g} to {last.time_s:g} s"
    if first.time_utc is None or last.time_utc is None:
        return seconds
    begun, ended = (datetime.fromisoformat(f.time_utc or "") for f in (first, last))
    return f"{seconds} ({begun:%H:%M:%S} to {ended:%H:%M:%S} UTC)"
