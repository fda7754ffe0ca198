import hashlib
import os

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.core.errors import InputError
from glasshelm.networks import checkpoint
from glasshelm.networks.checkpoint import (
    CheckpointError,
    file_sha256,
    load_tree,
    read_header,
    save_tree,
)
from glasshelm.networks.mlp import Mlp, relu

HEADER = {"preset": "tiny", "ship": {"gain_1_s": 0.1827}, "steps": 3}


def network(sizes=(3, 4, 2), seed: int = 0) -> Mlp:
    mlp = Mlp(sizes, relu, jax.random.key(seed))
    return eqx.tree_at(lambda m: m.biases[0], mlp, mlp.biases[0] + 0.25)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "deep" / "pilot.safetensors"


def test_round_trip_is_exact(path):
    tree = {"actor": network(), "step": jnp.int32(7), "key": jax.random.key_data(jax.random.key(3))}
    sha = save_tree(path, tree, HEADER)
    blank = {"actor": network(seed=9), "step": jnp.int32(0), "key": jnp.zeros(2, jnp.uint32)}
    found = load_tree(path, blank)
    for a, b in zip(jax.tree.leaves(tree), jax.tree.leaves(found), strict=True):
        if eqx.is_array(a):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)
    assert found["actor"].activation is blank["actor"].activation
    assert read_header(path) == HEADER
    assert sha == file_sha256(path) == hashlib.sha256(path.read_bytes()).hexdigest()


def test_tensors_are_named_by_their_path_and_hold_no_code(path):
    save_tree(path, {"actor": network()}, HEADER)
    head = path.read_bytes()[:2000]
    assert b'"actor.weights.0"' in head
    assert b'"actor.biases.1"' in head


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99])
def test_truncated_file_is_told_as_such(path, share):
    save_tree(path, network(), HEADER)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(CheckpointError, match=r"pilot\.safetensors: damaged") as error:
        load_tree(path, network())
    assert "\n" not in str(error.value)
    assert isinstance(error.value, InputError)


def test_other_files_are_told_as_such(path):
    with pytest.raises(CheckpointError, match="no such weights file"):
        read_header(path)
    path.parent.mkdir()
    path.write_bytes(b"not weights at all " * 100)
    with pytest.raises(CheckpointError, match="damaged or not a safetensors file"):
        read_header(path)
    from safetensors.numpy import save_file

    save_file({"x": np.zeros(3)}, path)
    with pytest.raises(CheckpointError, match="not a glasshelm checkpoint"):
        read_header(path)
    with pytest.raises(CheckpointError, match="a folder, not a weights file"):
        read_header(path.parent)


@pytest.mark.parametrize("header", [None, "{", "[1]"])
def test_a_header_that_is_no_configuration_is_told_as_such(path, header):
    from safetensors.numpy import save_file

    path.parent.mkdir()
    metadata = {"format": checkpoint.FORMAT} | ({} if header is None else {"header": header})
    save_file({"x": np.zeros(3)}, path, metadata)
    with pytest.raises(CheckpointError, match="header cannot be read") as error:
        read_header(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("like", "what"),
    [
        (lambda: network((3, 5, 2)), r"tensor (weights|biases)\.0 is .*expected float32"),
        (lambda: network((3, 4, 4, 2)), "lacks tensor"),
        (lambda: network((3, 2)), "has an unexpected tensor"),
        (lambda: jax.tree.map(lambda x: x.astype(jnp.float16), network()), "expected float16"),
    ],
)
def test_weights_of_another_architecture_are_told_as_such(path, like, what):
    save_tree(path, network(), HEADER)
    with pytest.raises(CheckpointError, match=f"weights of another architecture.*{what}"):
        load_tree(path, like())


def test_crash_while_writing_leaves_the_old_file(path, monkeypatch):
    save_tree(path, network(seed=1), HEADER)
    before = path.read_bytes()

    def crash(file):
        raise OSError("disk full")

    monkeypatch.setattr(os, "fsync", crash)
    with pytest.raises(InputError, match=f"{path.name}: cannot write it .disk full"):
        save_tree(path, network(seed=2), HEADER)
    assert path.read_bytes() == before
    monkeypatch.undo()
    save_tree(path, network(seed=2), HEADER)
    assert path.read_bytes() != before
    assert os.listdir(path.parent) == [path.name]


def test_alike_is_alike_to_the_byte(path):
    """The library writes metadata in any order; a file's hash must not depend on it."""
    assert len({save_tree(path, network(), HEADER) for _ in range(20)}) == 1
    assert read_header(path) == HEADER
    assert eqx.tree_equal(load_tree(path, network(seed=5)), network())


def test_nothing_is_allocated_for_what_is_not_there(path):
    """Sizes of 4 TB in ``like`` are refused by the file's own, before any array is made."""
    save_tree(path, network(), HEADER)
    like = eqx.filter_eval_shape(lambda: network((10**6, 10**6, 2)))
    with pytest.raises(CheckpointError, match="expected float32"):
        load_tree(path, like)
    shapes = eqx.filter_eval_shape(network)
    assert eqx.tree_equal(load_tree(path, shapes), network())
