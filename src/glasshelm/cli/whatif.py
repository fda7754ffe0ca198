"""``glasshelm whatif``: branch a log and simulate what would have happened otherwise."""

from pathlib import Path
from typing import Annotated

import tyro

from glasshelm.cli.voyage_options import logged_frames

_SHIPS = tyro.conf.arg(metavar="SHIP ...")


def run(
    log: Annotated[Path, tyro.conf.Positional],
    at: str,
    delete: Annotated[tuple[str, ...], _SHIPS] = (),
    hide: Annotated[tuple[str, ...], _SHIPS] = (),
    keep_course: Annotated[tuple[str, ...], _SHIPS] = (),
    rudder: float | None = None,
    rudder_seconds: float = 60.0,
    minutes: float = 30.0,
    pilot: str | None = None,
    out: Path | None = None,
) -> None:
    """Answer "what if that ship had not been there?": simulate on from one frame of a log, twice.

    Once as things are, and once with all the changes you name; the pilot and everything else stay
    the same. Targets go on as logged, then straight: recorded ships do not react. In a log of
    advice the pilot steers from that frame on.

    Args:
        log: The log: path/to/frames.jsonl.
        at: The frame: seconds of the log, frame:NUMBER, or HH:MM[:SS] (UTC) if the log has a clock.
        delete: Ships (id or name) that are not there.
        hide: Ships that are there, but the pilot does not see them.
        keep_course: Ships that keep course and speed from then on; "own" is own ship.
        rudder: Own ship's rudder [degrees, starboard positive] at first.
        rudder_seconds: How long that rudder is held.
        minutes: How long to simulate.
        pilot: The pilot that goes on, in the log's own ship (default: the log's pilot, if bundled).
        out: Folder for both logs and a figure.
    """
    from glasshelm.core.output_dir import atomic_write, writable_folder
    from glasshelm.core.terminal import Terminal
    from glasshelm.frames.frame_log import write_log
    from glasshelm.pilots.registry import pilot_named
    from glasshelm.whatif.ask import what_if
    from glasshelm.whatif.changes import Deleted, Hidden, KeptCourse, Rudder
    from glasshelm.whatif.futures_table import futures_table
    from glasshelm.whatif.logged_world import frame_at, pilot_of

    frames = logged_frames(log)
    number = frame_at(frames, at)
    if out is not None:
        writable_folder(out)
    changes = [
        *map(Deleted, delete),
        *map(Hidden, hide),
        *(KeptCourse(None if ship == "own" else ship) for ship in keep_course),
        *([] if rudder is None else [Rudder(rudder, rudder_seconds)]),
    ]
    steering = pilot_of(frames[number]) if pilot is None else pilot_named(pilot)
    answer = what_if(frames, number, steering, changes, minutes, explained=out is not None)
    console = Terminal(stderr=False)
    console.print(futures_table(answer))
    console.say(answer.summary)
    if out is None:
        return
    from glasshelm.figures.style import as_svg, save
    from glasshelm.whatif.futures_plot import draw_futures

    factual, counterfactual = answer.factual.frames(), answer.counterfactual.frames()
    write_log(out / "factual.jsonl", factual)
    write_log(out / "counterfactual.jsonl", counterfactual)
    figure = draw_futures(factual, counterfactual, answer.counterfactual.condition)
    save(figure, out / "whatif")
    with atomic_write(out / "whatif.svg") as partial:
        partial.write_bytes(as_svg(figure))
    for name in ("factual.jsonl", "counterfactual.jsonl", "whatif.pdf", "whatif.png", "whatif.svg"):
        console.say(f"{out / name}")
