"""What a test needs and this machine has not: a skip at a desk, a failure in CI."""

import importlib
import os
from typing import Any, NoReturn

import pytest


def missing(what: str) -> NoReturn:
    """Skip the test that needs ``what``; where CI is set, fail it."""
    if os.environ.get("CI", "").lower() not in ("", "0", "false"):
        pytest.fail(f"missing in CI: {what}", pytrace=False)
    pytest.skip(what)


def needed(module: str) -> Any:
    """The module of that name, or :func:`missing`."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError:
        missing(f"{module} is not installed: make install")
