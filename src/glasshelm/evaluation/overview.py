"""The examination on one page: a line a suite, a column a pilot."""

from collections.abc import Sequence

from glasshelm.evaluation.examination import Examined, of_suite, stacked, suites_of
from glasshelm.evaluation.markdown import markdown, percent
from glasshelm.evaluation.measure_columns import Sailed
from glasshelm.evaluation.statistics import rate

#: What is told of every suite, and the column that it is the rate of.
TOLD = {
    "Collisions": "collided",
    "Domain intrusions": "intruded",
    "Within 0.5 NM": "within_half_nm",
}


def overview(examined: Examined) -> str:
    """Tables of the rates over all suites, for each ship; empty where there is one suite."""
    suites = suites_of(examined)
    if len(suites) < 2:
        return ""
    found = [seeds for suite in suites for seeds in of_suite(examined, suite.name)]
    ships = dict.fromkeys(seeds[0].entrant.ship_name for seeds in found)
    parts = ["## Overview"]
    for ship in ships:
        sailed = [seeds for seeds in found if seeds[0].entrant.ship_name == ship]
        for what, column in TOLD.items():
            parts.append(f"**{what}, `{ship}`.**\n\n{_table(column, sailed)}")
    return "\n\n".join(parts)


def _table(column: str, sailed: Sequence[Sequence[Sailed]]) -> str:
    pilots = list(dict.fromkeys(seeds[0].entrant.name for seeds in sailed))
    cells = {
        (seeds[0].suite.name, seeds[0].entrant.name): percent(rate(stacked(seeds, column)))
        for seeds in sailed
    }
    sizes = {seeds[0].suite.name: seeds[0].suite.size for seeds in sailed}
    rows = [
        [suite, f"{size:,}", *(cells.get((suite, pilot), "–") for pilot in pilots)]
        for suite, size in sizes.items()
    ]
    return markdown(["suite", "encounters", *pilots], rows)
