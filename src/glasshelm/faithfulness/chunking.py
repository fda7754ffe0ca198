"""Many scenes through one compiled program of few."""

from collections.abc import Callable
from typing import Any, TypeVar

import jax
import numpy as np

Result = TypeVar("Result")

#: Scenes that a program takes at once.
CHUNK = 64


def map_in_chunks(work: Callable[[Any], Result], scenes: Any) -> Result:
    """``work`` on every scene [s, ...] of a pytree, :data:`CHUNK` at a time, on the host.

    The last chunk is filled up with its first scene, so that ``work`` is
    compiled for one shape whatever the number of scenes.
    """
    count = jax.tree.leaves(scenes)[0].shape[0]
    parts = []
    for first in range(0, count, CHUNK):
        wanted = np.arange(first, min(first + CHUNK, count))
        place = np.concatenate([wanted, np.full(CHUNK - len(wanted), first)])
        done = jax.device_get(work(jax.tree.map(lambda x, p=place: x[p], scenes)))
        parts.append(jax.tree.map(lambda x, n=len(wanted): x[:n], done))
    return jax.tree.map(lambda *x: np.concatenate(x), *parts)
