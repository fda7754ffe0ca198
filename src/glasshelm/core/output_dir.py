"""What a command writes: the folder is tried before anything is computed, files are there whole."""

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows has no such locks
    fcntl = None

from glasshelm.core.errors import InputError


def writable_folder(folder: Path) -> Path:
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


@contextlib.contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """Where to write a file that shall be at ``path`` whole or not at all.

    It takes the place of what was there when the block ends, once it is on the disk. Where that
    fails, or the block does, what was there stays; where the process is killed, a hidden file of
    the same suffix is left beside it. InputError if it cannot be written.
    """
    path = Path(path)
    partial = path.with_name(f".{os.getpid()}-{path.name[-100:]}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield partial
        with open(partial, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(partial, path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            partial.unlink()
        if isinstance(error, OSError):
            raise InputError(f"{path}: cannot write it ({error.strerror or error})") from None
        raise


@contextlib.contextmanager
def locked_folder(folder: Path) -> Iterator[Path]:
    """``folder``, writable (:func:`writable_folder`) and written in by nobody else meanwhile.

    InputError if another process has it. The claim ends with the process,
    however that ends; the empty file ``.lock`` stays.
    """
    with open(writable_folder(folder) / ".lock", "ab") as lock:
        if fcntl is not None:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise InputError(
                    f"{folder}: another process is at work there: wait for it, "
                    "or choose another --out"
                ) from None
            except OSError:  # a file system without locks
                pass
        yield folder
