"""Weights on disk: one safetensors file a checkpoint, configuration in its header.

Tensors are named by their path in the pytree (``actor.head.weights.0``). The
header carries the resolved configuration as JSON, so that a file alone can be
rebuilt. No pickle.
"""

import hashlib
import json
from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from glasshelm.errors import InputError
from glasshelm.folders import whole

Tree = TypeVar("Tree")
FORMAT = "glasshelm-1"


class CheckpointError(InputError):
    """A weights file that cannot be used; the message says which, why and what to do."""


def save_tree(path: Path, tree: Any, header: dict[str, Any]) -> str:
    """Write the arrays of a pytree with a JSON header; returns the file's SHA-256.

    The file appears whole or not at all: a crash while writing leaves the old one. InputError if
    it cannot be written.
    """
    tensors = {name: np.asarray(leaf) for name, leaf in _named(tree)}
    data = save(tensors, metadata={"format": FORMAT, "header": json.dumps(header)})
    with whole(path) as partial:
        partial.write_bytes(data)
    return hashlib.sha256(data).hexdigest()


def read_header(path: Path) -> dict[str, Any]:
    """The JSON header of a checkpoint; CheckpointError if the file is not one."""
    if path.is_dir():
        raise CheckpointError(f"{path}: a folder, not a weights file")
    try:
        with safe_open(path, framework="numpy") as file:
            metadata = file.metadata() or {}
    except FileNotFoundError:
        raise CheckpointError(f"{path}: no such weights file") from None
    except (SafetensorError, OSError) as error:
        raise CheckpointError(
            f"{path}: damaged or not a safetensors file ({error}); fetch or train it again"
        ) from None
    if metadata.get("format") != FORMAT:
        raise CheckpointError(
            f"{path}: not a glasshelm checkpoint "
            f"(format {metadata.get('format')!r}, not {FORMAT!r})"
        )
    try:
        header = json.loads(metadata.get("header", ""))
    except json.JSONDecodeError:
        header = None
    if not isinstance(header, dict):
        raise CheckpointError(f"{path}: its header cannot be read; fetch or train it again")
    return header


def load_tree(path: Path, like: Tree) -> Tree:
    """The pytree ``like`` with its arrays replaced by those of a file.

    CheckpointError if a tensor is missing, left over, or of another shape.
    """
    read_header(path)
    with safe_open(path, framework="numpy") as file:
        stored = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    wanted = dict(_named(like))
    if set(stored) != set(wanted):
        odd = sorted(set(stored) ^ set(wanted))[0]
        what = "lacks" if odd in wanted else "has an unexpected"
        raise CheckpointError(f"{path}: weights of another architecture ({what} tensor {odd})")
    for name, leaf in wanted.items():
        if stored[name].shape != leaf.shape or stored[name].dtype != leaf.dtype:
            raise CheckpointError(
                f"{path}: weights of another architecture (tensor {name} is "
                f"{stored[name].dtype}{list(stored[name].shape)}, "
                f"expected {leaf.dtype}{list(leaf.shape)})"
            )
    arrays, rest = eqx.partition(like, eqx.is_array)
    paths, structure = jax.tree_util.tree_flatten_with_path(arrays)
    leaves = [jax.numpy.asarray(stored[_name(path)]) for path, _ in paths]
    return eqx.combine(jax.tree_util.tree_unflatten(structure, leaves), rest)


def file_sha256(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _named(tree: Any) -> list[tuple[str, Any]]:
    arrays = eqx.filter(tree, eqx.is_array)
    return [(_name(path), leaf) for path, leaf in jax.tree_util.tree_leaves_with_path(arrays)]


def _name(path: tuple[Any, ...]) -> str:
    return jax.tree_util.keystr(path, simple=True, separator=".")
