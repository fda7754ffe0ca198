"""The exam of explanations: every one, in every scene, by every score."""

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
from glasshelm.faithfulness.chunking import CHUNK, in_chunks
from glasshelm.faithfulness.counterfactual import turned_without
from glasshelm.faithfulness.explainers import Explainer, explainers_for
from glasshelm.faithfulness.metrics import scores
from glasshelm.faithfulness.sanity_checks import depth, forgotten, sensitivity, spearman
from glasshelm.faithfulness.scenes import COUNTS, scenes_of
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.pilots.learned import LearnedPilot

#: The scores by name, in the order of the table.
MEASURES = (
    "kendall", "top", "sign", "deletion", "insertion", "infidelity", "as_told",
    "simulated", "sensitivity", "forgotten",
)  # fmt: skip

Networks = tuple[Actor, SubTaskCritic | None]
#: Encounters, states of their worlds and keys [scene, ...].
Chunk = tuple[Encounter, EnvState, Key[Array, " s"]]
#: So many scenes of a chunk share one draw of networks that forgot. Of the draws, those
#: that are also taken layer by layer: one scene in four.
DRAW = 8
STAGED = (0, 4)


def after_layers(layers: int) -> str:
    """The measure ``forgotten`` when only the top ``layers`` layers were."""
    return f"forgotten_{layers}"


@dataclasses.dataclass(frozen=True)
class Examined:
    """One pilot's explanations: ``told[explainer][measure]`` is one number a scene.

    Measures are :data:`MEASURES` and, of some scenes (nan elsewhere), :func:`after_layers`
    of every number of layers below ``layers``. ``voyage`` says which encounter each
    scene is of, ``ships`` how many there were; ``own_sensitivity`` is the rudder's.
    """

    pilot: LearnedPilot
    explainers: tuple[Explainer, ...]
    told: Mapping[str, Mapping[str, Float[np.ndarray, " s"]]]
    voyage: np.ndarray
    ships: np.ndarray
    own_sensitivity: Float[np.ndarray, " s"]

    @property
    def layers(self) -> int:
        """How many layers there are to forget."""
        return _layers((self.pilot.actor, self.pilot.critic))


def examine(
    pilot: LearnedPilot,
    encounters: int = 1000,
    most: int = 400,
    counts: Sequence[int] = COUNTS,
    say: Callable[[str, int, int], None] = lambda what, done, of: None,
) -> Examined:
    """Examine every explanation of a pilot in scenes of its own voyages.

    ``encounters`` voyages, at most ``most`` scenes of each number of ships;
    ``say`` receives the progress. InputError if no scene was found in
    which a ship matters.
    """
    groups = scenes_of(pilot, encounters, most, counts)
    if not groups:
        raise InputError(
            f"pilot {pilot.name!r}: in {encounters} encounters no ship moves her rudder by 0.25°; "
            "more encounters are needed, or she does not see ships"
        )
    explainers = explainers_for(pilot.actor, pilot.critic)
    draws = itertools.count()
    told: dict[str, dict[str, list[np.ndarray]]] = {e.name: {} for e in explainers}
    own: list[np.ndarray] = []
    for number, group in enumerate(groups):
        say(f"scenes with {group.ships} ships", number, len(groups))
        keys = jax.random.split(jax.random.key(0), group.size)

        def work(scenes: Chunk, draws: Iterator[int] = draws):
            return _scored(pilot, _forgetful(pilot, next(draws)), explainers, scenes)

        found, jumpy = in_chunks(work, (group.encounter, group.state, keys))
        own.append(np.asarray(jumpy))
        for name, measures in found.items():
            for measure, values in measures.items():
                told[name].setdefault(measure, []).append(np.asarray(values))
    return Examined(
        pilot,
        explainers,
        {e: {m: np.concatenate(v) for m, v in by.items()} for e, by in told.items()},
        np.concatenate([g.voyage for g in groups]),
        np.concatenate([np.full(g.size, g.ships) for g in groups]),
        np.concatenate(own),
    )


def _layers(networks: Networks) -> int:
    return max(map(depth, networks))


