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

from glasshelm.ais.table import OWN_SENSORS, Reports
from glasshelm.encounters.projection import Plane
from glasshelm.encounters.recorded import (
    LOST_AFTER_S,
    RecordingSettings,
    read_recording,
    recorded_scenario,
)
from glasshelm.encounters.source import BUNDLED
from glasshelm.encounters.types import Scenario
from glasshelm.errors import InputError
from glasshelm.evaluation.suites.stack import scenario_suite
from glasshelm.evaluation.types import Suite
from glasshelm.ships import KNOT_M_S, NAUTICAL_MILE_M, ShipParams

#: Of the bundled recordings; the other one lasts ten minutes.
LONGEST = "new-york"


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
    """Own ship's MMSI (``OWN_SENSORS``: the recorder), when it begins, whom she closes."""

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
    reports = read_recording(path).reports
    scenarios = []
    for window in windows(reports, settings):
        scenario = _scenario(path, name, window, ship, settings)
        if scenario is not None:
            scenarios.append(scenario)
    if not scenarios:
        raise InputError(f"{path}: no window in which ships under way close to a CPA")
    note = (
        f"Windows of {settings.lasts_s / 60:.0f} min of recorded AIS ({name}) that begin where a "
        f"ship closes another to within {settings.dcpa_m / NAUTICAL_MILE_M:g} NM in "
        f"{settings.tcpa_s[0] / 60:.0f} to {settings.tcpa_s[1] / 60:.0f} min; the pilot takes her "
        "place with her length and speed"
    )
    return scenario_suite(f"recorded-{name}", note, scenarios)


def _scenario(
    path: Path, name: str, window: Window, ship: ShipParams, settings: Windows
) -> Scenario | None:
    at = datetime.fromtimestamp(window.begins_s, UTC)
    own = "recorded" if window.mmsi == OWN_SENSORS else window.mmsi
    try:
        found = recorded_scenario(path, ship, own, at, RecordingSettings())
    except InputError:  # she goes nowhere after all
        return None
    return dataclasses.replace(
        found,
        source=f"{name} --own {own} --at {at:%H:%M:%S}",
        duration_s=min(found.duration_s, settings.lasts_s),
    )


def windows(reports: Reports, settings: Windows = Windows()) -> list[Window]:
    """The windows of cleaned reports, in order of own ship and time."""
    ships = [int(n) for n in np.unique(reports.mmsi)]
    plane = Plane(float(np.median(reports.latitude_deg)), float(np.median(reports.longitude_deg)))
    first, last = reports.time_s.min(), reports.time_s.max()
    grid = np.arange(first, last - settings.tcpa_s[0], settings.every_s)
    place, motion, here = _reckoned(reports, ships, plane, grid)
    # A ship must be heard long enough for the meeting to come, or her window ends before it.
    ends = np.array([reports.time_s[reports.mmsi == ship].max() for ship in ships])
    found = []
    for i, mmsi in enumerate(ships):
        free_from = -np.inf
        for k, time in enumerate(grid):
            enough = ends[i] - time >= settings.tcpa_s[1]
            if time < free_from or not here[i, k] or not enough:
                continue
            closing = _closing(i, place[:, k], motion[:, k], here[:, k], settings)
            if len(closing):
                found.append(Window(mmsi, float(time), tuple(ships[j] for j in closing)))
                free_from = time + settings.lasts_s
    return found


def _reckoned(
    reports: Reports, ships: list[int], plane: Plane, grid: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places [ships, times, 2], velocities and who is there, from each ship's latest report."""
    shape = (len(ships), len(grid))
    place, motion, here = np.zeros((*shape, 2)), np.zeros((*shape, 2)), np.zeros(shape, bool)
    east, north = plane.to_plane(reports.latitude_deg, reports.longitude_deg)
    speed, course = reports.sog_kn * KNOT_M_S, np.radians(reports.cog_deg)
    velocity = np.stack([speed * np.sin(course), speed * np.cos(course)], axis=-1)
    for i, ship in enumerate(ships):
        rows = np.flatnonzero(reports.mmsi == ship)
        latest = np.searchsorted(reports.time_s[rows], grid, side="right") - 1
        row = rows[np.maximum(latest, 0)]
        age = grid - reports.time_s[row]
        here[i] = (latest >= 0) & (age < LOST_AFTER_S)
        motion[i] = velocity[row]
        place[i] = np.stack([east[row], north[row]], -1) + velocity[row] * age[:, None]
    return place, motion, here


def _closing(
    own: int, place: np.ndarray, motion: np.ndarray, here: np.ndarray, settings: Windows
) -> np.ndarray:
    """The ships under way that would pass ``own`` within the limits."""
    away, relative = place - place[own], motion - motion[own]
    square = np.maximum(np.sum(relative**2, -1), 1e-6)
    tcpa = -np.sum(away * relative, -1) / square
    dcpa = np.linalg.norm(away + relative * tcpa[:, None], axis=-1)
    under_way = here & (np.linalg.norm(motion, axis=-1) >= settings.slowest_m_s)
    if not under_way[own]:
        return np.zeros(0, int)
    low, high = settings.tcpa_s
    near = (dcpa <= settings.dcpa_m) & (tcpa >= low) & (tcpa <= high)
    apart = np.linalg.norm(away, axis=-1) >= settings.nearest_m
    return np.flatnonzero(near & under_way & apart & (np.arange(len(here)) != own))
