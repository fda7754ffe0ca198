"""``glasshelm bridge`` as a process of its own, and where it is."""

import os
import re
import socket
import subprocess
import sys


def start(*args: str, **environment: str) -> tuple[subprocess.Popen[str], str]:
    """A bridge in a process of its own, and its address as it prints it."""
    command = [sys.executable, "-m", "glasshelm", "bridge", *args, "--no-open"]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, env=os.environ | environment
    )
    assert process.stderr is not None
    said = []
    for line in process.stderr:
        said.append(line)
        found = re.search(r"http://(\S+)/", line)
        if found:
            return process, f"ws://{found[1]}/ws"
    raise AssertionError(f"the bridge did not start: {''.join(said)}")


def free_port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]
