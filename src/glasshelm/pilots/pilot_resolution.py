"""Who sails which ship where only one of the two is named, or neither."""

from glasshelm.core.errors import InputError
from glasshelm.evaluation.contenders import ship_of
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import default_pilot, pilot_named
from glasshelm.ship.nomoto import ShipParams, ship_named

#: The ship where neither a pilot with a ship of his own nor a ship is named.
DEFAULT_SHIP = "paper"


def resolve_pilot_and_ship(pilot: str | None, ship: str | None) -> tuple[Pilot, ShipParams]:
    """The pilot and the ship of these names; by default the ship's pilot, the pilot's ship."""
    helm = pilot_named(default_pilot(ship or DEFAULT_SHIP) if pilot is None else pilot)
    return helm, ship_named(ship_for(helm, ship))


def ship_for(pilot: Pilot, ship: str | None) -> str:
    """The name of the preset ship: as asked for, or else the pilot's own, or else ``SHIP``."""
    if ship is not None:
        return ship
    try:
        return ship_of(pilot) or DEFAULT_SHIP
    except InputError as error:
        raise InputError(f"{error}; choose one with --ship") from None
