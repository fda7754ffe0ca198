"""However the server ends, what it wrote to Signal K does not stay behind."""

import os
import signal
import time

import pytest
from tests.bridge.process import PATIENCE_S, start
from tests.feeds.signalk_double import TOKEN, SignalKDouble

from glasshelm.live.signalk_writer import RUDDER, SELF

#: It is killed by nothing here: what it does within this, it does by itself.
SECOND_S = 0.3


def ctrl_c(process):
    process.send_signal(signal.SIGINT)


def ctrl_c_of_the_impatient(process):
    for _ in range(3):
        process.send_signal(signal.SIGINT)
        time.sleep(SECOND_S)


def terminated(process):
    process.send_signal(signal.SIGTERM)


def terminated_then_ctrl_c(process):
    process.send_signal(signal.SIGTERM)
    time.sleep(SECOND_S)
    process.send_signal(signal.SIGINT)


def terminal_closed(process):
    process.send_signal(signal.SIGHUP)


@pytest.fixture(autouse=True)
def _hangups_reach_children():
    """Tests started under nohup ignore SIGHUP, and so would every process that they start."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")
@pytest.mark.parametrize(
    "end", [ctrl_c, ctrl_c_of_the_impatient, terminated, terminated_then_ctrl_c, terminal_closed]
)
def test_nothing_stays_on_signal_k(tmp_path, end):
    with SignalKDouble() as server:
        process, _ = start(
            server.address, "--pilot", "straight", "--log-dir", str(tmp_path),
            "--write-back", "--signalk-token", TOKEN,
        )  # fmt: skip
        try:
            until = time.monotonic() + PATIENCE_S
            while server.written.get((SELF, RUDDER)) is None:
                assert time.monotonic() < until, "it advises nothing"
                time.sleep(0.05)
            end(process)
            process.wait(timeout=PATIENCE_S)
        finally:
            process.kill()
            process.wait(timeout=PATIENCE_S)
        stands = {
            key: value
            for key, value in server.written.items()
            if value is not None
            and not (isinstance(value, dict) and value.get("state") == "normal")
        }
        assert stands == {}
