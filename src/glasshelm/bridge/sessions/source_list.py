"""What the page may open: bundled names and generators, never a file of its own choice.

A file, a feed or a pilot named on the command line is on the list too, under its file name alone.
"""

import dataclasses
import threading
from pathlib import Path

from glasshelm.ais.reports import Feed
from glasshelm.bridge.server.protocol import Catalogue, PilotEntry, SourceEntry
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.core.errors import InputError, hide_paths
from glasshelm.encounters.imazu import imazu_cases
from glasshelm.encounters.random_encounters import FAMILIES
from glasshelm.encounters.scenario_factory import (
    BUNDLED,
    generated_scenario,
    recording_settings,
    scenario_from,
)
from glasshelm.encounters.types import Scenario
from glasshelm.feeds.feed_factory import create_feed
from glasshelm.pilots.course_pilot import CoursePilot
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.guarded import GuardedPilot
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.pilot_resolution import ship_of
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import DEFAULT_PILOT, METHODS, pilot_named, pilot_names
from glasshelm.ship.nomoto import ship_named

#: Before the name of a file: play it as live traffic.
LIVE_PREFIX = "live:"
_RECORDING_TITLES = {
    "gulf-of-finland": "Gulf of Finland, 10 minutes with a real own ship",
    "new-york": "New York harbour, one hour of AIS",
}
#: Random encounters that the menu offers; any other seed can be asked for.
_RANDOM = ("random:35", "random:7", "random:12:6", "wide:3", "converging:2")
_METHOD_TITLES = {
    "waypoint": "To the waypoint",
    "cpa": "CPA rule",
    "vo": "Velocity obstacles",
    "vo-colregs": "Velocity obstacles, COLREGs",
    "apf": "Potential field",
    "fuzzy": "Fuzzy risk",
    "mpc": "Scenario MPC",
}


class SourceList:
    """Scenarios, pilots and logs by the names the page may use.

    Args:
        log_index: The logs.
        source: The source of the command line, bundled or not.
        pilot: The pilot of the command line, bundled or not.
        signalk_token: A token of the Signal K server that ``source`` is; nobody else gets it.
        minutes: How much of recorded traffic is shown.
    """

    def __init__(
        self,
        log_index: LogIndex,
        source: str | None = None,
        pilot: str | None = None,
        signalk_token: str | None = None,
        minutes: float | None = None,
    ):
        self._log_index, self._signalk_token, self._recording = (
            log_index,
            signalk_token,
            recording_settings(minutes),
        )
        self._feed = source if source and is_live_source(source) else None
        simulated = source is not None and _is_built_in(source) and source not in BUNDLED
        if minutes is not None and (self._feed or simulated):
            raise InputError(f"{source}: minutes are of recorded traffic only")
        self._file = source if source and not (self._feed or _is_built_in(source)) else None
        self._weights = pilot if pilot and pilot not in pilot_names() else None
        self._pilots: dict[str, Pilot] = {}
        self._lock = threading.Lock()

    def catalogue(self) -> Catalogue:
        """Return the lists that the page gets."""
        pilots = [_pilot_entry(name, self.pilot(name)) for name in self._pilot_names()]
        return Catalogue(self._scenarios(), pilots, self._log_index.entries())

    def scenario(self, source: str, ship: str, own: str | None, at: str | None) -> Scenario:
        """Return the scenario of a name of the catalogue, or of a generator."""
        params = ship_named(ship)
        if source in BUNDLED:
            return scenario_from(source, params, own, at, self._recording)
        if _is_built_in(source):
            if own is not None or at is not None:
                raise InputError(f"{source}: own ship and time are of recorded traffic only")
            return generated_scenario(source, params)
        file = self._file
        if file is None or source not in (display_name(file), file):
            raise InputError(f"no source {source[:100]!r}: choose one of the catalogue")
        with hide_paths(display_name(file), file, Path(file)):
            scenario = scenario_from(file, params, own, at, self._recording)
        return dataclasses.replace(scenario, source=display_name(file))

    def is_live(self, source: str) -> bool:
        """Whether this names the feed of the command line."""
        return self._feed is not None and source in (self._feed, display_name(self._feed))

    def open_feed(self, own: str | None) -> Feed:
        """Open the feed of the command line."""
        if self._feed is None:
            raise InputError("no live traffic was named on the command line")
        address = self._feed.removeprefix(LIVE_PREFIX)
        with hide_paths(display_name(self._feed), address, Path(address)):
            return create_feed(address, own, self._signalk_token)

    def pilot(self, name: str) -> Pilot:
        """Return a pilot of the catalogue; it is read from disk once."""
        weights = self._weights
        if weights is not None and name == display_name(weights):
            name = weights
        with self._lock:
            if name not in self._pilots:
                if name != weights and name not in pilot_names():
                    raise InputError(f"no pilot {name[:100]!r}: choose one of the catalogue")
                self._pilots[name] = pilot_named(name)
            return self._pilots[name]

    def pilot_or_default(self, name: str | None) -> Pilot:
        """Return the pilot of that name, or the default pilot."""
        return self.pilot(DEFAULT_PILOT if name is None else name)

    def _pilot_names(self) -> tuple[str, ...]:
        extra = () if self._weights is None else (display_name(self._weights),)
        return (*extra, *pilot_names())

    def _scenarios(self) -> list[SourceEntry]:
        entries = []
        if self._feed is not None:
            name = display_name(self._feed)
            entries.append(SourceEntry(name, f"Live: {name}", "live"))
        if self._file is not None:
            name = display_name(self._file)
            is_json = ".json" in Path(self._file.lower()).suffixes
            entries.append(SourceEntry(name, name, "simulated" if is_json else "recorded"))
        entries += [SourceEntry(s, _RECORDING_TITLES.get(s, s), "recorded") for s in BUNDLED]
        for case, ships in imazu_cases().items():
            count = f"{len(ships)} {'ship' if len(ships) == 1 else 'ships'}"
            entries.append(SourceEntry(f"imazu:{case}", f"Imazu case {case}: {count}", "simulated"))
        for source in _RANDOM:
            family, _, seed = source.partition(":")
            title = f"{family.capitalize()} encounter, seed {seed.replace(':', ', ships: ')}"
            entries.append(SourceEntry(source, title, "simulated"))
        return entries


def display_name(source: str) -> str:
    """Return a source's name on the page: a path's file name, without its folder."""
    return source if "://" in source else Path(source.removeprefix(LIVE_PREFIX)).name


def is_live_source(source: str) -> bool:
    """Whether a source is live traffic."""
    return "://" in source or source.startswith(LIVE_PREFIX)


def _is_built_in(source: str) -> bool:
    """Whether a source is bundled or generated."""
    return source in BUNDLED or source.partition(":")[0] in (*FAMILIES, "imazu")


def _pilot_entry(name: str, pilot: Pilot) -> PilotEntry:
    ship, kind = ship_of(pilot), "classical"
    if isinstance(pilot, LearnedPilot):
        title, kind = f"Learned: {name}", "learned"
    elif isinstance(pilot, GuardedPilot):
        title, kind = f"Guarded: {name}", "learned"
    elif isinstance(pilot, GlassboxPilot):
        title, kind = f"Glassbox: {name}", "glassbox"
    elif isinstance(pilot, CoursePilot):
        method = next(name for name, method in METHODS.items() if method is pilot.method)
        title = f"{_METHOD_TITLES[method]}: {name}"
    else:
        title = "Keeps its course"
    return PilotEntry(name, title, kind, ship)
