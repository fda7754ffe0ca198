"""Signal K on the page: live, opened from the menu and by its name, and written back to."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from tests.bridge.page.conftest import PAGE_S, PATIENCE_S, Server, wait_for_words, words
from tests.feeds.signalk_double import TOKEN, SignalKDouble

Visit = Callable[..., Any]
ORDER = ("vessels.self", "steering.rudderAngleTarget")


@pytest.fixture(scope="module")
def boat() -> Iterator[SignalKDouble]:
    with SignalKDouble() as boat:
        yield boat


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server], boat: SignalKDouble) -> Server:
    asked = ("--write-back", "--signalk-token", TOKEN, "--pilot", "straight")
    return serve(boat.address, *asked)


def until(done: Callable[[], bool], seconds: float = PAGE_S) -> None:
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.1)


def test_live_traffic_moves_between_frames_and_the_actual_rudder_is_shown(
    server: Server, look: Visit, boat: SignalKDouble
) -> None:
    page = look(server)
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    assert "Rudder P 2.9°" in words(page, "gh-advice"), "what the sensor says"
    assert "Midships" in words(page, "gh-advice"), "what the pilot advises"
    until(lambda: boat.written.get(ORDER) == 0.0)
    page.locator("gh-target-list tbody tr .age").first.wait_for()
    clocks = set()
    for _ in range(40):  # four seconds: less than the way from one frame to the next
        clocks.add(words(page, "gh-top-bar .time"))
        page.wait_for_timeout(100)
    assert len(clocks) >= 4


def test_it_is_opened_from_the_menu_and_by_name_and_nothing_else_is(
    server: Server, look: Visit, boat: SignalKDouble
) -> None:
    page = look(server)
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    _open(page, lambda: page.locator("#scenario").select_option("imazu:1"))
    wait_for_words(page, "gh-top-bar", "Imazu case 1.*pilot straight", PATIENCE_S)  # as now
    until(lambda: boat.written.get(ORDER) is None)  # no advice of now stays behind
    _open(page, lambda: page.locator("#scenario").select_option(boat.address))
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    until(lambda: boat.written.get(ORDER) == 0.0)
    _open(page, lambda: page.locator("#source").fill("signalk://127.0.0.1:1"))
    wait_for_words(page, "gh-notices .failure", "no source")
    _open(page, lambda: page.locator("#source").fill("imazu:1"))
    wait_for_words(page, "gh-top-bar", "Imazu case 1")
    _open(page, lambda: page.locator("#source").fill(boat.address))
    wait_for_words(page, "gh-top-bar .state", "^Live$")


def _open(page: Any, choose: Callable[[], Any]) -> None:
    page.keyboard.press("?")
    choose()
    page.locator("#open").click()
