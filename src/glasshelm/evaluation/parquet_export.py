"""Results as Parquet: one row an encounter and pilot, and one row a meeting."""

import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from glasshelm.colregs.classification import EncounterType
from glasshelm.core.output_dir import atomic_write
from glasshelm.evaluation.measure_columns import Columns, SuiteResult

ENCOUNTERS, MEETINGS = "encounters.parquet", "meetings.parquet"


def write_parquet(sailed: tuple[SuiteResult, ...], out: Path) -> list[Path]:
    """Write both tables into a folder. What does not exist (the nearest of no ships) is null."""
    paths = []
    for name, columns_of in ((ENCOUNTERS, _encounters), (MEETINGS, _meetings)):
        paths.append(out / name)
        _write(paths[-1], (_arrow(one, columns_of(one)) for one in sailed))
    return paths


def _write(path: Path, tables: Iterator) -> None:
    import pyarrow.parquet as pq

    first = next(tables, None)
    if first is None:
        return
    with (
        atomic_write(path) as partial,
        pq.ParquetWriter(str(partial), first.schema, compression="zstd") as writer,
    ):
        for table in itertools.chain((first,), tables):
            writer.write_table(table)


def _encounters(one: SuiteResult) -> Columns:
    return {"number": np.arange(one.suite.size), **one.columns}


def _meetings(one: SuiteResult) -> Columns:
    kinds = np.array([kind.name.lower() for kind in EncounterType])
    facts = dict(one.meetings)
    return {"number": facts.pop("case"), **facts, "kind": kinds[facts["kind"]]}


def _arrow(one: SuiteResult, columns: Columns):
    import pyarrow as pa

    rows = len(columns["number"])
    names = np.array(one.suite.labels, dtype=object)[columns["number"]]
    same = {
        "suite": one.suite.name,
        "pilot": one.contender.name,
        "ship": one.contender.ship_name,
        "seed": one.seed,
        "weights": one.weights,
    }
    arrays = {name: pa.array([value] * rows) for name, value in same.items()}
    types = {"seed": pa.int32()}
    arrays = {n: a.cast(types.get(n, pa.string())) for n, a in arrays.items()}
    arrays["encounter"] = pa.array(names.tolist(), pa.string())
    for name, values in columns.items():
        missing = ~np.isfinite(values) if values.dtype.kind == "f" else None
        arrays[name] = pa.array(values, mask=missing)
    return pa.table(arrays)
