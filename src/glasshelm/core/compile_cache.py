"""Compiled programs: kept between runs, and let go within one before they are too many."""

import contextlib
import gc
import logging
import os
import warnings
from pathlib import Path
from typing import Any

from glasshelm.core.errors import InputError
from glasshelm.core.output_dir import atomic_write

#: Memory maps of a process at which its programs are let go: Linux ends it at 65,530.
MAX_MAPS = 25_000
_log = logging.getLogger("glasshelm")


def enable_compile_cache() -> None:
    """Keep them in the user's cache folder, unless another one is set.

    The second start of a command is seconds faster. If they cannot be kept, that is reported
    once, and they are compiled anew.
    """
    import jax

    if jax.config.values["jax_compilation_cache_dir"] is None:
        root = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
        jax.config.update("jax_compilation_cache_dir", str(root / "glasshelm" / "programs"))
    # A version of JAX that does it otherwise is left alone.
    with contextlib.suppress(ImportError, AttributeError):
        _keep_whole()


def _keep_whole() -> None:
    """Have JAX keep a program whole or not at all, and write anew what it could not read.

    It would leave half of one on a full disk, warn of it at every start and never mend it.
    """
    from jax._src.lru_cache import LRUCache

    really, told = LRUCache.put, set[str]()
    if getattr(really, "whole", False):
        return

    def put(self: Any, key: str, value: bytes) -> None:
        if self.eviction_enabled:
            really(self, key, value)
            return
        try:
            with atomic_write(Path(str(self.path)) / f"{key}-cache") as partial:
                partial.write_bytes(value)
        except InputError as error:
            why = str(error).rpartition(" (")[2].removesuffix(")")
            if why not in told:
                told.add(why)
                _log.warning("compiled programs cannot be kept in %s (%s)", self.path, why)

    put.whole = True  # type: ignore[attr-defined]
    LRUCache.put = put
    warnings.filterwarnings("ignore", "Error (reading|writing) persistent compilation cache entry")


def clear_if_full(most: int = MAX_MAPS) -> bool:
    """Let this process's programs go if they take more memory maps than ``most``.

    For long work of many programs, between its parts: what is needed again is read from where it
    is kept, or compiled anew. Whether they were let go; never where maps are not told (not Linux).
    """
    import jax

    maps = Path("/proc/self/maps")
    if not maps.exists() or len(maps.read_bytes().splitlines()) <= most:
        return False
    jax.clear_caches()
    gc.collect()
    return True
