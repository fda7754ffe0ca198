"""Every control of the page on a simulated encounter, and that it shows what the frames say."""

import itertools
import math
from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.conftest import PATIENCE_S, Server, wait_for_words, words

Visit = Callable[..., Any]


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    return serve("random:35")


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


def seconds(page: Any) -> int:
    """The time shown beside the play button."""
    minutes, rest = page.locator("gh-transport .number").first.inner_text().split(":")
    return 60 * int(minutes) + int(rest)


def without_alarms(server: Server) -> None:
    """Nothing flashes: two pictures differ only by what a test does."""
    server.ask({"type": "limits", "dcpa_m": 0.0, "tcpa_s": 0.0})


def canvas(page: Any) -> bytes:
    return page.locator("gh-plan canvas").screenshot()


def test_page_shows_what_the_frame_says_in_mariners_units(server: Server, look: Visit) -> None:
    page, shown = look(server, level=3), server.shown()
    frame, own = shown["frame"]["frame"], shown["frame"]["frame"]["own"]
    order = math.degrees(frame["decision"]["rudder_rad"])
    advice = words(page, "gh-advice")
    assert f"{abs(order):.1f}°" in advice
    assert ("Port" if order < 0 else "Starboard") in advice
    assert f"{round(math.degrees(own['heading_rad'])) % 360:03d}°" in advice
    assert f"{own['speed_m_s'] * 3600 / 1852:.1f} kn" in advice
    sentence = words(page, "gh-sentence")
    assert " ".join(shown["frame"]["sentence"]["what"].split()) in sentence
    for target in frame["targets"]:
        row = page.locator(f"gh-target-list tr[data-id='{target['id']}']").inner_text()
        assert f"{target['dcpa_m'] / 1852:.2f}" in row
        assert f"{target['range_m'] / 1852:.2f}" in row
        minutes, rest = divmod(round(target["tcpa_s"]), 60)
        assert ("past" if target["tcpa_s"] <= 0 else f"{minutes:02d}:{rest:02d}") in row
        assert f"{max(0.0, target['q_far'] - target['q']):.2f}" in row
    for alarm in shown["alarms"]["alarms"]:
        assert f"{alarm['dcpa_m'] / 1852:.2f} NM" in words(page, "gh-alarm-strip")
    assert "Advisory, not type-approved" in words(page, "gh-alarm-strip")


def test_four_ships_and_their_plots_fit_without_scrolling(server: Server, look: Visit) -> None:
    page = look(server, level=2)
    assert page.locator("gh-target-list tbody tr").count() == 4
    for part in ("gh-target-list .scroll", "aside"):
        hidden = page.locator(part).evaluate("e => e.scrollHeight - e.clientHeight")
        assert hidden <= 1, part
    plots = page.locator("gh-why gh-plot")
    assert all(plot.bounding_box()["height"] > 80 for plot in plots.all())


def test_list_has_the_largest_intention_first(server: Server, look: Visit) -> None:
    page, targets = look(server), server.shown()["frame"]["frame"]["targets"]
    sizes = {t["id"]: abs(t["intention"]) for t in targets}
    rows = page.locator("gh-target-list tbody tr")
    order = [row.get_attribute("data-id") for row in rows.all()]
    assert len(order) == len(sizes)
    assert all(sizes[a] >= sizes[b] - 1e-4 for a, b in itertools.pairwise(order))


def test_ship_lights_up_everywhere(server: Server, look: Visit) -> None:
    without_alarms(server)
    page = look(server, level=2)
    before = canvas(page)
    mentioned = page.locator("gh-sentence .ship").first
    row = page.locator("gh-target-list tr", has_text=mentioned.inner_text())
    row.hover()
    assert "hovered" in (row.get_attribute("class") or "")
    assert "lit" in (mentioned.get_attribute("class") or "")
    assert page.locator("gh-why li.lit").count() >= 1
    assert canvas(page) != before
    row.click()
    page.mouse.move(5, 5)
    assert "selected" in (row.get_attribute("class") or "")
    assert canvas(page) != before
    page.keyboard.press("Escape")
    assert "selected" not in (row.get_attribute("class") or "")


def test_ships_are_where_range_and_bearing_say(server: Server, look: Visit) -> None:
    """Head up: the ship lies at her relative bearing, six rings to the range scale."""
    page = look(server, orientation="head-up", motion="relative", range_nm=6)
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
        row = page.locator(f"gh-target-list tr[data-id='{target['id']}']")
        page.wait_for_timeout(150)
        assert "hovered" in (row.get_attribute("class") or ""), target["name"]


def test_play_pause_seek_and_speed(server: Server, look: Visit) -> None:
    page = look(server)
    assert "Paused" in words(page, "gh-top-bar")
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


