"""Every shape annotation of glasshelm is checked while tests run."""

import os

os.environ.setdefault("JAX_PLATFORMS", "cpu")

from hypothesis import settings
from jaxtyping import install_import_hook

install_import_hook("glasshelm", "beartype.beartype")

settings.register_profile("here", deadline=None, max_examples=50, derandomize=True)
settings.load_profile("here")
