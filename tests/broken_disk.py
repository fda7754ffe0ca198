"""A disk that fails when it is told to, as SQLite tries it: every call in turn."""

import builtins
import errno
import io
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

#: The calls on an open file that a disk may refuse.
_OF_FILES = ("write", "flush", "truncate", "read", "readline", "seek", "close")
#: Those on paths and descriptors.
_OF_SYSTEM = ("fsync", "replace", "rename", "mkdir", "pread", "fstat", "unlink")


class BrokenDisk:
    """Counts the calls on files under ``folder``; the ``first``-th fails, and ``count`` in all.

    A write that fails has written half of what it was given. ``failed`` names the calls that did.
    """

    def __init__(self, monkeypatch: Any, folder: Path, code: int = errno.ENOSPC):
        self.calls = 0
        self.failed: list[str] = []
        self._folder, self._code = str(folder), code
        self._first, self._count = 0, 0
        really = builtins.open

        def opened(file: Any, mode: str = "r", *args: Any, **more: Any) -> Any:
            if not self._ours(file):
                return really(file, mode, *args, **more)
            self._called("open")
            return _File(really(file, mode, *args, **more), self)

        for module in (builtins, io):
            monkeypatch.setattr(module, "open", opened)
        for name in _OF_SYSTEM:
            monkeypatch.setattr(os, name, self._wrapped(name, getattr(os, name)))

    def fail(self, first: int, count: int = 1) -> None:
        """From now on the ``first``-th call fails (from 1), and ``count`` calls from there on."""
        self.calls, self.failed = 0, []
        self._first, self._count = first, count

    def heal(self) -> None:
        self._count = 0

    def _ours(self, file: Any) -> bool:
        if isinstance(file, int):
            try:
                file = os.readlink(f"/proc/self/fd/{file}")
            except OSError:
                return False
        return str(file).startswith(self._folder)

    def _called(self, name: str) -> None:
        self.calls += 1
        if self._first <= self.calls < self._first + self._count:
            self.failed.append(name)
            raise OSError(self._code, os.strerror(self._code))

    def _wrapped(self, name: str, really: Callable[..., Any]) -> Callable[..., Any]:
        def call(file: Any, *args: Any, **more: Any) -> Any:
            if self._count and self._ours(file):
                self._called(name)
            return really(file, *args, **more)

        return call


class _File:
    """A file of the broken disk."""

    def __init__(self, file: Any, disk: BrokenDisk):
        self._file, self._disk = file, disk

    def __getattr__(self, name: str) -> Any:
        really = getattr(self._file, name)
        if name not in _OF_FILES:
            return really

        def call(*args: Any) -> Any:
            try:
                self._disk._called(name)
            except OSError:
                if name == "write":
                    self._file.write(args[0][: len(args[0]) // 2])
                raise
            return really(*args)

        return call

    def __enter__(self) -> "_File":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[Any]:
        return iter(self._file)
