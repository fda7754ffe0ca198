"""What a training begins with."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.errors import InputError
from glasshelm.learning.first import first_actor
from glasshelm.learning.presets import preset_named
from glasshelm.pilots.catalogue import WEIGHTS

SUM = dataclasses.replace(preset_named("fast"), actor="sum")


def named(*names: str) -> str:
    return ",".join(str(WEIGHTS / f"{name}.safetensors") for name in names)


def test_of_several_files_the_mean():
    one = first_actor(dataclasses.replace(SUM, start=named("paper-sum")))
    other = first_actor(dataclasses.replace(SUM, start=named("large-ship-sum")))
    both = first_actor(dataclasses.replace(SUM, start=named("paper-sum", "large-ship-sum")))
    for a, b, mean in zip(*map(jax.tree.leaves, (one, other, both)), strict=True):
        np.testing.assert_allclose(mean, (a + b) / 2, atol=1e-6)
    assert not np.allclose(one.head.weights[0], other.head.weights[0])


def test_a_new_one_follows_the_seed():
    drawn = [first_actor(dataclasses.replace(SUM, seed=seed)) for seed in (1, 1, 2)]
    first = [actor.head.weights[0] for actor in drawn]
    np.testing.assert_array_equal(first[0], first[1])
    assert float(jnp.abs(first[0] - first[2]).max()) > 0.01


def test_a_file_of_another_actor_is_named():
    given = dataclasses.replace(SUM, start=named("paper-sum", "paper-attention"))
    with pytest.raises(InputError, match=r"paper-attention\.safetensors: its actor is not"):
        first_actor(given)
