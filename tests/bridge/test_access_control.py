import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from glasshelm.bridge.server.access_control import AccessControl
from glasshelm.bridge.server.app import create_app
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.cli import main
from glasshelm.core.errors import InputError

TOKEN = "0123456789abcdef"
HERE = "http://127.0.0.1:8470"


def client(tmp_path, base=HERE, host="127.0.0.1", token=None) -> TestClient:
    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path)
    app = create_app(hub, AccessControl(host, token), static=tmp_path / "static")
    return TestClient(app, base_url=base)


def connects(client: TestClient, url: str = "/ws", **headers: str) -> bool:
    try:
        base = str(client.base_url).replace("http:", "ws:")
        with client.websocket_connect(f"{base}{url}", headers=headers) as socket:
            return socket.receive_json()["type"] == "hello"
    except WebSocketDisconnect:
        return False


@pytest.mark.parametrize(
    ("origin", "allowed"),
    [
        (None, True),  # no browser
        (HERE, True),
        ("http://127.0.0.1:9999", False),
        ("http://evil.example", False),
        ("http://127.0.0.1:8470.evil.example", False),
        ("null", False),
        ("http://127.0.0.1:8470@evil.example", False),
    ],
)
def test_the_page_of_another_site_gets_no_socket(tmp_path, origin, allowed):
    headers = {} if origin is None else {"origin": origin}
    with client(tmp_path) as browser:
        assert connects(browser, **headers) is allowed


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8470", "192.168.1.5", "", "[::1"])
def test_another_sites_name_for_this_machine_is_not_answered_to(tmp_path, host):
    with client(tmp_path) as browser:
        origin = {"host": host, "origin": f"http://{host}"}
        assert not connects(browser, **origin)
        assert browser.get("/", headers={"host": host}).status_code == 403


@pytest.mark.parametrize("name", ["localhost:8470", "[::1]:8470", "127.0.0.1:1234"])
def test_the_names_of_this_machine_are(tmp_path, name):
    with client(tmp_path) as browser:
        assert connects(browser, host=name, origin=f"http://{name}")


def test_without_the_token_nothing_but_the_sign_of_life_is_answered(tmp_path):
    with client(tmp_path, "http://ship.example:8470", "0.0.0.0", TOKEN) as browser:
        assert browser.get("/").status_code == 403
        assert browser.get(f"/?token={TOKEN[:-1]}").status_code == 403
        assert not connects(browser)
        assert not connects(browser, "/ws?token=")
        assert not connects(browser, "/ws?token=%ff%00")
        assert browser.get("/api/health").status_code == 200
        assert connects(browser, f"/ws?token={TOKEN}")
        assert not connects(browser, f"/ws?token={TOKEN}", origin="http://evil.example")


def test_the_page_hands_the_token_on_in_a_cookie_no_script_can_read(tmp_path):
    with client(tmp_path, "http://ship.example:8470", "0.0.0.0", TOKEN) as browser:
        cookie = browser.get(f"/?token={TOKEN}").headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=strict" in cookie
        assert connects(browser)


@pytest.mark.parametrize(
    ("host", "token"), [("0.0.0.0", None), ("192.168.1.5", None), ("::", None), ("", None),
                        ("0.0.0.0", ""), ("0.0.0.0", "short"), ("127.0.0.1", "ünicode-token-x")]
)  # fmt: skip
def test_an_address_that_others_reach_needs_a_token_that_nobody_guesses(host, token):
    with pytest.raises(InputError):
        AccessControl(host, token)


def test_the_command_says_so_in_one_line(capsys):
    assert main(["bridge", "imazu:1", "--host", "0.0.0.0", "--no-open"]) == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith("glasshelm: --host 0.0.0.0: ")


def test_every_answer_forbids_what_comes_from_elsewhere(tmp_path):
    with client(tmp_path) as browser:
        for path in ("/", "/api/health", "/no-such-file"):
            headers = browser.get(path).headers
            assert headers["content-security-policy"].startswith("default-src 'self';")
            assert "http:" not in headers["content-security-policy"]
            assert headers["x-content-type-options"] == "nosniff"
            assert headers["x-frame-options"] == "DENY"


def test_without_a_built_page_the_answer_says_how_to_build_it(tmp_path):
    with client(tmp_path) as browser:
        answer = browser.get("/")
        assert answer.status_code == 200
        assert "make page" in answer.text


@pytest.mark.parametrize(
    "path",
    ["/../secret", "/%2e%2e/secret", "/..%2fsecret", "/assets/../../secret", "//etc/passwd",
     "/%00", "/assets/..%5c..%5csecret"],
)  # fmt: skip
def test_no_file_but_the_pages_own_is_served(tmp_path, path):
    static = tmp_path / "static"
    (static / "assets").mkdir(parents=True)
    (static / "index.html").write_text("the page")
    (static / "assets" / "a.js").write_text("1")
    (tmp_path / "secret").write_text("secret")
    (static / "assets" / "link").symlink_to(tmp_path / "secret")
    with client(tmp_path) as browser:
        assert browser.get("/").text == "the page"
        assert browser.get("/assets/a.js").text == "1"
        for answer in (browser.get(path), browser.get("/assets/link")):
            assert answer.status_code == 404
            assert "secret" not in answer.text
