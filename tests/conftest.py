"""Every shape annotation of glasshelm is checked while tests run.

And what a test finds is not that of the machine: its terminal, its cache of programs.
"""

import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("JAX_PLATFORMS", "cpu")
# Most of a test's time is XLA compiling small programs. So they are compiled quickly, not well
# (XLA_FLAGS= in the environment has them as users do; tests/golden always does), and kept: the
# other workers, the processes that tests start and the next run find them.
os.environ.setdefault(
    "XLA_FLAGS",
    "--xla_backend_optimization_level=0 --xla_llvm_disable_expensive_passes=true "
    "--xla_cpu_use_fusion_emitters=false --xla_cpu_opt_preset=FAST_COMPILE",
)
os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(Path(__file__).parents[1] / ".cache/jax"))
os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"
os.environ["JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES"] = "0"

import pytest
from hypothesis import HealthCheck, settings
from jaxtyping import install_import_hook

install_import_hook("glasshelm", "beartype.beartype")

# What is printed is the same on any terminal, and on none.
for name in ("COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE"):
    os.environ.pop(name, None)

# How fast examples are drawn is the machine's business.
settings.register_profile(
    "here",
    deadline=None,
    max_examples=50,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("here")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Several workers begin with the modules that have slow tests, and end with small ones."""
    if hasattr(config, "workerinput"):
        slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
        items.sort(key=lambda item: -slow[item.path])


@pytest.fixture(autouse=True, scope="module")
def _programs_forgotten() -> Iterator[None]:
    """Compiled programs of earlier modules are let go before there are too many to map."""
    from glasshelm.core.compile_cache import clear_if_full  # not before its shapes are checked

    yield
    clear_if_full()
