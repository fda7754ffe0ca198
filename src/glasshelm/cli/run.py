"""``glasshelm run``: simulate an encounter without a display and write its frames."""

from pathlib import Path

from glasshelm.cli.voyage_options import Voyage


def run(voyage: Voyage, out: Path = Path("frames.jsonl"), parquet: Path | None = None) -> None:
    """Simulate an encounter and write its frames, one JSON line each.

    Ctrl-C stops the simulation; the frames written so far stay readable.

    Args:
        voyage: The encounter and its pilot.
        out: The log to write; an existing file is replaced.
        parquet: Also write the frames to this Parquet file.
    """
    from rich.progress import track

    from glasshelm.core.terminal import Terminal, print_result
    from glasshelm.frames.frame_log import FrameLog, read_log
    from glasshelm.frames.frame_parquet import to_parquet
    from glasshelm.frames.summary import Summary

    console, summary = Terminal(), Summary()
    scenario, pilot, count, frames = voyage.simulate()
    console.say(f"{scenario.title}, pilot {pilot.name}")
    for note in scenario.notes:
        console.say(f"  note: {note}")
    with FrameLog(out, fresh=True) as log:
        try:
            for frame in track(frames, "simulating", count, console=console, transient=True):
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
