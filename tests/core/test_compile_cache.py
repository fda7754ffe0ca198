"""Programs are let go when they are many, and only then."""

import errno
import os
from collections.abc import Iterator
from pathlib import Path

import jax
import jax.numpy as jnp
import pytest
from jax._src import compilation_cache
from tests.broken_disk import BrokenDisk

from glasshelm.core.compile_cache import clear_if_full, enable_compile_cache

told = pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="no maps are told here")


def test_few_programs_are_kept(monkeypatch):
    monkeypatch.setattr(jax, "clear_caches", lambda: pytest.fail("let go"))
    assert not clear_if_full(most=10**9)


@told
def test_many_are_let_go_and_work_again_afterwards():
    traced = []

    @jax.jit
    def twice(x):
        traced.append(x)
        return 2 * x

    assert twice(jnp.ones(())) == 2
    assert clear_if_full(most=0)
    assert twice(jnp.ones(())) == 2
    assert len(traced) == 2


@pytest.fixture
def kept(tmp_path) -> Iterator[Path]:
    """Where programs are kept while the test runs."""
    before = jax.config.values["jax_compilation_cache_dir"]
    jax.config.update("jax_compilation_cache_dir", str(tmp_path / "programs"))
    compilation_cache.reset_cache()
    enable_compile_cache()
    yield tmp_path / "programs"
    jax.config.update("jax_compilation_cache_dir", before)
    compilation_cache.reset_cache()


def computed() -> float:
    """By a program that this process has not compiled yet."""
    jax.clear_caches()
    return float(jax.jit(lambda x: jnp.sin(x).sum() * 3)(jnp.zeros(7)))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Error (reading|writing) persistent")
@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO, errno.EACCES], ids=os.strerror)
def test_a_cache_that_fails_costs_time_alone_and_heals(kept, tmp_path, monkeypatch, code):
    computed()
    whole = {path.name for path in kept.iterdir()}
    assert whole
    disk = BrokenDisk(monkeypatch, tmp_path, code)
    first, failed = 0, True
    while failed:
        first += 1
        for path in kept.iterdir():
            path.unlink()
        compilation_cache.reset_cache()
        disk.fail(first, count=1_000)
        assert computed() == 0.0
        failed = bool(disk.failed)
        disk.heal()
        assert computed() == 0.0
        # What could not be removed is no entry.
        left = {path.name for path in kept.iterdir() if not path.name.startswith(".")}
        assert left == whole
        for name in left:
            compilation_cache.decompress_executable((kept / name).read_bytes())
    assert first > 3


@pytest.mark.filterwarnings("ignore:Error (reading|writing) persistent")
def test_a_program_cut_off_is_written_anew(kept):
    computed()
    for path in kept.iterdir():
        path.write_bytes(path.read_bytes()[:100])
    assert computed() == 0.0
    assert all(path.stat().st_size > 100 for path in kept.iterdir())
