"""Owners and those who only look on: what each may do, and who is taken for which."""

import asyncio
import re
import subprocess
import sys
import urllib.request

import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect
from tests.bridge.test_background_jobs import Viewer, playing
from tests.bridge.test_server import Page

from glasshelm.bridge.server import protocol as m
from glasshelm.bridge.server.access_control import TOKEN_COOKIE, AccessControl
from glasshelm.bridge.server.app import create_app
from glasshelm.bridge.server.protocol import Open
from glasshelm.bridge.server.session_hub import (
    MAX_WAITING_QUESTIONS,
    RESERVED_FOR_OWNERS,
    SessionHub,
)
from glasshelm.bridge.server.viewer_queue import ViewerQueue
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.session_factory import prepare_session
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.core.errors import InputError

OWNER, VIEWER = "owner-0123456789", "viewer-0123456789"
HERE = "http://ship.example:8470"

#: One of every request that changes what others see.
CHANGES = [
    {"type": "open", "source": "imazu:2"},
    {"type": "replay", "log": "a.jsonl"},
    {"type": "pilot", "name": "straight"},
    {"type": "compare", "name": "straight"},
    {"type": "compare", "name": None},
    {"type": "play"},
    {"type": "pause"},
    {"type": "rate", "rate": 60},
    {"type": "seek", "time_s": 100},
    {"type": "acknowledge", "id": "cpa-1"},
    {"type": "limits", "dcpa_m": 1, "tcpa_s": 1},
]


def client(folder, token=OWNER, viewer_token=VIEWER, first=None, most=100) -> TestClient:
    hub = SessionHub(SourceList(LogIndex(folder)), folder)
    guard = AccessControl("0.0.0.0" if token else "127.0.0.1", token, viewer_token)
    app = create_app(hub, guard, first, static=folder / "static", max_viewers=most)
    return TestClient(app, base_url=HERE if token else "http://127.0.0.1:8470")


def role_of(browser: TestClient, query: str = "") -> str | None:
    """As whom a page of this browser is greeted; None if it is refused."""
    base = str(browser.base_url).replace("http:", "ws:")
    try:
        with browser.websocket_connect(f"{base}/ws{query}") as socket:
            return socket.receive_json()["role"]
    except WebSocketDisconnect:
        return None


def test_every_request_is_either_of_the_owner_or_of_all():
    tags = {kind.__struct_config__.tag for kind in m.Request.__args__}
    assert tags == {asked["type"] for asked in CHANGES} | {"ping", "whatif"}


def test_a_viewer_sees_all_and_changes_nothing(tmp_path):
    first = prepare_session(
        Open("imazu:1", "straight", "paper"), SourceList(LogIndex(tmp_path)), tmp_path
    )
    base = HERE.replace("http:", "ws:")
    with (
        client(tmp_path, first=first) as browser,
        browser.websocket_connect(f"{base}/ws?token={OWNER}") as one,
        browser.websocket_connect(f"{base}/ws?token={VIEWER}") as other,
    ):
        owner, viewer = Page(one), Page(other)
        assert one.receive_json()["role"] == "owner"
        assert other.receive_json()["role"] == "viewer"
        owner.until("alarms").ask("pause").until("session")
        owner.ask("seek", time_s=50.0).until("history", "frame")
        viewer.until("alarms")
        while viewer.frames != owner.frames:
            viewer.hear()
        before = browser.get("/api/health").json()["failed_messages"]
        for asked in CHANGES:
            viewer.ask(**asked).until("error")
            kind = asked["type"]
            assert viewer.failures[-1] == (
                f"you are a viewer: {kind!r} is for the owner of this bridge"
            )
        assert browser.get("/api/health").json()["failed_messages"] == before + len(CHANGES)
        viewer.ask("whatif", change="delete", ship="1").until("whatif")
        viewer.ask("ping").until("pong")
        # What is told to all is told to them in their own role.
        owner.ask("limits", dcpa_m=100.0, tcpa_s=60.0)
        for socket, role in ((one, "owner"), (other, "viewer")):
            while (said := socket.receive_json())["type"] != "hello":
                pass
            assert (said["role"], said["limits"]["dcpa_m"]) == (role, 100.0)
        owner.ask("seek", time_s=50.0).until("history", "frame")
        assert not owner.session["playing"]
        assert owner.session["rate"] == 1.0


@pytest.mark.parametrize(("given", "role"), [(OWNER, "owner"), (VIEWER, "viewer")])
def test_the_role_of_the_address_stays_with_the_browser(tmp_path, given, role):
    with client(tmp_path) as browser:
        assert role_of(browser) is None
        assert browser.get(f"/?token={given}").status_code == 200
        assert browser.cookies[TOKEN_COOKIE] == given
        assert role_of(browser) == role
        assert browser.get("/").status_code == 200  # reloaded without it
        assert browser.cookies[TOKEN_COOKIE] == given
        assert role_of(browser) == role


