"""The one exception for what a user gave us and cannot be used."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import msgspec

#: What msgspec raises for bytes that are not JSON, or not of the type that they should be.
DECODE_ERRORS = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)


class InputError(ValueError):
    """Bad input. The message is one line: what is wrong, where, and what would be right."""


@contextlib.contextmanager
def hide_paths(name: str, *paths: str | Path) -> Iterator[None]:
    """Errors within name ``name`` instead of the path, so that no folder is shown."""
    try:
        yield
    except InputError as error:
        text = str(error)
        for path in sorted({str(path) for path in paths}, key=len, reverse=True):
            text = text.replace(path, name)
        raise type(error)(text) from None
