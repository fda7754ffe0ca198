"""Recorded traffic: many ships, a pilot that only advises, and the training envelope."""

import math
import re
from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.conftest import Server, until, wait_for_words, wait_until_equal

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    server = serve("gulf-of-finland", "--pilot", "paper-attention")
    server.ask({"type": "pause"}, {"type": "seek", "time_s": 300})
    return server


def test_advice_is_labelled_as_advice_and_time_is_utc(server: Server, open_page: OpenPage) -> None:
    page, shown = open_page(server), server.shown()
    wait_for_words(page, "gh-advice", "(?i)advice.*advises only")
    wait_for_words(page, "gh-advice", "no sensor")  # the recording has no rudder
    cog = round(math.degrees(shown["frame"]["frame"]["own"]["heading_rad"])) % 360
    wait_for_words(page, "gh-advice", f"COG {cog:03d}° SOG")  # her heading is not known
    page.keyboard.press("?")
    page.get_by_role("heading", name="Who advises").wait_for()
    clock = shown["frame"]["frame"]["time_utc"][11:19]
    wait_for_words(page, "gh-top-bar .time", f"{clock} UTC")


def test_a_situation_outside_the_training_envelope_is_flagged(
    server: Server, open_page: OpenPage
) -> None:
    outside = server.shown()["frame"]["frame"]["outside_training"]
    page = open_page(server)
    wait_for_words(
        page, "gh-envelope-warning p", f"Outside the pilot's training: {re.escape(outside[0])}"
    )
    page.keyboard.press("3")
    for line in outside:
        wait_for_words(page, "gh-envelope-warning p", re.escape(line))


def test_the_list_expands_on_request_and_shows_ages(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    targets = server.shown()["frame"]["frame"]["targets"]
    rows = page.locator("gh-target-list tbody tr")
    wait_until_equal(rows.count, 6)
    page.get_by_role("button", name=f"All {len(targets)}").click()
    wait_until_equal(rows.count, len(targets))
    for target in targets[:20]:
        age_s, lost = target["age_s"], "lost " if target.get("lost") else ""
        age = f"{round(age_s)} s" if age_s < 99.5 else f"{round(age_s / 60)} min"
        row = f"gh-target-list tr[data-id='{target['id']}']"
        wait_for_words(page, f"{row} .age", f"^{lost}{age}$")


def badges(page: Any, part: str) -> list[tuple[str, str]]:
    """The ship badges in a part of the page: number and colour."""
    told = page.locator(f"{part} .badge").evaluate_all(
        "all => all.map(e => [e.textContent.trim(), getComputedStyle(e).backgroundColor])"
    )
    return sorted((number, colour) for number, colour in told if number)


def test_each_coloured_ship_has_its_own_colour(server: Server, open_page: OpenPage) -> None:
    """Six coloured ships have six numbers, the same in list and plots."""
    page = open_page(server, level=3)
    wait_until_equal(
        lambda: [number for number, _ in badges(page, "gh-target-list")], list("123456")
    )
    plot = "gh-explanation article:first-child"
    page.locator(f"{plot} .badge").first.wait_for()
    until(lambda: set(badges(page, plot)) <= set(badges(page, "gh-target-list")))


def layout_faults(page: Any, width: int, height: int) -> list[str]:
    """What is cut off or too small on a page of this size."""
    whole = page.evaluate(
        "(({scrollWidth, scrollHeight}) => [scrollWidth, scrollHeight])(document.documentElement)"
    )
    plan = page.locator("gh-plan").bounding_box()
    too_wide = page.locator("gh-target-list .scroll").evaluate("e => e.scrollWidth - e.clientWidth")
    last = page.locator("aside > *").last.bounding_box()
    scrolled = page.locator("aside").evaluate("e => e.scrollHeight > e.clientHeight + 1")
    under = page.locator("gh-transport").bounding_box()
    seen = page.locator("gh-target-list tbody tr").evaluate_all(
        """rows => {
            const room = rows[0]?.closest(".scroll").getBoundingClientRect();
            return rows.filter(row => row.getBoundingClientRect().bottom <= room.bottom + 1).length;
        }"""
    )
    plots = page.locator("gh-explanation gh-plot").evaluate_all(
        "all => all.map(e => e.clientHeight)"
    )
    titles = page.locator("gh-explanation article header").evaluate_all(
        "all => all.filter(e => e.scrollWidth > e.clientWidth).map(e => e.textContent)"
    )
    found = {
        "the page": whole[0] > width or whole[1] > height,
        "the plan, which stays the largest thing": min(plan["width"], plan["height"]) <= 400,
        "the list": too_wide > 0,
        "what lies on another": not scrolled and last["y"] + last["height"] > under["y"] + 1,
        "four ships": seen < 4,
        "plots": any(height < 90 for height in plots),
        "titles": titles != [],
    }
    return [what for what, is_so in found.items() if is_so]


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (1024, 768), (820, 1180)])
@pytest.mark.parametrize("level", [1, 2, 3])
def test_nothing_is_cut_off(
    server: Server, open_page: OpenPage, width: int, height: int, level: int
) -> None:
    page = open_page(server, width, height, level=level)
    alarms = server.shown()["alarms"]["alarms"]
    wait_until_equal(page.locator("gh-target-list tr.alarm").count, len(alarms))
    wait_until_equal(lambda: layout_faults(page, width, height), [])