def test_plan_controls_change_the_picture_and_say_so(server: Server, look: Visit) -> None:
    without_alarms(server)
    page = look(server)
    bar = page.locator("gh-plan-bar")
    before = canvas(page)
    for press in ("H UP", "C UP", "N UP", "TM", "RM"):
        bar.get_by_role("button", name=press, exact=True).click()
        pressed = bar.get_by_role("button", name=press, exact=True)
        assert pressed.get_attribute("aria-pressed") == "true"
        if press in ("H UP", "TM"):
            assert canvas(page) != before
    assert canvas(page) == before
    bar.get_by_role("group", name="Vectors").get_by_role("button", name="R").click()
    assert canvas(page) != before
    bar.get_by_label("Vector time").select_option("20")
    bar.get_by_label("Trail time").select_option("0")
    bar.get_by_role("button", name="Larger range").click()
    assert "12 NM" in words(page, "gh-plan-bar")
    assert "rings 2 NM" in words(page, "gh-plan-bar")
    assert "GND STAB" in words(page, "gh-plan-bar")
    for _ in range(6):
        page.keyboard.press("+")
    assert "0.75 NM" in words(page, "gh-plan-bar")
    assert "rings 0.125 NM" in words(page, "gh-plan-bar")
    assert bar.get_by_role("button", name="Smaller range").is_disabled()


def test_keyboard_does_what_the_menu_says(server: Server, look: Visit) -> None:
    page = look(server)
    top = page.locator("gh-top-bar")
    for key, name in (("3", "All"), ("2", "Why"), ("1", "Look")):
        page.keyboard.press(key)
        assert top.get_by_role("button", name=name).get_attribute("aria-pressed") == "true"
    for theme in ("dusk", "night", "day"):
        page.keyboard.press("p")
        assert page.locator("html").get_attribute("data-obc-theme") == theme
    page.keyboard.press("ArrowDown")
    first = page.locator("gh-target-list tbody tr").first
    assert "selected" in (first.get_attribute("class") or "")
    page.keyboard.press("?")
    assert page.get_by_role("dialog").is_visible()
    page.keyboard.press("Escape")
    assert not page.get_by_role("dialog").is_visible()
    for key, name in (("h", "H UP"), ("c", "C UP"), ("n", "N UP"), ("m", "TM"), ("m", "RM")):
        page.keyboard.press(key)
        button = page.locator("gh-plan-bar").get_by_role("button", name=name, exact=True)
        assert button.get_attribute("aria-pressed") == "true", key


def test_detail_is_small_at_first_and_grows(server: Server, look: Visit) -> None:
    page = look(server)
    assert page.locator("gh-why").count() == 0
    page.keyboard.press("2")
    assert page.locator("gh-why gh-plot").count() == 2
    page.keyboard.press("3")
    assert page.locator("gh-why gh-plot").count() == 6
    page.reload()
    page.wait_for_selector("gh-why gh-plot")
    assert page.locator("gh-why gh-plot").count() == 6, "the choice is kept"


def test_plots_hold_the_voyage_so_far(server: Server, look: Visit) -> None:
    """The late viewer's plots reach from the start to now, and a click goes to that time."""
    page = look(server, level=2)
    times = page.evaluate("""() => {
        const why = document.querySelector('gh-app').shadowRoot.querySelector('gh-why');
        return [...why.shadowRoot.querySelectorAll('gh-plot')][1].spec.data[0];
    }""")
    assert times[0] == 0
    assert times[-1] == pytest.approx(5.0)
    assert len(times) == 61
    plot = page.locator("gh-why gh-plot").nth(1).locator(".u-over")
    box = plot.bounding_box()
    plot.click(position={"x": box["width"] * 0.4, "y": 20})
    page.wait_for_function("""() => document.querySelector('gh-app').shadowRoot
        .querySelector('gh-top-bar').shadowRoot.querySelector('.time').textContent.trim() < '04'
    """)
    assert 60 <= seconds(page) <= 180


def test_a_plot_and_its_legend_light_up_the_ship(server: Server, look: Visit) -> None:
    page = look(server, level=2)
    lit = page.locator("gh-target-list tr.hovered")
    legend = page.locator("gh-why article").first.locator("li[title]").first
    legend.hover()
    assert lit.get_attribute("data-id") in {legend.get_attribute("title").removeprefix("ship ")}
    page.mouse.move(5, 5)
    assert lit.count() == 0
    at = (
        page.locator("gh-why gh-plot")
        .nth(1)
        .evaluate("""e => {
        const u = e.plot, k = Math.round(u.data[0].length * 0.7);
        const ship = u.series.findIndex((_, j) => j > 1 && Math.abs(u.data[j][k]) > 0.3);
        const box = u.over.getBoundingClientRect();
        return [box.x + u.valToPos(u.data[0][k], "x"), box.y + u.valToPos(u.data[ship][k], "y")];
    }""")
    )
    page.mouse.move(at[0] - 5, at[1])
    page.mouse.move(*at)
    lit.wait_for()
    assert lit.count() == 1


