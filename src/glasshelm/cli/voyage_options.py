"""The options that several commands share, and what they become."""

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from glasshelm.encounters.types import Scenario
    from glasshelm.frames.schema import Frame
    from glasshelm.pilots.protocols import Pilot


@dataclasses.dataclass(kw_only=True)
class PilotOptions:
    pilot: str | None = None
    """A bundled pilot (default: the ship's), straight, one without weights by ship and method
    (paper-glassbox, large-ship-cpa), a .safetensors file, or package.module:function, whose code is
    run; add -guarded to a learned pilot to put it under guard (paper-sum-guarded)."""
    ship: str | None = None
    """Own ship's model: paper or large_ship (default: the pilot's, or else paper)."""
    own: str | None = None
    """MMSI of own ship in recorded or live traffic, or "recorded" for the recording ship itself.
    In live traffic it is usually known without: from AIVDO or sensor sentences (NMEA 0183), or as
    the server's self (Signal K)."""
    at: str | None = None
    """When to begin in recorded traffic (UTC; ISO 8601 or a time of day)."""
    minutes: float | None = None
    """How long to go on in recorded traffic (default: while own ship is heard)."""


@dataclasses.dataclass(kw_only=True)
class VoyageOptions(PilotOptions):
    source: tyro.conf.Positional[str]
    """An encounter: random:SEED, wide:SEED, converging:SEED, imazu:5, gulf-of-finland,
    path/to/situation.json or path/to/ais.csv; for explain also a log, path/to/frames.jsonl."""
    advise: bool = False
    """Let own ship keep its recorded track; the pilot only advises."""
    sensor_errors: str | None = None
    """Largest sensor errors, in metres, degrees and knots (10,0.5,0.1): every frame of a sum or
    glassbox pilot then has its certified band."""
    steps: int | None = None
    """Number of steps of 5 s (default: as long as the source lasts)."""

    def simulate(self) -> "tuple[Scenario, Pilot, int, Iterator[Frame]]":
        """Return the scenario, its pilot, the number of frames at most, and the frames."""
        from glasshelm.certify.logged_measurements import with_bands
        from glasshelm.certify.sensor_error_bounds import parse_error_bounds
        from glasshelm.encounters.scenario_factory import recording_settings, scenario_from
        from glasshelm.pilots.pilot_resolution import resolve_pilot_and_ship
        from glasshelm.simulation.voyage import simulate, steps_of

        pilot, ship = resolve_pilot_and_ship(self.pilot, self.ship)
        scenario = scenario_from(
            self.source, ship, self.own, self.at, recording_settings(self.minutes)
        )
        n_steps = steps_of(scenario, self.steps)
        frames = simulate(scenario, pilot, n_steps, self.advise)
        if self.sensor_errors is not None:
            frames = with_bands(frames, pilot, parse_error_bounds(self.sensor_errors))
        return scenario, pilot, n_steps + 1, frames


#: An argument whose options have no prefix.
Pilots = Annotated[PilotOptions, tyro.conf.arg(name="")]
Voyage = Annotated[VoyageOptions, tyro.conf.arg(name="")]


def logged_frames(path: Path) -> "list[Frame]":
    """Read the frames of a log. InputError if there are none."""
    from glasshelm.core.errors import InputError
    from glasshelm.frames.frame_log import read_log

    frames = list(read_log(path))
    if not frames:
        raise InputError(f"{path}: no frame in it; it was cut off, or is not a log")
    return frames
