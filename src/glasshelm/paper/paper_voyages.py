"""The voyages that the figures are drawn from, each simulated once."""

import dataclasses
from collections.abc import Callable, Sequence

from glasshelm.core.text import file_name
from glasshelm.encounters.scenario_factory import scenario_from
from glasshelm.encounters.types import Scenario
from glasshelm.evaluation.contenders import code_digest, pilot_digest
from glasshelm.frames.frame_log import read_log, write_log
from glasshelm.frames.series import Series, to_series
from glasshelm.networks.actors import AttentionActor
from glasshelm.paper.kept_results import KeptResults, digest_of
from glasshelm.pilots.pilot_resolution import ship_for
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import pilot_named
from glasshelm.ship.nomoto import ShipParams, ship_named
from glasshelm.simulation.voyage import simulate

#: Steps of a voyage: an episode of the paper.
STEPS = 240
_CODE = (
    "ais", "colregs", "core", "encounters", "env", "explanation", "frames", "networks", "pilots",
    "planning", "ship", "simulation",
)  # fmt: skip

#: Called with what is being done, pieces done and all pieces of this stage.
Progress = Callable[[str, int, int], None]


@dataclasses.dataclass(frozen=True, eq=False)
class SteeringPilot:
    """A pilot with the name of its own ship, and a digest of all that it decides by."""

    name: str
    pilot: Pilot
    ship_name: str
    digest: str

    @property
    def ship(self) -> ShipParams:
        return ship_named(self.ship_name)

    @property
    def attends(self) -> bool:
        """Whether it weighs ships by attention, as in section 5.3 of the paper."""
        return isinstance(getattr(self.pilot, "actor", None), AttentionActor)

    @property
    def identity(self) -> str:
        """Its name, and the first digits of the SHA-256 of its weights or settings."""
        sha = getattr(self.pilot, "weights_sha256", None)
        return f"{self.name}, " + (
            f"weights {sha[:8]}" if sha else f"no weights, settings {self.digest[:8]}"
        )


def steering_pilots(names: Sequence[str]) -> list[SteeringPilot]:
    """The pilots of these names, each on its own ship. InputError if one is unknown."""
    found = []
    for name in names:
        pilot = pilot_named(name)
        found.append(SteeringPilot(pilot.name, pilot, ship_for(pilot, None), pilot_digest(pilot)))
    return found


class Voyages:
    """Voyages by pilot and source: read where they are kept, simulated where they are not.

    Args:
        kept: Where their frames are.
        wanted: Pilots and sources.
        progress: Called before each.

    Raises:
        InputError: A source is unknown, or frames cannot be written.
    """

    def __init__(
        self, kept: KeptResults, wanted: Sequence[tuple[SteeringPilot, str]], progress: Progress
    ):
        self._kept = kept
        self._series: dict[tuple[str, str], Series] = {}
        scenarios = {(p.ship_name, s): scenario_from(s, p.ship) for p, s in wanted}
        for done, (pilot, source) in enumerate(wanted):
            progress(f"simulating {source}, {pilot.name}", done, len(wanted))
            scenario = scenarios[pilot.ship_name, source]
            self._series[pilot.name, source] = self._one(pilot, source, scenario)

    @property
    def all(self) -> list[Series]:
        return list(self._series.values())

    def of(self, pilot: SteeringPilot, source: str) -> Series:
        return self._series[pilot.name, source]

    def _one(self, pilot: SteeringPilot, source: str, scenario: Scenario) -> Series:
        name = f"frames/{file_name(pilot.name)}-{file_name(source)}.jsonl"
        path, digest = self._kept.folder / name, voyage_digest(pilot, source)
        if self._kept.has(name, digest, path):
            return to_series(list(read_log(path)))
        frames = list(simulate(scenario, pilot.pilot, STEPS))
        write_log(path, frames)
        self._kept.add(name, digest)
        return to_series(frames)


def voyage_digest(pilot: SteeringPilot, source: str) -> str:
    """A digest of all that a voyage depends on."""
    return digest_of(code_digest(_CODE), pilot.digest, pilot.ship_name, source, str(STEPS))
