"""Signal K on the page: live traffic, opening it from the menu, and writing back."""

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    until,
    wait_for_words,
    wait_until_equal,
    words,
)
from tests.feeds.signalk_double import TOKEN, SignalKDouble

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]
ORDER = ("vessels.self", "steering.rudderAngleTarget")


@pytest.fixture(scope="module")
def boat() -> Iterator[SignalKDouble]:
    with SignalKDouble() as boat:
        yield boat


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server], boat: SignalKDouble) -> Server:
    asked = ("--write-back", "--signalk-token", TOKEN, "--pilot", "straight")
    return serve(boat.address, *asked)


def test_live_traffic_is_dead_reckoned_and_the_actual_rudder_is_shown(
    server: Server, open_page: OpenPage, boat: SignalKDouble
) -> None:
    page = open_page(server)
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    wait_for_words(page, "gh-advice", "Rudder P 2.9°")  # what the sensor says
    wait_for_words(page, "gh-advice", "Midships")  # what the pilot advises
    wait_until_equal(lambda: boat.written.get(ORDER), 0.0)
    page.locator("gh-target-list tbody tr .age").first.wait_for()
    seen: set[int] = set()

    def four_between_frames() -> bool:
        """Four times of the clock have been seen within less than the way between two frames."""
        hours, minutes, rest = map(int, re.findall(r"\d\d", words(page, "gh-top-bar .time")))
        seen.add(3600 * hours + 60 * minutes + rest)
        return any(len(seen & set(range(first, first + 5))) >= 4 for first in seen)

    until(four_between_frames)


def test_only_the_servers_own_address_can_be_opened(
    server: Server, open_page: OpenPage, boat: SignalKDouble
) -> None:
    page = open_page(server)
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    _open(page, lambda: page.locator("#scenario").select_option("imazu:1"))
    wait_for_words(page, "gh-top-bar", "Imazu case 1.*pilot straight", PATIENCE_S)  # as now
    wait_until_equal(lambda: boat.written.get(ORDER), None)  # no advice of now stays behind
    _open(page, lambda: page.locator("#scenario").select_option(boat.address))
    wait_for_words(page, "gh-top-bar .state", "^Live$", PATIENCE_S)
    wait_until_equal(lambda: boat.written.get(ORDER), 0.0)
    _open(page, lambda: page.locator("#source").fill("signalk://127.0.0.1:1"))
    wait_for_words(page, "gh-notices .failure", "no source")
    _open(page, lambda: page.locator("#source").fill("imazu:1"))
    wait_for_words(page, "gh-top-bar", "Imazu case 1", PATIENCE_S)
    _open(page, lambda: page.locator("#source").fill(boat.address))
    wait_for_words(page, "gh-top-bar .state", "^Live$")


def _open(page: Any, choose: Callable[[], Any]) -> None:
    page.keyboard.press("?")
    choose()
    page.locator("#open").click()
