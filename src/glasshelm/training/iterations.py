"""What stages share that collect a dataset by iterations and learn from the last of them."""

from typing import Protocol, TypeVar, runtime_checkable

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Int

Dataset = TypeVar("Dataset")


@runtime_checkable
class IterationSettings(Protocol):
    """The settings of a stage of iterations, as far as they are shared."""

    @property
    def iterations(self) -> int: ...
    @property
    def updates(self) -> int: ...
    @property
    def dataset_iterations(self) -> int: ...
    @property
    def learning_rate(self) -> float: ...
    @property
    def max_gradient_norm(self) -> float: ...


def optimiser_of(settings: IterationSettings) -> optax.GradientTransformation:
    """Adam with clipped gradients; its rate warms up, then falls along a cosine."""
    updates = settings.iterations * settings.updates
    schedule = optax.warmup_cosine_decay_schedule(
        0.1 * settings.learning_rate,
        settings.learning_rate,
        min(300, updates // 10 + 1),
        max(updates, 2),
        0.02 * settings.learning_rate,
    )
    return optax.chain(optax.clip_by_global_norm(settings.max_gradient_norm), optax.adam(schedule))


def with_newest(
    dataset: Dataset, new: Dataset, iteration: Int[Array, ""], settings: IterationSettings
) -> tuple[Dataset, Int[Array, ""]]:
    """The dataset with an iteration's rows in the place of the oldest, and how many it holds."""
    oldest = iteration % settings.dataset_iterations
    dataset = jax.tree.map(lambda all_, new: all_.at[oldest].set(new), dataset, new)
    return dataset, jnp.minimum(iteration + 1, settings.dataset_iterations)
