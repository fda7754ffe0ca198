"""A learned pilot under guard: while its own way brings a ship into the domain, the guard steers.

Run-time assurance after the Simplex architecture (Sha 2001). Every minute the pilot is sailed
ahead (:mod:`glasshelm.planning.lookahead`). While that way keeps clear of every ship it
steers; while it does not, own ship is steered by the guard, a glassbox pilot
(:mod:`glasshelm.pilots.glassbox`), which chooses anew at every decision and says why. Guard and
pilot see the same, and the guard takes every target to keep straight on.
"""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.errors import InputError
from glasshelm.env.observe import Observation
from glasshelm.env.training_envelope import TrainingEnvelope
from glasshelm.explanation.step_explanation import Explanation
from glasshelm.pilots.batched import in_step
from glasshelm.pilots.glassbox import GlassboxPilot, best_course
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.protocols import Decision, GuardStatus, Overruled, Pilot
from glasshelm.planning.lookahead import Lookahead, look_ahead
from glasshelm.planning.simulated_critic import ManoeuvreCosts, SimulatedCritic
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import ShipParams

#: What the name of a guarded pilot ends in.
GUARDED = "-guarded"


@dataclasses.dataclass(frozen=True)
class GuardSettings:
    """How the guard watches.

    It looks every ``period`` decisions as far ahead as its critic does, and takes
    over where the pilot's way brings a ship nearer to own ship's domain than ``slack`` (in
    Eq. 13, unclipped). It keeps off the others' midst at twice the usual weight:
    where an intrusion cannot be helped, a collision must not follow.
    """

    period: int = 12
    slack: float = 0.05
    costs: ManoeuvreCosts = dataclasses.field(
        default_factory=lambda: ManoeuvreCosts(near_weight=8000.0)
    )


class GuardState(eqx.Module):
    """What the guard remembers from its last look.

    ``engaged``: it has the helm. ``age``: decisions since the start.
    """

    engaged: Bool[Array, "*b"]
    age: Int[Array, "*b"]


class GuardedPilot(eqx.Module):
    """Steers as ``pilot`` while that keeps clear."""

    pilot: LearnedPilot
    settings: GuardSettings = eqx.field(static=True, default=GuardSettings())

    def __check_init__(self) -> None:
        if isinstance(self.pilot, Pilot) and not isinstance(self.pilot, LearnedPilot):
            raise InputError(f"pilot {self.pilot.name!r} cannot be guarded: only learned ones can")

    @property
    def name(self) -> str:
        return self.pilot.name + GUARDED

    @property
    def weights_sha256(self) -> str | None:
        return self.pilot.weights_sha256

    @property
    def trained(self) -> TrainingEnvelope:
        return self.pilot.trained

    @property
    def ship(self) -> ShipParams:
        return self.pilot.trained.ship

    @property
    def guard(self) -> GlassboxPilot:
        """Who steers while the pilot's own way does not keep clear."""
        return GlassboxPilot(self.ship, self.name, SimulatedCritic(costs=self.settings.costs))

    def start(self) -> GuardState:
        return GuardState(jnp.zeros((), bool), jnp.zeros((), jnp.int32))

    def decide(self, observation: Observation, memory: GuardState) -> tuple[Decision, GuardState]:
        """The pilot's own rudder or the guard's, and why by whoever of them steers."""
        rudder, memory = self._steer(observation, memory)
        own = jnp.where(memory.engaged, self.pilot.actor(observation), rudder)
        pilots, guards = self._explained(observation, rudder, memory.engaged)
        decision = Decision(
            rudder,
            pilots,
            Overruled(memory.engaged, own),
            GuardStatus(memory.engaged, self._look_ahead(observation), guards),
        )
        return decision, memory

    def explain(self, observation: Observation, rudder: Float[Array, ""]) -> Explanation:
        """What the pilot's networks say of a rudder."""
        return self.pilot.explain(observation, rudder)

    def _explained(
        self, observation: Observation, rudder: Float[Array, ""], engaged: Bool[Array, ""]
    ) -> tuple[Explanation, Explanation]:
        """The pilot's explanation and the guard's; all of it 0 of the one that does not steer."""

        def pilots() -> Explanation:
            return self.explain(observation, rudder)

        def guards() -> Explanation | None:
            return self.guard.decide(observation, ())[0].explanation

        return jax.lax.cond(
            engaged,
            lambda: (_zeros(jax.eval_shape(pilots)), guards()),
            lambda: (pilots(), _zeros(jax.eval_shape(guards))),
        )

    def _look_ahead(self, observation: Observation) -> Lookahead:
        """Where the pilot's own way leads from here."""
        settings = self.settings
        horizon_s = settings.costs.horizon_s
        return look_ahead(self.pilot.actor, observation, self.ship, horizon_s, settings.slack)

    @in_step
    def _steer(
        self, observation: Observation, memory: GuardState
    ) -> tuple[Float[Array, " w"], GuardState]:
        engaged = jax.lax.cond(
            memory.age[0] % self.settings.period == 0,
            lambda: jnp.isfinite(jax.vmap(self._look_ahead)(observation).within_s),
            lambda: memory.engaged,
        )
        # Encounter by encounter: the guard's choice costs something only where it steers.
        first = jnp.argsort(~engaged)

        def steered(k: Int[Array, ""], rudder: Float[Array, " w"]) -> Float[Array, " w"]:
            one = jax.tree.map(lambda x: x[first[k]], observation)
            offset = best_course(self.guard.critic, one, self.ship)
            return rudder.at[first[k]].set(rudder_towards(offset, one, self.ship))

        own = jax.vmap(self.pilot.actor)(observation)
        rudder = jax.lax.fori_loop(0, engaged.sum(), steered, own)
        return rudder, GuardState(engaged, memory.age + 1)


def _zeros(shapes: Any) -> Any:
    return jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), shapes)