def test_the_token_of_the_address_goes_before_that_of_the_cookie(tmp_path):
    with client(tmp_path) as browser:
        browser.get(f"/?token={OWNER}")
        assert role_of(browser, f"?token={VIEWER}") == "viewer"
        browser.get(f"/?token={VIEWER}")
        assert browser.cookies[TOKEN_COOKIE] == VIEWER
        assert role_of(browser) == "viewer"
        assert role_of(browser, "?token=wrong") == "viewer"
        assert role_of(browser, f"?token={OWNER}") == "owner"


@pytest.mark.parametrize(
    "cookie",
    [VIEWER + OWNER, OWNER[:-1], f"{VIEWER}; {TOKEN_COOKIE}=", f'"{OWNER}x"', OWNER.upper(),
     "owner", "", f"x{OWNER}", "\xfc" * 16, f"{OWNER}%00"],
)  # fmt: skip
def test_no_other_cookie_makes_an_owner(tmp_path, cookie):
    with client(tmp_path) as browser:
        value = f"{TOKEN_COOKIE}={cookie}".encode("latin-1")
        assert browser.get("/", headers={"cookie": value}).status_code == 403


def test_without_a_viewer_s_token_an_empty_one_is_none(tmp_path):
    with client(tmp_path, viewer_token=None) as browser:
        assert role_of(browser, "?token=") is None
        assert role_of(browser, f"?token={VIEWER}") is None


def test_without_any_token_everybody_here_is_the_owner(tmp_path):
    with client(tmp_path, None, None) as browser:
        assert role_of(browser) == "owner"
        assert "set-cookie" not in browser.get("/").headers


@pytest.mark.parametrize(
    ("token", "viewer_token", "line"),
    [
        (OWNER, OWNER, "--viewer-token: must be another"),
        (OWNER, "short", "--viewer-token: must be 12"),
        (OWNER, "", "--viewer-token: must be 12"),
        (OWNER, "ünicode-token-x", "--viewer-token: must be 12"),
        (OWNER, "with a space 123", "--viewer-token: must be 12"),
        (OWNER, "with-a-newline\n", "--viewer-token: must be 12"),
        (None, VIEWER, "--viewer-token: also give the owner's --token"),
        ("with a space 123", None, "--token: must be 12"),
    ],
)
def test_tokens_that_are_of_no_use_are_refused_in_one_line(token, viewer_token, line):
    with pytest.raises(InputError, match=line):
        AccessControl("127.0.0.1", token, viewer_token)


def test_viewers_leave_room_for_an_owner(tmp_path):
    base = HERE.replace("http:", "ws:")
    with client(tmp_path, most=10) as browser:
        sockets = [browser.websocket_connect(f"{base}/ws?token={VIEWER}") for _ in range(9)]
        for socket in sockets:
            socket.__enter__()
        try:
            assert role_of(browser, f"?token={VIEWER}") is None
            assert role_of(browser, f"?token={OWNER}") == "owner"
        finally:
            for socket in sockets:
                socket.__exit__(None, None, None)


def test_viewers_leave_questions_for_an_owner(tmp_path, monkeypatch):
    """While none is answered."""

    async def waiting(*args):
        await asyncio.sleep(3600)

    monkeypatch.setattr(SessionHub, "_answer", waiting)

    async def ask():
        async with playing(tmp_path) as (hub, owner):
            crowd = [Viewer(hub) for _ in range(10)]
            for one in crowd:
                one.outbox = ViewerQueue("viewer")
                await one.join()
                await one.ask("whatif", change="keep_course")
            assert len(hub._questions) == MAX_WAITING_QUESTIONS - RESERVED_FOR_OWNERS
            assert "too many questions" in (await crowd[-1].next("error"))["message"]
            for _ in range(4):
                await owner.ask("whatif", change="keep_course")
            assert "too many questions" in (await owner.next("error"))["message"]
            assert len(hub._questions) == MAX_WAITING_QUESTIONS

    asyncio.run(ask())


def test_both_addresses_are_printed_and_no_token_after_that(tmp_path):
    odd = "viewer&+%;=token"
    command = [sys.executable, "-m", "glasshelm", "bridge", "imazu:1", "--pilot", "straight"]
    command += ["--no-open", "--port", "0", "--log-dir", str(tmp_path)]
    command += ["--token", OWNER, "--viewer-token", odd]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    try:
        said = [process.stderr.readline() for _ in range(4)]
        owner = re.fullmatch(r"bridge: +(http://127\.0\.0\.1:\d+/)\?token=(\S+)\n", said[0])
        viewer = re.fullmatch(r"view only: +(http://127\.0\.0\.1:\d+/)\?token=(\S+)\n", said[1])
        assert owner is not None
        assert viewer is not None
        assert owner[2] == OWNER
        for line in said[:2]:
            with urllib.request.urlopen(line.split()[-1]) as answer:
                assert answer.status == 200
                assert answer.headers["set-cookie"]
        process.terminate()
        rest = process.communicate(timeout=60)[1]
        assert OWNER not in rest
        assert odd not in rest
    finally:
        process.kill()
        process.wait(timeout=60)
