"""One exam from beginning to end: pilot after pilot, each one's results written when it is done."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from glasshelm.core.compile_cache import clear_if_full
from glasshelm.core.output_dir import atomic_write
from glasshelm.core.terminal import Terminal, progress
from glasshelm.core.text import file_name
from glasshelm.evaluation.result_cache import ResultCache
from glasshelm.faithfulness.exam_runner import Examined, examine
from glasshelm.faithfulness.score_cache import kept_or, key_of
from glasshelm.faithfulness.score_plots import scores_figure
from glasshelm.faithfulness.score_tables import report
from glasshelm.figures.style import save
from glasshelm.pilots.learned import LearnedPilot

#: Encounters, scenes at most of each number of ships, numbers of ships.
What = tuple[int, int, tuple[int, ...]]


def examine_all(
    chosen: Sequence[tuple[str, Sequence[LearnedPilot]]],
    what: What,
    out: Path,
    command: str,
    machine: str,
    console: Terminal,
) -> None:
    """Examine the seeds of every named pilot; exam.md and a figure are written after each pilot.

    The scores of each seed are kept in ``out/chunks`` and are not computed again.
    """
    text = ["# Exam of explanations", "", "Definitions: docs/explanation/explanations.md.", ""]
    total, done = sum(len(seeds) for _, seeds in chosen), 0
    try:
        for name, seeds in chosen:
            examined = []
            for number, pilot in enumerate(seeds):
                found, before = _examined(name, pilot, what, out, console)
                examined.append(found)
                done += 1
                clear_if_full()
                kept = ", examined before" if before else ""
                said = f"{name}, seed {number}: {len(found.voyage)} scenes{kept}"
                console.say(said)
            text.append(report(name, examined, command, machine))
            with atomic_write(out / "exam.md") as partial:
                partial.write_text("\n".join(text), encoding="utf-8")
            save(scores_figure(examined, name), out / f"exam-{file_name(name)}")
    except KeyboardInterrupt:
        console.say(
            f"interrupted: {done} of {total} pilots and seeds are kept in {out}; "
            "the same command goes on from there"
        )
        raise
    console.say(f"{out / 'exam.md'}")


def _examined(
    name: str, pilot: LearnedPilot, what: What, out: Path, console: Terminal
) -> tuple[Examined, bool]:
    with progress(console) as bar:
        task = bar.add_task(name, total=None)

        def say(doing: str, done: int, of: int) -> None:
            bar.update(task, description=doing, completed=done, total=of)

        work = partial(examine, pilot, *what, say)
        return kept_or(work, ResultCache(out / "chunks"), key_of(pilot, *what), pilot)
