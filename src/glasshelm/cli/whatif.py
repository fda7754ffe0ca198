"""``glasshelm whatif``: branch a log and sail on with something changed."""

from pathlib import Path
from typing import Annotated

import tyro

_SHIPS = tyro.conf.arg(metavar="SHIP ...")


def run(
    log: Annotated[Path, tyro.conf.Positional],
    at: str,
    delete: Annotated[tuple[str, ...], _SHIPS] = (),
    blind: Annotated[tuple[str, ...], _SHIPS] = (),
    keep: Annotated[tuple[str, ...], _SHIPS] = (),
    rudder: float | None = None,
    for_: Annotated[float, tyro.conf.arg(name="for")] = 60.0,
    minutes: float = 30.0,
    pilot: str | None = None,
    out: Path | None = None,
) -> None:
    """What if that ship had not been there? Sail on from an instant of a log, twice.

    Once as things are, once with everything changed that is named; the same
    pilot, the same world. Targets go on as logged, then straight: recorded
    ships do not react. In a log of advice the pilot steers from that instant on.

    Args:
        log: A log: path/to/frames.jsonl.
        at: The instant: seconds of the log, frame:NUMBER, or where it has a clock HH:MM[:SS] (UTC).
        delete: Ships (id or name) that are not there.
        blind: Ships that the pilot does not see; they are there.
        keep: Ships that go straight from then on; "own" is own ship.
        rudder: Own rudder [degrees, starboard positive] to hold first.
        for_: Seconds for which the rudder is held.
        minutes: How far to sail.
        pilot: Who sails on, in the log's own ship (default: the log's pilot, if it is bundled).
        out: Folder for both logs and a figure.
    """
    from glasshelm.core.compile_cache import enable_compile_cache

    enable_compile_cache()
    from glasshelm.core.errors import InputError
    from glasshelm.core.output_dir import writable_folder
    from glasshelm.core.terminal import Terminal
    from glasshelm.frames.frame_log import read_log, write_log
    from glasshelm.pilots.registry import pilot_named
    from glasshelm.whatif.ask import what_if
    from glasshelm.whatif.changes import Deleted, Hidden, KeptCourse, Rudder
    from glasshelm.whatif.futures_table import futures_table
    from glasshelm.whatif.logged_world import frame_at, pilot_of

    frames = list(read_log(log))
    if not frames:
        raise InputError(f"{log}: no frame in it; it was cut off, or is no log")
    number = frame_at(frames, at)
    if out is not None:
        writable_folder(out)
    changes = [
        *map(Deleted, delete),
        *map(Hidden, blind),
        *(KeptCourse(None if ship == "own" else ship) for ship in keep),
        *([] if rudder is None else [Rudder(rudder, for_)]),
    ]
    helm = pilot_of(frames[number]) if pilot is None else pilot_named(pilot)
    answer = what_if(frames, number, helm, changes, minutes, explained=out is not None)
    console = Terminal(stderr=False)
    console.print(futures_table(answer))
    console.say(answer.summary)
    if out is None:
        return
    from glasshelm.core.output_dir import atomic_write
    from glasshelm.figures.style import as_svg, save
    from glasshelm.whatif.futures_plot import draw_futures

    fact, other = answer.factual.frames(), answer.counterfactual.frames()
    write_log(out / "fact.jsonl", fact)
    write_log(out / "other.jsonl", other)
    figure = draw_futures(fact, other, answer.counterfactual.condition)
    save(figure, out / "whatif")
    with atomic_write(out / "whatif.svg") as partial:
        partial.write_bytes(as_svg(figure))
    for name in ("fact.jsonl", "other.jsonl", "whatif.pdf", "whatif.png", "whatif.svg"):
        console.say(f"{out / name}")
