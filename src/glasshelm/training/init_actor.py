"""The actor that a training starts from: a new one, a file's, or the mean of several files'.

The mean of the weights of several trainings that started from the same weights is
often a better pilot than any of them ("model soup", Wortsman et al. 2022,
arXiv:2203.05482). Weights of trainings that started apart have no such mean. An
actor smaller than the one to be trained is widened (:mod:`glasshelm.training.net2wider`).
"""

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp

from glasshelm.core.errors import InputError
from glasshelm.networks.actors import Actor, make_actor
from glasshelm.pilots.load_networks import read_networks
from glasshelm.training.config import TrainConfig
from glasshelm.training.net2wider import widen


def init_actor(config: TrainConfig) -> Actor:
    """The actor of ``config.init_from``: new if there is none, the mean if there are several files.

    Raises:
        InputError: A file cannot be read, or holds an actor of another kind or one that has
            wider layers than the one to be trained.
    """
    key = jax.random.fold_in(jax.random.key(config.seed), 3)
    if config.init_from is None:
        return jax.jit(make_actor, static_argnums=(0, 1))(config.actor, config.actor_sizes, key)
    actors = [_read_actor(path, config, key) for path in init_files(config.init_from)]
    return jax.tree.map(lambda *leaves: jnp.mean(jnp.stack(leaves), axis=0), *actors)


def init_files(init_from: str) -> list[Path]:
    """The weights files that ``TrainConfig.init_from`` names."""
    return [Path(name) for name in init_from.split(",")]


def _read_actor(path: Path, config: TrainConfig, key: jax.Array) -> Actor:
    actor = read_networks(path)[0].actor
    if actor is None:
        raise InputError(f"{path}: holds no actor to start from, but a critic that steers")
    wanted = jax.eval_shape(lambda: make_actor(config.actor, config.actor_sizes, key))
    if jax.tree.structure(actor) != jax.tree.structure(wanted):
        raise InputError(f"{path}: its actor is not the one to be trained: another kind")
    if _shapes(actor) == _shapes(wanted):
        return actor
    try:
        return jax.jit(widen, static_argnums=1)(actor, config.actor_sizes, key)
    except ValueError as error:
        raise InputError(f"{path}: its actor is not the one to be trained: {error}") from None


def _shapes(actor: Any) -> list[tuple[int, ...]]:
    return [leaf.shape for leaf in jax.tree.leaves(actor)]
