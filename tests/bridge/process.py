"""``glasshelm bridge`` as a process of its own, and where it is."""

import collections
import contextlib
import os
import re
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from typing import Any

import websockets.sync.client as ws

#: What the server does takes so long on a crowded machine, programs to compile and all [s].
PATIENCE_S = 300.0

#: Ports of this process, bound as long as it lives.
_ours: list[socket.socket] = []


def start(
    *args: str, heard: list[str] | None = None, files: int | None = None, **environment: str
) -> tuple[subprocess.Popen[str], str]:
    """A bridge in a process of its own, at a port that it chooses, and its address.

    What it says later is put into ``heard``; it may open so many ``files``.
    """
    command = [sys.executable, "-m", "glasshelm", "bridge", *args, "--no-open", "--port", "0"]
    if files is not None:
        command = ["sh", "-c", f'ulimit -n {files}; exec "$@"', "sh", *command]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, env=os.environ | environment
    )
    assert process.stderr is not None
    said = []
    for line in process.stderr:
        said.append(line)
        found = re.search(r"http://(\S+)/", line)
        if found:
            # What it says from now on is read, lest it wait for a reader.
            later = collections.deque(maxlen=0) if heard is None else heard
            threading.Thread(target=later.extend, args=(process.stderr,), daemon=True).start()
            return process, f"ws://{found[1]}/ws"
    raise AssertionError(f"the bridge did not start: {''.join(said)}")


@contextlib.contextmanager
def viewing(url: str, **options: Any) -> Iterator[ws.ClientConnection]:
    """A viewer of it who takes nobody for gone who is only slow."""
    options |= {"open_timeout": PATIENCE_S, "ping_interval": None, "max_size": None}
    with ws.connect(url, **options) as viewer:
        yield viewer


def free_port() -> int:
    """A port that nobody listens on, and that nobody else is given while this process lives.

    On Linux a server may be bound beside what is bound and does not listen, if both reuse addresses
    (as the servers of Python and the bridge do). Elsewhere the port is only free at the moment.
    """
    bound = _bound(0)
    port = bound.getsockname()[1]
    try:
        with _bound(port) as beside:
            beside.listen()
    except OSError:
        bound.close()
    else:
        _ours.append(bound)
    return port


def _bound(port: int) -> socket.socket:
    one = socket.socket()
    one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        one.bind(("127.0.0.1", port))
    except OSError:
        one.close()
        raise
    return one
