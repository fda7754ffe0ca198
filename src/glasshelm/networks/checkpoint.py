"""Weights on disk: one safetensors file a checkpoint, configuration in its header.

Tensors are named by their path in the pytree (``actor.head.weights.0``). The
header carries the resolved configuration as JSON, so that a file alone can be
rebuilt. No pickle.
"""

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from glasshelm.core.errors import InputError
from glasshelm.core.output_dir import atomic_write

Tree = TypeVar("Tree")
FORMAT = "glasshelm-1"
#: What safetensors calls the types of numpy.
_DTYPES = {
    "BOOL": "bool", "U8": "uint8", "I8": "int8", "U16": "uint16", "I16": "int16",
    "U32": "uint32", "I32": "int32", "U64": "uint64", "I64": "int64",
    "F16": "float16", "F32": "float32", "F64": "float64",
}  # fmt: skip


class CheckpointError(InputError):
    """A weights file that cannot be used; the message says which, why and what to do."""


def save_tree(path: Path, tree: Any, header: dict[str, Any]) -> str:
    """Write the arrays of a pytree with a JSON header; returns the file's SHA-256.

    The file appears whole or not at all: a crash while writing leaves the old one. Its bytes
    depend on nothing but the arrays and the header. InputError if it cannot be written.
    """
    tensors = {name: np.asarray(leaf) for name, leaf in _named(tree)}
    data = save(tensors, metadata={"format": FORMAT, "header": json.dumps(header)})
    digest = hashlib.sha256()
    with atomic_write(path) as partial, open(partial, "wb") as file:
        for part in _in_order(data):
            file.write(part)
            digest.update(part)
    return digest.hexdigest()


def _in_order(data: bytes) -> tuple[bytes, memoryview]:
    """A safetensors file whose metadata are in order: the library writes them in any."""
    size = int.from_bytes(data[:8], "little")
    head = json.loads(data[8 : 8 + size])
    head["__metadata__"] = dict(sorted(head["__metadata__"].items()))
    text = json.dumps(head, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    return len(text).to_bytes(8, "little") + text, memoryview(data)[8 + size :]


def read_header(path: Path) -> dict[str, Any]:
    """The JSON header of a checkpoint; CheckpointError if the file is not one."""
    if os.path.isdir(path):
        raise CheckpointError(f"{path}: a folder, not a weights file")
    with _opened(path) as file:
        metadata = file.metadata() or {}
    if metadata.get("format") != FORMAT:
        raise CheckpointError(
            f"{path}: not a glasshelm checkpoint "
            f"(format {metadata.get('format')!r}, not {FORMAT!r})"
        )
    try:
        header = json.loads(metadata.get("header", ""))
    except (ValueError, RecursionError):
        header = None
    if not isinstance(header, dict):
        raise CheckpointError(f"{path}: its header cannot be read; fetch or train it again")
    return header


def load_tree(path: Path, like: Tree) -> Tree:
    """The pytree ``like`` with its arrays replaced by those of a file.

    ``like`` may have :class:`jax.ShapeDtypeStruct` in place of arrays. CheckpointError if a
    tensor is missing, left over, or of another shape: before any is read.
    """
    read_header(path)
    wanted = dict(_named(like))
    with _opened(path) as file:
        names = set(file.keys())
        if names != set(wanted):
            odd = sorted(names ^ set(wanted))[0]
            what = "lacks" if odd in wanted else "has an unexpected"
            raise CheckpointError(f"{path}: weights of another architecture ({what} tensor {odd})")
        for name, leaf in wanted.items():
            part = file.get_slice(name)
            there = f"{_DTYPES.get(part.get_dtype(), part.get_dtype())}{list(part.get_shape())}"
            expected = f"{leaf.dtype}{list(leaf.shape)}"
            if there != expected:
                raise CheckpointError(
                    f"{path}: weights of another architecture (tensor {name} is {there}, "
                    f"expected {expected})"
                )
        stored = {name: file.get_tensor(name) for name in names}
    arrays, rest = eqx.partition(like, _is_array)
    paths, structure = jax.tree_util.tree_flatten_with_path(arrays)
    leaves = [jax.numpy.asarray(stored[_name(path)]) for path, _ in paths]
    return eqx.combine(jax.tree_util.tree_unflatten(structure, leaves), rest)


def file_sha256(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The safetensors file; CheckpointError if it is none."""
    try:
        with safe_open(path, framework="numpy") as file:
            yield file
    except FileNotFoundError:
        raise CheckpointError(f"{path}: no such weights file") from None
    except (SafetensorError, OSError) as error:
        raise CheckpointError(
            f"{path}: damaged or not a safetensors file ({error}); fetch or train it again"
        ) from None


def _is_array(leaf: Any) -> bool:
    return eqx.is_array(leaf) or isinstance(leaf, jax.ShapeDtypeStruct)


def _named(tree: Any) -> list[tuple[str, Any]]:
    arrays = eqx.filter(tree, _is_array)
    return [(_name(path), leaf) for path, leaf in jax.tree_util.tree_leaves_with_path(arrays)]


def _name(path: tuple[Any, ...]) -> str:
    return jax.tree_util.keystr(path, simple=True, separator=".")
