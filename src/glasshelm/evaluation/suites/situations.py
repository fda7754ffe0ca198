"""DNV traffic situations: every file of a folder."""

import os
from pathlib import Path

from glasshelm.encounters.situation import read_situation
from glasshelm.errors import InputError
from glasshelm.evaluation.suites.stack import scenario_suite
from glasshelm.evaluation.types import Suite
from glasshelm.ships import ShipParams

#: Own ship avoids and comes back: so much longer than her route takes if nobody were there.
LONGER = 1.25


def situation_suite(folder: Path, ship: ShipParams) -> Suite:
    """The situations of a folder (or one file), each with its own length, beam and speed.

    Own ship keeps K, T and rudder of ``ship``. InputError if there is none, or one
    cannot be read.
    """
    files = sorted(folder.glob("*.json")) if os.path.isdir(folder) else [folder]
    if not files:
        raise InputError(f"{folder}: no situation in it (files ending in .json)")
    scenarios = [read_situation(file, ship) for file in files]
    least_s = LONGER * max(s.duration_s for s in scenarios)
    note = "DNV traffic situations; own ship has the length, beam and speed of the file"
    return scenario_suite("situations", note, scenarios, least_s)
