"""The scores of every explanation in every scene."""

import dataclasses
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Key, PRNGKeyArray

from glasshelm.core.errors import InputError
from glasshelm.encounters.types import Encounter
from glasshelm.env.observe import Observation
from glasshelm.env.step import EnvState
from glasshelm.explanation.coalitions import coalitions
from glasshelm.faithfulness.counterfactual import heading_effects
from glasshelm.faithfulness.explainers import Explainer, explainers_for
from glasshelm.faithfulness.manoeuvre_checks import manoeuvre_checks
from glasshelm.faithfulness.metrics import score_attribution
from glasshelm.faithfulness.sanity_checks import sensitivity, spearman
from glasshelm.faithfulness.scenes import CHUNK, SHIP_COUNTS, collect_scenes, map_in_chunks
from glasshelm.faithfulness.subjects import ManoeuvreSubject, Question, Subject, subject_of
from glasshelm.pilots.protocols import Pilot

#: The scores by name, in the order of the table.
MEASURES = (
    "kendall", "top", "sign", "deletion", "insertion", "infidelity", "unscaled_infidelity",
    "simulated", "sensitivity", "randomised",
)  # fmt: skip

#: Encounters, states of their worlds and keys [scene, ...].
Chunk = tuple[Encounter, EnvState, Key[Array, " s"]]
#: So many scenes of a chunk share one draw of randomised networks. The draws of which the layers
#: are also randomised one by one (cascading randomisation): one scene in four.
DRAW = 8
CASCADED = (0, 4)


def randomised_top(layers: int) -> str:
    """The measure ``randomised`` when only the top ``layers`` layers are."""
    return f"randomised_{layers}"


@dataclasses.dataclass(frozen=True)
class ExplanationScores:
    """The scores of one pilot's explanations: ``scores[explainer][measure]``, one a scene.

    Measures are :data:`MEASURES` and, of some scenes (nan elsewhere), :func:`randomised_top`
    of every number of layers below ``subject.layers``.

    Attributes:
        pilot: The pilot.
        subject: What is examined of it.
        explainers: Its explanations.
        scores: As above.
        checks: What must hold or may surprise in a scene (1 or 0; nan: not defined there), by
            name; only of pilots that choose manoeuvres.
        voyage: The encounter that each scene is of.
        ships: Its number of ships.
        own_sensitivity: Of what is decided itself.
    """

    pilot: Pilot
    subject: Subject
    explainers: tuple[Explainer, ...]
    scores: Mapping[str, Mapping[str, Float[np.ndarray, " s"]]]
    checks: Mapping[str, Float[np.ndarray, " s"]]
    voyage: np.ndarray
    ships: np.ndarray
    own_sensitivity: Float[np.ndarray, " s"]


def score_explanations(
    pilot: Pilot,
    encounters: int = 1000,
    max_scenes: int = 400,
    counts: Sequence[int] = SHIP_COUNTS,
    progress: Callable[[str, int, int], None] = lambda what, done, of: None,
) -> ExplanationScores:
    """Score every explanation of a pilot in scenes of its own voyages.

    Args:
        pilot: The pilot.
        encounters: How many voyages are simulated.
        max_scenes: Scenes at most of each number of ships.
        counts: Numbers of ships.
        progress: Called with what is being done, parts done and all parts.

    Raises:
        InputError: It explains nothing, or there is no scene in which a ship matters.
    """
    subject = subject_of(pilot)
    if subject is None:
        raise InputError(f"pilot {pilot.name!r} does not explain its own decisions")
    progress("voyages", 0, len(counts))
    groups = collect_scenes(subject, encounters, max_scenes, counts)
    if not groups:
        raise InputError(
            f"pilot {pilot.name!r}: in {encounters} encounters no ship moves its "
            f"{subject.quantity}; more encounters are needed, or it does not see ships"
        )
    explainers = explainers_for(subject)
    draws = itertools.count()
    parts: list[tuple[dict[str, dict[str, Array]], dict[str, Array], Array]] = []
    for number, group in enumerate(groups):
        progress(f"scenes with {group.ships} ships", number, len(groups))
        keys = jax.random.split(jax.random.key(0), group.size)

        def work(scenes: Chunk, draws: Iterator[int] = draws):
            return _scored(subject, _randomised(subject, next(draws)), explainers, scenes)

        parts.append(map_in_chunks(work, (group.encounter, group.state, keys)))
    scores, checks, own = jax.tree.map(lambda *x: np.concatenate(x), *parts)
    return ExplanationScores(
        pilot,
        subject,
        explainers,
        scores,
        checks,
        np.concatenate([g.voyage for g in groups]),
        np.concatenate([np.full(g.size, g.ships) for g in groups]),
        own,
    )


