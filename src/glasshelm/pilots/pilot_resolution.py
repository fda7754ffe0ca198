"""Which pilot steers which ship, where only one of the two is named, or neither."""

import dataclasses

import numpy as np

from glasshelm.core.errors import InputError
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import DEFAULT_PILOT, pilot_named
from glasshelm.ship.nomoto import SHIPS, ShipParams, ship_named

#: The ship where neither a pilot with a ship of its own nor a ship is named.
DEFAULT_SHIP = "paper"


def resolve_pilot_and_ship(pilot: str | None, ship: str | None) -> tuple[Pilot, ShipParams]:
    """The pilot and the ship of these names; by default :data:`DEFAULT_PILOT`, the pilot's ship."""
    chosen = pilot_named(DEFAULT_PILOT if pilot is None else pilot)
    return chosen, ship_named(ship_for(chosen, ship))


def ship_for(pilot: Pilot, ship: str | None) -> str:
    """The name of the preset ship: as asked for, or the pilot's own, or :data:`DEFAULT_SHIP`."""
    if ship is not None:
        return ship
    try:
        return ship_of(pilot) or DEFAULT_SHIP
    except InputError as error:
        raise InputError(f"{error}; choose one with --ship") from None


def ship_of(pilot: object) -> str | None:
    """The name of the preset ship that a pilot was made for; None if for any.

    Raises:
        InputError: It was made for a ship that is no preset.
    """
    ship = getattr(pilot, "ship", None)
    if not isinstance(ship, ShipParams):
        return None
    values = tuple(map(float, dataclasses.astuple(ship)))
    for name, preset in SHIPS.items():
        if np.allclose(values, tuple(map(float, dataclasses.astuple(preset))), rtol=1e-6):
            return name
    name = getattr(pilot, "name", "?")
    raise InputError(f"pilot {name!r} is for a ship that is none of {', '.join(SHIPS)}")
