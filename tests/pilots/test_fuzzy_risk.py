"""Fuzzy risk is a risk: in [0, 1], higher for nearer and for sooner."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import colliding, observed

from glasshelm.core.geometry import Cpa, Vector
from glasshelm.pilots.fuzzy_risk import FuzzySettings, fuzzy_course, fuzzy_risk, memberships
from glasshelm.ship.nomoto import SHIPS

SHIP, SETTINGS = SHIPS["paper"], FuzzySettings()


def risk(dcpa_m, tcpa_s):
    dcpa, tcpa = jnp.broadcast_arrays(*(jnp.asarray(x, jnp.float32) for x in (dcpa_m, tcpa_s)))
    return np.asarray(fuzzy_risk(Cpa(Vector(dcpa, dcpa), dcpa, tcpa), SHIP, SETTINGS))


def test_memberships_sum_to_one_and_peak_at_their_peaks():
    values = jnp.linspace(-3.0, 20.0, 47)
    np.testing.assert_allclose(memberships(values, SETTINGS.dcpa_loa).sum(-1), 1.0, atol=1e-5)
    peaks = jnp.asarray(SETTINGS.dcpa_loa)
    np.testing.assert_allclose(memberships(peaks, SETTINGS.dcpa_loa), jnp.eye(4), atol=1e-6)


def test_risk_falls_with_dcpa_and_with_tcpa_and_stays_in_bounds():
    table = risk(np.linspace(0, 4000, 41)[None, :], np.linspace(1, 6000, 61)[:, None])
    assert table.min() >= 0.0
    assert table.max() <= 1.0
    assert (np.diff(table, axis=0) <= 1e-6).all()
    assert (np.diff(table, axis=1) <= 1e-6).all()
    assert table[0, 0] > 0.99
    assert table[-1].max() == table[:, -1].max() == 0.0


def test_a_ship_that_has_passed_is_no_risk():
    assert risk(0.0, -1.0) == 0.0


def test_the_rules_are_a_table_of_so_many_sets():
    assert np.shape(SETTINGS.risks) == (len(SETTINGS.tcpa_loa), len(SETTINGS.dcpa_loa))


@pytest.mark.slow
def test_an_alteration_holds_while_the_way_ahead_is_between_the_limits():
    chosen = jax.jit(lambda s, o: fuzzy_course(s, o, SHIP, SETTINGS))
    way = np.asarray([risk(d, 1000.0) for d in np.linspace(0, 3000, 301)])
    between = np.linspace(0, 3000, 301)[
        (way > SETTINGS.return_below + 0.03) & (way < SETTINGS.act_above - 0.03)
    ]
    row = (-float(between.mean()), 10_000.0, 180.0, 5.0)
    assert float(chosen(observed(row), jnp.zeros(()))) == 0.0
    assert float(chosen(observed(row), jnp.float32(0.7))) > 0.0
    assert float(chosen(observed(colliding(180.0)), jnp.zeros(()))) != 0.0
