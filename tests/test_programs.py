"""Programs are let go when they are many, and only then."""

from pathlib import Path

import jax
import jax.numpy as jnp
import pytest

from glasshelm.programs import let_go_if_many

told = pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="no maps are told here")


def test_few_programs_are_kept(monkeypatch):
    monkeypatch.setattr(jax, "clear_caches", lambda: pytest.fail("let go"))
    assert not let_go_if_many(most=10**9)


@told
def test_many_are_let_go_and_work_again_afterwards():
    traced = []

    @jax.jit
    def twice(x):
        traced.append(x)
        return 2 * x

    assert twice(jnp.ones(())) == 2
    assert let_go_if_many(most=0)
    assert twice(jnp.ones(())) == 2
    assert len(traced) == 2
