"""Recorded traffic: many ships, a pilot who only advises, and what lies outside her training."""

from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.conftest import Server, words

Visit = Callable[..., Any]


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    server = serve("gulf-of-finland")
    server.ask({"type": "pause"}, {"type": "seek", "time_s": 300})
    return server


def test_advice_is_called_advice_and_time_is_utc(server: Server, look: Visit) -> None:
    page, shown = look(server), server.shown()
    advice = words(page, "gh-advice")
    assert "ADVICE" in advice.upper()
    assert "advises only" in advice
    assert "no sensor" in advice, "the recording has no rudder"
    clock = shown["frame"]["frame"]["time_utc"][11:19]
    assert f"{clock} UTC" in words(page, "gh-top-bar")


def test_what_lies_outside_the_training_is_flagged(server: Server, look: Visit) -> None:
    outside = server.shown()["frame"]["frame"]["outside"]
    page = look(server)
    flag = page.locator("gh-outside p")
    assert "Outside the pilot's training" in flag.inner_text()
    assert outside[0] in flag.inner_text()
    page.keyboard.press("3")
    for line in outside:
        assert line in flag.inner_text()


def test_list_is_small_until_asked_and_ages_are_told(server: Server, look: Visit) -> None:
    page = look(server)
    targets = server.shown()["frame"]["frame"]["targets"]
    rows = page.locator("gh-target-list tbody tr")
    assert rows.count() == 6
    page.get_by_role("button", name=f"All {len(targets)}").click()
    assert rows.count() == len(targets)
    for target in targets[:20]:
        age = page.locator(f"gh-target-list tr[data-id='{target['id']}'] .age").inner_text()
        age_s = target["age_s"]
        expected = f"{round(age_s)} s" if age_s < 99.5 else f"{round(age_s / 60)} min"
        assert expected in age
        assert ("lost" in age) == bool(target.get("lost"))


def test_colours_are_one_a_ship(server: Server, look: Visit) -> None:
    """Six ships of note, six numbers, none twice; the same in list and plots."""
    page = look(server, level=3)
    numbers = [n for n in page.locator("gh-target-list .chip").all_inner_texts() if n.strip()]
    assert sorted(numbers) == ["1", "2", "3", "4", "5", "6"]
    colours = page.locator("gh-target-list .chip").evaluate_all(
        "all => all.filter(e => e.textContent.trim())"
        ".map(e => [e.textContent.trim(), getComputedStyle(e).backgroundColor])"
    )
    drawn = (
        page.locator("gh-why article")
        .first.locator(".chip")
        .evaluate_all(
            "all => all.map(e => [e.textContent.trim(), getComputedStyle(e).backgroundColor])"
        )
    )
    told = dict(colours)
    assert drawn
    assert all(told[number] == colour for number, colour in drawn)


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (1024, 768), (820, 1180)])
@pytest.mark.parametrize("level", [1, 2, 3])
def test_nothing_is_cut_off(
    server: Server, look: Visit, width: int, height: int, level: int
) -> None:
    page = look(server, width, height, level=level)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate("document.documentElement.scrollHeight") <= height
    plan = page.locator("gh-plan").bounding_box()
    assert min(plan["width"], plan["height"]) > 400, "the plan stays the largest thing"
    too_wide = page.locator("gh-target-list .scroll").evaluate("e => e.scrollWidth - e.clientWidth")
    assert too_wide <= 0
    last = page.locator("aside > *").last.bounding_box()
    scrolled = page.locator("aside").evaluate("e => e.scrollHeight > e.clientHeight + 1")
    under = page.locator("gh-transport").bounding_box()
    assert scrolled or last["y"] + last["height"] <= under["y"] + 1, "nothing lies on another"
    seen = page.locator("gh-target-list tbody tr").evaluate_all(
        """rows => {
            const room = rows[0].closest(".scroll").getBoundingClientRect();
            return rows.filter(row => row.getBoundingClientRect().bottom <= room.bottom + 1).length;
        }"""
    )
    assert seen >= 4, "four ships are in full sight"
