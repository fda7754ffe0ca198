"""Day, dusk, night: how bright the page is, and that all can use it (axe-core)."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest
from tests.bridge.page.conftest import Server

Visit = Callable[..., Any]
AXE = Path(__file__).parents[3] / "web" / "node_modules" / "axe-core" / "axe.min.js"


@pytest.fixture(scope="module")
def server(serve: Callable[..., Server]) -> Server:
    server = serve("gulf-of-finland")
    server.ask({"type": "pause"}, {"type": "seek", "time_s": 300})
    return server


def luminance(page: Any) -> np.ndarray:
    """Relative luminance of every pixel of the page, 0 to 1."""
    pixels = matplotlib.image.imread(io.BytesIO(page.screenshot()), format="png")[..., :3]
    linear = np.where(pixels <= 0.04045, pixels / 12.92, ((pixels + 0.055) / 1.055) ** 2.4)
    return linear @ np.array([0.2126, 0.7152, 0.0722])


def test_night_is_dark_and_day_is_light(server: Server, look: Visit) -> None:
    day, dusk, night = (luminance(look(server, palette=p)) for p in ("day", "dusk", "night"))
    assert day.mean() > 0.7
    assert 0.01 < dusk.mean() < 0.1
    assert night.mean() < 0.02
    assert np.quantile(night, 0.999) < 0.4, "nothing dazzles at night"
    assert (night > 0.1).mean() > 0.002, "but it can be read"


@pytest.mark.skipif(not AXE.is_file(), reason="axe-core is not installed: scripts/page check")
@pytest.mark.parametrize("palette", ["day", "dusk", "night"])
@pytest.mark.parametrize("level", [1, 3])
def test_axe_finds_no_serious_fault(server: Server, look: Visit, palette: str, level: int) -> None:
    page = look(server, palette=palette, level=level)
    assert _faults(page) == []
    page.keyboard.press("?")
    assert _faults(page) == []


@pytest.mark.skipif(not AXE.is_file(), reason="axe-core is not installed: scripts/page check")
def test_axe_would_find_one(server: Server, look: Visit) -> None:
    page = look(server)
    page.evaluate("""() => {
        const picture = document.createElement('img');
        picture.src = './icon.svg';
        document.body.append(picture);
    }""")
    assert any("image-alt" in fault for fault in _faults(page))


def _faults(page: Any) -> list[str]:
    """What axe-core calls serious or critical, a line each."""
    page.add_script_tag(path=str(AXE))
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")
    return [
        f"{v['id']}: {node['target']} {node['failureSummary']}"
        for v in found["violations"]
        if v["impact"] in ("serious", "critical")
        for node in v["nodes"]
    ]
