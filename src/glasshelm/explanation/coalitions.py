"""Exact Shapley values and pair interactions of any game with few players.

A game gives every coalition S of the players N = {1 … n} a worth v(S). Here
players are ships and v(S) is what the pilot would do, or what that would be
worth, if only the ships of S were there. All 2ⁿ worths are known, so nothing is
sampled (Shapley 1953; the interaction index is Grabisch and Roubens').
"""

from functools import lru_cache
from math import factorial

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

#: Beyond so many players 2ⁿ worths are too many for a decision every few seconds.
MAX_EXACT = 12


class ShapleyValues(eqx.Module):
    """How a worth v(N) is shared out among the players.

    ``none`` is v(∅), ``all`` v(N), ``by_ship`` the Shapley value φ_i of each
    player, which add up to their difference, and ``pairs`` the Shapley
    interaction index I_ij: what two are worth together beyond each alone
    (symmetric, 0 on the diagonal). ``error`` is the standard error of
    ``by_ship`` where it was sampled, 0 where it is exact.
    """

    none: Float[Array, ""]
    all: Float[Array, ""]
    by_ship: Float[Array, " n"]
    pairs: Float[Array, "n n"]
    error: Float[Array, " n"]


@lru_cache
def coalitions(players: int) -> Bool[np.ndarray, "k n"]:
    """Every subset of the players, one a row: row r holds player i where bit i of r is set."""
    rows = np.arange(2**players)[:, None]
    return (rows >> np.arange(players)) % 2 == 1


def exact_from_worths(worth: Float[Array, " k"]) -> ShapleyValues:
    """φ_i = Σ_T |T|!(n−|T|−1)!/n! (v(T∪i) − v(T)) and I_ij, from the worths of all coalitions.

    ``worth`` [2ⁿ] is in the order of :func:`coalitions`. Both are one matrix
    product with weights that depend on n alone.
    """
    players = worth.shape[0].bit_length() - 1
    of_one, of_two = map(jnp.asarray, _weights(players))
    # Shares are of differences: without v(∅) the product keeps its last digits.
    gained = worth - worth[0]
    pairs = (of_two @ gained).reshape(players, players)
    nothing = jnp.zeros(players, worth.dtype)
    return ShapleyValues(worth[0], worth[-1], of_one @ gained, pairs, nothing)


@lru_cache
def _weights(players: int) -> tuple[np.ndarray, np.ndarray]:
    """What each coalition counts in each φ_i [n, 2ⁿ] and each I_ij [n², 2ⁿ]."""
    inside = coalitions(players)
    size = inside.sum(1)
    one = np.zeros((players, len(inside)))
    two = np.zeros((players, players, len(inside)))
    for i in range(players):
        others = size - inside[:, i]
        one[i] = np.where(inside[:, i], 1.0, -1.0) * _weight(players, 1)[others]
        for j in range(players):
            if i == j:
                continue
            others = size - inside[:, i] - inside[:, j]
            sign = np.where(inside[:, i] == inside[:, j], 1.0, -1.0)
            two[i, j] = sign * _weight(players, 2)[others]
    return one.astype(np.float32), two.reshape(-1, len(inside)).astype(np.float32)


def _weight(players: int, joining: int) -> np.ndarray:
    """|T|!(n−|T|−k)!/(n−k+1)! of coalitions T of the others, by their size, for k joining."""
    rest = players - joining
    if rest < 0:
        return np.zeros(1)
    return np.array(
        [factorial(t) * factorial(rest - t) / factorial(rest + 1) for t in range(rest + 1)]
    )
