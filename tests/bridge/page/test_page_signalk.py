"""Signal K on the page: live, opened from the menu and by its name, and written back to."""

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    becomes,
    until,
    wait_for_words,
    words,
)
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


def test_live_traffic_moves_between_frames_and_the_actual_rudder_is_shown(
    server: Server, look: Visit, boat: SignalKDouble
) -> None:
    page = look(server)
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    wait_for_words(page, "gh-advice", "Rudder P 2.9°")  # what the sensor says
    wait_for_words(page, "gh-advice", "Midships")  # what the pilot advises
    becomes(lambda: boat.written.get(ORDER), 0.0)
    page.locator("gh-target-list tbody tr .age").first.wait_for()
    seen: set[int] = set()

    def four_between_frames() -> bool:
        """Four times of the clock have been seen within less than the way between two frames."""
        hours, minutes, rest = map(int, re.findall(r"\d\d", words(page, "gh-top-bar .time")))
        seen.add(3600 * hours + 60 * minutes + rest)
        return any(len(seen & set(range(first, first + 5))) >= 4 for first in seen)

    until(four_between_frames)


def test_it_is_opened_from_the_menu_and_by_name_and_nothing_else_is(
    server: Server, look: Visit, boat: SignalKDouble
) -> None:
    page = look(server)
    wait_for_words(page, "gh-top-bar .state", "^Live$")
    _open(page, lambda: page.locator("#scenario").select_option("imazu:1"))
    wait_for_words(page, "gh-top-bar", "Imazu case 1.*pilot straight", PATIENCE_S)  # as now
    becomes(lambda: boat.written.get(ORDER), None)  # no advice of now stays behind
    _open(page, lambda: page.locator("#scenario").select_option(boat.address))
    wait_for_words(page, "gh-top-bar .state", "^Live$", PATIENCE_S)
    becomes(lambda: boat.written.get(ORDER), 0.0)
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
