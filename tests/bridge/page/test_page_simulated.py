"""The page on a simulated encounter: what it shows, and the controls of the voyage."""

import itertools
import math
import re
from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.conftest import (
    PATIENCE_S,
    Server,
    canvas,
    until,
    wait_for_other_canvas,
    wait_for_pressed,
    wait_for_words,
    wait_until_equal,
    wait_until_ready,
)

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    return serve("random:35", "--pilot", "paper-attention")


@pytest.fixture(autouse=True)
def voyage(server: Server) -> None:
    """Each test begins at five minutes of the same voyage, paused."""
    server.ask(
        {"type": "open", "source": "random:35", "pilot": "paper-attention", "ship": "paper"},
        {"type": "limits", "dcpa_m": 1852.0, "tcpa_s": 600.0},
        {"type": "pause"},
        {"type": "rate", "rate": 1},
        {"type": "seek", "time_s": 300},
    )


def shown_seconds(page: Any) -> int:
    """The time beside the play button."""
    minutes, rest = page.locator("gh-transport .number").first.inner_text().split(":")
    return 60 * int(minutes) + int(rest)


def disable_alarms(server: Server) -> None:
    """Stop all flashing, so that pictures differ only by what a test does."""
    server.ask({"type": "limits", "dcpa_m": 0.0, "tcpa_s": 0.0})


def has_class(part: Any, kind: str) -> bool:
    """Whether an element has a class."""
    return kind in (part.get_attribute("class") or "").split()


def wait_for_alarm(page: Any) -> None:
    """Wait for an alarm, which comes after its frame."""
    page.locator("gh-alarm-strip li.unacknowledged").first.wait_for()


def test_the_page_shows_the_frame_in_nautical_units(server: Server, open_page: OpenPage) -> None:
    page, shown = open_page(server, level=3), server.shown()
    frame, own = shown["frame"]["frame"], shown["frame"]["frame"]["own"]
    order = math.degrees(frame["decision"]["rudder_rad"])

    def says(part: str, *texts: str) -> None:
        for text in texts:
            wait_for_words(page, part, re.escape(text))

    says(
        "gh-advice",
        f"{abs(order):.1f}°",
        "Port" if order < 0 else "Starboard",
        f"{round(math.degrees(own['heading_rad'])) % 360:03d}°",
        f"{own['speed_m_s'] * 3600 / 1852:.1f} kn",
    )
    says("gh-sentence", " ".join(shown["frame"]["sentence"]["what"].split()))
    for target in frame["targets"]:
        minutes, rest = divmod(round(target["tcpa_s"]), 60)
        says(
            f"gh-target-list tr[data-id='{target['id']}']",
            f"{target['dcpa_m'] / 1852:.2f}",
            f"{target['range_m'] / 1852:.2f}",
            "past" if target["tcpa_s"] <= 0 else f"{minutes:02d}:{rest:02d}",
            f"{max(0.0, target['q_far'] - target['q']):.2f}",
        )
    for alarm in shown["alarms"]["alarms"]:
        says("gh-alarm-strip", f"{alarm['dcpa_m'] / 1852:.2f} NM")
    says("gh-alarm-strip", "Advisory, not type-approved")


def test_four_ships_and_their_plots_fit_without_scrolling(
    server: Server, open_page: OpenPage
) -> None:
    page = open_page(server, level=2)
    wait_for_alarm(page)
    wait_until_equal(page.locator("gh-target-list tbody tr").count, 4)

    def hidden() -> list[str]:
        parts = ("gh-target-list .scroll", "aside")
        more = "e => e.scrollHeight - e.clientHeight"
        return [part for part in parts if page.locator(part).evaluate(more) > 1]

    wait_until_equal(hidden, [])
    plots = page.locator("gh-explanation gh-plot")
    wait_until_equal(plots.count, 2)
    until(lambda: all(plot.bounding_box()["height"] > 80 for plot in plots.all()))


def test_the_list_has_alarms_first_then_the_largest_intention(
    server: Server, open_page: OpenPage
) -> None:
    page, shown = open_page(server), server.shown()
    sizes = {t["id"]: abs(t["intention"]) for t in shown["frame"]["frame"]["targets"]}
    alarms = sorted(shown["alarms"]["alarms"], key=lambda alarm: alarm["tcpa_s"])
    rows = page.locator("gh-target-list tbody tr")
    wait_until_equal(rows.count, len(sizes))
    wait_for_alarm(page)
    page.locator("gh-target-list tr.unacknowledged").first.wait_for()
    order = [row.get_attribute("data-id") for row in rows.all()]
    first, others = order[: len(alarms)], order[len(alarms) :]
    assert first == [alarm["target"] for alarm in alarms]
    assert all(sizes[a] >= sizes[b] - 1e-4 for a, b in itertools.pairwise(others))


