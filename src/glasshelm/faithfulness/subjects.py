"""What is examined of a pilot: the one quantity that ships move, and how it is explained."""

from functools import cached_property
from typing import Any, TypeAlias

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from glasshelm.core.geometry import wrap_angle
from glasshelm.env.observe import Observation, empty_observation
from glasshelm.explanation.actor_explanation import explain_rudder
from glasshelm.explanation.manoeuvre_explanation import SAME_COURSE_RAD
from glasshelm.explanation.step_explanation import Explanation, ManoeuvreExplanation
from glasshelm.faithfulness.sanity_checks import count_layers, randomise_weights
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.protocols import Pilot
from glasshelm.planning.situation import situation_of
from glasshelm.ship.nomoto import ShipParams

#: A rudder is an explanation's subject if some ship moves it by so much [rad].
MIN_RUDDER_RAD = float(np.radians(0.25))


class ActorSubject(eqx.Module):
    """A learned pilot: ships move its rudder, a fraction of the limit."""

    actor: Actor
    critic: SubTaskCritic | None
    ship: ShipParams = eqx.field(static=True)

    @property
    def quantity(self) -> str:
        """What ships move, in a word."""
        return "rudder"

    @property
    def scenes_at_once(self) -> int | None:
        """So many are computed side by side."""
        return 64

    @property
    def least(self) -> float:
        """What a ship must move for a scene to count."""
        return MIN_RUDDER_RAD / float(self.ship.rudder_limit_rad)

    @property
    def layers(self) -> int:
        """How many layers can be randomised, one after the other."""
        return max(count_layers(self.actor), count_layers(self.critic))

    def rudder(self, observation: Observation) -> Float[Array, ""]:
        return self.actor(observation)

    def decided(self, observation: Observation, members: Bool[Array, " n"]) -> Float[Array, ""]:
        """What it decides if only the ships of ``members`` are there."""
        return self.actor(_only(observation, members))

    def explain(self, observation: Observation) -> Explanation:
        return explain_rudder(self.actor, self.critic, observation, self.actor(observation))

    def randomised(self, seed: int, layers: int | None) -> "ActorSubject":
        """The same networks with the weights of the top layers shuffled."""
        actor = randomise_weights(self.actor, seed, layers)
        return ActorSubject(actor, randomise_weights(self.critic, seed, layers), self.ship)


class ManoeuvreSubject(eqx.Module):
    """A pilot that chooses manoeuvres: ships move the course that it steers [rad].

    It is asked again without the ships, as the sea would be then: its own table is not read.
    """

    pilot: Pilot
    ship: ShipParams = eqx.field(static=True)

    @property
    def quantity(self) -> str:
        """What ships move, in a word."""
        return "course"

    @property
    def scenes_at_once(self) -> int | None:
        """None: one after the other. All manoeuvres of one are enough for the processor's cache."""
        return None

    @property
    def least(self) -> float:
        """What a ship must move for a scene to count."""
        return SAME_COURSE_RAD

    @property
    def layers(self) -> int:
        """Nothing is randomised: what is simulated has no weights."""
        return 0

    def rudder(self, observation: Observation) -> Float[Array, ""]:
        return self.pilot.decide(observation, self.pilot.start())[0].rudder

    def decided(self, observation: Observation, members: Bool[Array, " n"]) -> Float[Array, ""]:
        """The course, off the waypoint's bearing, if only the ships of ``members`` are there."""
        why = self.explain(_only(observation, members))
        return wrap_angle(manoeuvre_of(why).course_rad - self.bearing_rad(observation))

    def bearing_rad(self, observation: Observation) -> Float[Array, ""]:
        """Of the waypoint, off own ship's heading."""
        return situation_of(observation, self.ship).bearing_rad

    def explain(self, observation: Observation) -> Explanation:
        why = self.pilot.decide(observation, self.pilot.start())[0].explanation
        assert why is not None
        return why


Subject: TypeAlias = ActorSubject | ManoeuvreSubject


def subject_of(pilot: Any) -> Subject | None:
    """What is examined of a pilot; None of one that gives no explanation of its own decision."""
    if isinstance(pilot, LearnedPilot):
        return ActorSubject(pilot.actor, pilot.critic, pilot.trained.ship)
    ship = getattr(pilot, "ship", None)
    if not isinstance(pilot, Pilot) or not isinstance(ship, ShipParams):
        return None
    if jax.tree.leaves(pilot.start()):
        return None  # with a memory, the same scene without a ship has another past
    decision = eqx.filter_eval_shape(lambda: pilot.decide(empty_observation(2), pilot.start())[0])
    why = decision.explanation
    if why is None or why.manoeuvre is None or decision.overruled is not None:
        return None
    return ManoeuvreSubject(pilot, ship)


def manoeuvre_of(why: Explanation) -> ManoeuvreExplanation:
    assert why.manoeuvre is not None
    return why.manoeuvre


class Question:
    """A subject asked about one observation; what several explanations share is computed once."""

    def __init__(self, subject: Subject, observation: Observation, key: PRNGKeyArray):
        self.subject, self.observation, self.key = subject, observation, key

    @cached_property
    def why(self) -> Explanation:
        """The explanation that every decision carries."""
        return self.subject.explain(self.observation)


def _only(observation: Observation, members: Bool[Array, " n"]) -> Observation:
    return eqx.tree_at(lambda o: o.present, observation, observation.present & members)
