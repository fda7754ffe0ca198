"""The paper from beginning to end: voyages, figures, tables and rates.

Voyages, figures and rates are kept in the folder with a digest of pilots and code, so that an
interrupted run goes on, and a later one computes only what has changed.
"""

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from glasshelm.core.errors import InputError
from glasshelm.evaluation.contenders import parse_contenders
from glasshelm.evaluation.evaluation_run import RunInfo, describe_machine, evaluate
from glasshelm.evaluation.measure_columns import SuiteResult
from glasshelm.paper import findings
from glasshelm.paper.kept_results import KeptResults
from glasshelm.paper.paper_figures import (
    INSTANTS_S,
    Drawing,
    MadeFigure,
    attention_figures,
    diagrams,
    learning_figure,
    track_figures,
)
from glasshelm.paper.paper_items import OTHERS
from glasshelm.paper.paper_voyages import Progress, SteeringPilot, Voyages, steering_pilots
from glasshelm.paper.parameter_tables import ParameterTable, parameter_tables
from glasshelm.paper.training_records import train_config, weights_path
from glasshelm.pilots.learned import LearnedPilot

#: Place of the encounter of Figures 10-15 among those of Figures 7-9.
_FOURTH = 3


@dataclasses.dataclass(frozen=True)
class PaperResult:
    """All that the page shows.

    Attributes:
        figures: In the order of their numbers and pilots.
        tables: A.1 to A.6.
        rates: Random encounters by each pilot; none if none were asked for.
        held: By equation, what the frames of this run show of it.
        encounters: The sources of Figures 7-9.
        pilots: Who steered.
        run_info: Command and machine.
    """

    figures: tuple[MadeFigure, ...]
    tables: tuple[ParameterTable, ...]
    rates: tuple[SuiteResult, ...]
    held: dict[str, str]
    encounters: tuple[str, ...]
    pilots: tuple[SteeringPilot, ...]
    run_info: RunInfo


def reproduce(
    names: Sequence[str],
    encounter: str,
    evaluated: int,
    out: Path,
    command: str,
    progress: Progress = lambda what, done, of: None,
) -> PaperResult:
    """Make all figures and tables of the paper in a folder.

    Args:
        names: Who steers. Those with attention make Figures 13-15, the others 7-11 (all of them,
            if each has attention).
        encounter: The encounter of Figures 10-15.
        evaluated: How many random encounters the rates are measured on; 0: none.
        out: The folder.
        command: The command line, which the page cites.
        progress: Called as work is done.

    Raises:
        InputError: A pilot or the encounter is unknown, or the folder cannot be written.
    """
    pilots = steering_pilots(names)
    contenders = parse_contenders(names, ("paper",))
    sources = (*OTHERS[:_FOURTH], encounter, *OTHERS[_FOURTH:])
    tracked = [p for p in pilots if not p.attends] or pilots
    attending = [p for p in pilots if p.attends]
    kept = KeptResults(out)
    wanted = [(p, s) for p in tracked for s in sources] + [(p, encounter) for p in attending]
    voyages = Voyages(kept, list(dict.fromkeys(wanted)), progress)
    for pilot, source in wanted:
        _check_length(voyages.of(pilot, source).time_s[-1], source, encounter)
    drawing = Drawing(kept, 8 + 5 * len(tracked) + 4 * len(attending), progress)
    figures = [*diagrams(drawing)]
    for p in tracked:
        figures += track_figures(drawing, p, [voyages.of(p, s) for s in sources], sources, _FOURTH)
    for p in attending:
        figures += attention_figures(drawing, p, voyages.of(p, encounter), encounter)
    figures.append(learning_figure(drawing, names, pilots))
    rates: tuple[SuiteResult, ...] = ()
    if evaluated:
        rates = evaluate(
            contenders, ["random"], out, command, evaluated, progress=progress
        ).results  # fmt: skip
    trained = [
        (p.pilot, config)
        for name, p in zip(names, pilots, strict=True)
        if isinstance(p.pilot, LearnedPilot) and (config := train_config(weights_path(name)))
    ]
    return PaperResult(
        tuple(figures),
        tuple(parameter_tables(trained)),
        rates,
        findings.held(voyages.all),
        sources,
        tuple(pilots),
        RunInfo(command, describe_machine()),
    )


def _check_length(end_s: float, source: str, encounter: str) -> None:
    if source == encounter and end_s < max(INSTANTS_S):
        raise InputError(
            f"{encounter}: ends after {end_s:g} s, and Figure 11 needs {max(INSTANTS_S):g} s"
        )
