import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.networks.mlp import Mlp, leaky_relu, relu, softsign

KEY = jax.random.key(3)


def test_activations():
    x = jnp.float32([-2.0, -0.5, 0.0, 3.0])
    np.testing.assert_allclose(relu(x), [0, 0, 0, 3])
    np.testing.assert_allclose(leaky_relu(x), [-0.2, -0.05, 0, 3])
    np.testing.assert_allclose(softsign(x), [-2 / 3, -1 / 3, 0, 0.75], rtol=1e-6)


@pytest.mark.parametrize("norm", [False, True])
def test_mlp_is_the_chain_written_out(norm):
    mlp = Mlp((3, 5, 4, 2), leaky_relu, KEY, norm)
    biases = tuple(jax.random.normal(KEY, b.shape) for b in mlp.biases)
    mlp = eqx.tree_at(lambda m: m.biases, mlp, biases)
    x = np.random.default_rng(0).normal(size=(7, 3)).astype(np.float32)

    def activate(h):
        if norm:
            h = (h - h.mean(-1, keepdims=True)) / np.sqrt(h.var(-1, keepdims=True) + 1e-5)
        return np.where(h > 0, h, 0.1 * h)

    w, b = ([np.asarray(k) for k in part] for part in (mlp.weights, mlp.biases))
    expected = activate(activate(x @ w[0] + b[0]) @ w[1] + b[1]) @ w[2] + b[2]
    np.testing.assert_allclose(mlp(jnp.asarray(x)), expected, rtol=1e-4, atol=1e-5)


def test_leading_axes_are_a_batch():
    mlp = Mlp((3, 5, 2), relu, KEY)
    x = jax.random.normal(KEY, (2, 4, 3))
    together = mlp(x)
    assert together.shape == (2, 4, 2)
    np.testing.assert_allclose(together[1, 3], mlp(x[1, 3]), rtol=1e-5, atol=1e-6)


def test_first_product_may_be_built_in_parts():
    mlp = Mlp((5, 6, 2), relu, KEY)
    x = jax.random.normal(KEY, (4, 5))
    parts = x[:, :2] @ mlp.weights[0][:2] + x[:, 2:] @ mlp.weights[0][2:]
    np.testing.assert_allclose(mlp.from_first_product(parts), mlp(x), rtol=1e-5, atol=1e-6)


def test_initial_outputs_neither_die_nor_explode():
    mlp = Mlp((50, 256, 256, 128), relu, KEY)
    out = mlp(jax.random.normal(KEY, (256, 50)))
    assert 0.1 < float(out.std()) < 3.0
