"""Every explanation as one number a ship, beside null explanations that ignore the pilot."""

import dataclasses
from collections.abc import Callable
from typing import Literal, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.env.observe import DISTANCE_M, TARGET_FEATURES, TIME_S, Observation
from glasshelm.explanation.actor_explanation import explain_rudder
from glasshelm.explanation.shapley import exact_shapley, value_function
from glasshelm.explanation.step_explanation import Explanation
from glasshelm.networks.actors import Actor, AttentionActor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

Kind = Literal["paper", "ours", "null"]
Part = TypeVar("Part")
#: (actor, critic, what is seen, key) -> one number a ship.
AttributionFn = Callable[
    [Actor, SubTaskCritic | None, Observation, PRNGKeyArray],
    Float[Array, " n"],
]


@dataclasses.dataclass(frozen=True)
class Explainer:
    """One explanation. ``signed``: it is a rudder, as a fraction of the limit, + = to starboard."""

    name: str
    title: str
    kind: Kind
    of: AttributionFn
    signed: bool = False
    needs_attention: bool = False
    needs_critic: bool = False

    def fits(self, actor: Actor, critic: SubTaskCritic | None) -> bool:
        """Whether this pilot has what the explanation is made of."""
        if self.needs_attention and not isinstance(actor, AttentionActor):
            return False
        return critic is not None or not self.needs_critic


def _of(part: Callable[[Explanation], Float[Array, " n"]]) -> AttributionFn:
    """A part of the explanation that every decision carries."""

    def of(actor, critic, observation, key):
        return part(explain_rudder(actor, critic, observation, actor(observation)))

    return of


def _there(part: Part | None) -> Part:
    """A part that the pilot has (``Explainer.fits``)."""
    assert part is not None
    return part


def _attention(e: Explanation) -> Float[Array, " n"]:
    return _there(e.attention)


def _danger(e: Explanation) -> Float[Array, " n"]:
    return _there(e.value).by_ship - _there(e.far)


def _priority(e: Explanation) -> Float[Array, " n"]:
    return _there(e.priority).by_ship


def _intention(e: Explanation) -> Float[Array, " n"]:
    return _there(e.intention).increment


def _intention_level(e: Explanation) -> Float[Array, " n"]:
    return _there(e.intention).level


def _shapley(game):
    def of(actor, critic, observation, key):
        return exact_shapley(
            value_function(game, actor, critic, observation, 1.0), observation.present.shape[-1]
        ).by_ship

    return of


def _leave_one_out(actor, critic, observation, key):
    worth = value_function("rudder", actor, None, observation, 1.0)
    others = ~jnp.eye(observation.present.shape[-1], dtype=bool)
    return worth(observation.present) - jax.vmap(worth)(others)


def _gradient(actor, critic, observation, key):
    def rudder(targets):
        return actor(Observation(observation.waypoint, targets, observation.present))

    return (jax.grad(rudder)(observation.targets) * observation.targets).sum((-1, -2))


def _column(observation: Observation, name: str) -> Float[Array, " n"]:
    return observation.targets[:, 0, TARGET_FEATURES.index(name)]


def _nearness(actor, critic, observation, key):
    return 1.0 / (_column(observation, "distance") + 1e-6)


def _cpa(actor, critic, observation, key):
    """1/(1 + DCPA/1 NM + TCPA/10 min) of a ship that closes, 0 of one that opens."""
    miles = _column(observation, "dcpa") * DISTANCE_M / NAUTICAL_MILE_M
    ahead_s = _column(observation, "tcpa") * TIME_S
    return jnp.where(ahead_s > 0, 1.0 / (1.0 + miles + ahead_s / 600.0), 0.0)


def _uniform(actor, critic, observation, key):
    return jnp.ones(observation.present.shape[-1])


def _random(actor, critic, observation, key):
    return jax.random.uniform(key, observation.present.shape)


#: In the order of the table.
EXPLAINERS = (
    Explainer("attention", "Attention α (Eq. 23)", "paper", _of(_attention), needs_attention=True),
    Explainer("danger", "Danger Q_ca, 0 for a far ship", "paper", _of(_danger), needs_critic=True),
    Explainer("priority", "Priority ΔQ_ca (Eq. 22)", "paper", _of(_priority), needs_critic=True),
    Explainer(
        "intention", "Intention ΔQ_ca·α (Eq. 24, journal)", "paper", _of(_intention),
        needs_attention=True, needs_critic=True,
    ),
    Explainer(
        "intention_level", "Intention Q_ca·α (Eq. 24, preprint)", "paper", _of(_intention_level),
        needs_attention=True, needs_critic=True,
    ),
    Explainer("shapley", "Shapley value of the rudder", "ours", _shapley("rudder"), signed=True),
    Explainer(
        "shapley_decision", "Shapley value of the decision's worth", "ours", _shapley("decision"),
        needs_critic=True,
    ),
    Explainer("leave_one_out", "Leave one out", "ours", _leave_one_out, signed=True),
    Explainer("gradient", "Gradient × input", "ours", _gradient, signed=True),
    Explainer("nearness", "1 / distance", "null", _nearness),
    Explainer("cpa", "DCPA and TCPA", "null", _cpa),
    Explainer("uniform", "Uniform", "null", _uniform),
    Explainer("random", "Random", "null", _random),
)  # fmt: skip


def explainers_for(actor: Actor, critic: SubTaskCritic | None) -> tuple[Explainer, ...]:
    """Those that this pilot can give."""
    return tuple(e for e in EXPLAINERS if e.fits(actor, critic))
