"""A real signalk-server on loopback, with its Gulf of Finland sample and security switched on."""

import contextlib
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

from tests.bridge.process import free_port

ROOT = Path(__file__).parents[2] / ".cache" / "signalk"
PACKAGE = ROOT / "node_modules" / "signalk-server"
STARTS_WITHIN_S = 300.0
#: Hand an open file on as number 3 and become another program.
_AS_THIRD = "import os, sys; os.dup2(int(sys.argv[1]), 3); os.execvp(sys.argv[2], sys.argv[2:])"


def why_not() -> str | None:
    """Why the server cannot be run here; None if it can."""
    if not (ROOT / "installed").is_file():
        return "signalk-server is not installed: run scripts/install-signalk"
    return None if shutil.which("node") else "no Node to run signalk-server with"


class SignalKServer:
    """One server. It listens on a loopback socket that is handed to it, and nowhere else."""

    def __init__(self, room: Path):
        self.room = room
        settings = {
            "interfaces": {"tcp": False, "nmea-tcp": False},
            "mdns": False,
            "security": {"strategy": "./tokensecurity"},
        }
        security = {
            "allow_readonly": True,
            "secretKey": "0123456789abcdef" * 4,
            "users": [{"username": "glasshelm", "type": "readwrite"}],
        }
        (room / "settings.json").write_text(json.dumps(settings))
        (room / "security.json").write_text(json.dumps(security))
        (room / "security.json").chmod(0o600)
        self._process: subprocess.Popen | None = None
        self.port = free_port()

    @property
    def address(self) -> str:
        return f"signalk://127.0.0.1:{self.port}"

    def token(self) -> str:
        """A token that may write."""
        command = ["node", PACKAGE / "bin" / "signalk-generate-token", "-u", "glasshelm"]
        command += ["-e", "1d", "-s", self.room / "security.json"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    def start(self) -> None:
        with socket.socket() as listening, (self.room / "log").open("a") as log:
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.bind(("127.0.0.1", self.port))
            listening.listen(64)
            # As a service started by its socket (LISTEN_FDS) it opens no port of its own.
            self._process = subprocess.Popen(
                [
                    sys.executable, "-c", _AS_THIRD, str(listening.fileno()), "node",
                    PACKAGE / "bin" / "signalk-server", "-c", self.room, "--sample-n2k-data",
                ],
                env={**os.environ, "LISTEN_FDS": "1", "SIGNALK_DISABLE_SERVER_UPDATES": "true"},
                pass_fds=[listening.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )  # fmt: skip
        until = time.monotonic() + STARTS_WITHIN_S
        while self.get("/signalk") is None:
            if self._process.poll() is not None or time.monotonic() > until:
                raise RuntimeError(f"signalk-server: {(self.room / 'log').read_text()[-2000:]}")
            time.sleep(0.3)

    def stop(self) -> None:
        if self._process is not None:
            self._process.terminate()
            try:
                self._process.wait(10)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait(10)
        self._process = None

    def get(self, path: str):
        """What a path of the REST interface holds; None if nothing is there."""
        url = f"http://127.0.0.1:{self.port}{path}"
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        with contextlib.suppress(urllib.error.URLError, OSError), opener.open(url, timeout=5) as r:
            return json.load(r)
        return None

    def vessel(self, path: str, number: str = "self"):
        """A value under a vessel."""
        return self.get(f"/signalk/v1/api/vessels/{number}/{path.replace('.', '/')}")
