"""Interval arithmetic in double precision, and intervals of a number and of its rate.

An interval is a pair of arrays that holds a number for certain. Every result is widened by a
few units in the last place, more than one operation can lose. It is NumPy: a band asks for
some hundred operations on a few thousand numbers, which is quicker done than compiled.
"""

import dataclasses
import math

import numpy as np
from jaxtyping import Float

_WIDEN = 4 * 2.0**-53
_TINY = 1e-290
QUARTER_TURN = 0.5 * math.pi

Numbers = Float[np.ndarray, "..."]


@dataclasses.dataclass(frozen=True)
class Interval:
    """All numbers from ``low`` to ``high``."""

    low: Numbers
    high: Numbers
    #: Products with an array on the left are ours too.
    __array_ufunc__ = None

    @property
    def midpoint(self) -> Numbers:
        return 0.5 * self.low + 0.5 * self.high

    @property
    def radius(self) -> Numbers:
        """Half the width, with room for what the midpoint lost."""
        half = np.maximum(self.high - self.midpoint, self.midpoint - self.low)
        return half + _WIDEN * (half + np.abs(self.midpoint))

    @property
    def magnitude(self) -> Numbers:
        """The largest absolute value in it."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    def __getitem__(self, place) -> "Interval":
        return Interval(self.low[place], self.high[place])

    def __add__(self, other: "Interval | Numbers | float") -> "Interval":
        other = point(other)
        return _out(self.low + other.low, self.high + other.high)

    def __neg__(self) -> "Interval":
        return Interval(-self.high, -self.low)

    def __sub__(self, other: "Interval | Numbers | float") -> "Interval":
        other = point(other)
        return _out(self.low - other.high, self.high - other.low)

    def __mul__(self, other: "Interval | Numbers | float") -> "Interval":
        other = point(other)
        a, b = self.low * other.low, self.low * other.high
        c, d = self.high * other.low, self.high * other.high
        # NaN (0·∞) must survive here: minimum and maximum pass it on.
        low = np.minimum(np.minimum(a, b), np.minimum(c, d))
        return _out(low, np.maximum(np.maximum(a, b), np.maximum(c, d)))

    def __rmul__(self, other: "Numbers | float") -> "Interval":
        return self * other

    def __truediv__(self, other: "Interval | float") -> "Interval":
        return self * (1.0 / other if isinstance(other, (int, float)) else other.reciprocal())

    def square(self) -> "Interval":
        """Never negative."""
        a, b = self.low * self.low, self.high * self.high
        least = np.where((self.low <= 0) & (self.high >= 0), 0.0, np.minimum(a, b))
        wide = _out(least, np.maximum(a, b))
        return Interval(np.maximum(wide.low, 0.0), wide.high)

    def root(self) -> "Interval":
        """Of what is not negative."""
        wide = _out(np.sqrt(np.maximum(self.low, 0.0)), np.sqrt(np.maximum(self.high, 0.0)))
        return Interval(np.maximum(wide.low, 0.0), wide.high)

    def reciprocal(self) -> "Interval":
        """Everything where it may be 0."""
        safe = (self.low > 0) | (self.high < 0)
        low, high = np.where(safe, self.low, 1.0), np.where(safe, self.high, 1.0)
        wide = _out(1.0 / high, 1.0 / low)
        return Interval(np.where(safe, wide.low, -np.inf), np.where(safe, wide.high, np.inf))

    def cosine(self) -> "Interval":
        """Monotone between whole half turns; 1 or −1 where such a one lies inside."""
        ends = np.cos(self.low), np.cos(self.high)
        lost = 1e-14 * (1.0 + self.magnitude)
        low, high = np.minimum(*ends) - lost, np.maximum(*ends) + lost

        def holds(phase: float) -> np.ndarray:
            first = np.ceil((self.low - phase) / (2 * math.pi) - 1e-12)
            return first * (2 * math.pi) + phase <= self.high + 1e-12

        high = np.where(holds(0.0), 1.0, np.minimum(high, 1.0))
        low = np.where(holds(math.pi), -1.0, np.maximum(low, -1.0))
        return Interval(low, high)

    def sine(self) -> "Interval":
        return (self - QUARTER_TURN).cosine()

    def within(self, low: "Numbers | float", high: "Numbers | float") -> "Interval":
        """Of a number that is known to lie between others too."""
        return Interval(np.clip(self.low, low, high), np.clip(self.high, low, high))

    def absolute(self) -> "Interval":
        """Of the number without its sign."""
        low = np.maximum(np.maximum(self.low, -self.high), 0.0)
        return Interval(low, self.magnitude)


def _out(low: Numbers, high: Numbers) -> Interval:
    """Widened; what is not a number could be any."""
    low = np.where(np.isnan(low), -np.inf, low - _WIDEN * np.abs(low) - _TINY)
    return Interval(low, np.where(np.isnan(high), np.inf, high + _WIDEN * np.abs(high) + _TINY))


def point(x: Interval | Numbers | float) -> Interval:
    """One number, as an interval."""
    if isinstance(x, Interval):
        return x
    x = np.atleast_1d(np.asarray(x, np.float64))
    return Interval(x, x)


def ball(x: Numbers, radius: Numbers) -> Interval:
    """All numbers within a radius of x."""
    return _out(x - radius, x + radius)


def hull(a: Interval, b: Interval) -> Interval:
    """The smallest interval that holds both."""
    return Interval(np.minimum(a.low, b.low), np.maximum(a.high, b.high))


def where(test: np.ndarray, a: Interval, b: Interval) -> Interval:
    return Interval(np.where(test, a.low, b.low), np.where(test, a.high, b.high))


def stack(parts: list[Interval], axis: int = -1) -> Interval:
    """Intervals of the same shape side by side."""
    return Interval(np.stack([x.low for x in parts], axis), np.stack([x.high for x in parts], axis))


def concatenate(parts: list[Interval], axis: int) -> Interval:
    """Intervals joined along an axis."""
    low, high = [x.low for x in parts], [x.high for x in parts]
    return Interval(np.concatenate(low, axis), np.concatenate(high, axis))


def polar(along: Interval, across: Interval) -> tuple[Interval, Interval]:
    """Length of a vector and its angle from the axis near which it points, any if it may not."""
    ahead = along.low > 0
    low = np.arctan2(across.low, np.where(across.low < 0, along.low, along.high))
    high = np.arctan2(across.high, np.where(across.high > 0, along.low, along.high))
    wide = _out(low - 1e-15, high + 1e-15)
    turn = Interval(np.where(ahead, wide.low, -math.pi), np.where(ahead, wide.high, math.pi))
    return (along.square() + across.square()).root(), turn


@dataclasses.dataclass(frozen=True)
class Jet:
    """An interval of a number, and one of its rate along a path: intervals for dual numbers."""

    value: Interval
    rate: Interval

    def __add__(self, other: "Jet | float") -> "Jet":
        if isinstance(other, (int, float)):
            return Jet(self.value + other, self.rate)
        return Jet(self.value + other.value, self.rate + other.rate)

    def __neg__(self) -> "Jet":
        return Jet(-self.value, -self.rate)

    def __sub__(self, other: "Jet") -> "Jet":
        return self + -other

    def __mul__(self, other: "Jet | Interval | float") -> "Jet":
        if isinstance(other, Jet):
            rate = self.rate * other.value + self.value * other.rate
            return Jet(self.value * other.value, rate)
        return Jet(self.value * other, self.rate * other)

    def __truediv__(self, other: "Jet | float") -> "Jet":
        return self * (1.0 / other if isinstance(other, (int, float)) else other.reciprocal())

    def reciprocal(self) -> "Jet":
        inverse = self.value.reciprocal()
        return Jet(inverse, -(inverse.square() * self.rate))

    def sine(self) -> "Jet":
        return Jet(self.value.sine(), self.value.cosine() * self.rate)

    def cosine(self) -> "Jet":
        return Jet(self.value.cosine(), -(self.value.sine() * self.rate))
