"""Linear bounds of the sum actor (Eq. 20-21), layer by layer from the rudder back (CROWN).

A row a of weights on a layer's outputs has a lower bound a·y ≥ a'·x + c in its inputs:
a positive weight takes the line below the activation, a negative one the line
above. The bounds that the lines need are found in the same way, from the first layer on
(Zhang et al. 2018). Encoders are added, so a bound of their sum is the sum of their bounds.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.certify.input_bounds import AffineForm
from glasshelm.certify.measurements import N_OWN_ERRORS
from glasshelm.certify.relaxations import LinearRelaxation, relax_leaky_relu, relax_softsign
from glasshelm.networks.actors import SumActor
from glasshelm.networks.mlp import LEAK, Mlp

#: What float32 may lose in the sums of one network, of the values' size or of 1.
ROUNDING = 2e-6
#: Steps of the slopes; the last one only evaluates.
SLOPE_STEPS = np.append(np.geomspace(0.4, 0.03, 8), 0.0).astype(np.float32)


class LinearBound(eqx.Module):
    """Numbers that are at least shift + own·φ_own + Σ_i each_i·φ_i for all symbols in [−1, 1]."""

    shift: Float[Array, " r"]
    own: Float[Array, "r 4"]
    target: Float[Array, "r n 4"]

    @property
    def minimum(self) -> Float[Array, " r"]:
        """The smallest value."""
        swing = jnp.abs(self.own).sum(-1) + jnp.abs(self.target).sum((-1, -2))
        return self.shift - swing - ROUNDING * (1.0 + jnp.abs(self.shift) + swing)


def _behind(
    rows: Float[Array, "r d"], lines: LinearRelaxation
) -> tuple[Float[Array, "r d"], Array]:
    """Rows on an activation's outputs as rows on its inputs, and what is added."""
    up, down = jnp.maximum(rows, 0.0), jnp.minimum(rows, 0.0)
    before = up * lines.low_slope + down * lines.high_slope
    return before, up @ lines.low_shift + down @ lines.high_shift


def _through(
    mlp: Mlp, layers: int, lines: list[LinearRelaxation], rows: Array
) -> tuple[Array, Array]:
    """Rows on the outputs of the first ``layers`` layers as rows on the inputs, and a shift."""
    shift = jnp.zeros(rows.shape[0])
    for i in reversed(range(layers)):
        shift = shift + rows @ mlp.biases[i]
        rows = rows @ mlp.weights[i].T
        if i > 0:
            rows, more = _behind(rows, lines[i - 1])
            shift = shift + more
    return rows, shift


def _both_ways(width: int) -> Float[Array, "r d"]:
    """Rows whose lower bounds are a vector's lower bounds and its negated upper bounds."""
    return jnp.concatenate([jnp.eye(width), -jnp.eye(width)])


def _ends(least: Float[Array, " r"]) -> tuple[Array, Array]:
    low, negated = jnp.split(least, 2)
    return low, -negated


def _on_form(rows: Array, shift: Array, form: AffineForm) -> tuple[Array, Array]:
    """The lower bound of rows on a form: slopes in its eight symbols and a shift."""
    return rows @ form.slope, shift + rows @ form.centre - jnp.abs(rows) @ form.slack


def _hidden_lines(mlp: Mlp, form: AffineForm) -> list[LinearRelaxation]:
    """The lines of every activation inside a network whose inputs are a form."""
    lines: list[LinearRelaxation] = []
    for layers in range(1, len(mlp.weights)):
        rows = _both_ways(mlp.biases[layers - 1].shape[0])
        slope, shift = _on_form(*_through(mlp, layers, lines, rows), form)
        bound = LinearBound(shift, slope[:, :N_OWN_ERRORS], slope[:, None, N_OWN_ERRORS:])
        lines.append(relax_leaky_relu(*_ends(bound.minimum)))
    return lines


