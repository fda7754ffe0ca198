"""Any file of AIS as a stream of recordings: tables of text, Parquet, NMEA 0183."""

from collections.abc import Iterator
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from glasshelm.ais.columns import find_columns
from glasshelm.ais.csv_file import header_columns, header_index, iter_csv
from glasshelm.ais.files import is_parquet, read_head
from glasshelm.ais.nmea_file import iter_nmea
from glasshelm.ais.nmea_sentence import SENTENCE
from glasshelm.ais.parquet_file import iter_parquet
from glasshelm.ais.table import Recording, ReportTable, Wanted
from glasshelm.ais.timestamps import MAX_TIME_S, MIN_TIME_S
from glasshelm.core.errors import InputError

Kind: TypeAlias = Literal["parquet", "json", "nmea", "table"]

_SHOWN = 40


def kind_of(path: str | Path) -> Kind:
    """What a file holds, by its first lines. InputError says what it is if it holds no AIS."""
    if is_parquet(path):
        return "parquet"
    text = read_head(path)
    lines = text.split(b"\n")
    first = lines[header_index(lines)].strip()
    if first[:1] in b"{[" and not SENTENCE.search(first):
        return "json"
    _, names = header_columns(first)
    if len(find_columns(names)) > 1 and not SENTENCE.search(first):
        return "table"
    if SENTENCE.search(text):
        return "nmea"
    if len(names) > 1:
        return "table"
    shown = first[:_SHOWN].decode("utf-8", errors="replace")
    raise InputError(
        f"{path}: neither a table with the names of its columns in the first line nor NMEA 0183 "
        f"sentences (such as !AIVDM,…): it begins with {shown!r}"
    )


def all_reports(reports: ReportTable) -> np.ndarray:
    """The mask that keeps every report."""
    return np.ones(len(reports), bool)


def iter_recording(
    path: str | Path,
    notes: list[str],
    wanted: Wanted = all_reports,
    begin_s: float = MIN_TIME_S,
    end_s: float = MAX_TIME_S,
) -> Iterator[Recording]:
    """The parts of a file, one after another.

    Args:
        path: A table of text, Parquet or NMEA 0183, packed or not.
        notes: What could not be read is added at the end.
        wanted: A mask of the reports to keep. It sees every report that can be read, but in
            Parquet those between ``begin_s`` and ``end_s`` alone.
        begin_s: No earlier report is needed [s since 1970].
        end_s: No later report is needed [s since 1970].

    Raises:
        InputError: The file holds no AIS (the message says what it is), or nothing can be read.
    """
    match kind_of(path):
        case "parquet":
            return iter_parquet(path, wanted, notes, begin_s, end_s)
        case "table":
            return iter_csv(path, wanted, notes)
        case "nmea":
            return iter_nmea(path, wanted, notes)
        case "json":
            raise InputError(f"{path}: JSON, not a table of AIS or NMEA 0183 sentences")


def read_recording_file(path: str | Path) -> Recording:
    """The whole of a file as it is, not cleaned. InputError as :func:`iter_recording`."""
    notes: list[str] = []
    return Recording.concat(iter_recording(path, notes), notes)
