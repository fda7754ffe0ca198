"""What a pilot that compares manoeuvres shows: the course, for which ship, and why no other."""

from collections.abc import Callable
from typing import Any

import pytest
from tests.bridge.page.axe import axe_violations
from tests.bridge.page.conftest import Server, wait_for_words

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    begun = serve("random:35")
    begun.ask({"type": "pause"}, {"type": "seek", "time_s": 60})
    return begun


def test_other_courses_are_listed_with_what_speaks_against_them(
    server: Server, open_page: Callable[..., Any]
) -> None:
    page = open_page(server, level=2)
    wait_for_words(page, "gh-sentence", r"Steer 0\d\d° for .* For ship 3: without it another")
    wait_for_words(page, "gh-explanation", "(?i)why not another course")
    wait_for_words(page, "gh-alternatives", r"Starboard 0\d\d° chosen")
    wait_for_words(page, "gh-alternatives", r"To waypoint 000° .\d{3,} 1 .\d{3,}")
    assert axe_violations(page) == []
