"""The exam of explanations: every one, in every scene, by every score."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key, PRNGKeyArray

from glasshelm.encounters.types import Encounter
from glasshelm.errors import InputError
from glasshelm.explain.coalitions import coalitions
from glasshelm.explain.shapley import worth_of
from glasshelm.faithfulness.chunks import in_chunks
from glasshelm.faithfulness.explainers import Explainer, explainers_for
from glasshelm.faithfulness.rollouts import turned_without
from glasshelm.faithfulness.scenes import COUNTS, scenes_of
from glasshelm.faithfulness.scores import scores
from glasshelm.faithfulness.stability import forgotten, sensitivity, spearman
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.world.observe import Observation
from glasshelm.world.step import WorldState

#: The scores by name, in the order of the table.
MEASURES = (
    "kendall", "top", "sign", "deletion", "insertion", "infidelity",
    "simulated", "sensitivity", "forgotten",
)  # fmt: skip


Networks = tuple[Actor, SubTaskCritic | None]


@dataclasses.dataclass(frozen=True)
class Examined:
    """One pilot's explanations: ``told[explainer][measure]`` is one number a scene.

    ``voyage`` says which encounter each scene is of, ``ships`` how many there
    were; ``own_sensitivity`` is the rudder's.
    """

    pilot: LearnedPilot
    explainers: tuple[Explainer, ...]
    told: Mapping[str, Mapping[str, Float[np.ndarray, " s"]]]
    voyage: np.ndarray
    ships: np.ndarray
    own_sensitivity: Float[np.ndarray, " s"]


def examine(
    pilot: LearnedPilot,
    encounters: int = 1000,
    most: int = 400,
    counts: Sequence[int] = COUNTS,
    say: Callable[[str, int, int], None] = lambda what, done, of: None,
) -> Examined:
    """Examine every explanation of a pilot in scenes of her own voyages.

    ``encounters`` voyages, at most ``most`` scenes of each number of ships;
    ``say`` is told what is being done. InputError if no scene was found in
    which a ship matters.
    """
    groups = scenes_of(pilot, encounters, most, counts)
    if not groups:
        raise InputError(
            f"pilot {pilot.name!r}: in {encounters} encounters no ship moves her rudder by 0.25°; "
            "more encounters are needed, or she does not see ships"
        )
    explainers = explainers_for(pilot.actor, pilot.critic)
    blank = (forgotten(pilot.actor, 0), forgotten(pilot.critic, 1))
    told: dict[str, dict[str, list[np.ndarray]]] = {e.name: {} for e in explainers}
    own: list[np.ndarray] = []
    for number, group in enumerate(groups):
        say(f"scenes with {group.ships} ships", number, len(groups))
        keys = jax.random.split(jax.random.key(0), group.size)
        work = partial(_scored, pilot, blank, explainers)
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


@eqx.filter_jit
def _scored(
    pilot: LearnedPilot,
    blank: Networks,
    explainers: tuple[Explainer, ...],
    scenes: tuple[Encounter, WorldState, Key[Array, " s"]],
) -> tuple[dict[str, dict[str, Array]], Array]:
    """Every measure of every explanation [scenes], and the rudder's own sensitivity.

    ``blank`` are the pilot's networks after they forgot everything.
    """
    ship, networks = pilot.trained.ship, (pilot.actor, pilot.critic)
    inside = jnp.asarray(coalitions(scenes[0].present.shape[-1]))

    signed = jnp.array([explainer.signed for explainer in explainers])
    names = [explainer.name for explainer in explainers]

    def one(scene: tuple[Encounter, WorldState, PRNGKeyArray]):
        encounter, state, key = scene
        seen = state.observation

        def tell(seen: Observation, networks: Networks = networks) -> Float[Array, "e n"]:
            actor, critic = networks
            return jnp.stack([explainer.of(actor, critic, seen, key) for explainer in explainers])

        def rudder(seen: Observation) -> Float[Array, "1 1"]:
            return pilot.actor(seen)[None, None]

        worth = worth_of("rudder", pilot.actor, None, seen, ship.rudder_limit_rad)
        rudders = jax.vmap(worth)(inside)
        turned = jnp.abs(turned_without(pilot.actor, encounter, state, ship))
        told = tell(seen)
        found = jax.vmap(lambda e, s: scores(e, rudders, s))(told, signed)
        by_measure = {field: getattr(found, field) for field in MEASURES[:6]} | {
            "simulated": jax.vmap(lambda e: spearman(jnp.abs(e), turned))(told),
            "sensitivity": sensitivity(tell, seen, key),
            "forgotten": jnp.abs(jax.vmap(spearman)(jnp.abs(told), jnp.abs(tell(seen, blank)))),
        }
        measures = {
            name: {measure: values[i] for measure, values in by_measure.items()}
            for i, name in enumerate(names)
        }
        return measures, sensitivity(rudder, seen, key)[0]

    return jax.vmap(one)(scenes)


def mean_with_interval(
    seeds: Sequence[np.ndarray], voyages: Sequence[np.ndarray], resamples: int = 1000
) -> tuple[float, float, float]:
    """A mean over scenes and its 95 % interval: seeds and voyages are drawn as wholes.

    Scenes of one voyage resemble each other, and all scenes of one training
    do; nan scenes (a score that is not defined there) are left out.
    """
    rng = np.random.default_rng(0)
    sums = []
    for values, whose in zip(seeds, voyages, strict=True):
        fine = np.isfinite(values)
        _, place = np.unique(whose, return_inverse=True)
        total = np.bincount(place[fine], values[fine], minlength=place.max() + 1)
        count = np.bincount(place[fine], minlength=place.max() + 1)
        sums.append((total, count))
    if not any(count.sum() for _, count in sums):
        return float("nan"), float("nan"), float("nan")

    def mean(parts) -> float:
        means = [t.sum() / c.sum() for t, c in parts if c.sum()]
        return float(np.mean(means)) if means else float("nan")

    drawn = []
    for _ in range(resamples):
        rows = rng.integers(len(sums), size=len(sums)) if len(sums) > 1 else [0]
        parts = []
        for row in rows:
            total, count = sums[row]
            voyage = rng.integers(len(total), size=len(total))
            parts.append((total[voyage], count[voyage]))
        drawn.append(mean(parts))
    low, high = np.nanquantile(drawn, [0.025, 0.975])
    return mean(sums), float(low), float(high)
