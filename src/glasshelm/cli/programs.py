"""Compiled programs are kept between runs: the second start of a command is seconds faster."""

import os
from pathlib import Path


def keep_compiled() -> None:
    """Keep them in the user's cache folder, unless another one is set."""
    import jax

    if jax.config.values["jax_compilation_cache_dir"] is None:
        root = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
        jax.config.update("jax_compilation_cache_dir", str(root / "glasshelm" / "programs"))
