"""Any number of ships through one network: padded slots, or packed rows.

A batch of worlds holds 0-6 ships each; half of its slots are empty. A network
sees ships as *rows*. :class:`Padded` makes a row of every slot and masks;
:class:`Packed` makes rows of the ships that are there, so that no matrix
product is spent on nobody. Networks are written once against these verbs:

* ``rows(x)``      slots → rows
* ``spread(a)``    one value a world → the rows of its ships
* ``collect(y)``   rows → their sum over the ships of each world (the transpose of ``spread``)
* ``softmax(y)``   over the ships of each world
* ``pairs(u, v)``  u_i + v_j for all ordered pairs of ships of a world
* ``collect_pairs(y)``  pairs → rows, the sum over j
* ``slots(y)``     rows → slots, zero where nobody is
"""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

_NEVER = -1e9


class Padded(eqx.Module):
    """Every slot is a row: shapes [*batch, n, ...]."""

    present: Bool[Array, "*b n"]

    def rows(self, x: Float[Array, "..."]) -> Float[Array, "..."]:
        return x

    def spread(self, a: Float[Array, "*b d"]) -> Float[Array, "*b 1 d"]:
        return a[..., None, :]

    def collect(self, y: Float[Array, "*b n d"]) -> Float[Array, "*b d"]:
        return jnp.sum(jnp.where(self.present[..., None], y, 0.0), axis=-2)

    def softmax(self, y: Float[Array, "*b n"]) -> Float[Array, "*b n"]:
        return _masked_softmax(y, self.present)

    def pairs(
        self, u: Float[Array, "*b n d"], v: Float[Array, "*b n d"]
    ) -> Float[Array, "*b n n d"]:
        return u[..., :, None, :] + v[..., None, :, :]

    def collect_pairs(self, y: Float[Array, "*b n n"]) -> Float[Array, "*b n"]:
        return jnp.sum(jnp.where(self.present[..., None, :], y, 0.0), axis=-1)

    def slots(self, y: Float[Array, "*b n"]) -> Float[Array, "*b n"]:
        return jnp.where(self.present, y, 0.0)


class _Packing(eqx.Module):
    """Where the set entries of a mask [w, n] went, and back."""

    flat: Int[Array, " r"]  # row -> w * n + slot
    group: Int[Array, " r"]  # row -> w
    place: Int[Array, "w n"]  # slot -> row (clipped; masked by `here`)
    here: Bool[Array, "w n"]  # slots that have a row


def _pack(mask: Bool[Array, "w n"], capacity: int) -> _Packing:
    worlds, slots = mask.shape
    flat = jnp.nonzero(mask.reshape(-1), size=capacity, fill_value=0)[0]
    order = (jnp.cumsum(mask.reshape(-1)) - 1).reshape(worlds, slots)
    here = mask & (order < capacity)
    return _Packing(flat, flat // slots, jnp.clip(order, 0, capacity - 1), here)


@partial(jax.custom_vjp)
def _gather_sum(y: Float[Array, "r d"], p: _Packing) -> Float[Array, "w d"]:
    return jnp.sum(jnp.where(p.here[..., None], y[p.place], 0.0), axis=1)


def _gather_sum_fwd(y, p):
    return _gather_sum(y, p), (p, y.shape[0])


def _gather_sum_bwd(res, g):
    p, rows = res
    used = (jnp.arange(rows) < p.here.sum())[:, None]
    return jnp.where(used, g[p.group], 0.0), None


_gather_sum.defvjp(_gather_sum_fwd, _gather_sum_bwd)


@partial(jax.custom_vjp)
def _gather_spread(a: Float[Array, "w d"], p: _Packing) -> Float[Array, "r d"]:
    return a[p.group]


_gather_spread.defvjp(
    lambda a, p: (_gather_spread(a, p), p),
    lambda p, g: (_gather_sum(g, p), None),
)


class Packed(eqx.Module):
    """The ships that are there, in order: shapes [rows, ...].

    ``capacity`` rows are kept; worlds whose ships do not all fit are told by
    ``whole`` (they come last) and must be left out of a mean.
    """

    present: Bool[Array, "w n"]
    _ships: _Packing
    _pairs: _Packing | None

    def __init__(
        self,
        present: Bool[Array, "w n"],
        capacity: int,
        pair_capacity: int | None = None,
    ):
        worlds, slots = present.shape
        self.present = present
        self._ships = _pack(present, capacity)
        self._pairs = None
        if pair_capacity is not None:
            here = self._ships.here
            both = here[:, :, None] & here[:, None, :]
            self._pairs = _pack(both.reshape(worlds, slots * slots), pair_capacity)

    @property
    def whole(self) -> Bool[Array, " w"]:
        """Worlds all of whose ships (and pairs) have a row."""
        fits = jnp.all(self._ships.here == self.present, axis=-1)
        if self._pairs is None:
            return fits
        count = self.present.sum(-1)
        return fits & (self._pairs.here.sum(-1) == count * count)

    def rows(self, x: Float[Array, "..."]) -> Float[Array, "..."]:
        return x.reshape(-1, *x.shape[2:])[self._ships.flat]

    def spread(self, a: Float[Array, "w d"]) -> Float[Array, "r d"]:
        return _gather_spread(a, self._ships)

    def collect(self, y: Float[Array, "r d"]) -> Float[Array, "w d"]:
        return _gather_sum(y, self._ships)

    def softmax(self, y: Float[Array, " r"]) -> Float[Array, " r"]:
        alpha = _masked_softmax(self._to_slots(y), self._ships.here)
        return alpha.reshape(-1)[self._ships.flat]

    def pairs(self, u: Float[Array, "r d"], v: Float[Array, "r d"]) -> Float[Array, "p d"]:
        i, j = self._pair_rows()
        return u[i] + v[j]

    def collect_pairs(self, y: Float[Array, " p"]) -> Float[Array, " r"]:
        assert self._pairs is not None, "give pair_capacity to use pairs"
        worlds, slots = self.present.shape
        padded = jnp.where(self._pairs.here, y[self._pairs.place], 0.0)
        return padded.reshape(worlds, slots, slots).sum(-1).reshape(-1)[self._ships.flat]

    def slots(self, y: Float[Array, " r"]) -> Float[Array, "w n"]:
        return self._to_slots(y)

    def _to_slots(self, y: Float[Array, " r"]) -> Float[Array, "w n"]:
        return jnp.where(self._ships.here, y[self._ships.place], 0.0)

    def _pair_rows(self) -> tuple[Int[Array, " p"], Int[Array, " p"]]:
        assert self._pairs is not None, "give pair_capacity to use pairs"
        slots = self.present.shape[1]
        pair = self._pairs.flat % (slots * slots)
        place = self._ships.place
        return place[self._pairs.group, pair // slots], place[self._pairs.group, pair % slots]


Fleet = Padded | Packed


def _masked_softmax(y: Float[Array, "*b n"], mask: Bool[Array, "*b n"]) -> Float[Array, "*b n"]:
    """Softmax over the set entries; all zero where none is set."""
    if y.shape[-1] == 0:
        return y
    y = jnp.where(mask, y, _NEVER)
    weight = jnp.where(mask, jnp.exp(y - jax.lax.stop_gradient(y.max(-1, keepdims=True))), 0.0)
    return weight / jnp.maximum(weight.sum(-1, keepdims=True), 1e-30)
