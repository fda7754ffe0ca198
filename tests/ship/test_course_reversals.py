"""Weaving is counted as a navigator would count it."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.ship.course_reversals import Reversals


def reversals(headings_deg) -> int:
    changes = jnp.radians(jnp.diff(jnp.asarray(headings_deg, jnp.float32)))
    return int(jax.lax.scan(lambda r, c: (r.after(c), None), Reversals.none(), changes)[0].count)


def ramp(*corners):
    """A heading that goes from corner to corner in steps of a degree."""
    parts = [np.arange(a, b, np.sign(b - a)) for a, b in itertools.pairwise(corners)]
    return np.concatenate([*parts, [corners[-1]]])


@pytest.mark.parametrize(
    ("corners", "number"),
    [
        ((0, 40), 0),  # an alteration alone
        ((0, 40, 0), 1),  # away and back
        ((0, 40, -20, 0), 2),  # back past the way, and up to it
        ((0, -40, 0), 1),  # the other side counts the same
        ((0, 4, -0.5, 4, 0), 0),  # less than the hysteresis
        ((0, 30, 27, 33, 29, 60), 0),  # a wandering alteration to one side
        ((0, 20, 5, 25, 0, 30, -10, 0), 6),
        ((350, 380, 350), 1),  # through north
    ],
)
def test_reversals(corners, number):
    assert reversals(ramp(*corners)) == number
