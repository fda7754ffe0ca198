"""What-if questions on the page: the answer, its dashed track, and their removal."""

from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    canvas,
    until,
    wait_for_other_canvas,
    wait_for_words,
    wait_until_equal,
    words,
)

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    server = serve("imazu:5", "--pilot", "paper-attention")
    server.ask(
        {"type": "limits", "dcpa_m": 0.0, "tcpa_s": 0.0},
        {"type": "pause"},
        {"type": "seek", "time_s": 0},
    )
    return server


def test_a_what_if_answer_is_shown_until_dismissed(server: Server, open_page: OpenPage) -> None:
    page, other = open_page(server), open_page(server)
    panel = page.locator("gh-what-if")
    question = panel.get_by_role("button", name="What if this ship were not there?")
    wait_for_words(page, "gh-what-if", "(?i)what if")
    wait_until_equal(question.count, 0)
    page.locator("gh-target-list tr[data-id='2']").click()
    page.mouse.move(5, 5)
    page.locator("gh-target-list tr.selected:not(.hovered)[data-id='2']").wait_for()
    before = canvas(page)
    question.click()
    wait_for_words(page, "gh-what-if", "Without ship 2, the pilot would", PATIENCE_S)
    wait_for_words(page, "gh-what-if", "other ships do not react")
    page.mouse.move(5, 5)
    wait_for_other_canvas(page, before)
    # Only the viewer who asked gets the answer: the other has received a later message.
    server.ask({"type": "limits", "dcpa_m": 0.0, "tcpa_s": 60.0})
    wait_for_words(other, "gh-alarm-strip", "0.00 NM, 1 min")
    wait_for_words(other, "gh-what-if", "(?i)what if")
    assert "Without ship 2" not in words(other, "gh-what-if")
    panel.get_by_role("button", name="Dismiss").click()
    page.mouse.move(5, 5)
    until(lambda: "Without ship 2" not in words(page, "gh-what-if"))
    wait_until_equal(lambda: canvas(page), before)


@pytest.mark.parametrize(
    ("question", "told"),
    [
        ("What if the pilot did not see this ship?", "If the pilot did not see ship 2"),
        ("What if this ship kept its course and speed?", "If ship 2 kept her course"),
    ],
)
def test_the_other_questions_about_a_ship(
    server: Server, open_page: OpenPage, question: str, told: str
) -> None:
    page = open_page(server)
    page.locator("gh-target-list tr[data-id='2']").click()
    page.locator("gh-what-if").get_by_role("button", name=question).click()
    wait_for_words(page, "gh-what-if", f"{told}.*other ships do not react", PATIENCE_S)


@pytest.mark.parametrize("palette", ["day", "dusk", "night"])
def test_the_what_if_track_has_its_own_colour(
    server: Server, open_page: OpenPage, palette: str
) -> None:
    page = open_page(server, palette=palette)
    page.get_by_role("button", name="What if the rudder went to P 5° now, for a minute?").click()
    wait_for_words(page, "gh-what-if", "With the rudder 5° to port for 60 s", PATIENCE_S)
    inks = page.evaluate(
        """() => ["what-if", "path", "compare", "own", "sea"].map(name =>
            getComputedStyle(document.documentElement).getPropertyValue(`--gh-${name}`).trim())"""
    )
    assert all(inks)
    assert inks[0] not in inks[1:]


def test_an_answer_disappears_when_time_jumps(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    page.get_by_role("button", name="What if the rudder went to S 5° now, for a minute?").click()
    wait_for_words(page, "gh-what-if", "With the rudder 5° to starboard", PATIENCE_S)
    server.ask({"type": "seek", "time_s": 60})
    wait_for_words(page, "gh-top-bar .time", "01:00")
    until(lambda: "With the rudder" not in words(page, "gh-what-if"))
    server.ask({"type": "seek", "time_s": 0})
