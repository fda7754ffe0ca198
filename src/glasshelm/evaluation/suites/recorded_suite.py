"""Windows cut from recorded AIS in which ships close to a given CPA; the pilot takes one's place.

A window is found by straight reckoning: at whole minutes, for each ship under way, who
would pass within the limit within the time limit. The first such minute of
a ship begins her window, and the next may begin only when it is over.
"""

import dataclasses
from datetime import UTC, datetime
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np

from glasshelm.ais.limits import LOST_AFTER_S
from glasshelm.ais.table import OWN_SENSORS, Recording, ReportTable
from glasshelm.core.errors import InputError
from glasshelm.encounters.recorded_traffic import RecordingSettings, scenario_from_excerpt
from glasshelm.encounters.recording_window import RECORDED, RecordingExcerpt, read_recording
from glasshelm.encounters.scenario_factory import BUNDLED
from glasshelm.encounters.snapshots import TrafficSnapshot, closest_approaches, snapshots
from glasshelm.encounters.types import Scenario
from glasshelm.evaluation.suites.batching import scenario_suite
from glasshelm.evaluation.types import Suite
from glasshelm.ship.nomoto import KNOT_M_S, NAUTICAL_MILE_M, ShipParams

#: Of the bundled recordings; the other one lasts ten minutes.
LONGEST = "new-york"
#: Own ship's waypoint is where she is so much later [s], if she is heard for as long.
HEADING_FOR_S = 3600.0
#: A ship silent for so long [s] begins anew.
SILENT_S = 6 * 3600.0


@dataclasses.dataclass(frozen=True)
class Windows:
    """Which windows are cut. SI units."""

    dcpa_m: float = 0.5 * NAUTICAL_MILE_M
    tcpa_s: tuple[float, float] = (180.0, 900.0)
    #: Ships nearer than this at the beginning are tugs at work and ships alongside.
    nearest_m: float = 0.5 * NAUTICAL_MILE_M
    slowest_m_s: float = 5.0 * KNOT_M_S
    lasts_s: float = 1200.0
    every_s: float = 60.0


@dataclasses.dataclass(frozen=True)
class Window:
    """Own ship's MMSI (``OWN_SENSORS``: the recorder), when it begins, which ship it closes on."""

    mmsi: int
    begins_s: float
    closing: tuple[int, ...]


def recorded_suites(paths: list[Path], ship: ShipParams) -> list[Suite]:
    """One suite a recording; without paths the bundled one that is long enough.

    InputError if a recording has no window.
    """
    if paths:
        return [_suite(path, path.name.split(".")[0], ship) for path in paths]
    with as_file(files("glasshelm") / "data" / BUNDLED[LONGEST][0]) as path:
        return [_suite(path, LONGEST, ship)]


def _suite(path: Path, name: str, ship: ShipParams, settings: Windows = Windows()) -> Suite:
    recording = read_recording(path)
    found = (
        _scenario(path, name, recording, window, ship, settings)
        for window in windows(recording.reports, settings)
    )
    scenarios = [scenario for scenario in found if scenario is not None]
    if not scenarios:
        raise InputError(f"{path}: no window in which ships under way close to a CPA")
    note = (
        f"Windows of {settings.lasts_s / 60:.0f} min of recorded AIS ({name}) that begin where a "
        f"ship closes another to within {settings.dcpa_m / NAUTICAL_MILE_M:g} NM in "
        f"{settings.tcpa_s[0] / 60:.0f} to {settings.tcpa_s[1] / 60:.0f} min; the pilot takes its "
        "place with its length and speed"
    )
    return scenario_suite(f"recorded-{name}", note, scenarios)


def _scenario(
    path: Path, name: str, recording: Recording, window: Window, ship: ShipParams, settings: Windows
) -> Scenario | None:
    own = RECORDED if window.mmsi == OWN_SENSORS else window.mmsi
    times = recording.reports.time_s
    around = (times > window.begins_s - LOST_AFTER_S) & (times <= window.begins_s + HEADING_FOR_S)
    traffic = Recording(recording.reports.take(around), recording.ships, recording.notes)
    try:
        part = RecordingExcerpt(traffic, window.mmsi, window.begins_s)
        found = scenario_from_excerpt(path, part, ship, RecordingSettings())
    except InputError:  # she goes nowhere after all
        return None
    at = datetime.fromtimestamp(window.begins_s, UTC)
    return dataclasses.replace(
        found,
        source=f"{name} --own {own} --at {at:%H:%M:%S}",
        duration_s=min(found.duration_s, settings.lasts_s),
    )


def windows(reports: ReportTable, settings: Windows = Windows()) -> list[Window]:
    """The windows of cleaned reports, in order of own ship and time."""
    ends = _last_heard(reports)
    free_from: dict[int, float] = {}
    found = []
    for ships in snapshots(reports, settings.every_s):
        speed = np.linalg.norm(ships.velocity_m_s, axis=-1)
        ships = ships.take(speed >= settings.slowest_m_s)
        for own, closing in _closing(ships, settings).items():
            time, last = ships.time_s, ends[own]
            # A ship must be heard long enough for the meeting to come, or her window ends before.
            later = last[np.searchsorted(last, time) :]
            heard = len(later) > 0 and later[0] - time >= settings.tcpa_s[1]
            if heard and time >= free_from.get(own, -np.inf):
                found.append(Window(own, time, tuple(sorted(closing))))
                free_from[own] = time + settings.lasts_s
    return sorted(found, key=lambda window: (window.mmsi, window.begins_s))


def _last_heard(reports: ReportTable) -> dict[int, np.ndarray]:
    """Of each ship the times after which she falls silent for long, in order; her last is one."""
    order = np.lexsort((reports.time_s, reports.mmsi))
    mmsi, time_s = reports.mmsi[order], reports.time_s[order]
    over = np.append((np.diff(mmsi) != 0) | (np.diff(time_s) > SILENT_S), True)
    ships, first = np.unique(mmsi[over], return_index=True)
    return dict(zip(ships.tolist(), np.split(time_s[over], first[1:]), strict=True))


def _closing(ships: TrafficSnapshot, settings: Windows) -> dict[int, list[int]]:
    """Of each ship those who would pass her within the limits."""
    if len(ships.mmsi) < 2:
        return {}
    fastest = float(np.linalg.norm(ships.velocity_m_s, axis=-1).max())
    pairs = ships.pairs(settings.dcpa_m + 2 * fastest * settings.tcpa_s[1])
    range_m, tcpa, dcpa = closest_approaches(ships, pairs)
    low, high = settings.tcpa_s
    near = (dcpa <= settings.dcpa_m) & (tcpa >= low) & (tcpa <= high)
    found: dict[int, list[int]] = {}
    for one, other in ships.mmsi[pairs[near & (range_m >= settings.nearest_m)]].tolist():
        found.setdefault(one, []).append(other)
        found.setdefault(other, []).append(one)
    return found
