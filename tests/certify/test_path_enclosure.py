"""Own ship's way lies in its enclosure, whatever the errors of its own measurements are."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.certify.path_enclosure import PathErrors, _Loop, enclose_paths
from glasshelm.core.geometry import Vector, wrap_angle
from glasshelm.planning.manoeuvres import ManoeuvreTable, PredictedOwn, predict_manoeuvres
from glasshelm.planning.simulated_critic import ManoeuvreCosts
from glasshelm.planning.situation import Situation
from glasshelm.ship.nomoto import SHIPS

TABLE, COSTS = ManoeuvreTable(), ManoeuvreCosts()
KEEP = np.arange(len(TABLE.off_waypoint()) + len(TABLE.keep_s)) >= len(TABLE.off_waypoint())
#: Place [m], heading [°], rate of turn [°/s].
LEVELS = ((0.0, 0.0, 0.0), (10.0, 0.5, 1e-3), (30.0, 1.0, 1e-3), (100.0, 3.0, 5e-3))
WAYPOINTS = {
    "ahead": (500.0, 40_000.0),
    "abeam": (15_000.0, 2_000.0),
    "abaft": (-9_000.0, -9_000.0),
}


def situation(waypoint: Vector, rate_rad_s: float) -> Situation:
    nobody = Vector(jnp.zeros(0), jnp.zeros(0))
    bearing = jnp.arctan2(waypoint.x, waypoint.y)
    return Situation(waypoint, bearing, jnp.asarray(rate_rad_s), nobody, nobody)


def errors_of(place_m: float, heading_deg: float, rate_deg_s: float) -> PathErrors:
    turned = np.array([[0.8, -0.6], [0.6, 0.8]]) * place_m
    return PathErrors(
        jnp.asarray(turned, jnp.float32),
        jnp.float32(np.radians(heading_deg)),
        jnp.float32(np.radians(rate_deg_s)),
    )


@eqx.filter_jit
def enclosed(at, errors, ship):
    return enclose_paths(TABLE.at(at.bearing_rad), at, KEEP, errors, ship, COSTS)


@eqx.filter_jit
def sailed(at, errors, fractions, rate, ship):
    """Places and headings [k, c], in the frame of the measured heading, with these errors."""
    turned = fractions[2] * errors.heading_rad
    off = errors.place @ fractions[:2]
    x, y = at.waypoint.x - off[0], at.waypoint.y - off[1]
    sine, cosine = jnp.sin(turned), jnp.cos(turned)
    seen = Vector(x * cosine - y * sine, x * sine + y * cosine)
    bearing = jnp.arctan2(seen.x, seen.y)
    here = Situation(seen, bearing, at.rate_of_turn_rad_s + rate * errors.rate_rad_s,
                     at.position, at.velocity)  # fmt: skip
    rows = TABLE.at(bearing)

    def step(carry, time):
        ahead, bearing = carry
        ahead = predict_manoeuvres(ahead, bearing, rows, time, here, ship, COSTS.step_s)
        east = ahead.x * cosine + ahead.y * sine
        north = ahead.y * cosine - ahead.x * sine
        return (ahead, ahead.bearing_of(seen)), (east, north, ahead.heading + turned)

    start = PredictedOwn.here(here.rate_of_turn_rad_s, rows.offset_rad.size)
    times = jnp.arange(round(COSTS.horizon_s / COSTS.step_s), dtype=jnp.float32) * COSTS.step_s
    return jax.lax.scan(step, (start, jnp.zeros_like(start.x) + bearing), times)[1]


@pytest.mark.slow
@pytest.mark.parametrize("ship", ["paper", "large_ship"])
@pytest.mark.parametrize("waypoint", WAYPOINTS)
@pytest.mark.parametrize("level", LEVELS, ids=str)
def test_no_error_leads_out_of_it(ship, waypoint, level):
    at = situation(Vector(*map(jnp.float32, WAYPOINTS[waypoint])), 0.001)
    errors, ship = errors_of(*level), SHIPS[ship]
    path = jax.device_get(enclosed(at, errors, ship))
    drawn = np.random.default_rng(0)
    for number in range(12):
        fractions = drawn.uniform(-1, 1, 4)
        if number % 2:
            fractions = np.sign(fractions)
        x, y, heading = jax.device_get(
            sailed(at, errors, jnp.asarray(fractions[:3]), fractions[3], ship)
        )
        slopes = fractions[:3].astype(np.float32)
        centre = [
            nominal + np.einsum("kgc,g->kc", slope, slopes)
            for nominal, slope in ((path.ahead.x, path.x), (path.ahead.y, path.y))
        ]
        assert np.all(np.hypot(x - centre[0], y - centre[1]) <= path.place_slack)
        turned = path.ahead.heading + np.einsum("kgc,g->kc", path.heading, slopes)
        off = np.abs(np.asarray(wrap_angle(jnp.asarray(heading - turned))))
        assert np.all((off <= path.heading_slack) | path.lost)
    if level[1] <= 0.5:
        assert np.mean(path.lost) < 0.05


@pytest.mark.parametrize("ship", SHIPS)
def test_the_closed_loop_contracts_what_is_not_known(ship):
    loop = _Loop(SHIPS[ship], COSTS.step_s)
    assert loop.norms[1] < 0.9
    np.testing.assert_allclose(loop.matrices[0], [[1, 0], [0, loop.matrices[0][1, 1]]])


def test_own_ship_that_passes_its_waypoint_is_lost_not_wrong():
    """A waypoint that is passed nearer than its place is known has no bearing."""
    at = situation(Vector(jnp.float32(0.0), jnp.float32(3000.0)), 0.0)
    path = jax.device_get(enclosed(at, errors_of(100.0, 0.5, 0.0), SHIPS["paper"]))
    assert path.lost[-1, 0]
    assert not path.lost[20, 0]
    assert path.heading_slack[-1, 0] == np.float32(np.pi)
