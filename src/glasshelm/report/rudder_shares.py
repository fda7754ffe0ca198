"""A rudder cut into its shares: what it would be with no other ship, and what each ship adds."""

import dataclasses
import math

import numpy as np

from glasshelm.frames.series import Series, ShipSeries, TimeSeries

#: A share below this is not said: to the tenth of a degree it is nothing.
NEGLIGIBLE_RAD = float(np.radians(0.05))


@dataclasses.dataclass(frozen=True)
class Share:
    """What one ship adds to the rudder, as a size [rad]; to which side, her list says."""

    ship: ShipSeries
    size_rad: float


@dataclasses.dataclass(frozen=True)
class RudderShares:
    """The rudder and its shares, means over some frames.

    ``way`` is the side of the rudder (1 starboard, −1 port). ``rudder_rad`` and ``base_rad`` are
    + to that side. ``supporting`` are the ships that move the rudder that way,
    ``opposing`` those that move it the other way, the largest share first. The base and the
    supporting shares, less the opposing ones, add up to the rudder.
    """

    way: float
    rudder_rad: float
    base_rad: float
    supporting: list[Share]
    opposing: list[Share]


def rudder_shares(voyage: Series, at: np.ndarray) -> RudderShares | None:
    """The shares in those of these frames that have any; None if none has."""
    at = at[np.isfinite(voyage.base_rad[at])]
    if not at.size:
        return None
    rudder = float(voyage.rudder_rad[at].mean())
    way = float(np.sign(rudder)) or 1.0
    found = [(s, way * _mean(s.shapley_rad[at])) for s in voyage.ships]
    found.sort(key=lambda one: -abs(one[1]))
    return RudderShares(
        way,
        way * rudder,
        way * float(voyage.base_rad[at].mean()),
        [Share(s, x) for s, x in found if x > 0],
        [Share(s, -x) for s, x in found if x < 0],
    )


def total(some: list[Share]) -> float:
    """What some ships add together [rad]."""
    return math.fsum(one.size_rad for one in some)


def largest(some: list[Share]) -> list[Share]:
    """The fewest of them, the largest first, who make up their total to the tenth of a degree."""
    left = total(some)
    for count, one in enumerate(some):
        if left < NEGLIGIBLE_RAD:
            return some[:count]
        left -= one.size_rad
    return some


def _mean(row: TimeSeries) -> float:
    """The mean share, where a ship who is not there has none: means then add up, too."""
    return float(np.nan_to_num(row).mean())