def _repeats(layers: int) -> list[tuple[int, int]]:
    """(draw, layers randomised) of each repeated evaluation of some scenes of a chunk."""
    all_of_them = [(draw, layers) for draw in range(CHUNK // DRAW)]
    return all_of_them + [(draw, top) for top in range(1, layers) for draw in CASCADED]


def _randomised(subject: Subject, chunk: int) -> Subject | None:
    """It with random weights, stacked [repeat, ...], other ones for every chunk; None without."""
    if isinstance(subject, ManoeuvreSubject):
        return None
    draws = CHUNK // DRAW
    found = [
        subject.randomised(chunk * draws + draw, top) for draw, top in _repeats(subject.layers)
    ]
    return jax.tree.map(lambda *x: jnp.asarray(np.stack(x)), *found)


@eqx.filter_jit
def _scored(
    subject: Subject,
    randomised: Subject | None,
    explainers: tuple[Explainer, ...],
    scenes: Chunk,
) -> tuple[dict[str, dict[str, Array]], dict[str, Array], Array]:
    """Every measure of every explanation [scenes], the checks, and the decision's sensitivity.

    ``scenes`` are :data:`CHUNK`; ``randomised`` as :func:`_randomised` makes it.
    """
    inside = jnp.asarray(coalitions(scenes[0].present.shape[-1]))
    side = jnp.array([explainer.claims != "none" for explainer in explainers])
    size = jnp.array([explainer.claims == "size" for explainer in explainers])
    names = [explainer.name for explainer in explainers]

    def attributions_of(question: Question) -> Float[Array, "e n"]:
        return jnp.stack([explainer.of(question) for explainer in explainers])

    def attribute(
        observation: Observation, key: PRNGKeyArray, subject: Subject
    ) -> Float[Array, "e n"]:
        return attributions_of(Question(subject, observation, key))

    def one(scene: tuple[Encounter, EnvState, PRNGKeyArray]):
        encounter, state, key = scene
        observation = state.observation

        def decided(observation: Observation) -> Float[Array, "1 1"]:
            return subject.decided(observation, observation.present)[None, None]

        worths = jax.vmap(lambda members: subject.decided(observation, members))(inside)
        effects = heading_effects(subject.rudder, encounter, state, subject.ship)
        turned = jnp.abs(effects)
        question = Question(subject, observation, key)
        attributions = attributions_of(question)
        found = jax.vmap(lambda e, s, c: score_attribution(e, worths, s, c))(
            attributions, side, size
        )
        by_measure = {field: getattr(found, field) for field in MEASURES[:7]} | {
            "simulated": jax.vmap(lambda e: spearman(jnp.abs(e), turned))(attributions),
            "sensitivity": sensitivity(lambda s: attribute(s, key, subject), observation, key),
        }
        checks = {}
        if isinstance(subject, ManoeuvreSubject):
            checks = manoeuvre_checks(question.why, worths, subject.bearing_rad(observation))
        return attributions, by_measure, checks, sensitivity(decided, observation, key)[0]

    attributions, by_measure, checks, own = jax.lax.map(
        one, scenes, batch_size=subject.scenes_at_once
    )
    if randomised is None:
        by_measure["randomised"] = jnp.full(attributions.shape[:2], jnp.nan)
    else:
        by_measure |= _randomisation_scores(
            attribute, attributions, randomised, subject.layers, scenes
        )
    measures = {
        name: {measure: values[:, i] for measure, values in by_measure.items()}
        for i, name in enumerate(names)
    }
    return measures, checks, own


def _randomisation_scores(
    attribute: Callable[[Observation, PRNGKeyArray, Subject], Float[Array, "e n"]],
    attributions: Float[Array, "s e n"],
    randomised: Subject,
    layers: int,
    scenes: Chunk,
) -> dict[str, Float[Array, "s e"]]:
    """ρ of the sizes of each explanation before (``attributions``) and after randomisation.

    nan where it did not tell the ships apart before, and where it was not computed again.
    """
    repeats = _repeats(layers)
    draws = CHUNK // DRAW
    which = jnp.array([np.arange(DRAW) * draws + draw for draw, _ in repeats])

    def after(repeat: tuple[Subject, Int[Array, " d"]]) -> Float[Array, "d e"]:
        other, place = repeat
        observation, keys = jax.tree.map(lambda x: x[place], (scenes[1].observation, scenes[2]))
        new = jax.vmap(lambda s, k: attribute(s, k, other))(observation, keys)
        return jax.vmap(jax.vmap(spearman))(jnp.abs(attributions[place]), jnp.abs(new))

    rho = jax.lax.map(after, (randomised, which))
    tied = jnp.ptp(jnp.abs(attributions), axis=-1) == 0
    found = {}
    for top in range(1, layers + 1):
        rows = np.array([i for i, (_, stage) in enumerate(repeats) if stage == top])
        values = jnp.full(attributions.shape[:2], jnp.nan).at[which[rows]].set(rho[rows])
        name = "randomised" if top == layers else randomised_top(top)
        found[name] = jnp.where(tied, jnp.nan, values)
    return found
