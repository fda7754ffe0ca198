"""Interval arithmetic, and the interval extension of any smooth scalar function.

An interval is a pair of arrays that holds a number for certain. Every result is
widened by a few units in the last place of a float32, more than one
operation can lose. A function is extended through its jaxpr, so that JAX differentiates
and intervals enclose: the extension of ``jax.jvp`` bounds a derivative over a box.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

_WIDEN = 4 * 2.0**-24
_TINY = 1e-35


class Interval(NamedTuple):
    """All numbers from ``low`` to ``high``."""

    low: Float[Array, "..."]
    high: Float[Array, "..."]

    @property
    def middle(self) -> Float[Array, "..."]:
        return 0.5 * self.low + 0.5 * self.high

    @property
    def radius(self) -> Float[Array, "..."]:
        """Half the width, with room for what the middle lost."""
        half = jnp.maximum(self.high - self.middle, self.middle - self.low)
        return half + _WIDEN * (half + jnp.abs(self.middle))

    @property
    def size(self) -> Float[Array, "..."]:
        """The largest absolute value in it."""
        return jnp.maximum(jnp.abs(self.low), jnp.abs(self.high))


def exactly(x: Float[Array, "..."]) -> Interval:
    """One number."""
    return Interval(x, x)


def around(x: Float[Array, "..."], radius: Float[Array, "..."]) -> Interval:
    """All numbers within a radius of x."""
    return _out(x - radius, x + radius)


def hull(a: Interval, b: Interval) -> Interval:
    """The smallest interval that holds both."""
    return Interval(jnp.minimum(a.low, b.low), jnp.maximum(a.high, b.high))


def _out(low: Array, high: Array) -> Interval:
    """Widened; what is not a number could be any."""
    low = jnp.where(jnp.isnan(low), -jnp.inf, low)
    high = jnp.where(jnp.isnan(high), jnp.inf, high)
    return Interval(low - _WIDEN * jnp.abs(low) - _TINY, high + _WIDEN * jnp.abs(high) + _TINY)


def add(a: Interval, b: Interval) -> Interval:
    return _out(a.low + b.low, a.high + b.high)


def negative(a: Interval) -> Interval:
    return Interval(-a.high, -a.low)


def subtract(a: Interval, b: Interval) -> Interval:
    return add(a, negative(b))


def multiply(a: Interval, b: Interval) -> Interval:
    corners = [a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high]
    low, high = corners[0], corners[0]
    for corner in corners[1:]:
        # NaN (0·∞) must survive here: minimum and maximum pass it on.
        low, high = jnp.minimum(low, corner), jnp.maximum(high, corner)
    return _out(low, high)


def reciprocal(a: Interval) -> Interval:
    """1/a; everything where a may be 0."""
    safe = (a.low > 0) | (a.high < 0)
    low, high = jnp.where(safe, a.low, 1.0), jnp.where(safe, a.high, 1.0)
    found = _out(1.0 / high, 1.0 / low)
    return Interval(jnp.where(safe, found.low, -jnp.inf), jnp.where(safe, found.high, jnp.inf))


def power(a: Interval, exponent: int) -> Interval:
    """a to a whole power, as one operation: a square is never negative."""
    if exponent < 0:
        return reciprocal(power(a, -exponent))
    ends = [a.low**exponent, a.high**exponent]
    low, high = jnp.minimum(*ends), jnp.maximum(*ends)
    if exponent % 2 == 0:
        low = jnp.where((a.low <= 0) & (a.high >= 0), 0.0, low)
    # x·x·… loses half a unit a factor.
    out = Interval(low - exponent * _WIDEN * jnp.abs(low), high + exponent * _WIDEN * jnp.abs(high))
    return _out(*out)


def square_root(a: Interval) -> Interval:
    """Of what is not negative."""
    found = _out(jnp.sqrt(jnp.maximum(a.low, 0.0)), jnp.sqrt(jnp.maximum(a.high, 0.0)))
    return Interval(jnp.maximum(found.low, 0.0), found.high)


def cosine(a: Interval) -> Interval:
    """Monotone between whole half turns; 1 or −1 where such a one lies inside."""
    ends = [jnp.cos(a.low), jnp.cos(a.high)]
    # The rounding of a large argument and of the cosine itself.
    lost = 4e-7 + 2.0**-22 * a.size
    low, high = jnp.minimum(*ends) - lost, jnp.maximum(*ends) + lost

    def holds(phase: float) -> Array:
        turn = 2 * math.pi
        first = jnp.ceil((a.low - phase) / turn - 1e-6)
        return first * turn + phase <= a.high + 1e-6

    high = jnp.where(holds(0.0), 1.0, jnp.minimum(high, 1.0))
    low = jnp.where(holds(math.pi), -1.0, jnp.maximum(low, -1.0))
    return Interval(low, high)


def sine(a: Interval) -> Interval:
    quarter = exactly(jnp.full_like(a.low, 0.5 * math.pi))
    return cosine(subtract(a, quarter))


def _any_angle(y: Interval, x: Interval) -> Interval:
    """arctan2, whose derivatives are wanted but not its value."""
    return Interval(jnp.full_like(y.low, -math.pi - 1e-6), jnp.full_like(y.low, math.pi + 1e-6))


_RULES: dict[str, Callable[..., Interval]] = {
    "add": add,
    "add_any": add,
    "sub": subtract,
    "mul": multiply,
    "neg": negative,
    "div": lambda a, b: multiply(a, reciprocal(b)),
    "sqrt": square_root,
    "rsqrt": lambda a: reciprocal(square_root(a)),
    "square": lambda a: power(a, 2),
    "sin": sine,
    "cos": cosine,
    "atan2": _any_angle,
}


def extension(f: Callable[..., Any], count: int) -> Callable[..., list[Interval]]:
    """The interval extension of a smooth function of ``count`` scalars with any outputs.

    Arguments and results are intervals of any common shape. Factors that are 0 whatever the
    arguments are left out.
    """
    jaxpr = jax.make_jaxpr(f)(*[jax.ShapeDtypeStruct((), jnp.float32)] * count)

    def extended(*boxes: Interval) -> list[Interval]:
        like = boxes[0].low
        found = _evaluate(jaxpr.jaxpr, jaxpr.consts, boxes)
        whole = [exactly(jnp.full_like(like, x)) if isinstance(x, float) else x for x in found]
        return [Interval(*(jnp.broadcast_to(e, like.shape) for e in x)) for x in whole]

    return extended


def _evaluate(jaxpr: Any, consts: Sequence[Any], args: Sequence[Any]) -> list[Any]:
    """Every equation in turn; a known constant stays a float."""
    known: dict[Any, Any] = dict(zip(jaxpr.constvars, map(float, consts), strict=True))
    known.update(zip(jaxpr.invars, args, strict=True))

    def value(atom: Any) -> Any:
        return float(atom.val) if hasattr(atom, "val") else known[atom]

    for eqn in jaxpr.eqns:
        given = [value(atom) for atom in eqn.invars]
        name = eqn.primitive.name
        if name in ("jit", "pjit"):
            inner = eqn.params["jaxpr"]
            out = _evaluate(inner.jaxpr, inner.consts, given)
        else:
            out = [_apply(name, eqn.params, given)]
        known.update(zip(eqn.outvars, out, strict=True))
    return [value(atom) for atom in jaxpr.outvars]


def _apply(name: str, params: dict[str, Any], given: list[Any]) -> Any:
    if name in ("convert_element_type", "copy", "broadcast_in_dim"):
        return given[0]
    if name == "mul" and 0.0 in given:
        return 0.0
    if name in ("mul", "div") and given[1] == 1.0:
        return given[0]
    if name == "mul" and given[0] == 1.0:
        return given[1]
    if name == "div" and given[0] == 0.0:
        return 0.0
    if name in ("add", "add_any") and 0.0 in given:
        return given[1] if given[0] == 0.0 else given[0]
    if name == "sub" and given[1] == 0.0:
        return given[0]
    if name == "neg" and isinstance(given[0], float):
        return -given[0]
    boxes = [exactly(jnp.asarray(x, jnp.float32)) if isinstance(x, float) else x for x in given]
    if name == "integer_pow":
        return power(boxes[0], params["y"])
    if name not in _RULES:
        raise NotImplementedError(f"no interval rule for {name}")
    return _RULES[name](*boxes)
