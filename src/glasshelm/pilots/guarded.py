"""A learned pilot under guard: while its own way brings a ship into the domain, the planner steers.

Run-time assurance after the Simplex architecture (Sha 2001). Every minute the pilot is sailed
ahead (:mod:`glasshelm.planning.lookahead`). While that way keeps clear of every ship it
steers; while it does not, own ship is steered on the course that the planner finds
(:mod:`glasshelm.planning.course_planner`). Guard and planner see what the pilot sees, and take
every target to keep straight on.
"""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.errors import InputError
from glasshelm.env.observe import Observation
from glasshelm.env.training_envelope import TrainingEnvelope
from glasshelm.explanation.step_explanation import Explanation
from glasshelm.pilots.batched import in_step
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.protocols import Decision, GuardStatus, Overruled, Pilot
from glasshelm.planning.course_planner import CourseSettings, plan_course
from glasshelm.planning.lookahead import Lookahead, look_ahead
from glasshelm.planning.situation import rudder_towards
from glasshelm.ship.nomoto import ShipParams

#: What the name of a guarded pilot ends in.
GUARDED = "-guarded"


@dataclasses.dataclass(frozen=True)
class GuardSettings:
    """How the guard watches.

    It looks every ``period`` decisions as far ahead as the planner does, and takes
    over where the pilot's way brings a ship nearer to own ship's domain than ``slack`` (in
    Eq. 13, unclipped). Its planner keeps off the others' midst at twice the usual weight:
    where an intrusion cannot be helped, a collision must not follow.
    """

    period: int = 12
    slack: float = 0.05
    planner: CourseSettings = dataclasses.field(
        default_factory=lambda: CourseSettings(near_weight=2000.0)
    )


class GuardState(eqx.Module):
    """What the guard remembers from its last look.

    ``engaged``: it has the helm, on a course ``offset_rad`` off the bearing of the waypoint.
    ``age``: decisions since the start.
    """

    engaged: Bool[Array, "*b"]
    offset_rad: Float[Array, "*b"]
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

    def start(self) -> GuardState:
        return GuardState(jnp.zeros((), bool), jnp.zeros(()), jnp.zeros((), jnp.int32))

    def decide(self, observation: Observation, memory: GuardState) -> tuple[Decision, GuardState]:
        """The pilot's own rudder or the guard's, and what the pilot's networks say of it."""
        rudder, memory = self._steer(observation, memory)
        own = jnp.where(memory.engaged, self.pilot.actor(observation), rudder)
        decision = Decision(
            rudder,
            self.explain(observation, rudder),
            Overruled(memory.engaged, own),
            GuardStatus(memory.engaged, self._look_ahead(observation)),
        )
        return decision, memory

    def explain(self, observation: Observation, rudder: Float[Array, ""]) -> Explanation:
        """What the pilot's networks say of a rudder."""
        return self.pilot.explain(observation, rudder)

    def _look_ahead(self, observation: Observation) -> Lookahead:
        """Where the pilot's own way leads from here."""
        settings = self.settings
        horizon_s = settings.planner.horizon_s
        return look_ahead(self.pilot.actor, observation, self.ship, horizon_s, settings.slack)

    @in_step
    def _steer(
        self, observation: Observation, memory: GuardState
    ) -> tuple[Float[Array, " w"], GuardState]:
        engaged, offset = jax.lax.cond(
            memory.age[0] % self.settings.period == 0,
            lambda: self._look(observation),
            lambda: (memory.engaged, memory.offset_rad),
        )
        own = jax.vmap(self.pilot.actor)(observation)
        planned = jax.vmap(lambda o, s: rudder_towards(o, s, self.ship))(offset, observation)
        return jnp.where(engaged, planned, own), GuardState(engaged, offset, memory.age + 1)

    def _look(self, observation: Observation) -> tuple[Bool[Array, " w"], Float[Array, " w"]]:
        """In which encounters the guard takes over, and on which course; planned only if in any."""
        engaged = jnp.isfinite(jax.vmap(self._look_ahead)(observation).within_s)
        offset = jax.lax.cond(
            engaged.any(),
            lambda: jax.vmap(self._planned)(observation),
            lambda: jnp.zeros_like(engaged, jnp.float32),
        )
        return engaged, offset

    def _planned(self, observation: Observation) -> Float[Array, ""]:
        return plan_course(observation, self.ship, self.settings.planner).offset_rad
