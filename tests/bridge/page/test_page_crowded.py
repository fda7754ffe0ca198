"""Many ships: an hour of New York harbour, and 200 targets, on a page that needs a token."""

import itertools
import math
from collections.abc import Callable
from datetime import datetime, timedelta
from typing import Any

import pytest
from tests.bridge.page.axe import faults
from tests.bridge.page.conftest import (
    PAGE_S,
    Server,
    becomes,
    settled,
    wait_for,
    wait_for_words,
    words,
)

Visit = Callable[..., Any]
#: Nothing that the page does may keep it from the next picture for so long [ms].
LONGEST_GAP_MS = 1500


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    return serve("new-york", "--pilot", "straight", token="0123456789abcdef")


@pytest.fixture(scope="module")
def many(server: Server) -> Server:
    """The same server, showing 200 targets at the fifth frame."""
    server.ask(
        {"type": "open", "source": "random:1:200", "pilot": "straight"},
        {"type": "limits", "dcpa_m": 1852.0, "tcpa_s": 600.0},
        {"type": "pause"},
        {"type": "seek", "time_s": 20},
    )
    return server


def test_the_token_in_the_address_lets_in_and_is_kept(server: Server, chromium: Any) -> None:
    context = chromium.new_context()
    page = context.new_page()
    page.set_default_timeout(1000 * PAGE_S)
    plain = server.url.partition("?")[0]
    refused = page.goto(plain)
    assert refused.status == 403
    assert "?token=" in page.inner_text("body")
    page.goto(server.url)
    settled(page)
    page.goto(plain)  # the cookie has it now
    wait_for_words(page, "gh-top-bar .state", "Playing|Paused")
    context.close()


def test_new_york_is_played_and_sought_in_utc(server: Server, look: Visit) -> None:
    server.ask({"type": "pause"}, {"type": "seek", "time_s": 120})
    page, shown = look(server), server.shown()
    frame = shown["frame"]["frame"]
    wait_for_words(page, "gh-top-bar", "Recorded")
    wait_for_words(page, "gh-top-bar .time", f"{frame['time_utc'][11:19]} UTC")
    wait_for_words(page, "gh-target-list", f"All {len(frame['targets'])} ")
    page.get_by_label("Time", exact=True).last.fill("240")
    later = datetime.fromisoformat(frame["time_utc"]) + timedelta(seconds=120)
    wait_for_words(page, "gh-top-bar .time", f"{later:%H:%M:%S} UTC")
    page.get_by_role("button", name="Menu").click()
    wait_for_words(page, "#scenario option:checked", "New York")


def test_of_200_ships_those_under_alarm_then_the_nearest_by_cpa_are_first(
    many: Server, look: Visit
) -> None:
    page, shown = look(many), many.shown()
    targets, alarms = shown["frame"]["frame"]["targets"], shown["alarms"]["alarms"]
    assert len(targets) == 200
    rows = page.locator("gh-target-list tbody tr")
    becomes(rows.count, 6)
    page.get_by_role("button", name="All 200").click()
    becomes(rows.count, 200)
    order = rows.evaluate_all("all => all.map(row => row.dataset.id)")
    assert sorted(order) == sorted(t["id"] for t in targets)
    told = sorted(alarms, key=lambda a: (a["state"] == "acknowledged", a["tcpa_s"], a["dcpa_m"]))
    assert order[: len(told)] == [alarm["target"] for alarm in told]
    near = {t["id"]: _closeness(t) for t in targets}
    listed = [near[id] for id in order[len(told) :]]
    assert all(a >= b - 2e-6 for a, b in itertools.pairwise(listed))


@pytest.mark.parametrize("level", [1, 2, 3])
def test_ships_that_the_alarms_name_have_a_number_and_a_row(
    many: Server, look: Visit, level: int
) -> None:
    alarms = many.shown()["alarms"]["alarms"]
    assert len(alarms) > 6
    page = look(many, level=level)
    rows = page.locator("gh-target-list tbody tr")
    becomes(lambda: rows.first.get_attribute("data-id"), alarms[0]["target"])
    becomes(page.locator("gh-target-list tbody tr.alarm").count, 6)
    named = page.locator("gh-alarm-strip li:not(.more):not(.all) .badge").all_inner_texts()
    assert named == page.locator("gh-target-list tbody .badge").all_inner_texts()[: len(named)]
    assert all(named)


def _closeness(target: dict[str, Any]) -> float:
    """How soon and near she comes: the order where the pilot has no opinion (web ranking.ts)."""
    if target["tcpa_s"] <= 0:
        return 0.3 * math.exp(-target["range_m"] / 1852)
    return math.exp(-target["dcpa_m"] / 1852 - target["tcpa_s"] / 900)


def test_with_200_ships_the_page_goes_on_answering(many: Server, look: Visit) -> None:
    """All of them listed, playing, two frames a second: pictures come, and a key is obeyed.

    Whatever else the machine does keeps the page from its pictures too, but not always: what the
    page itself does is in every stretch of time in which a frame comes.
    """
    page = look(many, level=3)
    page.get_by_role("button", name="All 200").click()
    many.ask({"type": "rate", "rate": 10}, {"type": "play"})

    def longest_gap_ms() -> float:
        time = words(page, "gh-top-bar .time")
        gap = page.evaluate("""async () => {
            let longest = 0, before = performance.now();
            const end = before + 2000;
            while (before < end) {
                const now = await new Promise(requestAnimationFrame);
                longest = Math.max(longest, now - before);
                before = now;
            }
            return longest;
        }""")
        return gap if words(page, "gh-top-bar .time") != time else math.inf

    wait_for(longest_gap_ms, lambda gap: gap < LONGEST_GAP_MS, f"less than {LONGEST_GAP_MS} ms")
    page.keyboard.press("+")
    wait_for_words(page, "gh-plan-bar", " 3 NM ")
    many.ask({"type": "pause"})


def test_axe_finds_no_serious_fault_among_200(many: Server, look: Visit) -> None:
    many.ask({"type": "pause"})
    assert faults(look(many, level=3)) == []