def test_a_ship_is_highlighted_everywhere(server: Server, open_page: OpenPage) -> None:
    disable_alarms(server)
    page = open_page(server, level=2)
    before = canvas(page)
    mentioned = page.locator("gh-sentence .ship").first
    row = page.locator("gh-target-list tr", has_text=mentioned.inner_text())
    row.hover()
    until(lambda: has_class(row, "hovered"))
    until(lambda: has_class(mentioned, "highlighted"))
    page.locator("gh-explanation li.highlighted").first.wait_for()
    wait_for_other_canvas(page, before)
    row.click()
    page.mouse.move(5, 5)
    until(lambda: has_class(row, "selected") and not has_class(row, "hovered"))
    wait_for_other_canvas(page, before)
    page.keyboard.press("Escape")
    until(lambda: not has_class(row, "selected"))
    wait_until_equal(lambda: canvas(page), before)


def test_ships_are_at_their_range_and_bearing(server: Server, open_page: OpenPage) -> None:
    """In head up, a ship is at its relative bearing."""
    page = open_page(server, orientation="head-up", motion="relative", range_nm=6)
    box = page.locator("gh-plan").bounding_box()
    radius = min(box["width"], box["height"]) / 2 - 34
    targets = server.shown()["frame"]["frame"]["targets"]
    near = [t for t in targets if t["range_m"] < 5.5 * 1852]
    assert near
    for target in near:
        reach = target["range_m"] / (6 * 1852) * radius
        x = box["x"] + box["width"] / 2 + reach * math.sin(target["bearing_rad"])
        y = box["y"] + box["height"] / 2 - reach * math.cos(target["bearing_rad"])
        page.mouse.move(x, y)
        page.locator(f"gh-target-list tr.hovered[data-id='{target['id']}']").wait_for()


