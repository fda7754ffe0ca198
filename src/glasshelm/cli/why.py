"""``glasshelm why``: why the pilot chose its manoeuvre, and not another course."""

from pathlib import Path
from typing import Annotated

import tyro

from glasshelm.cli.voyage_options import logged_frames


def run(
    log: Annotated[Path, tyro.conf.Positional],
    at: str,
    course: float,
    pilot: str | None = None,
) -> None:
    """Answer "why not 30° to starboard?": the difference in value, by sub-task and by ship.

    The pilot takes the manoeuvre whose value is largest, and values are sums over sub-tasks and
    ships: the difference between two manoeuvres is the whole reason.

    Args:
        log: The log: path/to/frames.jsonl.
        at: The frame: seconds of the log, frame:NUMBER, or HH:MM[:SS] (UTC) if the log has a clock.
        course: The true course that is asked about [degrees].
        pilot: A pilot that compares courses (default: the log's pilot).
    """
    import math

    from rich.table import Table
    from rich.text import Text

    from glasshelm.core.errors import InputError
    from glasshelm.core.terminal import Terminal
    from glasshelm.pilots.registry import pilot_named
    from glasshelm.whatif.contrast import why_not
    from glasshelm.whatif.logged_world import frame_at, pilot_of

    if not 0.0 <= course <= 360.0:
        raise InputError(f"--course {course:g}: a true course from 0 to 360 degrees")
    frames = logged_frames(log)
    number = frame_at(frames, at)
    deciding = pilot_of(frames[number]) if pilot is None else pilot_named(pilot)
    contrast = why_not(frames, number, deciding, math.radians(course))
    console = Terminal(stderr=False)
    table = Table("", "points", title=Text(f"{log} at {contrast.time_s:g} s"))
    for name, value in contrast.by_ship.items():
        table.add_row(Text(name), f"{value:+.2f}")
    table.add_row("way to the waypoint", f"{contrast.waypoint:+.2f}")
    table.add_row("altering course", f"{contrast.helm:+.2f}")
    table.add_section()
    table.add_row("total", f"{contrast.total:+.2f}")
    console.print(table)
    console.say(contrast.summary)
