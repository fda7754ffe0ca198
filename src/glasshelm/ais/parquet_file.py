"""AIS reports from Parquet and GeoParquet tables, read in batches of rows."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from glasshelm.ais.columns import NULL_TEXTS, find_columns, missing_column, pc, to_recording
from glasshelm.ais.files import as_utf8
from glasshelm.ais.limits import MAX_TIME_S, MIN_TIME_S
from glasshelm.ais.table import Recording, ReportTable
from glasshelm.ais.tally import RowErrors
from glasshelm.core.errors import InputError

#: Rows that are read at once.
BATCH = 65_536


def parquet_batches(
    path: str | Path,
    wanted: Callable[[ReportTable], np.ndarray],
    notes: list[str],
    begin_s: float = MIN_TIME_S,
    end_s: float = MAX_TIME_S,
) -> Iterator[Recording]:
    """A table part by part; of each part the reports that are ``wanted``.

    Groups of rows whose times all lie outside ``begin_s`` to ``end_s`` are not read. What could
    not be read is in ``notes`` at the end. InputError if the table is damaged, a needed column is
    missing, or no row can be read.
    """
    tally = RowErrors()
    try:
        with pq.ParquetFile(path) as file:
            names = file.schema_arrow.names
            found = find_columns(names)
            problem = missing_column(found, names)
            if problem is not None:
                raise InputError(f"{path}: {problem}")
            groups = [
                i
                for i in range(file.metadata.num_row_groups)
                if _overlaps(file, i, names[found["time"]], begin_s, end_s)
            ]
            columns = [names[place] for place in found.values()]
            row = 1
            for batch in file.iter_batches(BATCH, row_groups=groups, columns=columns):
                part = {column: batch.column(names[p]) for column, p in found.items()}
                part = {name: v if name == "point" else _plain(v) for name, v in part.items()}
                rows = np.arange(row, row + batch.num_rows)
                row += batch.num_rows
                yield to_recording(part, rows, wanted, tally)
            everything = len(groups) == file.metadata.num_row_groups
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0][:100]
        raise InputError(f"{path}: a Parquet table that cannot be read ({reason})") from None
    if everything and not tally.read:
        raise InputError(f"{path}: no report can be read: {tally.most_common()}")
    notes.extend(tally.notes())


def _plain(values: pa.Array) -> pa.Array:
    """Values without a dictionary; texts that stand for nothing are null."""
    if pa.types.is_dictionary(values.type):
        values = values.dictionary_decode()
    if pa.types.is_binary(values.type) or pa.types.is_large_binary(values.type):
        values = pa.array(
            [None if x is None else as_utf8(x).decode() for x in values.to_pylist()], pa.string()
        )
    if pa.types.is_string_view(values.type):
        values = values.cast(pa.string())
    if pa.types.is_string(values.type) or pa.types.is_large_string(values.type):
        nothing = pc.is_in(values, value_set=pa.array(NULL_TEXTS, values.type))
        values = pc.if_else(nothing, pa.scalar(None, values.type), values)
    return values


def _overlaps(file: pq.ParquetFile, group: int, column: str, begin_s: float, end_s: float) -> bool:
    """Whether a group of rows may hold times of an interval; yes, where its statistics are mute."""
    if not pa.types.is_timestamp(file.schema_arrow.field(column).type):
        return True
    meta = file.metadata.row_group(group)
    here = (meta.column(i) for i in range(meta.num_columns))
    said = next((c.statistics for c in here if c.path_in_schema == column), None)
    if said is None or not said.has_min_max:
        return True
    try:
        first, last = (
            pa.scalar(t, pa.timestamp("us", "UTC" if t.tzinfo else None)).cast(pa.int64()).as_py()
            / 1e6
            for t in (said.min, said.max)
        )
    except (ValueError, OverflowError):  # finer, or farther off, than a datetime can be
        return True
    return first <= end_s and last >= begin_s
