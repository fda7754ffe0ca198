"""A viewer sees everything and gets no owner controls."""

import dataclasses
from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.axe import axe_violations
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    until,
    wait_for_words,
    wait_until_equal,
    words,
)

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]
OWNER, VIEWER = "owner-0123456789", "viewer-0123456789"
#: Records the messages that a page sends, without pings.
SENT = """
  () => {
    const send = WebSocket.prototype.send;
    window.sent = [];
    WebSocket.prototype.send = function (text) {
      if (!text.includes('"ping"')) window.sent.push(text);
      send.call(this, text);
    };
  }
"""


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    """Paused, with a ship under alarm."""
    begun = serve("imazu:1", "--pilot", "paper-sum", "--viewer-token", VIEWER, token=OWNER)
    begun.ask(
        {"type": "pause"},
        {"type": "limits", "dcpa_m": 18520.0, "tcpa_s": 3600.0},
        {"type": "seek", "time_s": 120},
    )
    return begun


@pytest.fixture
def viewer(server: Server) -> Server:
    return dataclasses.replace(server, token=VIEWER)


@pytest.mark.parametrize("level", [1, 2, 3])
@pytest.mark.parametrize("size", [(1280, 800), (1024, 1366)])
def test_a_viewer_sees_everything_and_has_no_owner_controls(
    server: Server, viewer: Server, open_page: OpenPage, level: int, size: tuple[int, int]
) -> None:
    page = open_page(viewer, *size, level=level)
    page.evaluate(SENT)
    sign = page.get_by_text("View only", exact=True)
    sign.wait_for()
    box = sign.bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= size[0]
    wait_for_words(page, "gh-transport", "02:00")
    wait_for_words(page, "gh-alarm-strip", "CPA .* NM in")
    assert "cknowledge" not in words(page, "gh-alarm-strip")
    assert page.locator("gh-target-list tbody tr").count() >= 1
    for name in ("Play", "Time", "Speed"):
        assert page.locator("gh-transport").get_by_label(name, exact=True).is_disabled()
    for key in (" ", "ArrowLeft", "ArrowRight", "a"):
        page.keyboard.press(key)
    if level > 1:
        page.locator("gh-explanation gh-plot .u-over").first.wait_for()
    for plot in page.locator("gh-explanation gh-plot .u-over").all():
        plot.click(force=True)
    page.keyboard.press("?")
    menu = page.locator("gh-menu dialog")
    menu.wait_for()
    assert menu.get_by_role("heading").all_inner_texts() == [
        "Menu",
        "ABOUT THIS SESSION",
        "CPA ALARM",
        "SHORTCUTS",
    ]
    assert page.get_by_label("CPA [NM]").is_disabled()
    assert page.get_by_label("CPA [NM]").input_value() == "10.00"
    assert menu.get_by_role("button").all_inner_texts() == ["Close"]
    assert "Acknowledge the most urgent" not in words(page, "gh-menu dialog dl:last-of-type")
    page.get_by_role("button", name="Close").click()
    assert page.evaluate("window.sent") == []
    shown = server.shown()
    assert not shown["session"]["playing"]
    assert shown["session"]["time_s"] == 120.0
    assert shown["alarms"]["alarms"][0]["state"] == "unacknowledged"


def test_a_viewer_follows_the_owner_and_asks_what_if(
    server: Server, viewer: Server, open_page: OpenPage
) -> None:
    page = open_page(viewer)
    page.evaluate(SENT)
    page.get_by_role("button", name="What if the rudder went to S 5° now, for a minute?").click()
    wait_for_words(page, "gh-what-if p", "rudder", PATIENCE_S)
    assert [text for text in page.evaluate("window.sent") if "whatif" not in text] == []
    server.ask({"type": "seek", "time_s": 180})
    wait_for_words(page, "gh-transport", "03:00")
    server.ask({"type": "seek", "time_s": 120})


def test_the_role_survives_a_reload_without_the_token(
    server: Server, viewer: Server, open_page: OpenPage
) -> None:
    page = open_page(viewer)
    plain = viewer.url.split("?")[0]
    page.goto(plain)
    page.get_by_text("View only", exact=True).wait_for()
    # The same browser with the owner's address is the owner's, and stays it.
    page.goto(server.url)
    page.get_by_role("button", name="Play").wait_for()
    until(lambda: page.get_by_role("button", name="Play").is_enabled())
    page.goto(plain)
    until(lambda: page.get_by_role("button", name="Play").is_enabled())
    wait_until_equal(lambda: page.get_by_text("View only", exact=True).count(), 0)


@pytest.mark.parametrize("palette", ["day", "night"])
def test_axe_finds_no_serious_fault_in_the_viewer_s_page(
    viewer: Server, open_page: OpenPage, palette: str
) -> None:
    page = open_page(viewer, palette=palette)
    page.keyboard.press("?")
    page.locator("gh-menu dialog").wait_for()
    assert axe_violations(page) == []
