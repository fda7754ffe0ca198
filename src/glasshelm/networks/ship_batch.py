"""Any number of ships through one network: padded slots, or packed rows.

A batch of scenes holds 0-6 ships each; half of its slots are empty. A network
sees ships as *rows*. :class:`Padded` makes a row of every slot and masks;
:class:`Packed` makes rows of the ships that are there, so that no matrix
product is spent on nobody. Networks are written once against these verbs:

* ``to_rows(x)``    slots → rows
* ``broadcast(a)``  one value a scene → the rows of its ships
* ``sum_ships(y)``  rows → their sum over the ships of each scene (transpose of ``broadcast``)
* ``softmax(y)``    over the ships of each scene
* ``pairs(u, v)``   u_i + v_j for all ordered pairs of ships of a scene
* ``sum_pairs(y)``  pairs → rows, the sum over j
* ``to_slots(y)``   rows → slots, zero where there is no ship
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, Shaped

_NEVER = -1e9


class Padded(eqx.Module):
    """Every slot is a row: shapes [*batch, n, ...]."""

    present: Bool[Array, "*b n"]

    def to_rows(self, x: Shaped[Array, "..."]) -> Shaped[Array, "..."]:
        return x

    def broadcast(self, a: Float[Array, "*b d"]) -> Float[Array, "*b 1 d"]:
        return a[..., None, :]

    def sum_ships(self, y: Float[Array, "*b n d"]) -> Float[Array, "*b d"]:
        return jnp.sum(jnp.where(self.present[..., None], y, 0.0), axis=-2)

    def softmax(self, y: Float[Array, "*b n"]) -> Float[Array, "*b n"]:
        return _masked_softmax(y, self.present)

    def pairs(
        self, u: Float[Array, "*b n d"], v: Float[Array, "*b n d"]
    ) -> Float[Array, "*b n n d"]:
        return u[..., :, None, :] + v[..., None, :, :]

    def sum_pairs(self, y: Float[Array, "*b n n"]) -> Float[Array, "*b n"]:
        return jnp.sum(jnp.where(self.present[..., None, :], y, 0.0), axis=-1)

    def to_slots(self, y: Float[Array, "*b n"]) -> Float[Array, "*b n"]:
        return jnp.where(self.present, y, 0.0)


class _Packing(eqx.Module):
    """Where the set entries of a mask [w, n] went, and back."""

    flat: Int[Array, " r"]  # row -> w * n + slot
    group: Int[Array, " r"]  # row -> w
    place: Int[Array, "w n"]  # slot -> row (clipped; masked by `filled`)
    filled: Bool[Array, "w n"]  # slots that have a row


def _pack(mask: Bool[Array, "w n"], capacity: int) -> _Packing:
    scenes, slots = mask.shape
    flat = jnp.nonzero(mask.reshape(-1), size=capacity, fill_value=0)[0]
    order = (jnp.cumsum(mask.reshape(-1)) - 1).reshape(scenes, slots)
    filled = mask & (order < capacity)
    return _Packing(flat, flat // slots, jnp.clip(order, 0, capacity - 1), filled)


def _row_sums(y: Float[Array, "r d"], p: _Packing) -> Float[Array, "w d"]:
    return jnp.sum(jnp.where(p.filled[..., None], y[p.place], 0.0), axis=1)


def _pair_slots(y: Float[Array, "p d"], pairs: _Packing) -> Float[Array, "w n n d"]:
    scenes, square = pairs.filled.shape
    slots = round(square**0.5)
    padded = jnp.where(pairs.filled[..., None], y[pairs.place], 0.0)
    return padded.reshape(scenes, slots, slots, -1)


# The transpose of a gather is a scatter, which is slow. Every gather here has a
# gather for a transpose, because both directions are known from the packing.


@jax.custom_vjp
def _sum_rows(y: Float[Array, "r d"], p: _Packing) -> Float[Array, "w d"]:
    return _row_sums(y, p)


def _sum_rows_bwd(p: _Packing, g: Float[Array, "w d"]) -> tuple[Float[Array, "r d"], None]:
    used = (jnp.arange(p.group.shape[0]) < p.filled.sum())[:, None]
    return jnp.where(used, g[p.group], 0.0), None


_sum_rows.defvjp(lambda y, p: (_row_sums(y, p), p), _sum_rows_bwd)


@jax.custom_vjp
def _broadcast(a: Float[Array, "w d"], p: _Packing) -> Float[Array, "r d"]:
    return a[p.group]


_broadcast.defvjp(lambda a, p: (a[p.group], p), lambda p, g: (_row_sums(g, p), None))


@jax.custom_vjp
def _pair_up(
    u: Float[Array, "r d"], v: Float[Array, "r d"], ships: _Packing, pairs: _Packing
) -> Float[Array, "p d"]:
    i, j = _pair_rows(ships, pairs)
    return u[i] + v[j]


def _pair_up_bwd(res: tuple[_Packing, _Packing], g: Float[Array, "p d"]):
    ships, pairs = res
    square = _pair_slots(g, pairs)

    def to_rows(slots: Float[Array, "w n d"]) -> Float[Array, "r d"]:
        rows = slots.reshape(-1, slots.shape[-1])[ships.flat]
        used = (jnp.arange(rows.shape[0]) < ships.filled.sum())[:, None]
        return jnp.where(used, rows, 0.0)

    return to_rows(square.sum(2)), to_rows(square.sum(1)), None, None


_pair_up.defvjp(lambda u, v, s, p: (_pair_up(u, v, s, p), (s, p)), _pair_up_bwd)


@jax.custom_vjp
def _sum_pairs(y: Float[Array, "p d"], ships: _Packing, pairs: _Packing) -> Float[Array, "r d"]:
    slots = _pair_slots(y, pairs).sum(2)
    return slots.reshape(-1, slots.shape[-1])[ships.flat]


def _sum_pairs_bwd(res: tuple[_Packing, _Packing], g: Float[Array, "r d"]):
    ships, pairs = res
    i, _ = _pair_rows(ships, pairs)
    used = (jnp.arange(i.shape[0]) < pairs.filled.sum())[:, None]
    return jnp.where(used, g[i], 0.0), None, None


_sum_pairs.defvjp(lambda y, s, p: (_sum_pairs(y, s, p), (s, p)), _sum_pairs_bwd)


def _pair_rows(ships: _Packing, pairs: _Packing) -> tuple[Int[Array, " p"], Int[Array, " p"]]:
    slots = ships.filled.shape[1]
    pair = pairs.flat % (slots * slots)
    return ships.place[pairs.group, pair // slots], ships.place[pairs.group, pair % slots]


class Packed(eqx.Module):
    """The ships that are there, in order: shapes [rows, ...].

    ``capacity`` rows are kept; scenes whose ships do not all fit are marked by
    ``complete`` (they come last) and must be left out of a mean.
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
        scenes, slots = present.shape
        self.present = present
        self._ships = _pack(present, capacity)
        self._pairs = None
        if pair_capacity is not None:
            filled = self._ships.filled
            both = filled[:, :, None] & filled[:, None, :]
            self._pairs = _pack(both.reshape(scenes, slots * slots), pair_capacity)

    @property
    def complete(self) -> Bool[Array, " w"]:
        """Worlds all of whose ships (and pairs) have a row."""
        fits = jnp.all(self._ships.filled == self.present, axis=-1)
        if self._pairs is None:
            return fits
        count = self.present.sum(-1)
        return fits & (self._pairs.filled.sum(-1) == count * count)

    def to_rows(self, x: Shaped[Array, "..."]) -> Shaped[Array, "..."]:
        return x.reshape(-1, *x.shape[2:])[self._ships.flat]

    def broadcast(self, a: Float[Array, "w d"]) -> Float[Array, "r d"]:
        return _broadcast(a, self._ships)

    def sum_ships(self, y: Float[Array, "r d"]) -> Float[Array, "w d"]:
        return _sum_rows(y, self._ships)

    def softmax(self, y: Float[Array, " r"]) -> Float[Array, " r"]:
        alpha = _masked_softmax(self.to_slots(y), self._ships.filled)
        return alpha.reshape(-1)[self._ships.flat]

    def pairs(self, u: Float[Array, "r d"], v: Float[Array, "r d"]) -> Float[Array, "p d"]:
        return _pair_up(u, v, self._ships, self._paired)

    def sum_pairs(self, y: Float[Array, " p"]) -> Float[Array, " r"]:
        return _sum_pairs(y[:, None], self._ships, self._paired)[:, 0]

    def to_slots(self, y: Float[Array, " r"]) -> Float[Array, "w n"]:
        return jnp.where(self._ships.filled, y[self._ships.place], 0.0)

    @property
    def _paired(self) -> _Packing:
        assert self._pairs is not None, "give pair_capacity to use pairs"
        return self._pairs


ShipBatch = Padded | Packed


def _masked_softmax(y: Float[Array, "*b n"], mask: Bool[Array, "*b n"]) -> Float[Array, "*b n"]:
    """Softmax over the set entries; all zero where none is set."""
    if y.shape[-1] == 0:
        return y
    y = jnp.where(mask, y, _NEVER)
    weight = jnp.where(mask, jnp.exp(y - jax.lax.stop_gradient(y.max(-1, keepdims=True))), 0.0)
    return weight / jnp.maximum(weight.sum(-1, keepdims=True), 1e-30)
