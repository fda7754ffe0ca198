"""The folder of a command's results, made and tried before anything is computed."""

import tempfile
from pathlib import Path

from glasshelm.errors import InputError


def writable(folder: Path) -> Path:
    """``folder``, which is there now and can be written in; InputError if that cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (FileExistsError, NotADirectoryError):
        raise InputError(
            f"--out {folder}: there is a file of that name, a folder is needed"
        ) from None
    except OSError as error:
        raise InputError(f"--out {folder}: cannot write there ({error.strerror})") from None
    return folder
