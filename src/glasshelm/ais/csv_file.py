"""AIS reports from tables of text: a header line, then one report a row, read in blocks.

Columns are parted by commas, semicolons, tabs or bars, whichever tells most of the header; with
any but commas a number may have a decimal comma. A row ends with its line: a quote that does
not close, or a row of another length, costs itself alone. What columns hold: ``columns``.
"""

import csv
import dataclasses
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv

from glasshelm.ais.columns import NULL_TEXTS, find_columns, missing_column, pc, to_recording
from glasshelm.ais.files import TextFile
from glasshelm.ais.table import Recording, ReportTable
from glasshelm.ais.tally import RowErrors
from glasshelm.core.errors import InputError

#: Bytes of a table that are read at once.
BLOCK = 4 << 20
#: Rows by which the length of a row is known.
_SAMPLE = 100

_EXCEL = re.compile(rb"sep=.\s*$")
_END = "\x01"
DELIMITERS = ",;\t|"
QUOTE = "a quote that does not close"


@dataclasses.dataclass(frozen=True)
class Layout:
    """How a table is written."""

    delimiter: str
    header: tuple[str, ...]
    places: dict[str, int]
    #: Fields of a row, with those beyond the header that are always empty.
    width: int


def read_csv(path: Path) -> Recording:
    """The recording of a table; rows that cannot be read are counted in its notes.

    InputError if a needed column is missing or no row can be read.
    """
    notes: list[str] = []
    parts = list(csv_batches(path, lambda reports: np.ones(len(reports), bool), notes))
    return Recording.concat(parts, notes)


def csv_batches(
    path: str | Path, wanted: Callable[[ReportTable], np.ndarray], notes: list[str]
) -> Iterator[Recording]:
    """A table part by part; of each part the reports that are ``wanted``.

    What could not be read is in ``notes`` at the end. InputError if a needed column is missing
    or no row can be read; it gives the reason that holds for most.
    """
    tally = RowErrors()
    with TextFile(path) as file:
        layout: Layout | None = None
        number = 0  # of lines read
        for block in file.blocks(BLOCK):
            if layout is None:
                layout, block, number = _begun(path, block)
            lines = block.count(b"\n")
            yield _part(path, block, number, layout, wanted, tally)
            number += lines
        notes.extend(file.notes)
    if layout is None:
        raise InputError(f"{path}: nothing is in it")
    if not tally.read:
        raise InputError(f"{path}: no report can be read: {tally.most_common()}")
    notes.extend(tally.notes())


def header_at(lines: Sequence[bytes]) -> int:
    """Which line is the header: the first that is not empty, or names a delimiter as Excel does."""
    told = (i for i, line in enumerate(lines) if line.strip() and not _EXCEL.match(line))
    return next(told, 0)


def columns_named(line: bytes) -> tuple[str, tuple[str, ...]]:
    """The delimiter of a header line, and the names in it."""
    text = line.decode("utf-8", errors="replace")
    split = {mark: _fields(text, mark) or [] for mark in DELIMITERS}
    best = max(DELIMITERS, key=lambda mark: (len(find_columns(split[mark])), len(split[mark])))
    names = [name.strip().lstrip("#").strip() for name in split[best]]
    while names and not names[-1]:
        names.pop()
    return best, tuple(names)


def _begun(path: str | Path, block: bytes) -> tuple[Layout, bytes, int]:
    """The layout by the first lines, the block without them, and how many they are."""
    lines = block.split(b"\n", _SAMPLE)
    first = header_at(lines)
    delimiter, header = columns_named(lines[first])
    found = find_columns(header)
    problem = missing_column(found, header)
    if problem is not None:
        raise InputError(f"{path}: {problem}")
    rest = block.split(b"\n", first + 1)[first + 1] if len(lines) > first + 1 else b""
    sample = [_fields(line.decode("utf-8", errors="replace"), delimiter) or [] for line in
              lines[first + 1 : _SAMPLE] if line]  # fmt: skip
    longer = [len(row) for row in sample if len(row) > len(header) and not any(row[len(header) :])]
    width = max(longer) if len(longer) > len(sample) // 2 else len(header)
    return Layout(delimiter, header, found, width), rest, first + 1


