"""Frames as a Parquet table: one row a frame and target, flat columns.

Columns are the frame's fields with dots as underscores (``own_east_m``,
``value_total``), the target's under ``target_``; lists (Q over the rudder
range, alternatives) are list columns. What is absent is null; a frame without targets is one
row whose target columns are null. What belongs to a frame is repeated in each
of its rows, and the compression takes care of that.
"""

import types
import typing
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from glasshelm.core.output_dir import atomic_write
from glasshelm.frames.schema import Frame, Target

_ROWS = 20_000  # rows a group


def to_parquet(frames: Iterable[Frame], path: str | Path) -> int:
    """Write frames as a Parquet table, whole or not at all.

    Args:
        frames: The frames.
        path: The file.

    Returns:
        The number of rows.

    Raises:
        InputError: The file cannot be written.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = pa.schema([(name, _arrow_type(kind)) for name, kind in columns().items()])
    total = 0
    with (
        atomic_write(path) as partial,
        pq.ParquetWriter(str(partial), schema, compression="zstd") as writer,
    ):
        for group in _groups(rows(frames)):
            writer.write_table(pa.Table.from_pylist(group, schema=schema))
            total += len(group)
    return total


def columns() -> dict[str, Any]:
    """Name and type of every column, in order."""
    return _flat_types(Frame, "") | _flat_types(Target, "target_")


def rows(frames: Iterable[Frame]) -> Iterator[dict[str, Any]]:
    """The rows of the table."""
    for frame in frames:
        common = _flat(frame, "")
        if not frame.targets:
            yield common
        for target in frame.targets:
            yield common | _flat(target, "target_")


def _flat(part: msgspec.Struct, prefix: str) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for field in part.__struct_fields__:
        value = getattr(part, field)
        if isinstance(value, msgspec.Struct):
            values |= _flat(value, f"{prefix}{field}_")
        elif value is not None and prefix + field != "targets":  # those have rows of their own
            values[prefix + field] = _arrow_value(value)
    return values


def _arrow_type(kind: Any) -> Any:
    import pyarrow as pa

    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        hints = typing.get_type_hints(kind)
        return pa.struct([(name, _arrow_type(_plain(hint))) for name, hint in hints.items()])
    if typing.get_origin(kind) is list:
        return pa.list_(_arrow_type(typing.get_args(kind)[0]))
    if typing.get_origin(kind) is dict:
        return pa.map_(*map(_arrow_type, typing.get_args(kind)))
    return {float: pa.float64(), str: pa.string(), bool: pa.bool_()}[kind]


def _arrow_value(value: Any) -> Any:
    if isinstance(value, msgspec.Struct):
        return {field: _arrow_value(getattr(value, field)) for field in value.__struct_fields__}
    if isinstance(value, list):
        return [_arrow_value(item) for item in value]
    return list(value.items()) if isinstance(value, dict) else value


def _flat_types(struct: type[msgspec.Struct], prefix: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, hint in typing.get_type_hints(struct).items():
        kind = _plain(hint)
        if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
            found |= _flat_types(kind, f"{prefix}{name}_")
        elif prefix + name != "targets":
            found[prefix + name] = kind
    return found


def _plain(hint: Any) -> Any:
    """A type without its ``None``."""
    if isinstance(hint, types.UnionType):
        return next(kind for kind in typing.get_args(hint) if kind is not types.NoneType)
    return hint


def _groups(items: Iterator[dict[str, Any]]) -> Iterator[list[dict[str, Any]]]:
    group: list[dict[str, Any]] = []
    for item in items:
        group.append(item)
        if len(group) == _ROWS:
            yield group
            group = []
    if group:
        yield group