def test_alarm_flashes_until_acknowledged_for_all_viewers(server: Server, look: Visit) -> None:
    page, other = look(server), look(server)
    alarm = page.locator("gh-alarm-strip li.unacknowledged").first
    alarm.wait_for()
    red = alarm.evaluate("e => getComputedStyle(e).backgroundColor")
    assert red == "rgb(214, 0, 28)"
    assert alarm.evaluate("e => getComputedStyle(e).animationName") == "flash"
    assert page.locator("gh-target-list tr.unacknowledged").count() >= 1
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


def test_the_sound_of_an_alarm_can_be_switched_off_and_ends_with_it(
    server: Server, look: Visit
) -> None:
    page = look(server)
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
        """Begun within a little more than the time from one beep to the next."""
        page.evaluate("window.tones = 0")
        page.wait_for_timeout(1700)
        return page.evaluate("window.tones")

    page.locator("gh-alarm-strip li.unacknowledged").first.wait_for()
    assert tones() == 0, "no browser lets a page sound that nobody has touched"
    page.keyboard.press("?")
    assert tones() >= 2
    sound = page.get_by_role("checkbox", name="Sound while an alarm")
    sound.uncheck()
    assert tones() == 0
    page.reload()
    page.evaluate(count)
    page.locator("gh-alarm-strip li.unacknowledged").first.wait_for()
    page.keyboard.press("?")
    assert not sound.is_checked(), "the choice is kept"
    sound.check()
    assert tones() >= 2
    page.get_by_role("button", name="Close").click()
    while page.locator("gh-alarm-strip li.unacknowledged").count():
        page.keyboard.press("a")
        page.wait_for_timeout(200)
    assert tones() == 0


def test_alarm_limits_are_set_in_miles_and_minutes(server: Server, look: Visit) -> None:
    page = look(server)
    page.keyboard.press("?")
    page.locator("#dcpa").fill("0.05")
    page.locator("#tcpa").fill("1")
    page.locator("#set-limits").click()
    page.get_by_role("button", name="Close").click()
    wait_for_words(page, "gh-alarm-strip", r"No CPA alarm \(limits 0.05 NM, 1 min\)")
    assert server.shown()["alarms"]["alarms"] == []


def test_pilot_can_be_changed_and_compared(server: Server, look: Visit) -> None:
    page = look(server)
    page.keyboard.press("?")
    page.locator("#compare").select_option("straight")
    page.get_by_role("button", name="Close").click()
    wait_for_words(page, "gh-comparison", "straight", PATIENCE_S)
    rows = page.locator("gh-comparison tbody tr")
    assert rows.count() == 2
    assert "paper-attention" in rows.first.inner_text()
    page.keyboard.press("?")
    page.locator("#compare").select_option("")
    page.locator("#pilot").select_option("straight")
    page.get_by_role("button", name="Close").click()
    wait_for_words(page, "gh-top-bar", "pilot straight", PATIENCE_S)
    assert page.locator("gh-comparison table").count() == 0
    wait_for_words(page, "gh-advice", "Midships")
    page.keyboard.press("2")
    wait_for_words(page, "gh-why", "no critic")


def test_menu_opens_encounters_and_replays_logs(server: Server, look: Visit) -> None:
    page = look(server)
    page.keyboard.press("?")
    page.locator("#scenario").select_option("imazu:5")
    page.locator("#open").click()
    wait_for_words(page, "gh-top-bar", "Imazu case 5", PATIENCE_S)
    assert server.shown()["session"]["source"] == "imazu:5"
    page.reload()
    page.wait_for_selector("gh-plan canvas[aria-label*='range']")
    page.keyboard.press("?")
    log = page.locator("#log option", has_text="random-35-paper-attention").first
    page.locator("#log").select_option(log.get_attribute("value"))
    page.locator("#replay").click()
    wait_for_words(page, "gh-top-bar", "Replay")
    wait_for_words(page, "gh-advice", "recorded decision")
    page.get_by_label("Time", exact=True).last.fill("100")
    wait_for_words(page, "gh-top-bar .time", "01:40")


def test_unknown_encounter_gives_one_plain_line(server: Server, look: Visit) -> None:
    page = look(server)
    page.keyboard.press("?")
    page.locator("#source").fill("/etc/passwd")
    page.locator("#open").click()
    wait_for_words(page, "gh-notices .failure", "no source")
    assert "Random encounter 35" in words(page, "gh-top-bar")
    page.locator("gh-notices").get_by_role("button", name="Close").first.click()
