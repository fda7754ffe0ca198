"""One pass over the sets of ships serves every quantity of a chosen manoeuvre."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.explanation.coalitions import MAX_EXACT
from glasshelm.explanation.manoeuvre_explanation import choose, first_largest
from glasshelm.explanation.shapley import leave_one_out, shapley_padded
from glasshelm.networks.critics import QValues


def values(ships: int, rows: int = 97) -> QValues:
    """A table in which each ship costs some manoeuvres nothing."""
    rng = np.random.default_rng(ships)
    costs = 3 * rng.exponential(size=(rows, ships)) * (rng.random((rows, ships)) < 0.8)
    way = jnp.asarray(rng.normal(size=rows), jnp.float32)
    return QValues(way, jnp.asarray(-costs, jnp.float32), jnp.zeros(rows))


@pytest.mark.parametrize("rows", [1, 31, 32, 769])
def test_the_first_of_the_largest_is_found_as_argmax_does(rows):
    rng = np.random.default_rng(rows)
    for few in (3, 1000):  # many ties, and hardly any
        total = jnp.asarray(rng.integers(0, few, rows), jnp.float32)
        assert int(jax.jit(first_largest)(total)) == int(jnp.argmax(total))


@pytest.mark.parametrize(("ships", "there"), [(4, 3), (10, 5), (14, 14)])
def test_quantities_shared_out_together_have_the_shares_that_each_has_alone(ships, there):
    """Exact in few slots, exact for few ships in many slots, and sampled."""
    table = values(ships)
    first, second = jnp.linspace(0.0, 1.0, 97), table.total / 10
    present = jnp.arange(ships) < there
    table = QValues(table.waypoint, table.by_ship * present, table.helm)

    def together(members):
        row = choose(table, members)
        return first[row], second[row]

    def argmax(members):
        """The rows as they are defined, one set at a time."""
        return jnp.argmax(table.waypoint + table.by_ship @ members.astype(jnp.float32))

    both = jax.jit(lambda there: shapley_padded(together, there, MAX_EXACT, True))(present)
    alone = jax.jit(lambda: leave_one_out(together, ships))()
    for quantity, found, without in zip((first, second), both, alone, strict=True):

        def worth(members, quantity=quantity):
            return quantity[argmax(members)]

        expected = jax.jit(lambda p, w=worth: shapley_padded(w, p, MAX_EXACT, True))(present)
        jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, atol=1e-5), found, expected)
        np.testing.assert_allclose(without, leave_one_out(worth, ships), atol=1e-5)
        np.testing.assert_allclose(found.by_ship[there:], 0.0, atol=1e-5)
        assert np.any(found.by_ship)
