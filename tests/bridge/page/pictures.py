"""Make the screenshots of README and docs.

python -m tests.bridge.page.pictures       # writes docs/images/bridge-*.png
"""

import json
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright
from tests.bridge.page.conftest import FLAGS, PATIENCE_S, Server, find_chromium
from tests.bridge.process import free_port

IMAGES = Path(__file__).parents[3] / "docs" / "images"
SOURCE = "random:35"
TIME_S = 60
#: The picture of each palette.
PICTURES = {"bridge-day": "day", "bridge-night": "night"}


def take_screenshots(server: Server, time_s: float, pictures: dict[str, str]) -> None:
    """Write the screenshots of what the server shows."""
    server.ask({"type": "pause"}, {"type": "seek", "time_s": time_s})
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=FLAGS)
        for name, palette in pictures.items():
            page = browser.new_page(
                viewport={"width": 1280, "height": 800}, reduced_motion="reduce", bypass_csp=True
            )
            page.set_default_timeout(1000 * PATIENCE_S)
            kept = json.dumps(json.dumps({"level": 2, "palette": palette}))
            page.add_init_script(f"localStorage.setItem('glasshelm', {kept})")
            page.goto(server.url)
            page.wait_for_selector("gh-explanation gh-plot canvas")
            page.wait_for_timeout(1000)
            page.wait_for_function("performance.now() % 1000 < 100")  # flashing things are bright
            page.screenshot(path=IMAGES / f"{name}.png")
        browser.close()


def main() -> None:
    with tempfile.TemporaryDirectory() as logs:
        server = Server(SOURCE, free_port(), Path(logs))
        try:
            server.start()
            take_screenshots(server, TIME_S, PICTURES)
        finally:
            server.kill()


if __name__ == "__main__":
    main()
