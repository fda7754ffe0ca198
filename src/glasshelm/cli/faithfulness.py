"""``glasshelm faithfulness``: test whether the explanations of a pilot are true."""

from pathlib import Path
from typing import Annotated

import tyro


def run(
    pilots: Annotated[tuple[str, ...], tyro.conf.arg(metavar="PILOT ...")],
    out: Path = Path("faithfulness"),
    encounters: int = 1000,
    scenes: int = 400,
    ships: tuple[int, ...] = (2, 3, 4, 5, 6),
) -> None:
    """Test every explanation of a pilot: faithfulness.md and figures.

    Each explanation predicts what the pilot would do if ships were not there, and is compared with
    what the pilot does. Scores and nulls: docs/explanation/explanations.md.
    Finished pilots are kept in OUT/chunks: the same command goes on where Ctrl-C stopped it.

    Args:
        pilots: Learned pilots or .safetensors files, and pilots that choose manoeuvres
            (paper-glassbox); NAME=A.safetensors,B.safetensors for the training seeds of one pilot.
        out: Folder for what is written.
        encounters: Random encounters that are simulated for scenes.
        scenes: At most so many scenes for each number of ships.
        ships: Numbers of ships in the scenes (2 to 6).
    """
    import shlex
    import sys

    from glasshelm.core.errors import InputError
    from glasshelm.core.output_dir import locked_folder
    from glasshelm.core.terminal import Terminal
    from glasshelm.evaluation.contenders import parse_contenders
    from glasshelm.evaluation.evaluation_run import describe_machine
    from glasshelm.faithfulness.scenes import SHIP_COUNTS
    from glasshelm.faithfulness.scoring_session import eligible_pilots, score_pilots

    for name, value in (("encounters", encounters), ("scenes", scenes)):
        if value < 1:
            raise InputError(f"--{name} {value}: must be 1 or more")
    if not set(ships) <= set(SHIP_COUNTS) or not ships:
        raise InputError(f"--ships {' '.join(map(str, ships))}: numbers from 2 to 6")
    chosen = eligible_pilots(parse_contenders(pilots))
    command = shlex.join(["glasshelm", *sys.argv[1:]])
    what = (encounters, scenes, tuple(sorted(set(ships))))
    console = Terminal()
    with locked_folder(out):
        score_pilots(chosen, what, out, command, describe_machine(), console)
