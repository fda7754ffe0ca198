"""DNV traffic situations: every file of a folder."""

import os
import re
from pathlib import Path

from glasshelm.core.errors import InputError
from glasshelm.encounters.dnv_situation import read_situation
from glasshelm.evaluation.suites.batching import scenario_suite
from glasshelm.evaluation.types import Suite
from glasshelm.ship.nomoto import ShipParams

#: A case lasts so many times as long as own ship needs without traffic: it avoids and comes back.
LONGER = 1.25
_SHOWN = 5  # names in a message


def situation_suite(folder: Path, ship: ShipParams) -> Suite:
    """The situations of a folder (or one file), each with its own length, beam and speed.

    Own ship keeps K, T and rudder of ``ship``. InputError if there is none, or
    names the first that cannot be read, and which others.
    """
    files = sorted(filter(_is_json, folder.iterdir())) if os.path.isdir(folder) else [folder]
    if not files:
        raise InputError(f"{folder}: no situation in it (files ending in .json)")
    scenarios, wrong = [], {}
    for file in files:
        try:
            scenarios.append(read_situation(file, ship))
        except InputError as error:
            wrong[file.name] = error
    if wrong:
        shown = ", ".join(list(wrong)[:_SHOWN]) + (", …" if len(wrong) > _SHOWN else "")
        which = f" ({len(wrong)} of {len(files)} files: {shown})" if len(files) > 1 else ""
        raise InputError(f"{next(iter(wrong.values()))}{which}")
    least_s = LONGER * max(s.duration_s for s in scenarios)
    note = "DNV traffic situations; own ship has the length, beam and speed of the file"
    return scenario_suite("situations", note, scenarios, least_s)


def _is_json(path: Path) -> bool:
    """Whether a file's name says JSON, packed or not; hidden files do not count."""
    name = re.sub(r"\.(gz|zst|bz2|xz|zip)$", "", path.name.lower())
    return name.endswith(".json") and not name.startswith(".") and path.is_file()
