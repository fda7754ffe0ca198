"""Asking "what if" on the page: the answer in words, its dashed track, and that both go again."""

from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    becomes,
    canvas,
    other_canvas,
    until,
    wait_for_words,
    words,
)

Visit = Callable[..., Any]


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    server = serve("imazu:5")
    server.ask(
        {"type": "limits", "dcpa_m": 0.0, "tcpa_s": 0.0},
        {"type": "pause"},
        {"type": "seek", "time_s": 0},
    )
    return server


def test_what_if_she_were_not_there_is_told_and_drawn_until_dismissed(
    server: Server, look: Visit
) -> None:
    page, other = look(server), look(server)
    panel = page.locator("gh-what-if")
    question = panel.get_by_role("button", name="What if this ship were not there?")
    wait_for_words(page, "gh-what-if", "(?i)what if")
    becomes(question.count, 0)
    page.locator("gh-target-list tr[data-id='2']").click()
    page.mouse.move(5, 5)
    page.locator("gh-target-list tr.selected:not(.hovered)[data-id='2']").wait_for()
    before = canvas(page)
    question.click()
    wait_for_words(page, "gh-what-if", "Without ship 2, the pilot would", PATIENCE_S)
    wait_for_words(page, "gh-what-if", "other ships do not react")
    page.mouse.move(5, 5)
    other_canvas(page, before)
    # Only who asked is told: what all are told after it has come to the other.
    server.ask({"type": "limits", "dcpa_m": 0.0, "tcpa_s": 60.0})
    wait_for_words(other, "gh-alarm-strip", "0.00 NM, 1 min")
    wait_for_words(other, "gh-what-if", "(?i)what if")
    assert "Without ship 2" not in words(other, "gh-what-if")
    panel.get_by_role("button", name="Dismiss").click()
    page.mouse.move(5, 5)
    until(lambda: "Without ship 2" not in words(page, "gh-what-if"))
    becomes(lambda: canvas(page), before)


@pytest.mark.parametrize(
    ("question", "told"),
    [
        ("What if the pilot did not see this ship?", "If the pilot did not see ship 2"),
        ("What if this ship kept its course and speed?", "If ship 2 kept her course"),
    ],
)
def test_the_other_questions_about_a_ship(
    server: Server, look: Visit, question: str, told: str
) -> None:
    page = look(server)
    page.locator("gh-target-list tr[data-id='2']").click()
    page.locator("gh-what-if").get_by_role("button", name=question).click()
    wait_for_words(page, "gh-what-if", f"{told}.*other ships do not react", PATIENCE_S)


@pytest.mark.parametrize("palette", ["day", "dusk", "night"])
def test_what_if_the_rudder_went_over_has_an_ink_of_its_own(
    server: Server, look: Visit, palette: str
) -> None:
    page = look(server, palette=palette)
    page.get_by_role("button", name="What if the rudder went to P 5° now, for a minute?").click()
    wait_for_words(page, "gh-what-if", "With the rudder 5° to port for 60 s", PATIENCE_S)
    inks = page.evaluate(
        """() => ["what-if", "path", "compare", "own", "sea"].map(name =>
            getComputedStyle(document.documentElement).getPropertyValue(`--gh-${name}`).trim())"""
    )
    assert all(inks)
    assert inks[0] not in inks[1:]


def test_an_answer_goes_when_time_jumps(server: Server, look: Visit) -> None:
    page = look(server)
    page.get_by_role("button", name="What if the rudder went to S 5° now, for a minute?").click()
    wait_for_words(page, "gh-what-if", "With the rudder 5° to starboard", PATIENCE_S)
    server.ask({"type": "seek", "time_s": 60})
    wait_for_words(page, "gh-top-bar .time", "01:00")
    until(lambda: "With the rudder" not in words(page, "gh-what-if"))
    server.ask({"type": "seek", "time_s": 0})
