"""The kinds of sources that no other module shows on the page."""

import json
import socket
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from tests.bridge.page.conftest import PATIENCE_S, Server, wait_for_words, wait_until_equal
from tests.bridge.page.test_page_stale import Receiver
from tests.bridge.process import free_port

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]


@pytest.fixture
def port() -> Iterator[int]:
    """The port to which a receiver sends one datagram per second."""
    chosen, said, over = free_port(), Receiver().sentences, threading.Event()

    def send() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            second = 0
            while not over.wait(1.0):
                line.sendto(said(second), ("127.0.0.1", chosen))
                second += 1

    thread = threading.Thread(target=send)
    thread.start()
    yield chosen
    over.set()
    thread.join()


def test_nmea_over_udp(serve: Callable[..., Server], open_page: OpenPage, port: int) -> None:
    page = open_page(serve(f"udp://127.0.0.1:{port}", "--pilot", "straight"))
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    wait_for_words(page, "gh-target-list tr[data-id='230000102'] .age", r"^\d s$")
    page.keyboard.press("?")
    page.locator("#compare").select_option("paper-waypoint")
    page.get_by_role("button", name="Close").click()
    wait_for_words(page, "gh-comparison tbody tr.compared", "paper-waypoint", PATIENCE_S)


@pytest.fixture
def recording(tmp_path: Any) -> Any:
    """Ten minutes of that traffic, with tag blocks."""
    path = tmp_path / "traffic.nmea"
    lines = []
    for second in range(600):
        for line in Receiver().sentences(second).decode().split():
            tag = f"c:{1_700_000_000 + second}"
            check = 0
            for letter in tag.encode():
                check ^= letter
            lines.append(f"\\{tag}*{check:02X}\\{line}")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_an_nmea_file_as_live_source_and_as_recording(
    serve: Callable[..., Server], open_page: OpenPage, recording: Any
) -> None:
    page = open_page(serve(f"live:{recording}", "--pilot", "straight"))
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    wait_for_words(page, "gh-top-bar .time", "^22:1")  # the time of the recording
    page.locator("gh-target-list tr[data-id='230000102']").wait_for()
    wait_until_equal(page.get_by_role("button", name="Play").count, 0)
    page = open_page(serve(str(recording), "--own", "230000001", "--pilot", "straight"))
    wait_for_words(page, "gh-top-bar", "Recorded")
    page.locator("gh-target-list tr[data-id='230000102']").wait_for()
    wait_until_equal(page.get_by_role("button", name="Pause").count, 1)


def test_a_dnv_traffic_situation(
    serve: Callable[..., Server], open_page: OpenPage, tmp_path: Any
) -> None:
    def ship(latitude: float, course: float, **static: Any) -> dict[str, Any]:
        position = {"latitude": latitude, "longitude": 10.0}
        initial = {"position": position, "sog": 10.0, "cog": course, "heading": course}
        return {"initial": initial, "static": static}

    path = tmp_path / "situation.json"
    situation = {
        "title": "Head-on off nowhere",
        "ownShip": ship(58.9, 0.0),
        "targetShips": [ship(59.0, 180.0, id=7, name="SEVEN")],
    }
    path.write_text(json.dumps(situation))
    page = open_page(serve(str(path), "--pilot", "straight"))
    wait_for_words(page, "gh-top-bar", "Simulated")
    wait_for_words(page, "gh-target-list", "SEVEN")
    assert str(tmp_path) not in page.content(), "the page never learns where the file lies"
