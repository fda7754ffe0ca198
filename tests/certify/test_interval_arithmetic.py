"""An interval holds what it says at every point of the box; so does that of a rate."""

import numpy as np
import pytest

from glasshelm.certify.interval_arithmetic import Interval, Jet, hull, point, polar

#: The same function of intervals and of numbers.
ASKED = {
    "sum": (lambda x, y: x + y - x, lambda x, y: y),
    "product": (lambda x, y: x * y, lambda x, y: x * y),
    "quotient": (lambda x, y: x / (y.square() + 2.0), lambda x, y: x / (y**2 + 2)),
    "waves": (lambda x, y: x.sine() * (y * 3.0).cosine(), lambda x, y: np.sin(x) * np.cos(3 * y)),
    "root": (lambda x, y: (x.square() + y.square()).root(), np.hypot),
    "size": (lambda x, y: (x * y).absolute(), lambda x, y: np.abs(x * y)),
    "either": (hull, lambda x, y: x),
}


def _boxes(seed: int) -> tuple[np.ndarray, np.ndarray]:
    drawn = np.random.default_rng(seed)
    low = drawn.normal(size=(2, 300)) * 4
    return low, low + drawn.exponential(size=(2, 300)) * drawn.uniform(0, 1, 300) ** 3


def _inside(low: np.ndarray, high: np.ndarray, times: int = 60):
    drawn = np.random.default_rng(7)
    for _ in range(times):
        yield low + drawn.uniform(size=low.shape) * (high - low)


@pytest.mark.parametrize("name", ASKED)
def test_an_interval_holds_every_value(name):
    of_boxes, of_numbers = ASKED[name]
    low, high = _boxes(1)
    found = of_boxes(*(Interval(*x) for x in zip(low, high, strict=True)))
    for x, y in _inside(low, high):
        value = of_numbers(x, y)
        assert np.all((found.low <= value) & (value <= found.high))


def test_dividing_by_what_may_be_zero_gives_anything():
    found = Interval(-np.ones(1), np.ones(1)).reciprocal()
    assert found.low[0] == -np.inf
    assert found.high[0] == np.inf


def test_nothing_times_anything_is_anything():
    everything = Interval(np.full(1, -np.inf), np.full(1, np.inf))
    with np.errstate(invalid="ignore"):
        found = point(0.0) * everything
    assert found.low[0] == -np.inf
    assert found.high[0] == np.inf


def test_polar_coordinates_hold_every_vector_of_a_box():
    low, high = _boxes(2)
    length, turn = polar(*(Interval(*x) for x in zip(low, high, strict=True)))
    for along, across in _inside(low, high):
        angle, size = np.arctan2(across, along), np.hypot(along, across)
        assert np.all((length.low <= size) & (size <= length.high))
        assert np.all((turn.low <= angle) & (angle <= turn.high))


def test_a_jet_holds_the_rate():
    low, high = _boxes(3)
    rate = np.random.default_rng(4).normal(size=low.shape)
    x, y = (Jet(Interval(*b), point(r)) for *b, r in zip(low, high, rate, strict=True))
    found = (x * y).sine() / (Jet(y.value.square(), y.value * y.rate * 2.0) + 1.0)

    def at(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.sin(x * y) / (y**2 + 1)

    for x in _inside(low, high):
        step = 1e-6 * rate
        slope = (at(*(x + step)) - at(*(x - step))) / 2e-6
        room = 1e-6 * (1 + np.abs(slope)) * (1 + np.abs(rate).max())
        assert np.all((found.rate.low <= slope + room) & (slope - room <= found.rate.high))
