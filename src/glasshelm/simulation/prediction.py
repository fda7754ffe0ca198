"""Where own ship will go under the pilot, if every target keeps course and speed from now on."""

import equinox as eqx
import jax
import jax.numpy as jnp

from glasshelm.encounters.types import Encounter, straight_track
from glasshelm.env.step import EnvSettings, EnvState, step, targets_at
from glasshelm.pilots.decide import decide_on
from glasshelm.pilots.protocols import Memory, Pilot
from glasshelm.ship.nomoto import ShipParams, ShipState

#: How far ahead is looked [s].
AHEAD_S = 1200.0


def with_straight_targets(
    encounter: Encounter, state: EnvState, settings: EnvSettings
) -> Encounter:
    """The encounter as it would go on from this state with every target straight on, at t = 0."""
    now = targets_at(encounter, state.step * settings.step_s)
    straight = straight_track(now.east_m, now.north_m, now.course_rad, now.speed_m_s)
    return Encounter(state.own, encounter.route, straight, now.present)


@eqx.filter_jit
def predict_track(
    pilot: Pilot,
    encounter: Encounter,
    state: EnvState,
    memory: Memory,
    ship: ShipParams,
    settings: EnvSettings = EnvSettings(),
    ahead_s: float = AHEAD_S,
) -> ShipState:
    """Own ship now and after every step [steps + 1], steered by the pilot (Eq. 6-7).

    A recorded own ship leaves her track at once. She sails on past her last waypoint.
    """
    ahead = with_straight_targets(encounter, state, settings)

    def onward(
        carry: tuple[EnvState, Memory], _: None
    ) -> tuple[tuple[EnvState, Memory], ShipState]:
        state, memory = carry
        decision, memory, _selection = decide_on(pilot, state.observation, memory, ship)
        rudder = decision.rudder * ship.rudder_limit_rad
        after = step(ahead, state, rudder, ship, settings).state
        return (after, memory), after.own

    begin = eqx.tree_at(lambda s: s.step, state, jnp.zeros_like(state.step))
    _, later = jax.lax.scan(onward, (begin, memory), length=int(ahead_s / settings.step_s))
    return jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), state.own, later)
