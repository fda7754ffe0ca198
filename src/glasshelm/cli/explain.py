"""``glasshelm explain``: sail an encounter and tell its story."""

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
    out: Path = Path("explained"),
    steps: int | None = None,
    open_: Annotated[bool, tyro.conf.arg(name="open")] = False,
) -> None:
    """Sail an encounter and tell its story: frames.jsonl, figures and report.html.

    The figures are those of the paper (7-11, 13-15) and some more, each as PDF
    and PNG. A log of an earlier voyage (a .jsonl file) is reported without simulating
    it again. Ctrl-C ends the voyage; the frames sailed so far stay.

    Args:
        source: random:SEED, wide:SEED, converging:SEED, imazu:5, gulf-of-finland,
            path/to/situation.json, path/to/ais.csv, or a log: path/to/frames.jsonl
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
        out: Folder for frames, figures and report; files of those names are replaced.
        steps: Steps of 5 s (default: as long as the source lasts).
        open_: Open the report in the browser.
    """
    from glasshelm.core.compile_cache import enable_compile_cache

    enable_compile_cache()
    from glasshelm.certify.logged_measurements import with_bands
    from glasshelm.certify.sensor_error_bounds import parse_error_bounds
    from glasshelm.core.errors import InputError
    from glasshelm.core.output_dir import writable_folder
    from glasshelm.core.terminal import Terminal, print_result, progress
    from glasshelm.frames.frame_log import read_log
    from glasshelm.whatif.logged_world import pilot_of

    console = Terminal()
    writable_folder(out)
    title, notes = None, ()
    if source.endswith(".jsonl"):
        if advise or any(x is not None for x in (pilot, ship, own, at, minutes, steps)):
            left = "pilot, ship, own, at, minutes, advise, steps"
            raise InputError(f"{source}: a log is told as it is; leave out {left}")
        frames = list(read_log(source))
        if errors is not None and frames:
            frames = list(with_bands(frames, pilot_of(frames[0]), parse_error_bounds(errors)))
        if not frames:
            raise InputError(f"{source}: no frame in it; it was cut off, or is no log")
    else:
        from glasshelm.encounters.scenario_factory import recording_settings, scenario_from
        from glasshelm.frames.frame_log import FrameLog
        from glasshelm.pilots.pilot_resolution import resolve_pilot_and_ship
        from glasshelm.simulation.voyage import simulate, steps_of

        helm, params = resolve_pilot_and_ship(pilot, ship)
        scenario = scenario_from(source, params, own, at, recording_settings(minutes))
        title, notes = f"{scenario.title}, pilot {helm.name}", scenario.notes
        console.say(title)
        count = steps_of(scenario, steps)
        voyage = simulate(scenario, helm, count, advise)
        if errors is not None:
            voyage = with_bands(voyage, helm, parse_error_bounds(errors))
        frames = []
        with (
            FrameLog(out / "frames.jsonl", fresh=True) as log,
            progress(console) as bar,
        ):
            task = bar.add_task("sailing", total=count + 1)
            try:
                for frame in voyage:
                    log.write(frame)
                    frames.append(frame)
                    bar.advance(task)
            except KeyboardInterrupt:
                console.say(f"interrupted: {log.frames} frames are in {log.path}")
                raise

    from glasshelm.report.narrative import narrate
    from glasshelm.report.passages import verdict
    from glasshelm.report.write_report import write_report

    with progress(console) as bar:
        task = bar.add_task("drawing", total=1.0)
        path = write_report(
            frames,
            out,
            title,
            notes,
            progress=lambda name, share: bar.update(task, description=name, completed=share),
        )
    print_result(verdict(frames))
    for sentence in narrate(frames):
        print_result(str(sentence))
    print_result(f"report: {path}")
    if open_:
        import webbrowser

        webbrowser.open(path.resolve().as_uri())
