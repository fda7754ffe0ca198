"""A real server and a real browser: the page as a user sees it."""

import dataclasses
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import pytest
from tests.bridge.process import PATIENCE_S, free_port, viewing
from tests.missing import missing, needed

import glasshelm

PAGE_FILE = Path(glasshelm.__file__).parent / "bridge" / "static" / "index.html"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
#: Timeout for what the page does, or the server without compiling anything [s].
PAGE_TIMEOUT_S = 60.0
T = TypeVar("T")
#: No such pilot. Requests are done in order: its failure means that all before it are done.
_LAST = {"type": "pilot", "name": "no such pilot"}


@dataclasses.dataclass
class Server:
    """``glasshelm bridge`` as a process of its own, which can be killed and restarted."""

    source: str
    port: int
    logs: Path
    more: tuple[str, ...] = ()
    token: str = ""
    process: "subprocess.Popen[bytes] | None" = None

    @property
    def url(self) -> str:
        """The address of the page, with the token if there is one."""
        return f"http://127.0.0.1:{self.port}/{self._query}"

    @property
    def line(self) -> str:
        """The address of its WebSocket."""
        return f"ws://127.0.0.1:{self.port}/ws{self._query}"

    @property
    def _query(self) -> str:
        return f"?token={self.token}" if self.token else ""

    def start(self) -> None:
        command = [sys.executable, "-m", "glasshelm", "bridge", self.source, *self.more]
        options = ["--port", str(self.port), "--no-open", "--log-dir", str(self.logs)]
        options += ["--token", self.token] if self.token else []
        said = (self.logs / "server.txt").open("ab")
        path = [str(Path(glasshelm.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(path), "JAX_PLATFORMS": "cpu"}
        self.process = subprocess.Popen(command + options, stdout=said, stderr=said, env=env)
        health = f"http://127.0.0.1:{self.port}/api/health"
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            if self.process.poll() is not None:
                break
            try:
                with urllib.request.urlopen(health, timeout=2) as answer:
                    if answer.status == 200:
                        return
            except OSError:
                time.sleep(0.2)
        self.kill()
        raise AssertionError((self.logs / "server.txt").read_text())

    def kill(self) -> None:
        """As a power cut would."""
        if self.process is not None:
            self.process.kill()
            self.process.wait(PAGE_TIMEOUT_S)

    def ask(self, *messages: dict[str, Any]) -> None:
        """Send messages to the server as another viewer, and wait until they are done."""
        with viewing(self.line) as line:
            for message in messages:
                line.send(json.dumps(message))
            line.send(json.dumps(_LAST))
            until = time.monotonic() + PATIENCE_S
            while time.monotonic() < until:
                said = json.loads(line.recv(timeout=PATIENCE_S))
                if said["type"] == "error":
                    if _LAST["name"] in said["message"]:
                        return
                    raise AssertionError(said["message"])
        raise AssertionError("the server did not answer")

    def shown(self) -> dict[str, Any]:
        """The messages that a new viewer receives, by their type."""
        got: dict[str, Any] = {}
        with viewing(self.line) as line:
            while not {"session", "frame", "alarms"} <= set(got):
                message = json.loads(line.recv(timeout=PATIENCE_S))
                got[message["type"]] = message
        return got


#: The visible text of an element, including its shadow root.
_WORDS = """
    found => found.shadowRoot
      ? [...found.shadowRoot.children].map(child => child.innerText ?? "").join("\\n")
      : found.innerText
"""


def words(page: Any, part: str) -> str:
    """The visible text of a part of the page in one line, empty where there is none."""
    found = page.locator(part).evaluate_all(f"all => all.slice(0, 1).map({_WORDS})")
    return " ".join(" ".join(found).split())


def wait_for(
    get: Callable[[], T], good: Callable[[T], object], wanted: str, seconds: float = PAGE_TIMEOUT_S
) -> T:
    """The result of ``get`` once it is ``good``; fails with the last result after a timeout.

    The page follows its user and the server with a delay.
    """
    until = time.monotonic() + seconds
    while not good(got := get()):
        if time.monotonic() > until:
            raise AssertionError(f"waited for {wanted}, it is {got!r}")
        time.sleep(0.1)
    return got


def wait_until_equal(get: Callable[[], T], wanted: T, seconds: float = PAGE_TIMEOUT_S) -> None:
    """Wait until ``get`` gives what is wanted; fails with what it gives instead."""
    wait_for(get, lambda got: got == wanted, repr(wanted), seconds)


def until(done: Callable[[], bool], seconds: float = PAGE_TIMEOUT_S) -> None:
    """Wait until ``done`` is true."""
    wait_until_equal(done, True, seconds)


def wait_for_words(page: Any, part: str, pattern: str, seconds: float = PAGE_TIMEOUT_S) -> None:
    """Wait until the text of a part matches; fails with the text instead."""
    wait_for(
        lambda: words(page, part),
        lambda said: re.search(pattern, said),
        f"{pattern!r} in {part}",
        seconds,
    )


def wait_for_pressed(page: Any, part: str, name: str) -> None:
    """Wait until a button is pressed."""
    button = page.locator(part).get_by_role("button", name=name, exact=True, pressed=True)
    button.wait_for()


def canvas(page: Any) -> str:
    """A hash of the plan's picture."""
    return hashlib.sha256(page.locator("gh-plan canvas").screenshot()).hexdigest()


def wait_for_other_canvas(page: Any, before: str) -> str:
    """The hash of the plan's picture, once it differs from ``before``."""
    return wait_for(lambda: canvas(page), lambda now: now != before, "another picture")


def wait_until_ready(page: Any) -> Any:
    """The page, once it shows a frame in its own font and nothing is being prepared."""
    page.wait_for_selector("gh-plan canvas[aria-label*='range']", timeout=1000 * PATIENCE_S)
    page.wait_for_selector("gh-top-bar .preparing", state="detached", timeout=1000 * PATIENCE_S)
    page.evaluate("document.fonts.ready.then(() => null)")
    return page


def find_chromium() -> str | None:
    """The browser named in the environment, or the installed one."""
    named = os.environ.get("GLASSHELM_CHROMIUM")
    return named or next((path for path in map(shutil.which, BROWSERS) if path), None)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """Chromium; without it these tests are skipped, or fail in CI (tests/missing.py).

    Per module, because Playwright runs an event loop in this thread meanwhile: tests of other
    modules could not start one of their own.
    """
    playwright = needed("playwright.sync_api")
    found = find_chromium()
    if found is None:
        missing("no Chromium on this machine: scripts/install-chromium installs it")
    if not PAGE_FILE.is_file():
        missing("the page is not built: make page")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(
            executable_path=found, args=FLAGS, timeout=1000 * PAGE_TIMEOUT_S
        )
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def serve(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., Server]]:
    """Starts servers, which end with the module."""
    begun: list[Server] = []

    def start_server(source: str, *more: str, token: str = "") -> Server:
        server = Server(source, free_port(), tmp_path_factory.mktemp("logs"), more, token)
        server.start()
        begun.append(server)
        return server

    yield start_server
    for server in begun:
        server.kill()


@pytest.fixture
def open_page(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Opens the page as a new viewer, waits for a frame; an error in its console is a failure."""
    contexts: list[Any] = []
    errors: list[str] = []

    def open_at(server: Server, width: int = 1280, height: int = 800, **settings: Any) -> Any:
        context = chromium.new_context(
            viewport={"width": width, "height": height}, bypass_csp=True, reduced_motion="reduce"
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(1000 * PAGE_TIMEOUT_S)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        if settings:
            kept = json.dumps(json.dumps(settings))
            page.add_init_script(
                f"localStorage.getItem('glasshelm') ?? localStorage.setItem('glasshelm', {kept})"
            )
        page.goto(server.url)
        return wait_until_ready(page)

    yield open_at
    for context in contexts:
        context.close()
    # A refused connection while the server is down is reported by the browser, not by the page.
    assert [e for e in errors if "ERR_CONNECTION" not in e and "WebSocket" not in e] == []
