"""What was measured: the raw numbers behind an observation, and the errors they may have.

Networks see features (Eq. 10-12); sensors err in positions, courses and speeds. A
*plot* is the six numbers behind one row of one frame. An error is a bias: it is
the same in all five frames, as satellite positions, gyros and logs err over 20 s.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from glasshelm.core.geometry import Vector
from glasshelm.encounters.types import Motion
from glasshelm.env.observe import Observation, observe
from glasshelm.ship.nomoto import ShipState

#: Symbols of own ship's errors (east, north, heading, speed) and of one target's.
N_OWN_ERRORS, N_TARGET_ERRORS = 4, 4


class SensorErrors(eqx.Module):
    """The largest error of each measurement, either way.

    Positions on each axis (east, north), own ship's heading and speed, a
    target's course and speed over ground.
    """

    own_position_m: float | Float[Array, ""]
    own_heading_rad: float | Float[Array, ""]
    own_speed_m_s: float | Float[Array, ""]
    position_m: float | Float[Array, ""]
    course_rad: float | Float[Array, ""]
    speed_m_s: float | Float[Array, ""]

    def own(self) -> Float[Array, "4"]:
        """The radii of own ship's symbols."""
        one = (self.own_position_m, self.own_position_m, self.own_heading_rad, self.own_speed_m_s)
        return jnp.stack([jnp.asarray(x, jnp.float32) for x in one])

    def target(self) -> Float[Array, "4"]:
        """The radii of a target's symbols."""
        one = (self.position_m, self.position_m, self.course_rad, self.speed_m_s)
        return jnp.stack([jnp.asarray(x, jnp.float32) for x in one])


class RawPlots(eqx.Module):
    """Plots over five frames, newest first; a waypoint's course and speed mean still.

    A plot is (east, north) from own ship [m], own heading [rad] and speed [m/s] at that
    moment, the target's course [rad] and speed [m/s].
    """

    waypoint: Float[Array, "*b frames 6"]
    targets: Float[Array, "*b n frames 6"]
    present: Bool[Array, "*b n"]


def observe_plots(scene: RawPlots) -> Observation:
    """What the pilot observes of a scene, by the code of the environment (Eq. 10-12)."""
    observation = jax.vmap(lambda plot: _seen(plot[None])[0])(scene.waypoint)
    targets = jax.vmap(lambda row: _seen(row)[1])(scene.targets)
    return Observation(
        observation, jnp.where(scene.present[:, None, None], targets, 0.0), scene.present
    )


def _seen(plot: Float[Array, "k 6"]) -> tuple[Float[Array, "3"], Float[Array, "k 10"]]:
    """The rows of plots, each seen from own ship as it then was: the first as a waypoint too."""

    def one(p: Float[Array, "6"]) -> tuple[Array, Array]:
        zero = jnp.zeros_like(p[0])
        own = ShipState(zero, zero, p[2], zero, zero, p[3])
        motion = Motion(p[0:1], p[1:2], p[4:5], p[5:6], p[0:1] * 0, jnp.ones(1, bool))
        sight = observe(own, Vector(p[0], p[1]), motion, motion.present)
        return sight.waypoint, sight.targets[0]

    waypoint, targets = jax.vmap(one)(plot)
    return waypoint[0], targets


def with_errors(scene: RawPlots, own: Float[Array, "4"], target: Float[Array, "n 4"]) -> RawPlots:
    """The scene as it would have been measured with these errors [m, rad, m/s] on top.

    An own ship shown too far east sees everything too far west.
    """
    still = jnp.zeros(2)
    mine = jnp.concatenate([-own[:2], own[2:], still])
    theirs = jnp.concatenate([target[:, :2], jnp.zeros_like(target[:, :2]), target[:, 2:]], -1)
    return RawPlots(scene.waypoint + mine, scene.targets + mine + theirs[:, None], scene.present)
