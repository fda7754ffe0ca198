"""What is certain of a rudder or a manoeuvre while sensors err within declared bounds, in words.

Bands are those of the frames (docs/explanation/certified-band.md); without one, nothing is said.
"""

import math

import numpy as np

from glasshelm.frames.phrases import course, joined, miles, rudder_words, side
from glasshelm.frames.schema import Band, Frame, ManoeuvreBand, TargetBand
from glasshelm.frames.series import Series
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M

#: A band that ends so near the limit reaches it [rad].
_AT_LIMIT = 1e-4
_UNSURE = "course not certain"
#: Courses nearer to each other than this are the same.
_SAME_DEG = 1.0


def short_band_text(frame: Frame) -> str:
    """``certain: to starboard``, ``certain: amidships``, or that it is not; or nothing at all.

    Of a manoeuvre ``certain: course 060°``.
    """
    if frame.band is None or frame.decision is None:
        return ""
    if frame.band.manoeuvre is not None and frame.manoeuvre is not None:
        sure = _course_certain(frame.band.manoeuvre)
        return f"certain: course {course(frame.manoeuvre.course_rad)}" if sure else _UNSURE
    rudder = frame.decision.rudder_rad
    if rudder_words(rudder).startswith("rudder amidships"):
        sure = all(rudder_words(end).startswith("rudder amidships") for end in _ends(frame.band))
        return "certain: amidships" if sure else "amidships not certain"
    return f"certain: to {side(rudder)}" if frame.band.turn == side(rudder) else "side not certain"


def full_band_text(frame: Frame) -> str:
    """Between which rudders, while which errors; empty without a band.

    Of a manoeuvre: whether another course can be the best, what it is worth, which ships it keeps
    out of the domain.
    """
    band, limit = frame.band, frame.ship.rudder_limit_rad
    if band is None:
        return ""
    if band.manoeuvre is not None:
        said = [
            _courses(frame, band.manoeuvre),
            _worth(band.manoeuvre),
            _ships(frame, band.manoeuvre),
        ]
        return f"{'; '.join(part for part in said if part)}, {_within(band)}"
    if band.low_rad <= _AT_LIMIT - limit and band.high_rad >= limit - _AT_LIMIT:
        return f"any rudder is possible {_within(band)}"
    return f"rudder {_between(*_outward(band))} {_within(band)}"


def band_rows(frame: Frame) -> list[tuple[str, ...]]:
    """A table of a manoeuvre's band: each ship, the other parts of its value, other manoeuvres.

    Each row is a name, the least and the greatest value [points], and of a ship how deep it can
    come into the domain (Eq. 13, unclipped) and its least range. Empty without such a band.
    """
    band = None if frame.band is None else frame.band.manoeuvre
    if band is None:
        return []
    names = {target.id: target.name for target in frame.targets}

    def row(name: str, low: float, high: float, *more: str) -> tuple[str, ...]:
        ends = f"{math.floor(100 * low) / 100:+.2f}", f"{math.ceil(100 * high) / 100:+.2f}"
        return (name, *ends, *more, *[""] * (2 - len(more)))

    ships = [
        row(
            names.get(t.id, t.id),
            t.q_low,
            t.q_high,
            f"{math.ceil(100 * t.depth) / 100:.2f}",
            miles(_least_m(t)),
        )
        for t in band.targets
    ]
    others = [row(f"gain over: {a.name}", a.gain_low, a.gain_high) for a in band.alternatives]
    parts = ("way to the waypoint", "waypoint"), ("altering course", "helm"), ("total", "total")
    values = [
        row(name, getattr(band.low, part) or 0.0, getattr(band.high, part) or 0.0)
        for name, part in parts
    ]
    return [*ships, *values, *others]


def choice_text(frame: Frame) -> str:
    """That no other course can be the best, where that is so; else empty."""
    band = frame.band
    if band is None or band.manoeuvre is None or not _course_certain(band.manoeuvre):
        return ""
    return f"No other course can be better {_within(band)}"


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


def _course_certain(band: ManoeuvreBand) -> bool:
    return len(band.courses_rad) == 1


def _courses(frame: Frame, band: ManoeuvreBand) -> str:
    """How far from the chosen course the best one can be."""
    if _course_certain(band) or frame.manoeuvre is None:
        return "no other course can be better"
    chosen = frame.manoeuvre.course_rad
    off = np.degrees((np.array(band.courses_rad) - chosen + np.pi) % (2 * np.pi) - np.pi)
    ends = [end for end in (off.min(), off.max()) if abs(end) > _SAME_DEG]
    reach = " or ".join(f"{math.ceil(abs(end) - 1e-3)}° to {side(end)}" for end in ends)
    return f"another course can be better, up to {reach}"


def _worth(band: ManoeuvreBand) -> str:
    low, high = band.low.total or 0.0, band.high.total or 0.0
    return f"worth {math.floor(10 * low) / 10:.1f} to {math.ceil(10 * high) / 10:.1f} points"


def _ships(frame: Frame, band: ManoeuvreBand) -> str:
    """Which ships can come into the domain, or that none can, and how near the nearest can come."""
    if not band.targets:
        return ""
    names = {target.id: target.name for target in frame.targets}
    inside = [target for target in band.targets if target.depth > 0.0]

    def named(target: TargetBand) -> str:
        return names.get(target.id, target.id)

    nearest = min(inside or band.targets, key=lambda target: target.range_m)
    near = f"{named(nearest)} no nearer than {miles(_least_m(nearest))}"
    if not inside:
        return f"every ship stays out of the domain ({near})"
    return f"{joined([named(target) for target in inside])} can come into the domain ({near})"


def _least_m(target: TargetBand) -> float:
    """The least range, rounded down to what is said."""
    return math.floor(100 * target.range_m / NAUTICAL_MILE_M) / 100 * NAUTICAL_MILE_M


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
