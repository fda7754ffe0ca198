"""How true one number a ship is, measured against what the pilot does with any set of ships.

All 2ⁿ decisions are known, so nothing is sampled: a random order scores exactly
0 and the best possible one exactly 1 in deletion and insertion.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.explanation.coalitions import coalitions, exact_from_worths


class Scores(eqx.Module):
    """Of one explanation in one scene.

    ``kendall`` (τ_b) and ``top`` (1: the same first ship) compare |e| with |φ|,
    the Shapley value of what is decided; ``sign`` is the share of |φ| whose side e
    tells rightly (nan where it claims none). ``deletion`` and ``insertion``: 0 is a random
    order, 1 the best one (nan where all orders are alike). ``infidelity``
    (Yeh et al. 2019, uniform over coalitions): the share of the decision's
    variation that c·Σe misses with c fitted, ``unscaled_infidelity`` with c = 1 (nan where
    e is no rudder).
    """

    kendall: Float[Array, ""]
    top: Float[Array, ""]
    sign: Float[Array, ""]
    deletion: Float[Array, ""]
    insertion: Float[Array, ""]
    infidelity: Float[Array, ""]
    unscaled_infidelity: Float[Array, ""]


def score_attribution(
    attribution: Float[Array, " n"],
    worths: Float[Array, " k"],
    side: bool | Bool[Array, ""],
    size: bool | Bool[Array, ""],
) -> Scores:
    """The scores of one explanation of one scene.

    Args:
        attribution: One number a ship.
        worths: What is decided in all coalitions (rudders or courses), by their bits.
        side: The attribution claims a side.
        size: It is also in the units of ``worths``.
    """
    players = attribution.shape[0]
    true = exact_from_worths(worths).by_ship
    moved, rank = jnp.abs(true), _ranks(jnp.abs(attribution))
    right = (jnp.sign(attribution) == jnp.sign(true)) * moved
    sign = jnp.where(side, right.sum() / jnp.maximum(moved.sum(), 1e-12), jnp.nan)
    full = 2**players - 1
    left_out = jnp.abs(worths - worths[full])[::-1]  # by who is left out, not by who is in
    kept = jnp.abs(worths - worths[full])
    return Scores(
        kendall_tau(jnp.abs(attribution), moved),
        (jnp.argmax(jnp.abs(attribution)) == jnp.argmax(moved)).astype(jnp.float32),
        sign,
        _normalised(left_out, rank, best=1.0),
        _normalised(kept, rank, best=-1.0),
        _infidelity(attribution, worths),
        jnp.where(size, _infidelity(attribution, worths, 1.0), jnp.nan),
    )


def kendall_tau(a: Float[Array, " n"], b: Float[Array, " n"]) -> Float[Array, ""]:
    """Kendall's τ_b: agreement of two orders, ties counted; 0 where one has only ties."""
    i, j = np.triu_indices(a.shape[0], 1)
    da, db = jnp.sign(a[i] - a[j]), jnp.sign(b[i] - b[j])
    ties = jnp.sqrt(jnp.sum(da != 0) * jnp.sum(db != 0))
    return jnp.sum(da * db) / jnp.maximum(ties, 1.0)


def _ranks(size: Float[Array, " n"]) -> Int[Array, " n"]:
    """The rank of each in falling order, from 0; of equals the earlier slot comes first."""
    slot = jnp.arange(size.shape[0])
    larger = size[None, :] > size[:, None]
    equal = (size[None, :] == size[:, None]) & (slot[None, :] < slot[:, None])
    return (larger | equal).sum(1)


def _normalised(
    change: Float[Array, " k"], rank: Int[Array, " n"], best: float
) -> Float[Array, ""]:
    """(this order's area − a random one's) / (the best one's − a random one's).

    ``change`` [2ⁿ] is the change of the decision by who was taken (out or in);
    ``best`` +1 where a large area is good, −1 where a small one is.
    """
    value = best * change
    players = rank.shape[0]
    first = rank[None, :] < 1 + jnp.arange(players)[:, None]
    taken = (first * 2 ** jnp.arange(players)).sum(1)
    ours = value[taken].sum()
    sizes = coalitions(players).sum(1)
    chance = sum(value[sizes == k].mean() for k in range(1, players + 1))
    top = _best_path(value, players)
    room = top - chance
    return jnp.where(room > 1e-7, (ours - chance) / jnp.maximum(room, 1e-7), jnp.nan)


def _best_path(value: Float[Array, " k"], players: int) -> Float[Array, ""]:
    """The largest sum of values over a chain of coalitions from one player to all."""
    inside = coalitions(players)
    best = jnp.zeros(2**players)
    for size in range(1, players + 1):
        rows = np.flatnonzero(inside.sum(1) == size)
        before = rows[:, None] ^ (1 << np.arange(players))[None, :]
        reach = jnp.where(inside[rows], best[before], -jnp.inf).max(1)
        best = best.at[rows].set(reach + value[rows])
    return best[-1]


def _infidelity(
    attribution: Float[Array, " n"], worths: Float[Array, " k"], c: float | None = None
) -> Float[Array, ""]:
    """E_S[(v(N) − v(N∖S) − c·Σ_{i∈S} e_i)²] / E_S[(v(N) − v(N∖S))²], S uniform; least over c
    unless it is given."""
    drop = worths[-1] - worths[::-1]
    claimed = jnp.asarray(coalitions(attribution.shape[0]), jnp.float32) @ attribution
    scale = (claimed @ drop) / jnp.maximum(claimed @ claimed, 1e-20) if c is None else c
    return ((drop - scale * claimed) ** 2).sum() / jnp.maximum((drop**2).sum(), 1e-20)
