"""A plain multilayer perceptron on the last axis (Tables A.1-A.5)."""

import itertools
from collections.abc import Callable, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

Activation = Callable[[Float[Array, "..."]], Float[Array, "..."]]


def relu(x: Float[Array, "..."]) -> Float[Array, "..."]:
    return jnp.maximum(x, 0.0)


#: The leak of the paper's leaky ReLU (Appendix).
LEAK = 0.1


def leaky_relu(x: Float[Array, "..."]) -> Float[Array, "..."]:
    """Leaky ReLU with the paper's leak."""
    return jnp.maximum(x, LEAK * x)


def softsign(x: Float[Array, "..."]) -> Float[Array, "..."]:
    return x / (1.0 + jnp.abs(x))


class Mlp(eqx.Module):
    """Fully connected layers with an activation between them, none after the last.

    Works on the last axis of an array with any leading axes, so that a batch is
    one matrix product. ``norm`` puts a LayerNorm (without gain and offset)
    before every activation.
    """

    weights: tuple[Float[Array, "inputs outputs"], ...]
    biases: tuple[Float[Array, " outputs"], ...]
    activation: Activation = eqx.field(static=True)
    norm: bool = eqx.field(static=True)

    def __init__(
        self,
        sizes: Sequence[int],
        activation: Activation,
        key: PRNGKeyArray,
        norm: bool = False,
    ):
        keys = jax.random.split(key, len(sizes) - 1)
        pairs = list(itertools.pairwise(sizes))
        self.weights = tuple(
            jax.random.uniform(k, pair, minval=-1.0, maxval=1.0) * (3.0 / pair[0]) ** 0.5
            for k, pair in zip(keys, pairs, strict=True)
        )
        self.biases = tuple(jnp.zeros(outputs) for _, outputs in pairs)
        self.activation = activation
        self.norm = norm

    def __call__(self, x: Float[Array, "*b inputs"]) -> Float[Array, "*b outputs"]:
        return self.from_first_product(x @ self.weights[0])

    def from_first_product(self, product: Float[Array, "*b hidden"]) -> Float[Array, "*b outputs"]:
        """The network from its first matrix product on (bias, activation, other layers).

        For callers who build that product in parts: of two inputs side by side
        it is the sum of each input's own product.
        """
        x = product + self.biases[0]
        for weight, bias in zip(self.weights[1:], self.biases[1:], strict=True):
            if self.norm:
                x = _layer_norm(x)
            x = self.activation(x) @ weight + bias
        return x


def _layer_norm(x: Float[Array, "*b d"]) -> Float[Array, "*b d"]:
    centred = x - x.mean(-1, keepdims=True)
    return centred * jax.lax.rsqrt((centred**2).mean(-1, keepdims=True) + 1e-5)
