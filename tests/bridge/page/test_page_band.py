"""The certified band on the rudder scale, shown only for its own frame."""

import math
import re
from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.axe import axe_violations
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    until,
    wait_for_pressed,
    wait_for_words,
    wait_until_equal,
    words,
)

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]
BRACKET = "gh-advice path.bracket"
WITHIN = "while errors stay within 10 m, 0.5°, 0.1 kn"


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    return serve("random:35", "--pilot", "paper-sum", "--sensor-errors", "10,0.5,0.1")


def begin(server: Server, pilot: str) -> None:
    """Open the encounter, paused at five minutes."""
    server.ask(
        {"type": "open", "source": "random:35", "pilot": pilot, "ship": "paper"},
        {"type": "pause"},
        {"type": "seek", "time_s": 300},
    )


def wait_for_bracket(page: Any) -> None:
    """Wait until a band is shown; for the first one programs are compiled."""
    page.wait_for_selector(BRACKET, timeout=1000 * PATIENCE_S)


def edges(page: Any, part: str) -> tuple[float, float]:
    """Left and right edge of a part of the scale [px]."""
    box = page.locator(part).bounding_box()
    return box["x"], box["x"] + box["width"]


def test_the_advised_rudder_lies_within_the_bracket(server: Server, open_page: OpenPage) -> None:
    begin(server, "paper-sum")
    page = open_page(server)
    wait_for_bracket(page)

    def within() -> bool:
        low, high = edges(page, BRACKET)
        left, right = edges(page, "gh-advice path.order-mark")
        return low <= (left + right) / 2 <= high

    until(within)
    order = math.degrees(server.shown()["frame"]["frame"]["decision"]["rudder_rad"])
    midships = abs(order) < 0.45
    sure = "amidships" if midships else f"to {'starboard' if order > 0 else 'port'}"
    words_of_it = f"certain: {sure}|{'amidships' if midships else 'side'} not certain"
    # No more than this at first.
    wait_for_words(page, "gh-advice .band-text", f"(?i)^({words_of_it})$")


def test_higher_levels_show_the_band_and_its_errors(server: Server, open_page: OpenPage) -> None:
    begin(server, "paper-sum")
    page = open_page(server, level=2)
    wait_for_words(page, "gh-advice .band-text", WITHIN, PATIENCE_S)
    said = words(page, "gh-advice .band-text")
    found = re.search(r"between ([\d.]+)°(?: to (\w+))? and ([\d.]+)° to (\w+)", said)
    assert found or "any rudder is possible" in said
    if found:
        order = math.degrees(server.shown()["frame"]["frame"]["decision"]["rudder_rad"])
        sign = {"port": -1.0, "starboard": 1.0}
        a = float(found[1]) * sign[found[2] or found[4]]
        b = float(found[3]) * sign[found[4]]
        assert min(a, b) <= order <= max(a, b)


def test_the_band_disappears_with_its_frame(server: Server, open_page: OpenPage) -> None:
    begin(server, "paper-sum")
    page = open_page(server)
    wait_for_bracket(page)
    server.ask({"type": "rate", "rate": 60}, {"type": "play"})
    page.wait_for_selector(BRACKET, state="detached")
    server.ask({"type": "pause"})
    wait_for_bracket(page)


def test_an_attention_pilot_has_no_band_and_level_3_says_why(
    server: Server, open_page: OpenPage
) -> None:
    begin(server, "paper-attention")
    page = open_page(server, level=3)
    wait_for_words(page, "gh-advice", "(?i)no certified band: paper-attention has an att")
    wait_until_equal(page.locator(BRACKET).count, 0)
    page.keyboard.press("1")
    wait_for_pressed(page, "gh-top-bar", "Basic")
    until(lambda: "certified" not in words(page, "gh-advice"))


@pytest.mark.parametrize("palette", ["day", "dusk", "night"])
def test_axe_finds_no_serious_fault_beside_a_band(
    server: Server, open_page: OpenPage, palette: str
) -> None:
    begin(server, "paper-sum")
    page = open_page(server, palette=palette, level=2)
    wait_for_bracket(page)
    assert axe_violations(page) == []
