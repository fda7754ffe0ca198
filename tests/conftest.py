"""Every shape annotation of glasshelm is checked while tests run."""

import gc
import os
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("JAX_PLATFORMS", "cpu")

import jax
import pytest
from hypothesis import settings
from jaxtyping import install_import_hook

install_import_hook("glasshelm", "beartype.beartype")

# Most of a test's time is XLA compiling small programs: the next run finds them here.
jax.config.update("jax_compilation_cache_dir", str(Path(__file__).parents[1] / ".cache" / "jax"))
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)

settings.register_profile("here", deadline=None, max_examples=50, derandomize=True)
settings.load_profile("here")

#: Memory maps of a process at which its programs are forgotten: Linux ends it at 65,530.
MOST_MAPS = 25_000


@pytest.fixture(autouse=True, scope="module")
def _programs_forgotten() -> Iterator[None]:
    """Compiled programs of earlier modules are let go before there are too many to map."""
    yield
    maps = Path("/proc/self/maps")
    if maps.exists() and len(maps.read_bytes().splitlines()) > MOST_MAPS:
        jax.clear_caches()
        gc.collect()
