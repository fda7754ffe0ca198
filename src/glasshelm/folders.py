"""The folder that a command writes in, made and tried before anything is computed."""

import tempfile
from pathlib import Path

from glasshelm.errors import InputError


def writable(folder: Path) -> Path:
    """``folder``, which is there now and can be written in; InputError if that cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        a_file = isinstance(error, FileExistsError | NotADirectoryError)
        problem = "a file has that name, a folder is needed" if a_file else error.strerror
        raise InputError(f"{folder}: cannot write there ({problem})") from None
    return folder
