"""What may be opened from the page: bundled names and generators, never a file of the disk.

A file, a feed or a pilot that the user named on the command line is on the
list too, under its last name alone.
"""

import dataclasses
import threading
from pathlib import Path

from glasshelm.ais.reports import Feed
from glasshelm.bridge.server import protocol
from glasshelm.bridge.server.protocol import PilotCard, Source
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
from glasshelm.pilots.guarded import GuardedPilot
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.pilot_resolution import ship_of
from glasshelm.pilots.planner import PLANNER
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import METHODS, default_pilot, pilot_named, pilot_names
from glasshelm.ship.nomoto import ShipParams, ship_named

#: Before a file: it is played as if its traffic were here and now.
LIVE = "live:"
_RECORDINGS = {
    "gulf-of-finland": "Gulf of Finland, 10 minutes with a real own ship",
    "new-york": "New York harbour, one hour of AIS",
}
#: Random encounters that the menu offers; any other seed can be asked for.
_RANDOM = ("random:35", "random:7", "random:12:6", "wide:3", "converging:2")


#: The ways of choosing courses as the page calls them.
TITLES = {
    "waypoint": "To the waypoint",
    "cpa": "CPA rule",
    "vo": "Velocity obstacles",
    "vo-colregs": "Velocity obstacles, COLREGs",
    "apf": "Potential field",
    "fuzzy": "Fuzzy risk",
    "mpc": "Scenario MPC",
    "planner": "Planner",
}


class SourceList:
    """Scenarios, pilots and logs by the names that the page may use.

    ``source`` and ``pilot`` are what the command line named, if not bundled; ``token`` is of
    the server that ``source`` is, and nobody else gets it; ``minutes`` is how much of recorded
    traffic is shown.
    """

    def __init__(
        self,
        shelf: LogIndex,
        source: str | None = None,
        pilot: str | None = None,
        token: str | None = None,
        minutes: float | None = None,
    ):
        self.shelf, self._token, self._cut = shelf, token, recording_settings(minutes)
        self.feed = source if source and is_feed(source) else None
        simulated = source is not None and _known(source) and source not in BUNDLED
        if minutes is not None and (self.feed or simulated):
            raise InputError(f"{source}: minutes are of recorded traffic only")
        self._file = source if source and not (self.feed or _known(source)) else None
        self._weights = pilot if pilot and pilot not in pilot_names() else None
        self._pilots: dict[str, Pilot] = {}
        self._reading = threading.Lock()

    def told(self) -> protocol.Catalogue:
        """The lists as the page gets them."""
        cards = [_card(name, self.pilot(name)) for name in self._pilot_names()]
        return protocol.Catalogue(self._scenarios(), cards, self.shelf.cards())

    def scenario(self, source: str, ship: str, own: str | None, at: str | None) -> Scenario:
        """The scenario of a name of the catalogue, or of a generator."""
        params = ship_named(ship)
        if source in BUNDLED:
            return scenario_from(source, params, own, at, self._cut)
        if _known(source):
            if own is not None or at is not None:
                raise InputError(f"{source}: own ship and time are of recorded traffic only")
            return generated_scenario(source, params)
        if self._file is not None and source in (alias(self._file), self._file):
            return self._from_file(self._file, params, own, at)
        raise InputError(f"no source {source[:100]!r}: choose one of the catalogue")

    def is_live(self, source: str) -> bool:
        """Whether this names the feed of the command line."""
        return self.feed is not None and source in (self.feed, alias(self.feed))

    def live(self, own: str | None) -> Feed:
        """The feed of the command line."""
        if self.feed is None:
            raise InputError("no live traffic was named on the command line")
        named = self.feed.removeprefix(LIVE)
        with hide_paths(alias(self.feed), named, Path(named)):
            return create_feed(named, own, self._token)

    def pilot(self, name: str) -> Pilot:
        """A pilot of the catalogue; read from disk once."""
        if name == self._weights:
            name = alias(name)
        with self._reading:
            if name not in self._pilots:
                if name not in self._pilot_names():
                    raise InputError(f"no pilot {name[:100]!r}: choose one of the catalogue")
                given = self._weights is not None and name == alias(self._weights)
                self._pilots[name] = pilot_named(self._weights if given and self._weights else name)
            return self._pilots[name]

    def pilot_for(self, ship: str, name: str | None) -> Pilot:
        """The pilot asked for, or the one that steers that ship."""
        return self.pilot(default_pilot(ship) if name is None else name)

    def _pilot_names(self) -> tuple[str, ...]:
        extra = () if self._weights is None else (alias(self._weights),)
        return (*extra, *pilot_names())

    def _scenarios(self) -> list[Source]:
        found = [Source(s, _RECORDINGS.get(s, s), "recorded") for s in BUNDLED]
        if self._file is not None:
            kind = "simulated" if ".json" in Path(self._file.lower()).suffixes else "recorded"
            found.insert(0, Source(alias(self._file), alias(self._file), kind))
        if self.feed is not None:
            found.insert(0, Source(alias(self.feed), f"Live: {alias(self.feed)}", "live"))
        for case, ships in imazu_cases().items():
            count = f"{len(ships)} {'ship' if len(ships) == 1 else 'ships'}"
            found.append(Source(f"imazu:{case}", f"Imazu case {case}: {count}", "simulated"))
        for source in _RANDOM:
            family, _, seed = source.partition(":")
            title = f"{family.capitalize()} encounter, seed {seed.replace(':', ', ships: ')}"
            found.append(Source(source, title, "simulated"))
        return found

    def _from_file(self, path: str, ship: ShipParams, own: str | None, at: str | None) -> Scenario:
        with hide_paths(alias(path), path, Path(path)):
            scenario = scenario_from(path, ship, own, at, self._cut)
        return dataclasses.replace(scenario, source=alias(path))


def alias(given: str) -> str:
    """A source as a page shows it: of a path its last name, no folder of the disk."""
    return given if "://" in given else Path(given.removeprefix(LIVE)).name


def is_feed(source: str) -> bool:
    """Whether a source is live traffic."""
    return "://" in source or source.startswith(LIVE)


def _known(source: str) -> bool:
    """Whether a source is bundled or generated."""
    return source in BUNDLED or source.partition(":")[0] in (*FAMILIES, "imazu")


def _card(name: str, pilot: Pilot) -> PilotCard:
    ship = ship_of(pilot)
    if isinstance(pilot, LearnedPilot):
        return PilotCard(name, f"Learned: {name}", "learned", ship)
    if isinstance(pilot, GuardedPilot):
        return PilotCard(name, f"Guarded: {name}", "learned", ship)
    if isinstance(pilot, CoursePilot):
        kind = "planner" if pilot.method is PLANNER else "classical"
        return PilotCard(name, f"{TITLES[_method(pilot)]}: {name}", kind, ship)
    return PilotCard(name, "Keeps her course", "classical", ship)


def _method(pilot: CoursePilot) -> str:
    return next(name for name, method in METHODS.items() if method is pilot.method)
