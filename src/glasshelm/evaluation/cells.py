"""How tables and their numbers are written."""

from collections.abc import Sequence

from glasshelm.evaluation.statistics import Interval


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [" | ".join(header), " | ".join(["---"] * len(header)), *map(" | ".join, rows)]
    return "\n".join(f"| {line} |" for line in lines)


def percent(interval: Interval) -> str:
    """A rate and its interval."""
    value, low, high = (100 * x for x in (interval.value, interval.low, interval.high))
    return f"{value:.2f} % [{low:.2f}, {high:.2f}]"
