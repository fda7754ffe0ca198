"""How tables and their numbers are written."""

from collections.abc import Sequence

from glasshelm.core.text import markdown_text
from glasshelm.evaluation.statistics import ConfidenceInterval


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; cells are text, whatever is in them."""
    texts = [map(markdown_text, cells) for cells in (header, *rows)]
    head, *body = map(" | ".join, texts)
    lines = [head, " | ".join(["---"] * len(header)), *body]
    return "\n".join(f"| {line} |" for line in lines)


def percent(interval: ConfidenceInterval) -> str:
    """A rate and its interval."""
    value, low, high = (100 * x for x in (interval.value, interval.low, interval.high))
    return f"{value:.2f} % [{low:.2f}, {high:.2f}]"
