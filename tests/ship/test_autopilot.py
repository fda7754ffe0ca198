import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.geometry import wrap_angle
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import SHIPS, ShipState, advance


@pytest.mark.parametrize("name", SHIPS)
@pytest.mark.parametrize("course_deg", [5.0, 60.0, -90.0])
def test_the_helmsman_reaches_a_course_and_does_not_overshoot(name, course_deg):
    ship, course = SHIPS[name], np.radians(course_deg)
    helm = autopilot_for(ship)

    def once(own, _):
        error = wrap_angle(course - own.heading_rad)
        own = advance(own, helm.rudder_rad(error, own.rate_of_turn_rad_s), ship, 5.0)
        return own, own.heading_rad

    start = ShipState.steady(0.0, 0.0, 0.0, ship.speed_m_s)
    _, headings = jax.lax.scan(once, start, None, length=360)
    assert abs(np.degrees(headings[-1]) - course_deg) < 0.3
    assert jnp.max(headings * np.sign(course)) < abs(course) + np.radians(1.0)


def test_the_rudder_never_passes_its_limit():
    ship = SHIPS["paper"]
    rudders = autopilot_for(ship).rudder_rad(jnp.linspace(-3, 3, 50), jnp.linspace(0.1, -0.1, 50))
    assert jnp.max(jnp.abs(rudders)) <= ship.rudder_limit_rad
