"""AIS reports from tables of text: a header line, then one report a row, read in blocks.

Columns are separated by commas, semicolons, tabs or bars, whichever finds most columns in the
header; with any but commas a number may have a decimal comma. A row ends with its line: a quote
that does not close, or a row of another length, costs itself alone.
"""

import csv
import dataclasses
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv

from glasshelm.ais.columns import NULL_TEXTS, find_columns, missing_column, pc, to_recording
from glasshelm.ais.files import TextFile
from glasshelm.ais.row_errors import RowErrors
from glasshelm.ais.table import Recording, Wanted
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
    """How a table is written: its delimiter, header, used columns and fields in a row."""

    delimiter: str
    header: tuple[str, ...]
    columns: dict[str, int]
    #: Fields of a row, with those beyond the header that are always empty.
    width: int

    def fields(self, line: bytes) -> list[str] | None:
        """The fields of a line; None if a quote in it does not close."""
        return _split(line.decode("utf-8", errors="replace"), self.delimiter)


def iter_csv(path: str | Path, wanted: Wanted, notes: list[str]) -> Iterator[Recording]:
    """The parts of a table; see :func:`glasshelm.ais.reading.iter_recording`.

    Raises:
        InputError: A required column is missing, or no row can be read; the message gives the
            reason that holds for most.
    """
    errors = RowErrors()
    with TextFile(path) as file:
        layout: Layout | None = None
        line_number = 0  # of the last line read
        for block in file.blocks(BLOCK):
            if layout is None:
                layout, block, line_number = _read_header(path, block)
            yield _read_block(path, block, line_number, layout, wanted, errors)
            line_number += block.count(b"\n")
        notes.extend(file.notes)
    if layout is None:
        raise InputError(f"{path}: nothing is in it")
    if not errors.read:
        raise InputError(f"{path}: no report can be read: {errors.most_common()}")
    notes.extend(errors.notes())


def header_index(lines: Sequence[bytes]) -> int:
    """The line that is the header: the first that is not empty, nor Excel's ``sep=``."""
    headers = (i for i, line in enumerate(lines) if line.strip() and not _EXCEL.match(line))
    return next(headers, 0)


def header_columns(line: bytes) -> tuple[str, tuple[str, ...]]:
    """The delimiter of a header line, and the names in it."""
    text = line.decode("utf-8", errors="replace")
    split = {mark: _split(text, mark) or [] for mark in DELIMITERS}
    best = max(DELIMITERS, key=lambda mark: (len(find_columns(split[mark])), len(split[mark])))
    names = [name.strip().lstrip("#").strip() for name in split[best]]
    while names and not names[-1]:
        names.pop()
    return best, tuple(names)


def _read_header(path: str | Path, block: bytes) -> tuple[Layout, bytes, int]:
    """The layout by the first lines, the block without them, and how many they are."""
    lines = block.split(b"\n", _SAMPLE)
    first = header_index(lines)
    delimiter, header = header_columns(lines[first])
    columns = find_columns(header)
    problem = missing_column(columns, header)
    if problem is not None:
        raise InputError(f"{path}: {problem}")
    layout = Layout(delimiter, header, columns, len(header))
    sample = [layout.fields(line) or [] for line in lines[first + 1 : _SAMPLE] if line]
    longer = [len(row) for row in sample if len(row) > len(header) and not any(row[len(header) :])]
    if len(longer) > len(sample) // 2:
        layout = dataclasses.replace(layout, width=max(longer))
    rest = block.split(b"\n", first + 1)[first + 1 :]
    return layout, b"".join(rest), first + 1


def _read_block(
    path: str | Path,
    block: bytes,
    line_number: int,
    layout: Layout,
    wanted: Wanted,
    errors: RowErrors,
) -> Recording:
    """The reports of the whole lines that follow line ``line_number`` of the file."""
    lines = block.count(b"\n")
    rows = np.arange(line_number + 1, line_number + lines + 1)
    table = _parse(block, layout)
    last = block[block.rfind(b"\n", 0, -1) + 1 : -1]
    if table is None or table.num_rows != lines or layout.fields(last) is None:
        block, rows = _repair(block, line_number, layout, errors)
        table = _parse(block, layout)
        if table is None or table.num_rows != len(rows):
            first, final = line_number + 1, line_number + lines
            raise InputError(f"{path}: lines {first} to {final} are no table")
    if not len(rows):
        return Recording.concat([])
    # Where tables were concatenated, a header in the middle is no row.
    header = layout.header[layout.columns["mmsi"]].lower()
    mmsi = pc.utf8_lower(table.column(str(layout.columns["mmsi"])))
    repeated = pc.fill_null(pc.equal(mmsi, header), False).to_numpy()
    if repeated.any():
        table, rows = table.filter(pa.array(~repeated)), rows[~repeated]
    columns = {
        column: table.column(str(index)).combine_chunks()
        for column, index in layout.columns.items()
    }
    return to_recording(columns, rows, wanted, errors, layout.delimiter != ",")


def _parse(block: bytes, layout: Layout) -> pa.Table | None:
    """A block of lines as texts; None if a row is of another length, or a quote does not close.

    Where a quote swallows the end of its line there are fewer rows than lines.
    """
    bad_rows = []
    names = [str(i) for i in range(layout.width)]
    used = [names[index] for index in layout.columns.values()]
    if not block:
        return pa.table({name: pa.array([], pa.string()) for name in used})
    try:
        table = pa_csv.read_csv(
            pa.BufferReader(block),
            read_options=pa_csv.ReadOptions(column_names=names, block_size=len(block) + 1),
            parse_options=pa_csv.ParseOptions(
                delimiter=layout.delimiter,
                invalid_row_handler=lambda row: bad_rows.append(row) or "skip",
                ignore_empty_lines=True,
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
    return None if bad_rows else table


def _repair(
    block: bytes, line_number: int, layout: Layout, errors: RowErrors
) -> tuple[bytes, np.ndarray]:
    """The lines of a block that are rows, and their numbers; the others are counted.

    Fields beyond the header that are empty do no harm (a comma at the end of the line).
    """
    mark, width = layout.delimiter.encode(), len(layout.header)
    kept, rows = [], []
    for number, line in enumerate(block.split(b"\n")[:-1], line_number + 1):
        if b'"' not in line and line.count(mark) == layout.width - 1:
            row = line
        elif not line.strip(b" \t" + mark):
            continue
        else:
            fields = layout.fields(line)
            if fields is None or len(fields) < width or any(fields[width:]):
                reason = f"{len(fields)} fields, the header has {width}" if fields else QUOTE
                errors.rows += 1
                errors.add(reason, number)
                continue
            fields = fields[: layout.width] + [""] * (layout.width - len(fields))
            row = _join(fields, layout.delimiter)
        kept.append(row + b"\n")
        rows.append(number)
    return b"".join(kept), np.array(rows, np.int64)


def _split(line: str, delimiter: str) -> list[str] | None:
    """The fields of a line; None if a quote does not close: it would swallow an added field."""
    try:
        fields = next(csv.reader([line + delimiter + _END], delimiter=delimiter))
    except csv.Error:  # a field longer than may be
        return None
    return fields[:-1] if fields[-1] == _END else None


def _join(fields: Sequence[str], delimiter: str) -> bytes:
    quoted = ['"' + f.replace('"', '""') + '"' if '"' in f or delimiter in f else f for f in fields]
    return delimiter.join(quoted).encode("utf-8")