def _part(
    path: str | Path,
    block: bytes,
    number: int,
    layout: Layout,
    wanted: Callable[[ReportTable], np.ndarray],
    tally: RowErrors,
) -> Recording:
    """The reports of whole lines after the first ``number`` of the file."""
    lines = block.count(b"\n")
    rows = np.arange(number + 1, number + lines + 1)
    table = _table(block, layout)
    last = block[block.rfind(b"\n", 0, -1) + 1 : -1].decode("utf-8")
    if table is None or table.num_rows != lines or _fields(last, layout.delimiter) is None:
        block, rows = _mended(block, number, layout, tally)
        table = _table(block, layout)
        if table is None or table.num_rows != len(rows):
            raise InputError(f"{path}: lines {number + 1} to {number + lines} are no table")
    if not len(rows):
        return Recording.concat([])
    columns = {
        column: table.column(str(place)).combine_chunks() for column, place in layout.places.items()
    }
    # A header in the middle, where tables were put one behind the other, is no row.
    texts = pc.utf8_lower(columns["mmsi"])
    again = pc.equal(texts, layout.header[layout.places["mmsi"]].lower())
    if pc.any(again).as_py():
        kept = ~pc.fill_null(again, False).to_numpy(zero_copy_only=False)
        columns = {name: column.filter(pa.array(kept)) for name, column in columns.items()}
        rows = rows[kept]
    return to_recording(columns, rows, wanted, tally, layout.delimiter != ",")


def _table(block: bytes, layout: Layout) -> pa.Table | None:
    """A block of lines as texts; None if any row is of another length, or a quote does not close.

    Where a quote swallows the end of its line there are fewer rows than lines.
    """
    odd = False

    def found(_: object) -> str:
        nonlocal odd
        odd = True
        return "skip"

    names = [str(i) for i in range(layout.width)]
    used = [names[place] for place in layout.places.values()]
    if not block:
        return pa.table({name: pa.array([], pa.string()) for name in used})
    try:
        table = pa_csv.read_csv(
            pa.BufferReader(block),
            read_options=pa_csv.ReadOptions(column_names=names, block_size=len(block) + 1),
            parse_options=pa_csv.ParseOptions(
                delimiter=layout.delimiter, invalid_row_handler=found, ignore_empty_lines=True
            ),
            convert_options=pa_csv.ConvertOptions(
                include_columns=used,
                column_types=dict.fromkeys(used, pa.string()),
                null_values=list(NULL_TEXTS),
                strings_can_be_null=True,
            ),
        )
    except pa.ArrowInvalid:
        return None
    return None if odd else table


def _mended(
    block: bytes, number: int, layout: Layout, tally: RowErrors
) -> tuple[bytes, np.ndarray]:
    """The lines of a block that are rows, and their numbers; the others are counted.

    Fields beyond the header that are empty do no harm (a comma at the end of the line).
    """
    mark = layout.delimiter.encode()
    kept, rows = [], []
    for i, line in enumerate(block.split(b"\n")[:-1], number + 1):
        if b'"' not in line and line.count(mark) == layout.width - 1:
            kept.append(line)
            rows.append(i)
            continue
        if not line.strip(b" \t" + mark):
            continue
        fields = _fields(line.decode("utf-8"), layout.delimiter)
        if fields is None:
            reason = QUOTE
        elif len(fields) < len(layout.header) or any(fields[len(layout.header) :]):
            reason = f"{len(fields)} fields, the header has {len(layout.header)}"
        else:
            fields = fields[: layout.width] + [""] * (layout.width - len(fields))
            kept.append(_line(fields, layout.delimiter))
            rows.append(i)
            continue
        tally.rows += 1
        tally.add(reason, i)
    return b"".join(line + b"\n" for line in kept), np.array(rows, np.int64)


def _fields(line: str, delimiter: str) -> list[str] | None:
    """The fields of a line; None if a quote in it does not close: it holds what is put behind."""
    try:
        fields = next(csv.reader([line + delimiter + _END], delimiter=delimiter))
    except csv.Error:  # a field longer than may be
        return None
    return fields[:-1] if fields[-1] == _END else None


def _line(fields: Sequence[str], delimiter: str) -> bytes:
    quoted = ['"' + f.replace('"', '""') + '"' if '"' in f or delimiter in f else f for f in fields]
    return delimiter.join(quoted).encode("utf-8")
