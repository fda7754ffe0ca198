"""Any file of AIS as a stream of recordings: tables of text, Parquet, NMEA 0183."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from glasshelm.ais.columns import find_columns
from glasshelm.ais.csv_file import columns_named, csv_batches, header_at
from glasshelm.ais.files import is_parquet, read_head
from glasshelm.ais.limits import MAX_TIME_S, MIN_TIME_S
from glasshelm.ais.nmea_file import nmea_recordings
from glasshelm.ais.parquet_file import parquet_batches
from glasshelm.ais.table import Recording, ReportTable
from glasshelm.core.errors import InputError

Kind: TypeAlias = Literal["parquet", "json", "nmea", "table"]

_SENTENCE = re.compile(rb"[!$][A-Z]{4,5},", re.IGNORECASE)
_SHOWN = 40


def kind_of(path: str | Path) -> Kind:
    """What a file holds, by its first lines. InputError says what it is if it holds no AIS."""
    if is_parquet(path):
        return "parquet"
    text = read_head(path)
    lines = text.split(b"\n")
    first = lines[header_at(lines)].strip()
    if first[:1] in b"{[" and not _SENTENCE.search(first):
        return "json"
    _, names = columns_named(first)
    if len(find_columns(names)) > 1 and not _SENTENCE.search(first):
        return "table"
    if _SENTENCE.search(text):
        return "nmea"
    if len(names) > 1:
        return "table"
    shown = first[:_SHOWN].decode("utf-8", errors="replace")
    raise InputError(
        f"{path}: neither a table with the names of its columns in the first line nor NMEA 0183 "
        f"sentences (such as !AIVDM,…): it begins with {shown!r}"
    )


def iter_recording(
    path: str | Path,
    wanted: Callable[[ReportTable], np.ndarray],
    notes: list[str],
    begin_s: float = MIN_TIME_S,
    end_s: float = MAX_TIME_S,
) -> Iterator[Recording]:
    """A file part by part; of each part the reports that are ``wanted``.

    Args:
        path: A table of text, Parquet or NMEA 0183, packed or not.
        wanted: A mask of the reports to keep. It sees every report that can be read, but in
            Parquet those between ``begin_s`` and ``end_s`` alone.
        notes: What could not be read is added at the end.
        begin_s: No earlier report is needed [s since 1970].
        end_s: No later report is needed [s since 1970].

    Raises:
        InputError: in one line: what the file is, if it holds no AIS; or why nothing can be read.
    """
    kind = kind_of(path)
    if kind == "parquet":
        return parquet_batches(path, wanted, notes, begin_s, end_s)
    if kind == "json":
        raise InputError(f"{path}: JSON, not a table of AIS or NMEA 0183 sentences")
    return (csv_batches if kind == "table" else nmea_recordings)(path, wanted, notes)
