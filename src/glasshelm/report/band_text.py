"""What is certain about a rudder while the sensors err within declared bounds, in words.

Bands are those of the frames (docs/explanation/certified-band.md); without one, nothing is said.
"""

import math

import numpy as np

from glasshelm.frames.phrases import rudder_words, side
from glasshelm.frames.schema import Band, Frame
from glasshelm.frames.series import Series
from glasshelm.ship.nomoto import KNOT_M_S

#: A band that ends so near the limit reaches it [rad].
_AT_LIMIT = 1e-4


def short_band_text(frame: Frame) -> str:
    """``certain: to starboard``, ``certain: amidships``, or that it is not; or nothing at all."""
    if frame.band is None or frame.decision is None:
        return ""
    rudder = frame.decision.rudder_rad
    if rudder_words(rudder).startswith("rudder amidships"):
        sure = all(rudder_words(end).startswith("rudder amidships") for end in _ends(frame.band))
        return "certain: amidships" if sure else "amidships not certain"
    return f"certain: to {side(rudder)}" if frame.band.turn == side(rudder) else "side not certain"


def full_band_text(frame: Frame) -> str:
    """Between which rudders, while which errors; empty without a band."""
    band, limit = frame.band, frame.ship.rudder_limit_rad
    if band is None:
        return ""
    if band.low_rad <= _AT_LIMIT - limit and band.high_rad >= limit - _AT_LIMIT:
        return f"any rudder is possible {_within(band)}"
    return f"rudder {_between(*_outward(band))} {_within(band)}"


def certainty_text(voyage: Series, at: np.ndarray) -> str:
    """That the side of the rudder is certain in all of these frames; else empty.

    Each must have a band, for the same errors, on the side of its rudder.
    """
    frames = [voyage.frames[k] for k in at]
    first = frames[0].band
    if first is None or not all(_as_certain(frame, first) for frame in frames):
        return ""
    return f"To {first.turn} for certain {_within(first)}"


def _as_certain(frame: Frame, first: Band) -> bool:
    band, decision = frame.band, frame.decision
    if band is None or decision is None or band.turn is None:
        return False
    return side(decision.rudder_rad) == band.turn and _what_for(band) == _what_for(first)


def _what_for(band: Band) -> tuple[str | None, float, float, float]:
    return band.turn, band.position_m, band.course_rad, band.speed_m_s


def _ends(band: Band) -> tuple[float, float]:
    return band.low_rad, band.high_rad


def _within(band: Band) -> str:
    course, speed = math.degrees(band.course_rad), band.speed_m_s / KNOT_M_S
    return f"while errors stay within {band.position_m:g} m, {course:.3g}°, {speed:.3g} kn"


def _outward(band: Band) -> tuple[float, float]:
    """Its ends to the tenth of a degree, never narrower than it is [deg]."""
    low, high = (10 * math.degrees(end) for end in _ends(band))
    return math.floor(low + 1e-4) / 10, math.ceil(high - 1e-4) / 10


def _between(low_deg: float, high_deg: float) -> str:
    """``between 2.1° and 5.0° to starboard``, ``between 1.2° to port and 0.3° to starboard``."""
    if low_deg < 0 < high_deg:
        return f"between {-low_deg:.1f}° to port and {high_deg:.1f}° to starboard"
    small, large = sorted((abs(low_deg), abs(high_deg)))
    reach = f"{large:.1f}°" if small == large else f"between {small:.1f}° and {large:.1f}°"
    return f"{reach} to {side(low_deg + high_deg)}"
