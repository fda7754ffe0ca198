"""Made-up observations and small networks: what must hold does so whatever the numbers are."""

import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.env.observe import Observation
from glasshelm.networks.actors import ActorSizes
from glasshelm.networks.critics import CriticSizes

SIZES = ActorSizes(encoder=(16, 12), head=(16,), attention=(8,))
CRITIC = CriticSizes(hidden=(16, 12))
KEY = jax.random.key(0)
SLOTS = 4
#: Ships in each world of a batch: none, some, all.
COUNTS = (0, 3, 1, 4, 2, 0)


def observations(present, seed: int = 0) -> Observation:
    """A batch with these slots filled; empty ones hold nonsense that nobody may read."""
    present = np.asarray(present, bool)
    draw = np.random.default_rng(seed)
    targets = draw.normal(size=(*present.shape, 5, 10))
    targets[~present] = 77.0
    waypoint = draw.normal(size=(*present.shape[:-1], 5, 3))
    return Observation(jnp.float32(waypoint), jnp.float32(targets), jnp.asarray(present))


def of_counts(counts=COUNTS, seed: int = 0) -> Observation:
    """A batch of worlds with so many ships, in scattered slots."""
    draw = np.random.default_rng(seed)
    present = np.zeros((len(counts), SLOTS), bool)
    for row, count in zip(present, counts, strict=True):
        row[draw.permutation(SLOTS)[:count]] = True
    return observations(present, seed)


def actions(worlds: int, seed: int = 0):
    return jnp.float32(np.random.default_rng(seed + 100).uniform(-1, 1, worlds))