def _sittings(layers: int) -> list[tuple[int, int]]:
    """(draw, layers forgotten) of each time that some scenes of a chunk are asked again."""
    all_of_them = [(draw, layers) for draw in range(CHUNK // DRAW)]
    return all_of_them + [(draw, top) for top in range(1, layers) for draw in STAGED]


def _forgetful(pilot: LearnedPilot, chunk: int) -> Networks:
    """The pilot's networks after they forgot, stacked [sitting, ...]; others for every chunk."""
    networks = (pilot.actor, pilot.critic)
    draws = CHUNK // DRAW
    found = [
        (forgotten(pilot.actor, seed, top), forgotten(pilot.critic, seed, top))
        for draw, top in _sittings(_layers(networks))
        for seed in [chunk * draws + draw]
    ]
    return jax.tree.map(lambda *x: jnp.asarray(np.stack(x)), *found)


@eqx.filter_jit
def _scored(
    pilot: LearnedPilot,
    forgetful: Networks,
    explainers: tuple[Explainer, ...],
    scenes: Chunk,
) -> tuple[dict[str, dict[str, Array]], Array]:
    """Every measure of every explanation [scenes], and the rudder's own sensitivity.

    ``scenes`` are :data:`CHUNK`; ``forgetful`` as :func:`_forgetful` makes them.
    """
    ship, networks = pilot.trained.ship, (pilot.actor, pilot.critic)
    inside = jnp.asarray(coalitions(scenes[0].present.shape[-1]))
    signed = jnp.array([explainer.signed for explainer in explainers])
    names = [explainer.name for explainer in explainers]

    def tell(
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
        turned = jnp.abs(turned_without(pilot.actor, encounter, state, ship))
        told = tell(observation, key, networks)
        found = jax.vmap(lambda e, s: scores(e, rudders, s))(told, signed)
        by_measure = {field: getattr(found, field) for field in MEASURES[:7]} | {
            "simulated": jax.vmap(lambda e: spearman(jnp.abs(e), turned))(told),
            "sensitivity": sensitivity(lambda s: tell(s, key, networks), observation, key),
        }
        return told, by_measure, sensitivity(rudder, observation, key)[0]

    told, by_measure, jumpy = jax.vmap(one)(scenes)
    by_measure |= _forgetting(tell, told, forgetful, _layers(networks), scenes)
    measures = {
        name: {measure: values[:, i] for measure, values in by_measure.items()}
        for i, name in enumerate(names)
    }
    return measures, jumpy


def _forgetting(
    tell: Callable[[Observation, PRNGKeyArray, Networks], Float[Array, "e n"]],
    told: Float[Array, "s e n"],
    forgetful: Networks,
    layers: int,
    scenes: Chunk,
) -> dict[str, Float[Array, "s e"]]:
    """ρ of the sizes of each explanation before (``told``) and after the networks forgot.

    nan where it made no difference between the ships before, and where nobody asked.
    """
    sittings = _sittings(layers)
    draws = CHUNK // DRAW
    which = jnp.array([np.arange(DRAW) * draws + draw for draw, _ in sittings])

    def after(sitting: tuple[Networks, Int[Array, " d"]]) -> Float[Array, "d e"]:
        networks, place = sitting
        observation, keys = jax.tree.map(lambda x: x[place], (scenes[1].observation, scenes[2]))
        new = jax.vmap(lambda s, k: tell(s, k, networks))(observation, keys)
        return jax.vmap(jax.vmap(spearman))(jnp.abs(told[place]), jnp.abs(new))

    rho = jax.lax.map(after, (forgetful, which))
    tied = jnp.ptp(jnp.abs(told), axis=-1) == 0
    found = {}
    for top in range(1, layers + 1):
        rows = np.array([i for i, (_, stage) in enumerate(sittings) if stage == top])
        values = jnp.full(told.shape[:2], jnp.nan).at[which[rows]].set(rho[rows])
        name = "forgotten" if top == layers else after_layers(top)
        found[name] = jnp.where(tied, jnp.nan, values)
    return found
