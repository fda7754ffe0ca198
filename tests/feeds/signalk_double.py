"""A small server of Signal K's protocol, in a thread: says a recording, keeps what is written.

Quick where the real one (``signalk_server``) is slow to start. Own ship has a rudder sensor.
"""

import contextlib
import json
import threading
import time
from datetime import datetime
from typing import Any

from benchmarks.feeds_fuzz import recording, signalk
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection, serve

TOKEN = "secret"
RUDDER_RAD = -0.05
#: So much of the recording is said at once [s].
BEFORE_S = 20.0


class SignalKDouble:
    """For as long as the block lasts. ``written`` holds the last value of each context and path."""

    def __init__(self) -> None:
        self.written: dict[tuple[str, str], Any] = {}
        self._said = list(signalk(recording()))

    def __enter__(self) -> "SignalKDouble":
        self._server = serve(self._talk, "127.0.0.1", 0)
        self.address = f"signalk://127.0.0.1:{self._server.socket.getsockname()[1]}"
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()

    def _talk(self, line: ServerConnection) -> None:
        assert line.request is not None
        with contextlib.suppress(ConnectionClosed):
            if line.request.path.endswith("subscribe=none"):
                assert line.request.headers["Authorization"] == f"Bearer {TOKEN}"
                for text in line:
                    self._take(json.loads(text))
            else:
                self._say(line)

    def _say(self, line: ServerConnection) -> None:
        hello, *deltas = self._said
        line.send(hello)
        own, begun, first = json.loads(hello)["self"], time.monotonic(), None
        for text in deltas:
            delta = json.loads(text)
            update = delta["updates"][0]
            told = datetime.fromisoformat(update["timestamp"]).timestamp()
            first = told if first is None else first
            time.sleep(max(told - first - BEFORE_S - (time.monotonic() - begun), 0.0))
            if delta["context"] == own:
                update["values"].append({"path": "steering.rudderAngle", "value": RUDDER_RAD})
            line.send(json.dumps(delta))

    def _take(self, delta: dict[str, Any]) -> None:
        for update in delta["updates"]:
            for one in update["values"]:
                self.written[delta["context"], one["path"]] = one["value"]
