"""Every control beside those of the voyage: each is operated, and what it does is seen."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.conftest import PATIENCE_S, Server, wait_for_words, words

Visit = Callable[..., Any]


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    return serve("gulf-of-finland", "--pilot", "straight")


@pytest.fixture(autouse=True)
def voyage(server: Server) -> None:
    """Each test begins at five minutes of the same recording, paused, without alarms."""
    server.ask(
        {"type": "open", "source": "gulf-of-finland", "pilot": "straight"},
        {"type": "limits", "dcpa_m": 0.0, "tcpa_s": 0.0},
        {"type": "pause"},
        {"type": "seek", "time_s": 300},
    )


def canvas(page: Any) -> bytes:
    page.mouse.move(5, 5)
    return page.locator("gh-plan canvas").screenshot()


def pressed(page: Any, part: str, name: str) -> bool:
    button = page.locator(part).get_by_role("button", name=name, exact=True)
    return button.get_attribute("aria-pressed") == "true"


def marked(page: Any, kind: str) -> list[str]:
    """The ids of the rows that are selected or hovered."""
    return page.locator(f"gh-target-list tr.{kind}").evaluate_all(
        "all => all.map(row => row.dataset.id)"
    )


def test_shortcuts_work_while_the_slider_has_the_focus(server: Server, look: Visit) -> None:
    page = look(server)
    slider = page.get_by_label("Time", exact=True).last
    slider.focus()
    page.keyboard.press("h")
    assert pressed(page, "gh-plan-bar", "H UP")
    page.keyboard.press("+")
    assert "3 NM" in words(page, "gh-plan-bar")
    page.keyboard.press("2")
    assert pressed(page, "gh-top-bar", "Why")
    page.keyboard.press(" ")
    wait_for_words(page, "gh-top-bar .state", "Playing")
    page.keyboard.press(" ")
    wait_for_words(page, "gh-top-bar .state", "Paused")
    server.ask({"type": "seek", "time_s": 120})
    wait_for_words(page, "gh-transport", "^02:00")
    # Its own keys are its own: a step of the slider, not the page's minute.
    for key, clock in (("ArrowRight", "02:05"), ("ArrowLeft", "02:00"), ("Home", "00:00")):
        page.keyboard.press(key)
        wait_for_words(page, "gh-transport", f"^{clock}")
    assert slider.evaluate("e => e.getRootNode().activeElement === e")


def test_a_list_in_focus_keeps_its_digits_and_nothing_else(server: Server, look: Visit) -> None:
    page = look(server)
    page.get_by_label("Vector time").focus()
    page.keyboard.press("v")
    assert pressed(page, "gh-plan-bar", "R")
    page.keyboard.press("3")
    assert pressed(page, "gh-top-bar", "Look"), "the digit was the list's"


def test_vectors_and_trails_are_as_long_as_they_say(server: Server, look: Visit) -> None:
    page = look(server)
    bar = page.locator("gh-plan-bar")
    for label, choices in (
        ("Vector time", ("1", "3", "6", "12", "20", "30")),
        ("Trail time", ("0", "3", "6")),  # five minutes have been sailed
    ):
        seen = set()
        for minutes in choices:
            bar.get_by_label(label).select_option(minutes)
            seen.add(canvas(page))
        assert len(seen) == len(choices), label
    bar.get_by_label("Vector time").select_option("6")
    page.locator("gh-plan canvas").focus()
    for key, minutes in (("]", "12"), ("]", "20"), ("[", "12")):
        page.keyboard.press(key)
        assert bar.get_by_label("Vector time").input_value() == minutes
    page.keyboard.press("v")
    assert pressed(page, "gh-plan-bar", "R")
    relative = canvas(page)
    bar.get_by_role("button", name="T", exact=True).click()
    assert canvas(page) != relative


def test_orientation_and_motion_turn_and_shift_the_picture(server: Server, look: Visit) -> None:
    page = look(server)
    seen = {}
    for name in ("N UP", "H UP", "C UP", "TM"):
        page.locator("gh-plan-bar").get_by_role("button", name=name, exact=True).click()
        seen[name] = canvas(page)
    assert len(set(seen.values())) == 4
    page.locator("gh-plan canvas[aria-label*='course-up, true motion']").wait_for()


def test_range_by_buttons_keys_and_wheel(server: Server, look: Visit) -> None:
    page = look(server)
    bar = page.locator("gh-plan-bar")
    for nm in ("3", "1.5", "0.75"):
        bar.get_by_role("button", name="Smaller range").click()
        assert f"{nm} NM" in words(page, "gh-plan-bar")
    for nm in ("1.5", "3", "6", "12", "24"):
        page.keyboard.press("-")
        assert f"{nm} NM rings" in words(page, "gh-plan-bar")
    assert bar.get_by_role("button", name="Larger range").is_disabled()
    box = page.locator("gh-plan").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 200)
    page.mouse.wheel(0, -100)
    wait_for_words(page, "gh-plan-bar", "12 NM rings 2 NM")
    page.mouse.wheel(0, 100)
    wait_for_words(page, "gh-plan-bar", "24 NM rings 4 NM")


def test_a_click_on_the_picture_selects_the_ship_there(server: Server, look: Visit) -> None:
    page = look(server, level=3)
    box = page.locator("gh-plan").bounding_box()
    radius = min(box["width"], box["height"]) / 2 - 34
    frame = server.shown()["frame"]["frame"]
    heading = frame["own"]["heading_rad"]

    def place(target: dict[str, Any]) -> tuple[float, float]:
        reach = target["range_m"] / (6 * 1852) * radius
        angle = heading + target["bearing_rad"]
        x = box["x"] + box["width"] / 2 + reach * math.sin(angle)
        return x, box["y"] + box["height"] / 2 - reach * math.cos(angle)

    near = {t["id"]: place(t) for t in frame["targets"] if t["range_m"] < 5.5 * 1852}
    alone = max(near, key=lambda id: min(math.dist(near[id], near[o]) for o in near if o != id))
    page.mouse.click(*near[alone])
    page.mouse.move(5, 5)
    assert marked(page, "selected") == [alone]
    assert marked(page, "hovered") == []
    page.mouse.click(box["x"] + 4, box["y"] + 4)
    assert marked(page, "selected") == []


def test_detail_and_palette_by_their_buttons(server: Server, look: Visit) -> None:
    page = look(server)
    top = page.locator("gh-top-bar")
    plan = page.locator("gh-plan")
    widths = []
    for name in ("Look", "Why", "All"):
        top.get_by_role("button", name=name, exact=True).click()
        assert pressed(page, "gh-top-bar", name)
        widths.append(plan.bounding_box()["width"])
    assert widths == sorted(widths, reverse=True)
    assert len(set(widths)) == 3
    colours = set()
    for palette in ("night", "dusk", "day"):
        top.get_by_role("button", name=f"{palette} palette").click()
        assert page.locator("html").get_attribute("data-obc-theme") == palette
        colours.add(page.evaluate("getComputedStyle(document.body).backgroundColor"))
    assert len(colours) == 3


def test_list_by_keyboard_and_its_two_lengths(server: Server, look: Visit) -> None:
    page = look(server)
    rows = page.locator("gh-target-list tbody tr")
    first, second = rows.evaluate_all("all => all.slice(0, 2).map(row => row.dataset.id)")
    rows.nth(1).get_by_role("button").focus()
    assert marked(page, "hovered") == [second]
    page.keyboard.press("Enter")
    assert marked(page, "selected") == [second]
    page.keyboard.press("ArrowUp")
    assert marked(page, "selected") == [first]
    page.keyboard.press("ArrowDown")
    assert marked(page, "selected") == [second]
    whole = len(server.shown()["frame"]["frame"]["targets"])
    page.get_by_role("button", name=f"All {whole}").click()
    assert rows.count() == whole
    page.get_by_role("button", name="Fewer").click()
    assert rows.count() == 6


def test_a_ship_named_in_the_sentence_lights_up_and_is_selected(
    server: Server, look: Visit
) -> None:
    page = look(server)
    named = page.locator("gh-sentence .ship").first
    targets, name = server.shown()["frame"]["frame"]["targets"], named.inner_text()
    (said,) = (t["id"] for t in targets if t["name"].endswith(name))
    page.get_by_role("button", name="All").last.click()
    named.hover()
    assert marked(page, "hovered") == [said]
    named.click()
    page.mouse.move(5, 5)
    assert marked(page, "selected") == [said]


def test_alarms_are_acknowledged_all_at_once_and_lead_to_their_ships(
    server: Server, look: Visit
) -> None:
    page = look(server, level=3)
    server.ask({"type": "limits", "dcpa_m": 9260.0, "tcpa_s": 3600.0})
    alarms = server.shown()["alarms"]["alarms"]
    assert len(alarms) > 3
    strip = page.locator("gh-alarm-strip")
    wait_for_words(page, "gh-alarm-strip", f"and {len(alarms) - 2} more")
    soonest = min(alarms, key=lambda alarm: alarm["tcpa_s"])
    strip.locator("button.cause").first.click()
    page.mouse.move(5, 5)
    assert marked(page, "selected") == [soonest["target"]]
    assert page.locator("gh-target-list tr.unacknowledged").count() == len(alarms)
    strip.get_by_role("button", name=f"Acknowledge all {len(alarms)}").click()
    page.locator("gh-alarm-strip li.unacknowledged").first.wait_for(state="detached")
    wait_for_words(page, "gh-alarm-strip", "CPA")
    assert {a["state"] for a in server.shown()["alarms"]["alarms"]} == {"acknowledged"}


def test_an_encounter_is_opened_with_the_pilot_chosen(server: Server, look: Visit) -> None:
    page = look(server)
    page.get_by_role("button", name="Menu").click()
    page.locator("#scenario").select_option("imazu:1")
    page.locator("#open-pilot").select_option("large-ship-waypoint")
    page.locator("#open").click()
    wait_for_words(page, "gh-top-bar", "Preparing imazu:1|pilot large-ship-waypoint")
    wait_for_words(page, "gh-top-bar", "Imazu case 1.*pilot large-ship-waypoint", PATIENCE_S)
    shown = server.shown()["session"]
    assert (shown["pilot"], shown["ship"]) == ("large-ship-waypoint", "large_ship")