def test_play_pause_seek_and_speed(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    wait_for_words(page, "gh-top-bar .state", "Paused")
    page.get_by_label("Speed").select_option("20")
    page.get_by_role("button", name="Play").click()
    wait_for_words(page, "gh-top-bar .state", "Playing ×20")
    page.wait_for_function("""() => {
        const text = document.querySelector('gh-app').shadowRoot.querySelector('gh-transport')
          .shadowRoot.querySelector('.number').textContent;
        const [m, s] = text.split(':').map(Number);
        return 60 * m + s >= 330;
    }""")
    page.get_by_role("button", name="Pause").click()
    wait_for_words(page, "gh-top-bar .state", "Paused")
    slider = page.get_by_label("Time", exact=True).last
    slider.fill("120")
    wait_for_words(page, "gh-top-bar .time", "02:00")
    page.keyboard.press("Tab")
    page.locator("gh-plan canvas").click(position={"x": 5, "y": 5})
    page.keyboard.press("ArrowRight")
    wait_for_words(page, "gh-top-bar .time", "03:00")
    page.keyboard.press("ArrowLeft")
    wait_for_words(page, "gh-top-bar .time", "02:00")
    page.keyboard.press(" ")
    wait_for_words(page, "gh-top-bar .state", "Playing")
    page.keyboard.press(" ")
    wait_for_words(page, "gh-top-bar .state", "Paused")


def test_plan_controls_change_the_picture(server: Server, open_page: OpenPage) -> None:
    disable_alarms(server)
    page = open_page(server)
    bar = page.locator("gh-plan-bar")
    before = canvas(page)
    for press in ("H UP", "C UP", "N UP", "TM", "RM"):
        bar.get_by_role("button", name=press, exact=True).click()
        wait_for_pressed(page, "gh-plan-bar", press)
        if press in ("H UP", "TM"):
            wait_for_other_canvas(page, before)
    wait_until_equal(lambda: canvas(page), before)
    bar.get_by_role("group", name="Vectors").get_by_role("button", name="R").click()
    wait_for_other_canvas(page, before)
    bar.get_by_label("Vector time").select_option("20")
    bar.get_by_label("Trail time").select_option("0")
    bar.get_by_role("button", name="Larger range").click()
    wait_for_words(page, "gh-plan-bar", " 12 NM rings 2 NM .* GND STAB")
    for _ in range(6):
        page.keyboard.press("+")
    wait_for_words(page, "gh-plan-bar", " 0.75 NM rings 0.125 NM")
    until(bar.get_by_role("button", name="Smaller range").is_disabled)


def test_shortcuts_do_what_the_menu_says(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    for key, name in (("3", "All"), ("2", "Why"), ("1", "Basic")):
        page.keyboard.press(key)
        wait_for_pressed(page, "gh-top-bar", name)
    for theme in ("dusk", "night", "day"):
        page.keyboard.press("p")
        page.locator(f"html[data-obc-theme='{theme}']").wait_for()
    page.keyboard.press("ArrowDown")
    first = page.locator("gh-target-list tbody tr").first
    until(lambda: has_class(first, "selected"))
    page.keyboard.press("?")
    page.get_by_role("dialog").wait_for()
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="hidden")
    for key, name in (("h", "H UP"), ("c", "C UP"), ("n", "N UP"), ("m", "TM"), ("m", "RM")):
        page.keyboard.press(key)
        wait_for_pressed(page, "gh-plan-bar", name)


def test_the_level_of_detail_starts_low_and_is_kept(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    plots = page.locator("gh-explanation gh-plot")
    wait_until_equal(page.locator("gh-explanation").count, 0)
    page.keyboard.press("2")
    wait_until_equal(plots.count, 2)
    page.keyboard.press("3")
    wait_until_equal(plots.count, 6)
    page.reload()
    wait_until_ready(page)
    wait_until_equal(plots.count, 6)  # the choice is kept


def test_plots_show_the_voyage_so_far(server: Server, open_page: OpenPage) -> None:
    """A late viewer's plots reach from the start to now, and a click seeks to its time."""
    page = open_page(server, level=2)
    plot = page.locator("gh-explanation gh-plot").nth(1).locator(".u-over")
    plot.wait_for()
    times = page.evaluate("""() => {
        const why = document.querySelector('gh-app').shadowRoot.querySelector('gh-explanation');
        return [...why.shadowRoot.querySelectorAll('gh-plot')][1].spec.data[0];
    }""")
    assert times[0] == 0
    assert times[-1] == pytest.approx(5.0)
    assert len(times) == 61
    box = plot.bounding_box()
    plot.click(position={"x": box["width"] * 0.4, "y": 20})
    until(lambda: 60 <= shown_seconds(page) <= 180)


def test_a_plot_and_its_legend_highlight_the_ship(server: Server, open_page: OpenPage) -> None:
    page = open_page(server, level=2)
    lit = page.locator("gh-target-list tr.hovered")
    legend = page.locator("gh-explanation article").first.locator("li[title]").first
    legend.hover()
    ship = legend.get_attribute("title").removeprefix("ship ")
    wait_until_equal(lambda: lit.get_attribute("data-id"), ship)
    page.mouse.move(5, 5)
    wait_until_equal(lit.count, 0)
    plot = page.locator("gh-explanation gh-plot").nth(1)
    plot.locator(".u-over").wait_for()
    at = plot.evaluate("""e => {
        const u = e.plot, k = Math.round(u.data[0].length * 0.7);
        const ship = u.series.findIndex((_, j) => j > 1 && Math.abs(u.data[j][k]) > 0.3);
        const box = u.over.getBoundingClientRect();
        return [box.x + u.valToPos(u.data[0][k], "x"), box.y + u.valToPos(u.data[ship][k], "y")];
    }""")
    page.mouse.move(at[0] - 5, at[1])
    page.mouse.move(*at)
    wait_until_equal(lit.count, 1)


def test_alarm_flashes_until_acknowledged_for_all_viewers(
    server: Server, open_page: OpenPage
) -> None:
    page, other = open_page(server), open_page(server)
    alarm = page.locator("gh-alarm-strip li.unacknowledged").first
    alarm.wait_for()
    red = alarm.evaluate("e => getComputedStyle(e).backgroundColor")
    assert red == "rgb(214, 0, 28)"
    assert alarm.evaluate("e => getComputedStyle(e).animationName") == "flash"
    page.locator("gh-target-list tr.unacknowledged").first.wait_for()
    open_before = page.locator("gh-alarm-strip li.unacknowledged").count()
    alarm.get_by_role("button", name="Acknowledge").click()
    for viewer in (page, other):
        viewer.wait_for_function(
            "n => document.querySelector('gh-app').shadowRoot.querySelector('gh-alarm-strip')"
            ".shadowRoot.querySelectorAll('li.unacknowledged').length < n",
            arg=open_before,
        )
        known = viewer.locator("gh-alarm-strip li.acknowledged").first
        assert known.evaluate("e => getComputedStyle(e).animationName") == "none"


def test_the_alarm_sound_can_be_switched_off_and_ends_with_the_alarm(
    server: Server, open_page: OpenPage
) -> None:
    page = open_page(server)
    count = """() => {
        const begin = OscillatorNode.prototype.start;
        window.tones = 0;
        OscillatorNode.prototype.start = function (...at) {
            window.tones += 1;
            return begin.apply(this, at);
        };
    }"""
    page.evaluate(count)

    def tones() -> int:
        """Begun within a little more than the time from one beep to the next, by its own clock."""
        return page.evaluate("""() => {
            window.tones = 0;
            return new Promise(done => setTimeout(() => done(window.tones), 1700));
        }""")

    wait_for_alarm(page)
    assert tones() == 0, "no browser lets a page sound that nobody has touched"
    page.keyboard.press("?")
    until(lambda: tones() >= 2)
    sound = page.get_by_role("checkbox", name="Sound while an alarm")
    sound.uncheck()
    assert tones() == 0
    page.reload()
    page.evaluate(count)
    wait_for_alarm(page)
    page.keyboard.press("?")
    wait_until_equal(sound.is_checked, False)  # the choice is kept
    sound.check()
    until(lambda: tones() >= 2)
    page.get_by_role("button", name="Close").click()
    alarms = page.locator("gh-target-list tr.unacknowledged")
    for left in reversed(range(alarms.count())):
        page.keyboard.press("a")
        wait_until_equal(alarms.count, left)
    page.locator("gh-alarm-strip li.unacknowledged").first.wait_for(state="detached")
    assert tones() == 0


def test_alarm_limits_are_set_in_miles_and_minutes(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    wait_for_alarm(page)
    page.keyboard.press("?")
    page.locator("#dcpa").fill("0.05")
    page.locator("#tcpa").fill("1")
    page.locator("#set-limits").click()
    page.get_by_role("button", name="Close").click()
    wait_for_words(page, "gh-alarm-strip", r"No CPA alarm \(limits 0.05 NM, 1 min\)")
    wait_until_equal(lambda: server.shown()["alarms"]["alarms"], [])


def test_pilot_can_be_changed_and_compared(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    page.keyboard.press("?")
    page.locator("#compare").select_option("straight")
    page.get_by_role("button", name="Close").click()
    wait_for_words(page, "gh-comparison", "straight", PATIENCE_S)
    wait_until_equal(page.locator("gh-comparison tbody tr").count, 2)
    wait_for_words(page, "gh-comparison tbody tr", "paper-attention")
    page.keyboard.press("?")
    page.locator("#compare").select_option("")
    page.locator("#pilot").select_option("straight")
    page.get_by_role("button", name="Close").click()
    wait_for_words(page, "gh-top-bar", "pilot straight", PATIENCE_S)
    wait_until_equal(page.locator("gh-comparison table").count, 0)
    wait_for_words(page, "gh-advice", "Midships")
    page.keyboard.press("2")
    wait_for_words(page, "gh-explanation", "no critic")


def test_menu_opens_encounters_and_replays_logs(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    page.keyboard.press("?")
    page.locator("#scenario").select_option("imazu:5")
    page.locator("#open").click()
    wait_for_words(page, "gh-top-bar", "Imazu case 5", PATIENCE_S)
    assert server.shown()["session"]["source"] == "imazu:5"
    page.reload()
    wait_until_ready(page)
    page.keyboard.press("?")
    log = page.locator("#log option", has_text="random-35-paper-attention").first
    page.locator("#log").select_option(log.get_attribute("value"))
    page.locator("#replay").click()
    wait_for_words(page, "gh-top-bar", "Replay", PATIENCE_S)
    wait_for_words(page, "gh-advice", "recorded decision")
    server.ask({"type": "pause"})
    page.get_by_label("Time", exact=True).last.fill("100")
    wait_for_words(page, "gh-top-bar .time", "01:40")


def test_unknown_encounter_gives_one_plain_line(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    page.keyboard.press("?")
    page.locator("#source").fill("/etc/passwd")
    page.locator("#open").click()
    failure = page.locator("gh-notices .failure", has_text="no source")
    failure.get_by_role("button", name="Close").click()  # else it goes by itself, after a while
    wait_for_words(page, "gh-top-bar", "Random encounter 35")
