"""Every control of the display: operate it, and see what it does."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    canvas,
    until,
    wait_for,
    wait_for_other_canvas,
    wait_for_pressed,
    wait_for_words,
    wait_until_equal,
)

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]


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


def wait_for_rows(page: Any, kind: str, *ids: str) -> None:
    """Wait until exactly these ships' rows have the class."""
    rows = page.locator(f"gh-target-list tr.{kind}")
    wait_until_equal(lambda: tuple(rows.evaluate_all("all => all.map(row => row.dataset.id)")), ids)


def test_shortcuts_work_while_the_slider_has_focus(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    slider = page.get_by_label("Time", exact=True).last
    slider.focus()
    page.keyboard.press("h")
    wait_for_pressed(page, "gh-plan-bar", "H UP")
    page.keyboard.press("+")
    wait_for_words(page, "gh-plan-bar", " 3 NM ")
    page.keyboard.press("2")
    wait_for_pressed(page, "gh-top-bar", "Why")
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
    until(lambda: slider.evaluate("e => e.getRootNode().activeElement === e"))


def test_a_focused_list_keeps_only_its_digits(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    minutes = page.get_by_label("Vector time")
    minutes.focus()
    page.keyboard.press("v")
    wait_for_pressed(page, "gh-plan-bar", "R")
    page.keyboard.press("3")
    until(lambda: minutes.input_value().startswith("3"))  # the digit was the list's
    wait_for_pressed(page, "gh-top-bar", "Basic")


def test_vector_and_trail_times_change_the_picture(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    page.mouse.move(5, 5)
    bar, picture = page.locator("gh-plan-bar"), canvas(page)
    for label, choices in (
        ("Vector time", ("1", "3", "6", "12", "20", "30")),
        ("Trail time", ("0", "3", "6")),  # five minutes have been sailed
    ):
        seen = set()
        for minutes in choices:
            bar.get_by_label(label).select_option(minutes)
            picture = wait_for_other_canvas(page, picture)
            seen.add(picture)
        assert len(seen) == len(choices), label
    minutes = bar.get_by_label("Vector time")
    minutes.select_option("6")
    page.locator("gh-plan canvas").focus()
    for key, chosen in (("]", "12"), ("]", "20"), ("[", "12")):
        page.keyboard.press(key)
        wait_until_equal(minutes.input_value, chosen)
    true = canvas(page)
    page.keyboard.press("v")
    wait_for_pressed(page, "gh-plan-bar", "R")
    wait_for_other_canvas(page, true)
    bar.get_by_role("button", name="T", exact=True).click()
    page.mouse.move(5, 5)
    wait_until_equal(lambda: canvas(page), true)


def test_orientation_and_motion_change_the_picture(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    page.mouse.move(5, 5)
    seen = [canvas(page)]
    for name in ("H UP", "N UP", "C UP", "TM"):
        page.locator("gh-plan-bar").get_by_role("button", name=name, exact=True).click()
        page.mouse.move(5, 5)
        seen.append(wait_for_other_canvas(page, seen[-1]))
    assert len(set(seen[1:])) == 4
    page.locator("gh-plan canvas[aria-label*='course-up, true motion']").wait_for()


def test_range_is_set_by_buttons_keys_and_wheel(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    bar = page.locator("gh-plan-bar")
    for nm in ("3", "1.5", "0.75"):
        bar.get_by_role("button", name="Smaller range").click()
        wait_for_words(page, "gh-plan-bar", f" {nm} NM rings")
    for nm in ("1.5", "3", "6", "12", "24"):
        page.keyboard.press("-")
        wait_for_words(page, "gh-plan-bar", f" {nm} NM rings")
    until(bar.get_by_role("button", name="Larger range").is_disabled)
    box = page.locator("gh-plan").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 200)
    page.mouse.wheel(0, -100)
    wait_for_words(page, "gh-plan-bar", "12 NM rings 2 NM")
    page.mouse.wheel(0, 100)
    wait_for_words(page, "gh-plan-bar", "24 NM rings 4 NM")


def test_a_click_on_the_picture_selects_the_ship_there(server: Server, open_page: OpenPage) -> None:
    page = open_page(server, level=3)
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
    wait_for_rows(page, "selected", alone)
    wait_for_rows(page, "hovered")
    page.mouse.click(box["x"] + 4, box["y"] + 4)
    wait_for_rows(page, "selected")


def test_detail_and_palette_are_set_by_buttons(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    top = page.locator("gh-top-bar")
    plan = page.locator("gh-plan")

    def narrower(than: float) -> float:
        return wait_for(
            lambda: plan.bounding_box()["width"], lambda now: now < than, f"less than {than} px"
        )

    width = math.inf
    for name in ("Basic", "Why", "All"):
        top.get_by_role("button", name=name, exact=True).click()
        wait_for_pressed(page, "gh-top-bar", name)
        width = narrower(width)
    colours = set()
    for palette in ("night", "dusk", "day"):
        top.get_by_role("button", name=f"{palette} palette").click()
        page.locator(f"html[data-obc-theme='{palette}']").wait_for()
        colours.add(page.evaluate("getComputedStyle(document.body).backgroundColor"))
    assert len(colours) == 3


def test_the_list_works_by_keyboard_and_expands(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    rows = page.locator("gh-target-list tbody tr")
    wait_until_equal(rows.count, 6)
    first, second = rows.evaluate_all("all => all.slice(0, 2).map(row => row.dataset.id)")
    rows.nth(1).get_by_role("button").focus()
    wait_for_rows(page, "hovered", second)
    page.keyboard.press("Enter")
    wait_for_rows(page, "selected", second)
    page.keyboard.press("ArrowUp")
    wait_for_rows(page, "selected", first)
    page.keyboard.press("ArrowDown")
    wait_for_rows(page, "selected", second)
    whole = len(server.shown()["frame"]["frame"]["targets"])
    page.get_by_role("button", name=f"All {whole}").click()
    wait_until_equal(rows.count, whole)
    page.get_by_role("button", name="Fewer").click()
    wait_until_equal(rows.count, 6)


def test_a_ship_named_in_the_sentence_is_highlighted_and_selected(
    server: Server, open_page: OpenPage
) -> None:
    page = open_page(server)
    named = page.locator("gh-sentence .ship").first
    targets, name = server.shown()["frame"]["frame"]["targets"], named.inner_text()
    (said,) = (t["id"] for t in targets if t["name"].endswith(name))
    page.get_by_role("button", name="All").last.click()
    wait_until_equal(page.locator("gh-target-list tbody tr").count, len(targets))
    named.hover()
    wait_for_rows(page, "hovered", said)
    named.click()
    page.mouse.move(5, 5)
    wait_for_rows(page, "selected", said)


def test_alarms_select_their_ships_and_are_acknowledged_together(
    server: Server, open_page: OpenPage
) -> None:
    page = open_page(server, level=3)
    server.ask({"type": "limits", "dcpa_m": 9260.0, "tcpa_s": 3600.0})
    alarms = server.shown()["alarms"]["alarms"]
    assert len(alarms) > 3
    strip = page.locator("gh-alarm-strip")
    wait_for_words(page, "gh-alarm-strip", f"and {len(alarms) - 2} more")
    soonest = min(alarms, key=lambda alarm: alarm["tcpa_s"])
    strip.locator("button.alarm-text").first.click()
    page.mouse.move(5, 5)
    wait_for_rows(page, "selected", soonest["target"])
    wait_until_equal(page.locator("gh-target-list tr.unacknowledged").count, len(alarms))
    strip.get_by_role("button", name=f"Acknowledge all {len(alarms)}").click()
    page.locator("gh-alarm-strip li.unacknowledged").first.wait_for(state="detached")
    wait_for_words(page, "gh-alarm-strip", "CPA")
    assert {a["state"] for a in server.shown()["alarms"]["alarms"]} == {"acknowledged"}


def test_an_encounter_opens_with_the_chosen_pilot(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    page.get_by_role("button", name="Menu").click()
    page.locator("#scenario").select_option("imazu:1")
    page.locator("#open-pilot").select_option("large-ship-waypoint")
    page.locator("#open").click()
    wait_for_words(page, "gh-top-bar", "Preparing imazu:1|pilot large-ship-waypoint", PATIENCE_S)
    wait_for_words(page, "gh-top-bar", "Imazu case 1.*pilot large-ship-waypoint", PATIENCE_S)
    shown = server.shown()["session"]
    assert (shown["pilot"], shown["ship"]) == ("large-ship-waypoint", "large_ship")
