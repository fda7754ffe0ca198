"""Sub-task critics (Eq. 19, Tables A.1-A.2): one value a sub-task, one a ship."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from glasshelm.env.observe import Observation
from glasshelm.networks.input_features import Lens, encode, input_size
from glasshelm.networks.mlp import Mlp, relu
from glasshelm.networks.ship_batch import Padded, ShipBatch


@dataclasses.dataclass(frozen=True)
class CriticSizes:
    """Layer widths. The defaults are Tables A.1-A.2."""

    hidden: tuple[int, ...] = (256, 256, 128)
    norm: bool = False
    lens: Lens = "flat"


class QValues(eqx.Module):
    """Q split by sub-task: ``waypoint`` [*b] and ``by_ship`` [*b, n] (0 in empty slots).

    ``helm`` is what the manoeuvre itself costs, where the actions are manoeuvres.
    """

    waypoint: Float[Array, "*b"]
    by_ship: Float[Array, "*b n"]
    helm: Float[Array, "*b"] | None = None

    @property
    def collision(self) -> Float[Array, "*b"]:
        return self.by_ship.sum(-1)

    @property
    def by_task(self) -> Float[Array, "*b 2"]:
        """In the order of :class:`glasshelm.env.rewards.SubTask`."""
        return jnp.stack([self.waypoint, self.collision], axis=-1)

    @property
    def total(self) -> Float[Array, "*b"]:
        """Q of Eq. 19: always the sum of its parts."""
        total = self.waypoint + self.collision
        return total if self.helm is None else total + self.helm


class SubTaskCritic(eqx.Module):
    """Q(s, a) = Q_wp(s_wp, a) + Σ_i Q_ca(s_i, a) (Eq. 19)."""

    of_waypoint: Mlp
    of_target: Mlp
    lens: Lens = eqx.field(static=True)

    def __init__(self, sizes: CriticSizes, key: PRNGKeyArray):
        waypoint_key, target_key = jax.random.split(key)
        self.of_waypoint = Mlp(
            (input_size(sizes.lens, "waypoint") + 1, *sizes.hidden, 1),
            relu,
            waypoint_key,
            sizes.norm,
        )
        self.of_target = Mlp(
            (input_size(sizes.lens, "target") + 1, *sizes.hidden, 1), relu, target_key, sizes.norm
        )
        self.lens = sizes.lens

    def __call__(
        self, observation: Observation, action: Float[Array, "*b"], ships: ShipBatch | None = None
    ) -> QValues:
        """Values of a rudder ``action`` (a fraction of the limit), head by head."""
        ships = Padded(observation.present) if ships is None else ships
        column = action[..., None]
        own = encode(self.lens, observation.waypoint)
        others = encode(self.lens, ships.to_rows(observation.targets))
        return QValues(
            _head(self.of_waypoint, own, column),
            ships.to_slots(_head(self.of_target, others, ships.broadcast(column))),
        )


def _head(
    mlp: Mlp, inputs: Float[Array, "*#r d"], action: Float[Array, "*#r 1"]
) -> Float[Array, "*r"]:
    """One head on [inputs, action]; the product of each is formed apart, the action last."""
    first = mlp.weights[0]
    return mlp.from_first_product(inputs @ first[:-1] + action * first[-1])[..., 0]
