"""``glasshelm evaluate``: evaluate pilots on suites of encounters."""

from pathlib import Path
from typing import Annotated, Literal

import tyro


def run(
    pilots: Annotated[tuple[str, ...], tyro.conf.arg(metavar="PILOT ...")],
    suites: Annotated[tuple[str, ...], tyro.conf.arg(metavar="SUITE ...")] = ("random", "imazu"),
    out: Path = Path("evaluation"),
    encounters: int | None = None,
    ships: tuple[Literal["paper", "large_ship"], ...] = ("paper", "large_ship"),
    against: tuple[str, ...] = ("straight", "paper-cpa", "large-ship-cpa"),
    workers: Literal["here", "ray"] = "here",
    address: str | None = None,
    parquet: bool = True,
    figures: bool = True,
) -> None:
    """Evaluate pilots on suites of encounters: report.md, Parquet tables and figures.

    Finished chunks are kept in OUT/chunks: the same command goes on where Ctrl-C stopped it, and
    another pilot or suite simulates only what is new.

    Args:
        pilots: Bundled names, straight, glassbox, .safetensors files, package.module:function
            (which runs that module's code; the current folder is searched too);
            NAME-guarded for a learned pilot under guard;
            NAME=A.safetensors,B.safetensors for the training seeds of one pilot.
        suites: random, congested, imazu, disturbed, recorded, recorded:FILE (AIS),
            situations:FOLDER (DNV traffic situations).
        out: Folder for everything that is written.
        encounters: Encounters of each random suite (default: random 10,000, others 1,000).
        ships: Own ships for pilots that are not made for one.
        against: Baselines that the others' risk is divided by, where they are evaluated too.
        workers: This process, or a Ray cluster.
        address: Address of the Ray cluster (default: one of this machine's processors).
        parquet: Write encounters.parquet and meetings.parquet.
        figures: Draw the figures.
    """
    import shlex
    import sys

    from glasshelm.core.output_dir import atomic_write, locked_folder
    from glasshelm.core.terminal import Terminal, print_result
    from glasshelm.evaluation.contenders import check_references, parse_contenders
    from glasshelm.evaluation.evaluation_progress import EvaluationProgress
    from glasshelm.evaluation.evaluation_run import evaluate
    from glasshelm.evaluation.parquet_export import write_parquet
    from glasshelm.evaluation.ray_workers import executor_named
    from glasshelm.evaluation.result_report import markdown_report

    console = Terminal()
    command = shlex.join(["glasshelm", *sys.argv[1:]])
    chosen = parse_contenders(pilots, ships)
    check_references(against, chosen)
    executor = executor_named(workers, address)
    with locked_folder(out):
        with EvaluationProgress(console) as display:
            try:
                found = evaluate(chosen, suites, out, command, encounters, executor, display.show)
            except KeyboardInterrupt:
                console.say(
                    f"interrupted: {display.done} of {display.total} voyages are kept in {out}; "
                    "the same command goes on from there"
                )
                raise
        text = markdown_report(found, against)
        with atomic_write(out / "report.md") as partial:
            partial.write_text(text, encoding="utf-8")
        if parquet:
            write_parquet(found.results, out)
        if figures:
            from glasshelm.evaluation.result_plots import draw_all

            for path in draw_all(found, out / "figures"):
                console.say(f"figure: {path}")
    print_result(text)
    console.say(f"report: {out / 'report.md'}")
