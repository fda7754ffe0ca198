"""``glasshelm exam``: are the explanations of a pilot true?"""

from pathlib import Path
from typing import Annotated

import tyro


def run(
    pilots: Annotated[tuple[str, ...], tyro.conf.arg(metavar="PILOT ...")],
    out: Path = Path("exam"),
    encounters: int = 1000,
    scenes: int = 400,
    ships: tuple[int, ...] = (2, 3, 4, 5, 6),
) -> None:
    """Put every explanation of a pilot to the test: exam.md and a figure.

    Each is asked what the pilot would do if ships were not there, and the
    pilot is asked too. Scores and nulls: docs/explanations.md.

    Args:
        pilots: Bundled names or .safetensors files; NAME=A.safetensors,B.safetensors for the
            training seeds of one pilot.
        out: Folder for what is written.
        encounters: Random encounters that are sailed for scenes.
        scenes: Scenes at most of each number of ships.
        ships: Numbers of ships in the scenes (2 to 6).
    """
    from glasshelm.cli.programs import keep_compiled

    keep_compiled()
    import shlex
    import sys

    from rich.console import Console
    from rich.progress import Progress

    from glasshelm.errors import InputError
    from glasshelm.evaluation.entrants import entrants
    from glasshelm.evaluation.exam import machine
    from glasshelm.faithfulness.exam import examine
    from glasshelm.faithfulness.plots import scores_figure
    from glasshelm.faithfulness.scenes import COUNTS
    from glasshelm.faithfulness.tables import report
    from glasshelm.figures.style import save
    from glasshelm.pilots.learned import LearnedPilot

    for name, value in (("encounters", encounters), ("scenes", scenes)):
        if value < 1:
            raise InputError(f"--{name} {value}: must be 1 or more")
    if not set(ships) <= set(COUNTS) or not ships:
        raise InputError(f"--ships {' '.join(map(str, ships))}: numbers from 2 to 6")
    console = Console(stderr=True)
    command = shlex.join(["glasshelm", *sys.argv[1:]])
    text = ["# Exam of explanations", "", "Definitions: docs/explanations.md.", ""]
    for entrant in entrants(pilots):
        examined = []
        for seed, pilot in enumerate(entrant.pilots):
            if not isinstance(pilot, LearnedPilot):
                raise InputError(
                    f"pilot {pilot.name!r} has no networks to explain, or is guarded: "
                    "name a learned pilot or a .safetensors file"
                )
            with Progress(console=console, transient=True) as bar:
                task = bar.add_task(entrant.name, total=None)

                def say(what: str, done: int, of: int, bar=bar, task=task) -> None:
                    bar.update(task, description=what, completed=done, total=of)

                examined.append(examine(pilot, encounters, scenes, ships, say))
            count = len(examined[-1].voyage)
            console.print(f"{entrant.name}, seed {seed}: {count} scenes", markup=False)
        text.append(report(entrant.name, examined, command, machine()))
        save(scores_figure(examined, entrant.name), out / f"exam-{entrant.name}")
    out.mkdir(parents=True, exist_ok=True)
    (out / "exam.md").write_text("\n".join(text), encoding="utf-8")
    console.print(f"{out / 'exam.md'}", markup=False)
