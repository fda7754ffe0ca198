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
from glasshelm.explanation.shapley import value_function
from glasshelm.faithfulness.counterfactual import heading_effects
from glasshelm.faithfulness.explainers import Explainer, explainers_for
from glasshelm.faithfulness.metrics import score_attribution
from glasshelm.faithfulness.sanity_checks import (
    count_layers,
    randomise_weights,
    sensitivity,
    spearman,
)
from glasshelm.faithfulness.scenes import CHUNK, SHIP_COUNTS, collect_scenes, map_in_chunks
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.pilots.learned import LearnedPilot

#: The scores by name, in the order of the table.
MEASURES = (
    "kendall", "top", "sign", "deletion", "insertion", "infidelity", "unscaled_infidelity",
    "simulated", "sensitivity", "randomised",
)  # fmt: skip

Networks = tuple[Actor, SubTaskCritic | None]
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
    of every number of layers below ``layers``. ``voyage`` is the encounter that each scene is
    of, ``ships`` its number of ships; ``rudder_sensitivity`` is that of the rudder itself.
    """

    pilot: LearnedPilot
    explainers: tuple[Explainer, ...]
    scores: Mapping[str, Mapping[str, Float[np.ndarray, " s"]]]
    voyage: np.ndarray
    ships: np.ndarray
    rudder_sensitivity: Float[np.ndarray, " s"]

    @property
    def layers(self) -> int:
        """How many layers can be randomised."""
        return _layers((self.pilot.actor, self.pilot.critic))


def score_explanations(
    pilot: LearnedPilot,
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
        InputError: There is no scene in which a ship matters.
    """
    groups = collect_scenes(pilot, encounters, max_scenes, counts)
    if not groups:
        raise InputError(
            f"pilot {pilot.name!r}: in {encounters} encounters no ship moves its rudder by 0.25°; "
            "more encounters are needed, or it does not see ships"
        )
    explainers = explainers_for(pilot.actor, pilot.critic)
    draws = itertools.count()
    scores: dict[str, dict[str, list[np.ndarray]]] = {e.name: {} for e in explainers}
    sensitivities: list[np.ndarray] = []
    for number, group in enumerate(groups):
        progress(f"scenes with {group.ships} ships", number, len(groups))
        keys = jax.random.split(jax.random.key(0), group.size)

        def work(scenes: Chunk, draws: Iterator[int] = draws):
            return _scored(pilot, _randomised_networks(pilot, next(draws)), explainers, scenes)

        found, own = map_in_chunks(work, (group.encounter, group.state, keys))
        sensitivities.append(np.asarray(own))
        for name, measures in found.items():
            for measure, values in measures.items():
                scores[name].setdefault(measure, []).append(np.asarray(values))
    return ExplanationScores(
        pilot,
        explainers,
        {e: {m: np.concatenate(v) for m, v in by.items()} for e, by in scores.items()},
        np.concatenate([g.voyage for g in groups]),
        np.concatenate([np.full(g.size, g.ships) for g in groups]),
        np.concatenate(sensitivities),
    )


def _layers(networks: Networks) -> int:
    return max(map(count_layers, networks))


def _repeats(layers: int) -> list[tuple[int, int]]:
    """(draw, layers randomised) of each repeated evaluation of some scenes of a chunk."""
    all_of_them = [(draw, layers) for draw in range(CHUNK // DRAW)]
    return all_of_them + [(draw, top) for top in range(1, layers) for draw in CASCADED]


def _randomised_networks(pilot: LearnedPilot, chunk: int) -> Networks:
    """Networks with random weights, stacked [repeat, ...]; other ones for every chunk."""
    networks = (pilot.actor, pilot.critic)
    draws = CHUNK // DRAW
    found = [
        (randomise_weights(pilot.actor, seed, top), randomise_weights(pilot.critic, seed, top))
        for draw, top in _repeats(_layers(networks))
        for seed in [chunk * draws + draw]
    ]
    return jax.tree.map(lambda *x: jnp.asarray(np.stack(x)), *found)


@eqx.filter_jit
def _scored(
    pilot: LearnedPilot,
    randomised: Networks,
    explainers: tuple[Explainer, ...],
    scenes: Chunk,
) -> tuple[dict[str, dict[str, Array]], Array]:
    """Every measure of every explanation [scenes], and the rudder's own sensitivity.

    ``scenes`` are :data:`CHUNK`; ``randomised`` as :func:`_randomised_networks` makes them.
    """
    ship, networks = pilot.trained.ship, (pilot.actor, pilot.critic)
    inside = jnp.asarray(coalitions(scenes[0].present.shape[-1]))
    signed = jnp.array([explainer.signed for explainer in explainers])
    names = [explainer.name for explainer in explainers]

    def attribute(
        observation: Observation, key: PRNGKeyArray, networks: Networks
    ) -> Float[Array, "e n"]:
        actor, critic = networks
        return jnp.stack(
            [explainer.of(actor, critic, observation, key) for explainer in explainers]
        )

    def one(scene: tuple[Encounter, EnvState, PRNGKeyArray]):
        encounter, state, key = scene
        observation = state.observation

        def rudder(observation: Observation) -> Float[Array, "1 1"]:
            return pilot.actor(observation)[None, None]

        rudders = jax.vmap(value_function("rudder", pilot.actor, None, observation, 1.0))(inside)
        turned = jnp.abs(heading_effects(pilot.actor, encounter, state, ship))
        attributions = attribute(observation, key, networks)
        found = jax.vmap(lambda e, s: score_attribution(e, rudders, s))(attributions, signed)
        by_measure = {field: getattr(found, field) for field in MEASURES[:7]} | {
            "simulated": jax.vmap(lambda e: spearman(jnp.abs(e), turned))(attributions),
            "sensitivity": sensitivity(lambda s: attribute(s, key, networks), observation, key),
        }
        return attributions, by_measure, sensitivity(rudder, observation, key)[0]

    attributions, by_measure, own = jax.vmap(one)(scenes)
    by_measure |= _randomisation_scores(
        attribute, attributions, randomised, _layers(networks), scenes
    )
    measures = {
        name: {measure: values[:, i] for measure, values in by_measure.items()}
        for i, name in enumerate(names)
    }
    return measures, own


def _randomisation_scores(
    attribute: Callable[[Observation, PRNGKeyArray, Networks], Float[Array, "e n"]],
    attributions: Float[Array, "s e n"],
    randomised: Networks,
    layers: int,
    scenes: Chunk,
) -> dict[str, Float[Array, "s e"]]:
    """ρ of the sizes of each explanation before (``attributions``) and after randomisation.

    nan where it did not tell the ships apart before, and where it was not computed again.
    """
    repeats = _repeats(layers)
    draws = CHUNK // DRAW
    which = jnp.array([np.arange(DRAW) * draws + draw for draw, _ in repeats])

    def after(repeat: tuple[Networks, Int[Array, " d"]]) -> Float[Array, "d e"]:
        networks, place = repeat
        observation, keys = jax.tree.map(lambda x: x[place], (scenes[1].observation, scenes[2]))
        new = jax.vmap(lambda s, k: attribute(s, k, networks))(observation, keys)
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
