"""``glasshelm certify``: what is certain of a logged decision while the sensors err."""

from pathlib import Path
from typing import Annotated

import tyro

from glasshelm.certify.sensor_error_bounds import DEFAULT_ERRORS
from glasshelm.cli.voyage_options import logged_frames


def run(
    log: Annotated[Path, tyro.conf.Positional],
    at: str,
    errors: str = DEFAULT_ERRORS,
    pilot: str | None = None,
) -> None:
    """Bound a decision: the rudder of a sum pilot, the manoeuvre of a glassbox pilot.

    Of a manoeuvre: what it is worth at least and at most, by sub-task and ship, how near every
    ship can come, and whether another course can be the best. The bounds hold for all errors of
    the sensors up to those given, if every other ship keeps course and speed.

    Args:
        log: The log: path/to/frames.jsonl.
        at: The frame: seconds of the log, frame:NUMBER, or HH:MM[:SS] (UTC) if the log has a clock.
        errors: Largest errors in metres, degrees and knots.
        pilot: A pilot that decides the same (default: the log's pilot).
    """
    import msgspec
    from rich.table import Table
    from rich.text import Text

    from glasshelm.certify.logged_measurements import band_of_frames
    from glasshelm.certify.sensor_error_bounds import parse_error_bounds
    from glasshelm.core.terminal import Terminal
    from glasshelm.frames.phrases import capitalised
    from glasshelm.pilots.registry import pilot_named
    from glasshelm.report.band_text import band_rows, full_band_text, short_band_text
    from glasshelm.whatif.logged_world import frame_at, pilot_of

    frames, bounds = logged_frames(log), parse_error_bounds(errors)
    number = frame_at(frames, at)
    deciding = pilot_of(frames[number]) if pilot is None else pilot_named(pilot)
    band = band_of_frames(frames[: number + 1], deciding, bounds)
    frame = msgspec.structs.replace(frames[number], band=band)
    console = Terminal(stderr=False)
    rows = band_rows(frame)
    if rows:
        heads = "", "at least", "at most", "deepest in the domain", "no nearer than"
        table = Table(*heads, title=Text(f"{log} at {frame.time_s:g} s"))
        for name, *cells in rows:
            table.add_row(Text(name), *cells)
        console.print(table)
    console.say(f"{capitalised(short_band_text(frame))}. {capitalised(full_band_text(frame))}.")
