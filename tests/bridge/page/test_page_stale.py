"""Stale data is never shown as live, and the page recovers by itself."""

import socketserver
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
from pyais.encode import encode_dict
from tests.bridge.page.conftest import PATIENCE_S, Server, until, wait_for_words, wait_until_equal
from tests.bridge.process import free_port

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]


def test_the_page_reports_a_lost_server_and_reconnects(
    serve: Callable[..., Server], open_page: OpenPage
) -> None:
    server = serve("imazu:5", "--pilot", "paper-attention")
    page = open_page(server)
    wait_for_words(page, "gh-top-bar", "Playing")
    wait_until_equal(page.locator("gh-plan .stale-banner").count, 0)
    server.ask({"type": "limits", "dcpa_m": 18520.0, "tcpa_s": 3600.0})
    page.locator("gh-alarm-strip li.unacknowledged").first.wait_for()
    server.kill()
    wait_for_words(page, "gh-top-bar", r"No connection for \d+ s")
    wait_for_words(page, "gh-plan", "NOT LIVE")
    page.locator("gh-plan canvas.stale").wait_for()
    crossed = page.locator("gh-advice .angle")
    until(lambda: "line-through" in crossed.evaluate("e => getComputedStyle(e).textDecoration"))
    page.keyboard.press(" ")
    wait_for_words(page, "gh-notices", "no connection")
    page.locator("gh-alarm-strip li.unacknowledged").first.wait_for()
    page.evaluate("""() => {
        const begin = OscillatorNode.prototype.start;
        OscillatorNode.prototype.start = function (...at) {
            window.sounded = true;
            return begin.apply(this, at);
        };
    }""")
    page.wait_for_function("window.sounded")  # nobody has acknowledged it
    server.start()
    wait_for_words(page, "gh-top-bar", "Playing", PATIENCE_S)
    wait_until_equal(page.locator("gh-plan .stale-banner").count, 0)
    wait_for_words(page, "gh-top-bar", "Imazu case 5")


class Receiver:
    """An AIS receiver on TCP: own ship and one target, one report per second, until unplugged."""

    def __init__(self) -> None:
        self.port = free_port()
        self._plugged = threading.Event()
        receiver = self

        class Line(socketserver.BaseRequestHandler):
            def handle(self) -> None:
                second = 0
                while receiver._plugged.is_set():
                    try:
                        self.request.sendall(receiver.sentences(second))
                    except OSError:
                        return
                    second += 1
                    time.sleep(1.0)

        class Lines(socketserver.ThreadingTCPServer):
            allow_reuse_address, daemon_threads = True, True

        self._lines = Lines
        self._line = Line

    def plug(self) -> None:
        self._plugged.set()
        self._server = self._lines(("127.0.0.1", self.port), self._line)
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def unplug(self) -> None:
        self._plugged.clear()
        self._server.shutdown()
        self._server.server_close()

    def sentences(self, second: int) -> bytes:
        moving = {"type": 1, "speed": 10.0, "status": 0, "second": second % 60}
        north = 10 * second / 3600 / 60
        own = {"mmsi": 230000001, "lat": 59.7 + north, "lon": 24.7, "course": 0.0, "heading": 0}
        other = {"mmsi": 230000102, "lat": 59.76, "lon": 24.74, "course": 270.0, "heading": 270}
        lines = encode_dict({**moving, **own}, talker_id="AI", sentence_type="VDO")
        lines += encode_dict({**moving, **other}, talker_id="AI", sentence_type="VDM")
        return "".join(f"{line}\r\n" for line in lines).encode()


def test_live_traffic_is_live_only_while_data_arrives(
    serve: Callable[..., Server], open_page: OpenPage
) -> None:
    receiver = Receiver()
    receiver.plug()
    try:
        page = open_page(serve(f"tcp://127.0.0.1:{receiver.port}"))
        wait_for_words(page, "gh-top-bar .state", "^Live$")
        wait_for_words(page, "gh-advice", "advises only")
        wait_until_equal(page.get_by_role("button", name="Play").count, 0)
        wait_for_words(page, "gh-target-list tr[data-id='230000102'] .age", r"^\d s$")
        wait_for_words(page, "gh-alarm-strip", "No CPA alarm")
        receiver.unplug()
        wait_for_words(page, "gh-top-bar .state", "not connected|No data")
        wait_for_words(page, "gh-alarm-strip", "CPA not monitored: no current data")
        wait_for_words(page, "gh-plan", "NOT LIVE")
        receiver.plug()
        wait_for_words(page, "gh-top-bar .state", "^Live$", PATIENCE_S)
        wait_until_equal(page.locator("gh-plan .stale-banner").count, 0)
    finally:
        receiver.unplug()
