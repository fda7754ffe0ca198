"""The autopilot: from a course to a rudder, for pilots that think in courses."""

import dataclasses

import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.ship.nomoto import ShipParams

Number = float | Float[Array, ""]


@dataclasses.dataclass(frozen=True)
class Autopilot:
    """δ = P·(course error) − D·(rate of turn), within the limit."""

    proportional: Number
    derivative_s: Number
    limit_rad: Number

    def rudder_rad(
        self, error_rad: Float[Array, "*b"], rate_of_turn_rad_s: Float[Array, "*b"]
    ) -> Float[Array, "*b"]:
        """The rudder for a course error in [−π, π); starboard positive."""
        wanted = self.proportional * error_rad - self.derivative_s * rate_of_turn_rad_s
        return jnp.clip(wanted, -self.limit_rad, self.limit_rad)


#: No autopilot is faster than this: commands may be held for 15 s.
MIN_TIME_CONSTANT_S = 20.0


def autopilot_for(ship: ShipParams) -> Autopilot:
    """The autopilot that brings a ship to a new course without overshoot (critically damped).

    With Eq. 6 the course error obeys T·ë + (1 + K·D)·ė + K·P·e = 0. Both roots
    are −1/τ with P = T/(K·τ²) and D = (2·T/τ − 1)/K; τ is somewhat less than
    half of the ship's own T, a course error of 5° then asks for about full rudder.
    """
    gain, lag = ship.gain_1_s, ship.time_constant_s
    tau = jnp.maximum(0.45 * lag, MIN_TIME_CONSTANT_S)
    return Autopilot(
        lag / (gain * tau**2),
        jnp.maximum((2.0 * lag / tau - 1.0) / gain, 0.0),
        ship.rudder_limit_rad,
    )
