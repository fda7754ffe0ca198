"""AIS reports from Parquet and GeoParquet tables, read in batches of rows."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from glasshelm.ais.columns import NULL_TEXTS, find_columns, missing_column, pc, to_recording
from glasshelm.ais.files import as_utf8
from glasshelm.ais.row_errors import RowErrors
from glasshelm.ais.table import Recording, Wanted
from glasshelm.ais.timestamps import as_utc
from glasshelm.core.errors import InputError

#: Rows that are read at once.
BATCH = 65_536


def iter_parquet(
    path: str | Path, wanted: Wanted, notes: list[str], begin_s: float, end_s: float
) -> Iterator[Recording]:
    """The parts of a table; see :func:`glasshelm.ais.reading.iter_recording`.

    Groups of rows whose times all lie outside ``begin_s`` to ``end_s`` are not read.

    Raises:
        InputError: The table is damaged, a required column is missing, or no row can be read.
    """
    errors = RowErrors()
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
            columns = [names[index] for index in found.values()]
            row = 1
            for batch in file.iter_batches(BATCH, row_groups=groups, columns=columns):
                part = {column: batch.column(names[index]) for column, index in found.items()}
                part = {name: v if name == "point" else _plain(v) for name, v in part.items()}
                rows = np.arange(row, row + batch.num_rows)
                row += batch.num_rows
                yield to_recording(part, rows, wanted, errors)
            all_groups = len(groups) == file.metadata.num_row_groups
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0][:100]
        raise InputError(f"{path}: a Parquet table that cannot be read ({reason})") from None
    if all_groups and not errors.read:
        raise InputError(f"{path}: no report can be read: {errors.most_common()}")
    notes.extend(errors.notes())


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
    """Whether a group of rows may hold times of an interval; yes, where it has no statistics."""
    if not pa.types.is_timestamp(file.schema_arrow.field(column).type):
        return True
    meta = file.metadata.row_group(group)
    chunks = (meta.column(i) for i in range(meta.num_columns))
    statistics = next((c.statistics for c in chunks if c.path_in_schema == column), None)
    if statistics is None or not statistics.has_min_max:
        return True
    try:
        first, last = (as_utc(t).timestamp() for t in (statistics.min, statistics.max))
    except (ValueError, OverflowError):  # finer, or farther off, than a datetime can be
        return True
    return first <= end_s and last >= begin_s
