"""Rows of a table that cannot be read: how many for which reason, with an example of each."""

import dataclasses

import numpy as np
import pyarrow as pa

_MAX_SHOWN = 24


@dataclasses.dataclass
class RowErrors:
    """How many rows a table has, and which could not be read.

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

    def add_mask(
        self, reason: str, bad: np.ndarray, rows: np.ndarray, texts: pa.Array | None
    ) -> None:
        """The rows of a mask; ``rows`` are the numbers of all, ``texts`` what they hold."""
        if bad.any():
            first = int(np.argmax(bad))
            text = "" if texts is None else _shown(texts[first])
            self.add(reason, int(rows[first]), text, int(bad.sum()))

    def notes(self) -> tuple[str, ...]:
        """A line for each reason, the commonest first."""
        notes = []
        for reason, count in sorted(self.counts.items(), key=lambda item: -item[1]):
            rows, first = ("row", "") if count == 1 else ("rows", "the first: ")
            row = self._first[reason][0]
            notes.append(
                f"{count} {rows} unreadable: {self._with_example(reason)} ({first}row {row})"
            )
        return tuple(notes)

    def most_common(self) -> str:
        """Why none of the rows can be read: the reason that holds for most."""
        if not self.counts:
            return "no row is in it"
        reason = max(self.counts, key=lambda known: self.counts[known])
        row, count = self._first[reason][0], self.counts[reason]
        return f"{count} of {self.rows} rows: {self._with_example(reason)} (row {row})"

    def _with_example(self, reason: str) -> str:
        text = self._first[reason][1]
        text = text if len(text) <= _MAX_SHOWN else text[:_MAX_SHOWN] + "…"
        return reason.replace("{}", repr(text))


def _shown(value: pa.Scalar) -> str:
    """A value of an Arrow array as text."""
    try:
        return str(value.as_py())
    except (ValueError, OverflowError):  # an instant that no datetime can be, or a finer one
        return str(value.value)  # pyright: ignore
