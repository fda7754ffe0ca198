"""Every explanation as one number a ship, beside null explanations that ignore the pilot."""

import dataclasses
from collections.abc import Callable
from typing import Literal, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from glasshelm.core.geometry import wrap_angle
from glasshelm.env.observe import DISTANCE_M, TARGET_FEATURES, TIME_S, Observation
from glasshelm.explanation.shapley import Game, exact_shapley, leave_one_out, value_function
from glasshelm.explanation.step_explanation import ALTERNATIVES, Explanation
from glasshelm.faithfulness.subjects import ActorSubject, Question, Subject, manoeuvre_of
from glasshelm.networks.actors import AttentionActor
from glasshelm.networks.critics import QValues
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

Kind = Literal["paper", "ours", "null"]
#: Of what is decided an explanation claims the size and the side, the side (+ = to starboard), or
#: neither.
Claim = Literal["size", "side", "none"]
Part = TypeVar("Part")
#: A question -> one number a ship.
AttributionFn = Callable[[Question], Float[Array, " n"]]


@dataclasses.dataclass(frozen=True)
class Explainer:
    """One explanation."""

    name: str
    title: str
    kind: Kind
    of: AttributionFn
    claims: Claim = "none"
    needs_attention: bool = False
    needs_critic: bool = False

    def fits(self, subject: Subject) -> bool:
        """Whether this pilot has what the explanation is made of."""
        if not isinstance(subject, ActorSubject):
            return True
        if self.needs_attention and not isinstance(subject.actor, AttentionActor):
            return False
        return subject.critic is not None or not self.needs_critic


def _of(part: Callable[[Explanation], Float[Array, " n"]]) -> AttributionFn:
    """A part of the explanation that every decision carries."""
    return lambda question: part(question.why)


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


def _shapley(game: Game) -> AttributionFn:
    def of(question: Question) -> Float[Array, " n"]:
        subject, observation = _actor(question), question.observation
        worth = value_function(game, subject.actor, subject.critic, observation, 1.0)
        return exact_shapley(worth, observation.present.shape[-1]).by_ship

    return of


def _leave_one_out(question: Question) -> Float[Array, " n"]:
    worth = value_function("rudder", _actor(question).actor, None, question.observation, 1.0)
    return leave_one_out(worth, question.observation.present.shape[-1])


def _gradient(question: Question) -> Float[Array, " n"]:
    observation, actor = question.observation, _actor(question).actor

    def rudder(targets: Float[Array, "n f d"]) -> Float[Array, ""]:
        return actor(Observation(observation.waypoint, targets, observation.present))

    return (jax.grad(rudder)(observation.targets) * observation.targets).sum((-1, -2))


def _actor(question: Question) -> ActorSubject:
    assert isinstance(question.subject, ActorSubject)
    return question.subject


def _alternative(e: Explanation, name: str) -> QValues:
    row = ALTERNATIVES.index(name)
    return jax.tree.map(lambda x: x[row], manoeuvre_of(e).alternatives)


def _danger_of_keeping(e: Explanation) -> Float[Array, " n"]:
    return _alternative(e, "keep").by_ship


def _danger_of_chosen(e: Explanation) -> Float[Array, " n"]:
    return _there(e.value).by_ship


def _against_empty_sea(e: Explanation) -> Float[Array, " n"]:
    return _there(e.value).by_ship - _alternative(e, "without ships").by_ship


def _against_other_side(e: Explanation) -> Float[Array, " n"]:
    """The chosen manoeuvre less the best to the side it does not take; 0 if there is none."""
    sides = [_alternative(e, f"best to {side}").by_ship for side in ("port", "starboard")]
    other = jnp.where(wrap_angle(manoeuvre_of(e).course_rad) > 0, *sides)
    return jnp.nan_to_num(_there(e.value).by_ship - other)


def _needed(e: Explanation) -> Float[Array, " n"]:
    return manoeuvre_of(e).needed.astype(jnp.float32)


def _column(observation: Observation, name: str) -> Float[Array, " n"]:
    return observation.targets[:, 0, TARGET_FEATURES.index(name)]


def _nearness(question: Question) -> Float[Array, " n"]:
    return 1.0 / (_column(question.observation, "distance") + 1e-6)


def _cpa(question: Question) -> Float[Array, " n"]:
    """1/(1 + DCPA/1 NM + TCPA/10 min) of a ship that closes, 0 of one that opens."""
    miles = _column(question.observation, "dcpa") * DISTANCE_M / NAUTICAL_MILE_M
    ahead_s = _column(question.observation, "tcpa") * TIME_S
    return jnp.where(ahead_s > 0, 1.0 / (1.0 + miles + ahead_s / 600.0), 0.0)


def _uniform(question: Question) -> Float[Array, " n"]:
    return jnp.ones(question.observation.present.shape[-1])


def _random(question: Question) -> Float[Array, " n"]:
    return jax.random.uniform(question.key, question.observation.present.shape)


_NULLS = (
    Explainer("nearness", "1 / distance", "null", _nearness),
    Explainer("cpa", "DCPA and TCPA", "null", _cpa),
    Explainer("uniform", "Uniform", "null", _uniform),
    Explainer("random", "Random", "null", _random),
)
#: Of learned pilots, in the order of the table.
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
    Explainer("shapley", "Shapley value of the rudder", "ours", _shapley("rudder"), claims="size"),
    Explainer(
        "shapley_decision", "Shapley value of the decision's worth", "ours", _shapley("decision"),
        needs_critic=True,
    ),
    Explainer("leave_one_out", "Leave one out", "ours", _leave_one_out, claims="size"),
    Explainer("gradient", "Gradient × input", "ours", _gradient, claims="size"),
    *_NULLS,
)  # fmt: skip
#: Of pilots that choose manoeuvres.
MANOEUVRE_EXPLAINERS = (
    Explainer("danger", "Danger Q_ca of keeping on", "paper", _of(_danger_of_keeping)),
    Explainer("danger_chosen", "Danger Q_ca of the chosen", "paper", _of(_danger_of_chosen)),
    Explainer("priority", "Priority ΔQ_ca (Eq. 22)", "paper", _of(_priority)),
    Explainer(
        "shapley", "Shapley value of the course", "ours",
        _of(lambda e: manoeuvre_of(e).course_shapley.by_ship), claims="size",
    ),
    Explainer(
        "leave_one_out", "Leave one out, course", "ours",
        _of(lambda e: manoeuvre_of(e).course_leave_one_out), claims="size",
    ),
    Explainer(
        "shapley_rudder", "Shapley value of the rudder", "ours",
        _of(lambda e: e.rudder_shapley.by_ship), claims="side",
    ),
    Explainer(
        "shapley_decision", "Shapley value of Q", "ours",
        _of(lambda e: _there(e.value_shapley).by_ship),
    ),
    Explainer("needed", "Needed", "ours", _of(_needed)),
    Explainer(
        "empty_sea", "ΔQ_ca against the way of an empty sea", "ours", _of(_against_empty_sea)
    ),
    Explainer(
        "other_side", "ΔQ_ca against the best to the other side", "ours", _of(_against_other_side)
    ),
    *_NULLS,
)  # fmt: skip


def explainers_for(subject: Subject) -> tuple[Explainer, ...]:
    """Those that this pilot can give."""
    every = EXPLAINERS if isinstance(subject, ActorSubject) else MANOEUVRE_EXPLAINERS
    return tuple(e for e in every if e.fits(subject))
