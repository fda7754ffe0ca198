"""``glasshelm paper``: make every table and figure of the paper, on one page."""

from pathlib import Path
from typing import Annotated

import tyro

from glasshelm.paper.paper_items import ENCOUNTER, PILOTS


def run(
    out: Path = Path("paper"),
    pilots: Annotated[tuple[str, ...], tyro.conf.arg(metavar="PILOT ...")] = PILOTS,
    encounter: str = ENCOUNTER,
    rates: int = 200,
    open_: Annotated[bool, tyro.conf.arg(name="open")] = False,
) -> None:
    """Make every table and figure of the paper: index.html, figures and frames.

    The page holds each beside what the paper says of it. What is made is kept in OUT: the same
    command goes on where Ctrl-C stopped it, and makes again only what has changed.

    Args:
        out: Folder for everything that is written.
        pilots: Bundled names, pilots without weights, or .safetensors files. Pilots with attention
            make Figures 13 to 15, the others 7 to 11.
        encounter: The encounter of Figures 10 to 15.
        rates: Random encounters on which intrusions and collisions are counted; 0: none.
        open_: Open the page in the browser.
    """
    import shlex
    import sys

    from glasshelm.core.errors import InputError
    from glasshelm.core.output_dir import atomic_write, locked_folder
    from glasshelm.core.terminal import Terminal, print_result
    from glasshelm.evaluation.evaluation_progress import EvaluationProgress
    from glasshelm.paper.paper_page import paper_page
    from glasshelm.paper.reproduce import reproduce

    if not 0 <= rates <= 100_000:
        raise InputError(f"--rates {rates}: must be from 0 to 100000")
    console = Terminal()
    command = shlex.join(["glasshelm", *sys.argv[1:]])
    page = out / "index.html"
    with locked_folder(out):
        with EvaluationProgress(console) as display:
            try:
                result = reproduce(pilots, encounter, rates, out, command, display.show)
            except KeyboardInterrupt:
                console.say(
                    f"interrupted: what is done is kept in {out}; "
                    "the same command goes on from there"
                )
                raise
        with atomic_write(page) as partial:
            partial.write_text(paper_page(result), encoding="utf-8")
    print_result(f"page: {page}")
    print_result(f"figures: {out / 'figures'}")
    if open_:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())
