"""Numbers as a navigator says them: miles, degrees, minutes, and on which side."""

import math
from datetime import timedelta

from glasshelm.core.geometry import CPA_HORIZON_S
from glasshelm.frames.series import Series
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: Below this a value makes no difference.
NEGLIGIBLE = 0.0005
#: A rudder below this [°] is called amidships: nobody at a wheel steers half a degree.
#: The page has the same (``web/src/domain/units.ts``).
AMIDSHIPS_DEG = 0.5


def capitalised(text: str) -> str:
    """The text with its first letter large, to begin a sentence."""
    return text[:1].upper() + text[1:]


def miles(metres: float) -> str:
    """``0.30 NM`` below ten miles, ``12.4 NM`` above."""
    nautical = metres / NAUTICAL_MILE_M
    return f"{nautical:.2f} NM" if nautical < 10 else f"{nautical:.1f} NM"


def duration(seconds: float) -> str:
    """A duration: ``45 s``, ``2.5 min``, ``12 min``."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes >= 10 or minutes % 1 < 0.05 else f"{minutes:.1f} min"


def degrees(radians: float) -> str:
    """The size of an angle: ``4°``, with a decimal below two degrees."""
    size = abs(math.degrees(radians))
    return f"{size:.1f}°" if size < 2 else f"{size:.0f}°"


def rudder_degrees(radians: float) -> str:
    """The size of a rudder, or of a part of one, as a page shows it: ``4.0°``."""
    return f"{abs(math.degrees(radians)):.1f}°"


def rudder_words(rudder_rad: float) -> str:
    """A rudder in words, to the tenth of a degree that a page shows beside it.

    ``rudder 3.4° to starboard``; small ones ``rudder amidships (0.2° to starboard)``.
    """
    size = rudder_degrees(rudder_rad)
    degree = float(size.rstrip("°"))
    if degree == 0:
        return "rudder amidships"
    angle = f"{size} to {side(rudder_rad)}"
    return f"rudder amidships ({angle})" if degree < AMIDSHIPS_DEG else f"rudder {angle}"


def course(radians: float) -> str:
    """A course in three digits: ``005°``."""
    return f"{round(math.degrees(radians)) % 360:03d}°"


def side(angle_rad: float) -> str:
    """Starboard or port."""
    return "starboard" if angle_rad > 0 else "port"


def relative_bearing(bearing_rad: float) -> str:
    """A relative bearing in words: ``ahead``, ``on the port bow``, ``on the starboard quarter``."""
    size = abs(math.degrees(bearing_rad))
    if size < 10:
        return "ahead"
    if size > 170:
        return "astern"
    part = "bow" if size < 67.5 else "beam" if size < 112.5 else "quarter"
    return f"on the {side(bearing_rad)} {part}"


def cpa_words(dcpa_m: float, tcpa_s: float) -> str:
    """A CPA in words: ``CPA 0.30 NM in 8 min``, or that there is none to come."""
    if tcpa_s >= CPA_HORIZON_S:
        return "no CPA within the hour"
    if tcpa_s <= 0:
        return "past her CPA"
    return f"CPA {miles(dcpa_m)} in {duration(tcpa_s)}"


def clock(voyage: Series, k: int) -> str:
    """The time of a frame: UTC if the source has a clock, else minutes since the start."""
    start = voyage.start_utc
    since = float(voyage.time_s[k] - voyage.time_s[0])
    if start is None:
        return f"{since / 60:.1f} min"
    time = start + timedelta(seconds=since)
    return f"{time:%H:%M:%S}" if voyage.minutes[-1] < 15 else f"{time:%H:%M}"


def joined(names: list[str]) -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]
