"""The examination on one page: a line a suite, a column a pilot."""

from collections.abc import Sequence

from glasshelm.evaluation.evaluation_run import (
    EvaluationResult,
    results_by_contender,
    stack_seeds,
    suites_of,
)
from glasshelm.evaluation.measure_columns import SuiteResult
from glasshelm.evaluation.statistics import rate_interval
from glasshelm.evaluation.tables import markdown_table, percent

#: What is told of every suite, and the column that it is the rate of.
SUMMARY_RATES = {
    "Collisions": "collided",
    "Domain intrusions": "intruded",
    "Within 0.5 NM": "within_half_nm",
}


def overview(examined: EvaluationResult) -> str:
    """Tables of the rates over all suites, for each ship; empty where there is one suite."""
    suites = suites_of(examined)
    if len(suites) < 2:
        return ""
    found = [seeds for suite in suites for seeds in results_by_contender(examined, suite.name)]
    ships = dict.fromkeys(seeds[0].contender.ship_name for seeds in found)
    parts = ["## Overview"]
    for ship in ships:
        sailed = [seeds for seeds in found if seeds[0].contender.ship_name == ship]
        for what, column in SUMMARY_RATES.items():
            parts.append(f"**{what}, `{ship}`.**\n\n{_table(column, sailed)}")
    return "\n\n".join(parts)


def _table(column: str, sailed: Sequence[Sequence[SuiteResult]]) -> str:
    pilots = list(dict.fromkeys(seeds[0].contender.name for seeds in sailed))
    cells = {
        (seeds[0].suite.name, seeds[0].contender.name): percent(
            rate_interval(stack_seeds(seeds, column))
        )
        for seeds in sailed
    }
    sizes = {seeds[0].suite.name: seeds[0].suite.size for seeds in sailed}
    rows = [
        [suite, f"{size:,}", *(cells.get((suite, pilot), "–") for pilot in pilots)]
        for suite, size in sizes.items()
    ]
    return markdown_table(["suite", "encounters", *pilots], rows)
