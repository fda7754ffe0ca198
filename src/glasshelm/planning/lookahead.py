"""Where a pilot's own way leads while all keep straight on: a simulation ahead."""

import dataclasses
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.geometry import Vector, direction, norm
from glasshelm.encounters.types import Encounter, straight_track
from glasshelm.env.observe import Observation
from glasshelm.env.step import EnvSettings, EnvState, step
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import ShipParams, ShipState

#: Steps for which a rudder is held in thought (15 s): a third of the decisions.
HOLD_STEPS = 3


#: A state, and whether its waypoint was reached.
_Carry = tuple[EnvState, Bool[Array, ""]]


class Lookahead(eqx.Module):
    """What lies on the way.

    ``worst`` is the deepest Eq. 13 of any ship, unclipped (above 0: inside own ship's domain; −1:
    nobody there). ``slot`` is the first ship who comes nearer than was asked for, ``within_s`` when
    (inf: nobody does), ``depth`` how deep she comes.
    """

    worst: Float[Array, "*b"]
    slot: Int[Array, "*b"]
    within_s: Float[Array, "*b"]
    depth: Float[Array, "*b"]


def look_ahead(
    steer: Callable[[Observation], Float[Array, ""]],
    observation: Observation,
    ship: ShipParams,
    horizon_s: float,
    slack: float = 0.0,
) -> Lookahead:
    """Sail ahead from one observation, own ship by Eq. 6-7, seeing what will be seen there.

    ``steer`` gives a rudder as a fraction of the limit and remembers nothing. A ship is
    near from ``slack`` (in Eq. 13) outside the domain on. What comes after the waypoint does
    not count.
    """
    if observation.present.shape[0] == 0:
        nobody = jnp.array(-1.0)
        return Lookahead(nobody, jnp.zeros((), jnp.int32), jnp.array(jnp.inf), nobody)
    at = situation_of(observation, ship)
    still = ShipState.steady(0.0, 0.0, 0.0, ship.speed_m_s)
    own = dataclasses.replace(still, rate_of_turn_rad_s=at.rate_of_turn_rad_s)
    course, speed = direction(at.velocity), norm(at.velocity)
    targets = straight_track(at.position.x, at.position.y, course, speed)
    route = Vector(at.waypoint.x[None], at.waypoint.y[None])
    ahead = Encounter(own, route, targets, observation.present)
    zero = jnp.zeros((), jnp.int32)
    begin = EnvState(own, zero, zero, observation, jnp.zeros(observation.present.shape))

    def onward(carry: _Carry, _: None) -> tuple[_Carry, Float[Array, " n"]]:
        state, arrived = carry
        rudder = steer(state.observation) * ship.rudder_limit_rad
        worst = jnp.full(observation.present.shape, -1.0)
        for _step in range(HOLD_STEPS):
            out = step(ahead, state, rudder, ship)
            state, arrived = out.state, arrived | out.terminated
            worst = jnp.where(arrived, worst, jnp.maximum(worst, out.margin))
        return (state, arrived), jnp.where(observation.present, worst, -1.0)

    held_s = HOLD_STEPS * EnvSettings().step_s
    _, worst = jax.lax.scan(onward, (begin, jnp.zeros((), bool)), length=round(horizon_s / held_s))
    near = worst > -slack
    first = jnp.where(near.any(0), jnp.argmax(near, axis=0) * held_s, jnp.inf)
    slot = jnp.argmin(first)
    return Lookahead(worst.max(), slot, first[slot], worst[:, slot].max())
