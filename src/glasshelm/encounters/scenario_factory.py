"""One string names any encounter: random, designed, a situation file, recorded traffic."""

import dataclasses
import math
from datetime import datetime
from importlib.resources import as_file, files
from pathlib import Path

from glasshelm.ais.reading import kind_of
from glasshelm.core.errors import InputError, hide_paths
from glasshelm.encounters.dnv_situation import read_situation
from glasshelm.encounters.imazu import imazu_scenario
from glasshelm.encounters.random_encounters import FAMILIES, random_scenario
from glasshelm.encounters.recorded_traffic import RecordingSettings, recorded_scenario
from glasshelm.encounters.types import Scenario
from glasshelm.ship.nomoto import ShipParams

#: Recordings that come with the package (data/README.md): name -> file, own ship if none is named.
BUNDLED: dict[str, tuple[str, str | None]] = {
    "gulf-of-finland": ("gulf_of_finland.csv.gz", None),
    "new-york": ("new_york.csv.gz", "367000190"),
}
SOURCES = (
    "random:SEED, random:SEED:SHIPS, wide:SEED, converging:SEED, "
    "imazu:1 to imazu:22, imazu:8b, imazu:12b, "
    f"{', '.join(BUNDLED)}, or a file: a DNV traffic situation (json), "
    "a table of AIS (csv, parquet), or sentences (nmea)"
)
MAX_SHIPS = 500
_LARGEST_SEED = 2**31 - 1


def scenario_from(
    source: str,
    ship: ShipParams,
    own: int | str | None = None,
    at: str | datetime | None = None,
    settings: RecordingSettings = RecordingSettings(),
) -> Scenario:
    """The scenario that a source string names.

    ``random:7`` is the random encounter of seed 7, ``random:7:3`` one of
    exactly 3 ships; ``wide:7`` one of the wider distribution that pilots are
    trained on, ``converging:7`` one of ships that go much the same way;
    ``imazu:8b`` a designed case; ``gulf-of-finland`` and ``new-york`` are
    recordings that come with the package; anything else is a file.

    Args:
        source: The source string.
        ship: Own ship.
        own: As :func:`~glasshelm.encounters.recorded_traffic.recorded_scenario`.
        at: The same.
        settings: The same.

    Raises:
        InputError: The source is unknown (the message lists what is possible), or unusable.
    """
    source = source.strip()
    kind = source.partition(":")[0]
    if source in BUNDLED:
        file, default_own = BUNDLED[source]
        with as_file(files("glasshelm") / "data" / file) as path, hide_paths(source, path):
            chosen = default_own if own is None else own
            scenario = recorded_scenario(path, ship, chosen, at, settings)
        return dataclasses.replace(scenario, source=source)
    path = Path(source)
    if kind in (*FAMILIES, "imazu") and not _is_file(path):
        _only_recorded(source, own, at, settings)
        return generated_scenario(source, ship)
    if not _is_file(path):
        raise InputError(f"no source {source[:200]!r} (nor such a file): choose {SOURCES}")
    if kind_of(path) == "json":
        _only_recorded(source, own, at, settings)
        return read_situation(path, ship)
    return recorded_scenario(path, ship, own, at, settings)


def recording_settings(minutes: float | None) -> RecordingSettings:
    """Settings to read so much of a recording; None: as long as own ship is recorded."""
    if minutes is None:
        return RecordingSettings()
    if not 0 < minutes < math.inf:
        raise InputError(f"{minutes:g} minutes: must be more than 0")
    return RecordingSettings(duration_s=60.0 * minutes)


def generated_scenario(source: str, ship: ShipParams) -> Scenario:
    """The scenario of a generator (``random:7``, ``imazu:8b``); no file is ever looked at."""
    kind, _, rest = source.partition(":")
    if kind == "imazu":
        return imazu_scenario(rest, ship)
    if kind not in FAMILIES:
        raise InputError(f"no source {source!r}: choose {', '.join((*FAMILIES, 'imazu'))}")
    return _random(kind, rest, ship)


def _random(family: str, rest: str, ship: ShipParams) -> Scenario:
    source = f"{family}:{rest}"
    seed, _, count = rest.partition(":")
    given = [seed] if ":" not in rest else [seed, count]
    if not all(text.isascii() and text.isdigit() for text in given):
        raise InputError(
            f"{source!r}: must be {family}:SEED or {family}:SEED:SHIPS (whole numbers)"
        )
    if int(seed) > _LARGEST_SEED:
        raise InputError(f"{source!r}: the seed must be at most {_LARGEST_SEED}")
    settings = FAMILIES[family]
    if len(given) > 1:
        ships = int(count)
        if ships > MAX_SHIPS:
            raise InputError(f"{source!r}: at most {MAX_SHIPS} ships")
        settings = dataclasses.replace(settings, targets=(ships, ships))
    return random_scenario(int(seed), ship, settings)


def _only_recorded(source: str, own: object, at: object, settings: RecordingSettings) -> None:
    given = {"an own ship": own, "a start time": at, "a number of minutes": settings.duration_s}
    for what, value in given.items():
        if value is not None:
            raise InputError(f"{source}: {what} can be chosen only in recorded traffic")


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that no file can have
        return False
