"""Many ships: an hour of New York harbour, and 200 targets, on a page that needs a token."""

import itertools
import math
from collections.abc import Callable
from datetime import datetime, timedelta
from typing import Any

import pytest
from tests.bridge.page.axe import faults, needs_axe
from tests.bridge.page.conftest import PAGE_S, Server, wait_for_words, words

Visit = Callable[..., Any]
#: Nothing may keep the page from the next picture for so long [ms].
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
    page.wait_for_selector("gh-plan canvas[aria-label*='range']")
    page.goto(plain)  # the cookie has it now
    wait_for_words(page, "gh-top-bar .state", "Playing|Paused")
    context.close()


def test_new_york_is_played_and_sought_in_utc(server: Server, look: Visit) -> None:
    server.ask({"type": "pause"}, {"type": "seek", "time_s": 120})
    page, shown = look(server), server.shown()
    frame = shown["frame"]["frame"]
    assert "Recorded" in words(page, "gh-top-bar")
    assert f"{frame['time_utc'][11:19]} UTC" in words(page, "gh-top-bar")
    assert f"All {len(frame['targets'])}" in words(page, "gh-target-list")
    page.get_by_label("Time", exact=True).last.fill("240")
    later = datetime.fromisoformat(frame["time_utc"]) + timedelta(seconds=120)
    wait_for_words(page, "gh-top-bar .time", f"{later:%H:%M:%S} UTC")
    page.get_by_role("button", name="Menu").click()
    chosen = page.locator("#scenario option:checked").inner_text()
    assert "New York" in chosen


def test_of_200_ships_the_nearest_by_cpa_are_listed_first(many: Server, look: Visit) -> None:
    page, targets = look(many), many.shown()["frame"]["frame"]["targets"]
    assert len(targets) == 200
    rows = page.locator("gh-target-list tbody tr")
    assert rows.count() == 6
    page.get_by_role("button", name="All 200").click()
    order = rows.evaluate_all("all => all.map(row => row.dataset.id)")
    assert sorted(order) == sorted(t["id"] for t in targets)
    near = {t["id"]: _closeness(t) for t in targets}
    listed = [near[id] for id in order]
    assert all(a >= b - 2e-6 for a, b in itertools.pairwise(listed))


def _closeness(target: dict[str, Any]) -> float:
    """How soon and near she comes: the order where the pilot has no opinion (web ranking.ts)."""
    if target["tcpa_s"] <= 0:
        return 0.3 * math.exp(-target["range_m"] / 1852)
    return math.exp(-target["dcpa_m"] / 1852 - target["tcpa_s"] / 900)


def test_with_200_ships_the_page_goes_on_answering(many: Server, look: Visit) -> None:
    """All of them listed, playing, two frames a second: pictures come, and a key is obeyed."""
    page = look(many, level=3)
    many.ask({"type": "rate", "rate": 10}, {"type": "play"})
    gap = page.evaluate("""async () => {
        let longest = 0, before = performance.now();
        const end = before + 4000;
        while (before < end) {
            const now = await new Promise(requestAnimationFrame);
            longest = Math.max(longest, now - before);
            before = now;
        }
        return longest;
    }""")
    assert gap < LONGEST_GAP_MS
    page.keyboard.press("+")
    assert "3 NM" in words(page, "gh-plan-bar")
    many.ask({"type": "pause"})


@needs_axe
def test_axe_finds_no_serious_fault_among_200(many: Server, look: Visit) -> None:
    many.ask({"type": "pause"})
    assert faults(look(many, level=3)) == []
