"""Day, dusk and night palettes: brightness and accessibility."""

import io
from collections.abc import Callable
from typing import Any

import matplotlib.image
import numpy as np
import pytest
from tests.bridge.page.axe import axe_violations
from tests.bridge.page.conftest import Server

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Any]


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    server = serve("gulf-of-finland", "--pilot", "paper-attention")
    server.ask({"type": "pause"}, {"type": "seek", "time_s": 300})
    return server


def luminance(page: Any) -> np.ndarray:
    """Relative luminance of every pixel of the page, 0 to 1."""
    pixels = matplotlib.image.imread(io.BytesIO(page.screenshot()), format="png")[..., :3]
    linear = np.where(pixels <= 0.04045, pixels / 12.92, ((pixels + 0.055) / 1.055) ** 2.4)
    return linear @ np.array([0.2126, 0.7152, 0.0722])


def test_night_is_dark_and_day_is_light(server: Server, open_page: OpenPage) -> None:
    day, dusk, night = (luminance(open_page(server, palette=p)) for p in ("day", "dusk", "night"))
    assert day.mean() > 0.7
    assert 0.01 < dusk.mean() < 0.1
    assert night.mean() < 0.02
    assert np.quantile(night, 0.999) < 0.4, "nothing dazzles at night"
    assert (night > 0.1).mean() > 0.002, "but it can be read"


@pytest.mark.parametrize("palette", ["day", "dusk", "night"])
@pytest.mark.parametrize("level", [1, 3])
def test_axe_finds_no_serious_fault(
    server: Server, open_page: OpenPage, palette: str, level: int
) -> None:
    page = open_page(server, palette=palette, level=level)
    assert axe_violations(page) == []
    page.keyboard.press("?")
    page.get_by_role("dialog").wait_for()
    assert axe_violations(page) == []


def test_axe_finds_a_deliberate_fault(server: Server, open_page: OpenPage) -> None:
    page = open_page(server)
    page.evaluate("""() => {
        const picture = document.createElement('img');
        picture.src = './icon.svg';
        document.body.append(picture);
    }""")
    assert any("image-alt" in fault for fault in axe_violations(page))
