"""What a training begins with."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.errors import InputError
from glasshelm.encounters.random_encounters import random_encounter
from glasshelm.env.step import reset
from glasshelm.networks.actors import ActorSizes
from glasshelm.pilots.registry import WEIGHTS
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.config import preset_named
from glasshelm.training.init_actor import init_actor

SUM = dataclasses.replace(preset_named("fast"), actor="sum")


def named(*names: str) -> str:
    return ",".join(str(WEIGHTS / f"{name}.safetensors") for name in names)


def test_of_several_files_the_mean():
    one = init_actor(dataclasses.replace(SUM, init_from=named("paper-sum")))
    other = init_actor(dataclasses.replace(SUM, init_from=named("large-ship-sum")))
    both = init_actor(dataclasses.replace(SUM, init_from=named("paper-sum", "large-ship-sum")))
    for a, b, mean in zip(*map(jax.tree.leaves, (one, other, both)), strict=True):
        np.testing.assert_allclose(mean, (a + b) / 2, atol=1e-6)
    assert not np.allclose(one.head.weights[0], other.head.weights[0])


def test_a_new_one_follows_the_seed():
    drawn = [init_actor(dataclasses.replace(SUM, seed=seed)) for seed in (1, 1, 2)]
    first = [actor.head.weights[0] for actor in drawn]
    np.testing.assert_array_equal(first[0], first[1])
    assert float(jnp.abs(first[0] - first[2]).max()) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sum", "attention"])
def test_a_wider_one_says_what_the_narrow_one_says_and_learns_more(kind):
    """Same rudder; the copies get gradients of their own."""
    narrow = dataclasses.replace(SUM, actor=kind, init_from=named(f"paper-{kind}"))
    wide = dataclasses.replace(
        narrow, actor_sizes=ActorSizes((192, 160, 100), (150, 128, 64), (64, 80), "fine")
    )
    ship = SHIPS["paper"]
    seen = jax.vmap(lambda key: reset(random_encounter(key, ship, count=6), ship).observation)
    observation = jax.jit(seen)(jax.random.split(jax.random.key(3), 8))
    small, large = init_actor(narrow), init_actor(wide)
    assert large.encode_target.weights[1].shape == (192, 160)
    rudder = eqx.filter_jit(lambda actor: actor(observation))
    np.testing.assert_allclose(rudder(large), rudder(small), atol=2e-5)
    weights, pulls = (
        np.asarray(a.encode_target.weights[0])
        for a in (large, eqx.filter_jit(jax.grad(lambda a: a(observation).sum()))(large))
    )
    origin = np.abs(weights[:, :128] - weights[:, 128:129]).sum(0).argmin()
    np.testing.assert_array_equal(weights[:, origin], weights[:, 128])
    assert np.abs(pulls[:, origin] - pulls[:, 128]).max() > 1e-3 * np.abs(pulls).max()


def test_a_narrower_one_is_refused():
    given = dataclasses.replace(
        SUM,
        init_from=named("paper-sum"),
        actor_sizes=ActorSizes((64, 64, 64), (8, 8, 8), (), "fine"),
    )
    with pytest.raises(InputError, match=r"paper-sum\.safetensors: .* of 128 units"):
        init_actor(given)


def test_a_file_of_another_actor_is_named():
    given = dataclasses.replace(SUM, init_from=named("paper-sum", "paper-attention"))
    with pytest.raises(InputError, match=r"paper-attention\.safetensors: its actor is not"):
        init_actor(given)
