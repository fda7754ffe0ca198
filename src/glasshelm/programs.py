"""Compiled programs: kept between runs, and let go within one before they are too many."""

import gc
import os
from pathlib import Path

#: Memory maps of a process at which its programs are let go: Linux ends it at 65,530.
MOST_MAPS = 25_000


def keep_compiled() -> None:
    """Keep them in the user's cache folder, unless another one is set.

    The second start of a command is seconds faster.
    """
    import jax

    if jax.config.values["jax_compilation_cache_dir"] is None:
        root = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
        jax.config.update("jax_compilation_cache_dir", str(root / "glasshelm" / "programs"))


def let_go_if_many(most: int = MOST_MAPS) -> bool:
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