def rudder_bounds(
    actor: SumActor, waypoint: AffineForm, targets: AffineForm, present: Bool[Array, " n"]
) -> tuple[LinearBound, LinearBound]:
    """Lower bounds of the head's output and of its negative, before the last softsign."""
    encoders = (
        _hidden_lines(actor.encode_waypoint, waypoint),
        jax.vmap(lambda form: _hidden_lines(actor.encode_target, form))(targets),
    )

    def at_sum(
        encoders: tuple[list[LinearRelaxation], list[LinearRelaxation]], rows: Array, shift: Array
    ) -> LinearBound:
        """Rows on the sum of the encoders' outputs."""
        of_waypoint, of_targets = encoders
        depth = len(actor.encode_waypoint.weights)
        wp_rows, wp_shift = _through(actor.encode_waypoint, depth, of_waypoint, rows)
        slope, start = _on_form(wp_rows, wp_shift, waypoint)

        def ship(lines: list[LinearRelaxation], form: AffineForm) -> tuple[Array, Array]:
            depth = len(actor.encode_target.weights)
            return _on_form(*_through(actor.encode_target, depth, lines, rows), form)

        slopes, shifts = jax.vmap(ship)(of_targets, targets)
        slopes = jnp.where(present[:, None, None], slopes, 0.0)
        shifts = jnp.where(present[:, None], shifts, 0.0)
        own = slope[:, :N_OWN_ERRORS] + slopes[..., :N_OWN_ERRORS].sum(0)
        return LinearBound(
            shift + start + shifts.sum(0), own, jnp.swapaxes(slopes[..., N_OWN_ERRORS:], 0, 1)
        )

    width = actor.head.weights[0].shape[0]
    traffic = at_sum(encoders, _both_ways(width), jnp.zeros(2 * width))
    pooled = relax_softsign(*_ends(traffic.minimum))
    head: list[LinearRelaxation] = []

    def behind_sum(head: list[LinearRelaxation], layers: int, rows: Array) -> tuple[Array, Array]:
        """Rows on the head's outputs as rows on the sum."""
        rows, shift = _through(actor.head, layers, head, rows)
        rows, more = _behind(rows, pooled)
        return rows, shift + more

    for layers in range(1, len(actor.head.weights)):
        rows, shift = behind_sum(head, layers, _both_ways(actor.head.biases[layers - 1].shape[0]))
        head.append(relax_leaky_relu(*_ends(at_sum(encoders, rows, shift).minimum)))

    def bound(row: Array) -> LinearBound:
        def lower_bound(lines: tuple) -> LinearBound:
            encoders, head = lines
            return at_sum(encoders, *behind_sum(head, len(actor.head.weights), row[None]))

        return lower_bound(
            _optimised(lambda lines: lower_bound(lines).minimum[0], (encoders, head))
        )

    both = jax.vmap(bound)(_both_ways(1))
    low, high = (jax.tree.map(lambda x, i=i: x[i], both) for i in (0, 1))
    return low, high


def _optimised(least: Callable[[tuple], Array], lines: tuple) -> tuple:
    """LinearRelaxation moved to make the bound as good as a few steps along its gradient do.

    Below a leaky ReLU that bends, every line through 0 with a slope between its two arms will
    do (Xu et al. 2021).
    """

    def slopes(lines: tuple) -> list:
        return [x.low_slope for x in jax.tree.leaves(lines, is_leaf=_is_lines)]

    bends = [x.high_shift > 0 for x in jax.tree.leaves(lines, is_leaf=_is_lines)]

    def turn(state: tuple[tuple, tuple, Array], step: Array) -> tuple[tuple, None]:
        lines, best, most = state
        value, gradient = jax.value_and_grad(least)(lines)
        better = value > most
        best = jax.tree.map(lambda x, y: jnp.where(better, x, y), lines, best)
        moved = [
            jnp.where(bend, jnp.clip(slope + step * jnp.sign(jnp.nan_to_num(up)), LEAK, 1.0), slope)
            for bend, slope, up in zip(bends, slopes(lines), slopes(gradient), strict=True)
        ]
        return (eqx.tree_at(slopes, lines, moved), best, jnp.where(better, value, most)), None

    start = (lines, lines, jnp.array(-jnp.inf))
    return jax.lax.scan(turn, start, jnp.asarray(SLOPE_STEPS))[0][1]


def _is_lines(x: object) -> bool:
    return isinstance(x, LinearRelaxation)
