"""The certified band on the rudder scale: round the rudder that it is for, and no other."""

import math
import re
from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.axe import faults
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    becomes,
    until,
    wait_for_pressed,
    wait_for_words,
    words,
)

Visit = Callable[..., Any]
BRACKET = "gh-advice path.bracket"
WITHIN = "while errors stay within 10 m, 0.5°, 0.1 kn"


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    return serve("random:35", "--pilot", "paper-sum", "--errors", "10,0.5,0.1")


def begin(server: Server, pilot: str) -> None:
    """At five minutes of the voyage, paused."""
    server.ask(
        {"type": "open", "source": "random:35", "pilot": pilot, "ship": "paper"},
        {"type": "pause"},
        {"type": "seek", "time_s": 300},
    )


def bracketed(page: Any) -> None:
    """Until a band is shown: the programs for the first one are compiled."""
    page.wait_for_selector(BRACKET, timeout=1000 * PATIENCE_S)


def edges(page: Any, part: str) -> tuple[float, float]:
    """Left and right edge of a part of the scale [px]."""
    box = page.locator(part).bounding_box()
    return box["x"], box["x"] + box["width"]


def test_the_advised_rudder_lies_within_the_bracket(server: Server, look: Visit) -> None:
    begin(server, "paper-sum")
    page = look(server)
    bracketed(page)

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


def test_deeper_levels_say_between_which_rudders_and_for_which_errors(
    server: Server, look: Visit
) -> None:
    begin(server, "paper-sum")
    page = look(server, level=2)
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


def test_the_band_goes_with_its_frame(server: Server, look: Visit) -> None:
    begin(server, "paper-sum")
    page = look(server)
    bracketed(page)
    server.ask({"type": "rate", "rate": 60}, {"type": "play"})
    page.wait_for_selector(BRACKET, state="detached")
    server.ask({"type": "pause"})
    bracketed(page)


def test_an_attention_pilot_has_none_and_the_third_level_says_so(
    server: Server, look: Visit
) -> None:
    begin(server, "paper-attention")
    page = look(server, level=3)
    wait_for_words(page, "gh-advice", "(?i)no certified band: paper-attention has an att")
    becomes(page.locator(BRACKET).count, 0)
    page.keyboard.press("1")
    wait_for_pressed(page, "gh-top-bar", "Basic")
    until(lambda: "certified" not in words(page, "gh-advice"))


@pytest.mark.parametrize("palette", ["day", "dusk", "night"])
def test_axe_finds_no_serious_fault_beside_a_band(
    server: Server, look: Visit, palette: str
) -> None:
    begin(server, "paper-sum")
    page = look(server, palette=palette, level=2)
    bracketed(page)
    assert faults(page) == []
