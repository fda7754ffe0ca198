"""Keeping watch: pictures of live traffic become frames, one look after the other.

The same observation, decision and reasons as under way (:mod:`glasshelm.simulation.voyage`),
but every look brings a picture of its own: own ship goes her own way, and the
targets are known only until now.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.ais.limits import LOST_SHOWN_S
from glasshelm.encounters.types import Encounter, Scenario
from glasshelm.env.rewards import Reward
from glasshelm.env.step import EnvSettings, observe_step, reset
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.ship.nomoto import ShipParams, ShipState
from glasshelm.simulation.explained_step import ExplainedStep, explain_step
from glasshelm.simulation.frame_builder import FrameBuilder
from glasshelm.simulation.prediction import predict_track
from glasshelm.simulation.voyage import Carry, init_carry


class LiveAdvisor:
    """One pilot on watch, advising. Pictures are scenarios at whose t = 0 it is now.

    They keep their slots: a ship stays in hers as long as she is known. Looks
    are meant to be one step (5 s) apart; an observation holds the last five.
    """

    def __init__(
        self,
        pilot: Pilot,
        settings: EnvSettings = EnvSettings(),
        lost_shown_s: float = LOST_SHOWN_S,
    ):
        self.pilot, self.settings = pilot, settings
        self._lost_shown_s = lost_shown_s
        self._last: tuple[Scenario, Carry, ShipParams, float] | None = None

    def look(self, scenario: Scenario, time_s: float) -> Frame:
        """The frame of a picture at a time of the watch; ``scenario.start`` is that of time 0.

        Where the pictures' origin has moved, everything begins anew.
        """
        encounter = scenario.encounter
        ship = jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), scenario.ship)
        if self._last is None or self._last[0].origin != scenario.origin:
            carry = init_carry(encounter, ship, self.settings, self.pilot)
            first, others, since_s = True, np.ones(len(scenario.targets), bool), 0.0
        else:
            before, carry, _, last_s = self._last
            pairs = zip(before.targets, scenario.targets, strict=True)
            others = np.array([a.id != b.id for a, b in pairs], bool)
            first, since_s = False, time_s - last_s
        carry, moment, reward = _look(
            self.pilot,
            encounter,
            carry,
            ship,
            jnp.asarray(first),
            jnp.asarray(others),
            jnp.asarray(since_s, jnp.float32),
            self.settings,
            self._lost_shown_s,
        )
        self._last = scenario, carry, ship, time_s
        framer = FrameBuilder(scenario, self.pilot, applied=False)
        moment, reward = jax.device_get((moment, reward))
        return framer.frame(moment, time_s, None if first else reward)

    def predicted(self) -> ShipState | None:
        """Own ship's track under the pilot from the last look on."""
        if self._last is None:
            return None
        scenario, carry, ship, _ = self._last
        state, memory = carry.state, carry.memory
        return predict_track(self.pilot, scenario.encounter, state, memory, ship, self.settings)


@eqx.filter_jit
def _look(
    pilot: Pilot,
    encounter: Encounter,
    carry: Carry,
    ship: ShipParams,
    first: Bool[Array, ""],
    others: Bool[Array, " n"],
    since_s: Float[Array, ""],
    settings: EnvSettings,
    lost_shown_s: float,
) -> tuple[Carry, ExplainedStep, Reward]:
    """One look: what is seen, then what is decided.

    ``others`` are the slots that hold another ship than before; ``since_s`` is
    the time since the look before. Time 0 of the world is always now.
    """
    known, held = carry.state.observation, carry.held
    known = eqx.tree_at(lambda o: o.present, known, known.present & ~others)
    held = eqx.tree_at(
        lambda h: (h.time_s, h.motion.present),
        held,
        (held.time_s - since_s, held.motion.present & ~others),
    )
    before = eqx.tree_at(
        lambda s: (s.step, s.observation, s.danger),
        carry.state,
        (jnp.full_like(carry.state.step, -1), known, jnp.where(others, 0.0, carry.state.danger)),
    )
    observation = observe_step(encounter, before, encounter.own, ship, settings)
    state = jax.tree.map(
        lambda new, on: jnp.where(first, new, on),
        reset(encounter, ship, settings),
        observation.state,
    )
    moment, held, memory = explain_step(
        pilot, encounter, state, held, carry.memory, ship, settings, lost_shown_s
    )
    return Carry(state, held, memory), moment, observation.reward
