"""``glasshelm run``: sail an encounter headless and write its frames."""

from pathlib import Path
from typing import Annotated

import tyro


def run(
    source: Annotated[str, tyro.conf.Positional],
    pilot: str | None = None,
    ship: str | None = None,
    own: str | None = None,
    at: str | None = None,
    minutes: float | None = None,
    advise: bool = False,
    errors: str | None = None,
    out: Path = Path("frames.jsonl"),
    parquet: Path | None = None,
    steps: int | None = None,
) -> None:
    """Sail an encounter headless and write its frames, one JSON line each.

    Ctrl-C ends the voyage; what is written stays and can be read.

    Args:
        source: random:SEED, wide:SEED, converging:SEED, imazu:5, gulf-of-finland,
            path/to/situation.json, path/to/ais.csv, …
        pilot: A bundled pilot (by default the ship's), straight, one without weights by
            ship and method (paper-planner, large-ship-cpa), or a .safetensors file; a learned
            one followed by -guarded is that pilot under guard (paper-sum-guarded).
        ship: Own ship: paper or large_ship (default: the pilot's own, or else paper).
        own: In recorded traffic, the MMSI to take as own ship, or "recorded".
        at: In recorded traffic, when to begin (UTC, ISO 8601 or a time of day).
        minutes: In recorded traffic, how long from then (default: as long as own ship is heard).
        advise: Own ship keeps her recorded track; the pilot only advises.
        errors: Largest errors of the sensors (10,0.5,0.1: metres, degrees, knots); every frame of a
            sum pilot then carries its certified rudder band.
        out: The log; a file of that name is replaced.
        parquet: Also write the frames as a Parquet table.
        steps: Steps of 5 s (default: as long as the source lasts).
    """
    from glasshelm.core.compile_cache import enable_compile_cache

    enable_compile_cache()
    from rich.progress import track

    from glasshelm.certify.logged_measurements import with_bands
    from glasshelm.certify.sensor_error_bounds import parse_error_bounds
    from glasshelm.core.terminal import Terminal, print_result
    from glasshelm.encounters.scenario_factory import recording_settings, scenario_from
    from glasshelm.frames.frame_log import FrameLog, read_log
    from glasshelm.frames.frame_parquet import to_parquet
    from glasshelm.frames.summary import Summary
    from glasshelm.pilots.pilot_resolution import resolve_pilot_and_ship
    from glasshelm.simulation.voyage import simulate, steps_of

    console = Terminal()
    helm, params = resolve_pilot_and_ship(pilot, ship)
    scenario = scenario_from(source, params, own, at, recording_settings(minutes))
    count = steps_of(scenario, steps)
    frames = simulate(scenario, helm, count, advise)
    if errors is not None:
        frames = with_bands(frames, helm, parse_error_bounds(errors))
    summary = Summary()
    console.say(f"{scenario.title}, pilot {helm.name}")
    for note in scenario.notes:
        console.say(f"  note: {note}")
    with FrameLog(out, fresh=True) as log:
        try:
            for frame in track(frames, "sailing", total=count + 1, console=console, transient=True):
                log.write(frame)
                summary.add(frame)
        except KeyboardInterrupt:
            console.say(f"interrupted: {log.frames} frames are in {out}")
            raise
    console.say(f"{log.frames} frames in {out}")
    if parquet is not None:
        rows = to_parquet(read_log(out), parquet)
        console.say(f"{rows} rows in {parquet}")
    print_result(summary.text())
