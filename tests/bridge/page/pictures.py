"""Make the screenshots of README and docs.

    python -m tests.bridge.page.pictures [PORT]       # writes docs/images/bridge-*.png

``PORT`` is that of a running `glasshelm bridge random:35`; without it one is started.
"""

import json
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright
from tests.bridge.page.conftest import FLAGS, PATIENCE_S, Server, find_chromium
from tests.bridge.process import free_port

IMAGES = Path(__file__).parents[3] / "docs" / "images"
SOURCE, PILOT, TIME_S = "random:35", "paper-attention", 255
PICTURES = {"bridge-day": "day", "bridge-night": "night"}


def take_screenshots(server: Server) -> None:
    """Write the screenshots of what the server shows."""
    server.ask({"type": "pause"}, {"type": "seek", "time_s": TIME_S})
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=FLAGS)
        for name, palette in PICTURES.items():
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
        port = int(sys.argv[1]) if sys.argv[1:] else free_port()
        server = Server(SOURCE, port, Path(logs), ("--pilot", PILOT))
        try:
            if not sys.argv[1:]:
                server.start()
            take_screenshots(server)
        finally:
            server.kill()


if __name__ == "__main__":
    main()
