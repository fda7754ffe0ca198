"""Rows of a table that cannot be used: how many for which reason, with an example of each."""

import dataclasses

import numpy as np

_CLIPPED = 24


@dataclasses.dataclass
class RowErrors:
    """How many rows there were, and which could not be read.

    A reason may hold ``{}``, which stands for the text of its first row.
    """

    rows: int = 0
    read: int = 0
    counts: dict[str, int] = dataclasses.field(default_factory=dict)
    _first: dict[str, tuple[int, str]] = dataclasses.field(default_factory=dict)

    def add(self, reason: str, row: int, text: str = "", count: int = 1) -> None:
        """``count`` rows that cannot be read for a reason, the first of them with its text."""
        self.counts[reason] = self.counts.get(reason, 0) + count
        self._first.setdefault(reason, (row, text))

    def add_all(self, reason: str, bad: np.ndarray, rows: np.ndarray, texts) -> None:
        """The rows of a mask; ``rows`` are the numbers of all, ``texts`` an Arrow array or None."""
        if bad.any():
            first = int(np.argmax(bad))
            text = "" if texts is None else _shown(texts[first])
            self.add(reason, int(rows[first]), text, int(bad.sum()))

    def notes(self) -> tuple[str, ...]:
        """A line for each reason, the commonest first."""
        found = []
        for reason, count in sorted(self.counts.items(), key=lambda item: -item[1]):
            rows = "row" if count == 1 else "rows"
            first = "" if count == 1 else "the first: "
            found.append(
                f"{count} {rows} unreadable: {self._said(reason)} "
                f"({first}row {self._first[reason][0]})"
            )
        return tuple(found)

    def most_common(self) -> str:
        """Why none of the rows can be read: the reason that holds for most."""
        if not self.counts:
            return "no row is in it"
        reason = max(self.counts, key=lambda known: self.counts[known])
        row = self._first[reason][0]
        return f"{self.counts[reason]} of {self.rows} rows: {self._said(reason)} (row {row})"

    def _said(self, reason: str) -> str:
        text = self._first[reason][1]
        text = text if len(text) <= _CLIPPED else text[:_CLIPPED] + "…"
        return reason.replace("{}", repr(text))


def _shown(value) -> str:
    """A value of an Arrow array as text."""
    try:
        return str(value.as_py())
    except (ValueError, OverflowError):  # an instant that no datetime can be, or a finer one
        return str(value.value)
