"""Batches of encounters in which every number of targets has its fixed share."""

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import PRNGKeyArray

from glasshelm.encounters.random_encounters import (
    CONVERGING,
    PAPER,
    WIDE,
    RandomEncounters,
    random_encounter,
)
from glasshelm.encounters.types import Encounter
from glasshelm.ship.nomoto import ShipParams


@dataclasses.dataclass(frozen=True)
class EncounterMix:
    """How many episodes a batch has for every number of targets, and where they come from."""

    #: Episodes with 0, 1, 2, ... targets.
    episodes: tuple[int, ...] = (4, 10, 16, 20, 24, 26, 28)
    #: Episodes are drawn from these in turn, whatever number of targets they name.
    distributions: tuple[RandomEncounters, ...] = (WIDE, PAPER, CONVERGING, PAPER)

    @property
    def size(self) -> int:
        """Episodes in a batch."""
        return sum(self.episodes)

    @property
    def max_targets(self) -> int:
        return len(self.episodes) - 1

    @property
    def total_targets(self) -> int:
        """Targets in a batch."""
        return sum(n * episodes for n, episodes in enumerate(self.episodes))

    @property
    def total_pairs(self) -> int:
        """Ordered pairs of targets of one episode in a batch, each with itself too."""
        return sum(n * n * episodes for n, episodes in enumerate(self.episodes))

    def with_targets(self, distribution: RandomEncounters) -> RandomEncounters:
        """The distribution with this mix's numbers of targets."""
        return dataclasses.replace(distribution, targets=(0, self.max_targets))

    def draw(self, key: PRNGKeyArray, ship: ShipParams) -> Encounter:
        """A batch of encounters for own ship ``ship`` [size]."""
        counts = jnp.repeat(
            jnp.arange(len(self.episodes)), jnp.array(self.episodes), total_repeat_length=self.size
        )
        keys = jax.random.split(key, self.size)
        batches = [
            jax.vmap(lambda k, n, d=self.with_targets(d): random_encounter(k, ship, d, n))(
                keys, counts
            )
            for d in self.distributions
        ]
        episode = jnp.arange(self.size)
        return jax.tree.map(
            lambda *x: jnp.stack(x)[episode % len(self.distributions), episode], *batches
        )
