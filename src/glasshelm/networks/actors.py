"""Actors for any number of ships: sum (Eq. 20-21) and attention (Eq. 23).

An actor returns the rudder as a fraction of the limit, in (−1, 1), starboard
positive. ``ships`` chooses padded slots (default) or packed rows.
"""

import dataclasses
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.core.errors import InputError
from glasshelm.env.observe import Observation
from glasshelm.networks.input_features import Lens, encode, input_size
from glasshelm.networks.mlp import Mlp, leaky_relu, softsign
from glasshelm.networks.ship_batch import Padded, ShipBatch

#: Anything that steers as an actor does: observations -> rudders in [−1, 1].
Policy = Callable[[Observation], Float[Array, "*b"]]


@dataclasses.dataclass(frozen=True)
class ActorSizes:
    """Layer widths. Defaults: Tables A.3-A.5; for attention, docs/explanation/paper.md."""

    encoder: tuple[int, ...] = (256, 256, 128)
    head: tuple[int, ...] = (256, 256, 128)
    attention: tuple[int, ...] = (128, 128)
    lens: Lens = "flat"


class SumActor(eqx.Module):
    """π(s) = A(softsign(E_wp(s_wp) + Σ_i E_oth(s_i))) (Eq. 20-21)."""

    encode_waypoint: Mlp
    encode_target: Mlp
    head: Mlp
    lens: Lens = eqx.field(static=True)

    def __init__(self, sizes: ActorSizes, key: PRNGKeyArray):
        waypoint_key, target_key, head_key = jax.random.split(key, 3)
        self.encode_waypoint, self.encode_target, self.head = _parts(
            sizes, waypoint_key, target_key, head_key
        )
        self.lens = sizes.lens

    def __call__(
        self, observation: Observation, ships: ShipBatch | None = None
    ) -> Float[Array, "*b"]:
        ships = Padded(observation.present) if ships is None else ships
        traffic = ships.sum_ships(
            self.encode_target(encode(self.lens, ships.to_rows(observation.targets)))
        )
        own = self.encode_waypoint(encode(self.lens, observation.waypoint))
        return softsign(self.head(softsign(own + traffic)))[..., 0]


class AttentionActor(eqx.Module):
    """The sum replaced by an average weighted with attention (Eq. 23, Fig. 12)."""

    encode_waypoint: Mlp
    encode_target: Mlp
    head: Mlp
    score: Mlp
    lens: Lens = eqx.field(static=True)

    def __init__(self, sizes: ActorSizes, key: PRNGKeyArray):
        waypoint_key, target_key, head_key, score_key = jax.random.split(key, 4)
        self.encode_waypoint, self.encode_target, self.head = _parts(
            sizes, waypoint_key, target_key, head_key
        )
        pair = 2 * input_size(sizes.lens, "target")
        self.score = Mlp((pair, *sizes.attention, 1), leaky_relu, score_key)
        self.lens = sizes.lens

    def __call__(
        self, observation: Observation, ships: ShipBatch | None = None
    ) -> Float[Array, "*b"]:
        ships = Padded(observation.present) if ships is None else ships
        inputs = encode(self.lens, ships.to_rows(observation.targets))
        alpha = self._attend(inputs, ships)
        traffic = ships.sum_ships(alpha[..., None] * self.encode_target(inputs))
        own = self.encode_waypoint(encode(self.lens, observation.waypoint))
        return softsign(self.head(softsign(own + traffic)))[..., 0]

    def attention(self, observation: Observation) -> Float[Array, "*b n"]:
        """α of every slot (Eq. 23): sums to 1 over the ships present, 0 elsewhere."""
        ships = Padded(observation.present)
        return ships.to_slots(self._attend(encode(self.lens, observation.targets), ships))

    def _attend(self, inputs: Float[Array, "*r d"], ships: ShipBatch) -> Float[Array, "*r"]:
        first, second = jnp.split(self.score.weights[0], 2)  # of s_i and of s_j
        score = self.score.from_first_product(ships.pairs(inputs @ first, inputs @ second))[..., 0]
        return ships.softmax(ships.sum_pairs(score))


Actor = SumActor | AttentionActor


def make_actor(kind: str, sizes: ActorSizes, key: PRNGKeyArray) -> Actor:
    """A new actor of kind ``sum`` or ``attention``."""
    if kind == "sum":
        return SumActor(sizes, key)
    if kind == "attention":
        return AttentionActor(sizes, key)
    raise InputError(f"unknown actor {kind!r}: choose sum or attention")


def _parts(
    sizes: ActorSizes, waypoint_key: PRNGKeyArray, target_key: PRNGKeyArray, head_key: PRNGKeyArray
) -> tuple[Mlp, Mlp, Mlp]:
    width = sizes.encoder[-1]
    return (
        Mlp((input_size(sizes.lens, "waypoint"), *sizes.encoder), leaky_relu, waypoint_key),
        Mlp((input_size(sizes.lens, "target"), *sizes.encoder), leaky_relu, target_key),
        Mlp((width, *sizes.head, 1), leaky_relu, head_key),
    )
