"""Which ship is sailed where only the pilot is named: the one that he was made for."""

from glasshelm.errors import InputError
from glasshelm.evaluation.entrants import ship_of
from glasshelm.pilots.types import Pilot

#: The ship where neither a pilot with a ship of his own nor a ship is named.
SHIP = "paper"


def ship_for(pilot: Pilot, ship: str | None) -> str:
    """The name of the preset ship: as asked for, or else the pilot's own, or else ``SHIP``."""
    if ship is not None:
        return ship
    try:
        return ship_of(pilot) or SHIP
    except InputError as error:
        raise InputError(f"{error}; choose one with --ship") from None
