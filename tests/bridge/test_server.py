"""The server as a page meets it: requests in, messages out."""

import contextlib
import json
import socket

import pytest
from starlette.testclient import TestClient, WebSocketTestSession

from glasshelm.bridge.server.access_control import AccessControl
from glasshelm.bridge.server.app import create_app
from glasshelm.bridge.server.protocol import MAX_REQUEST_BYTES, Open
from glasshelm.bridge.server.server import bind, serve
from glasshelm.bridge.server.session_hub import SessionHub
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.session_factory import prepare_session
from glasshelm.bridge.sessions.session_log import FileLog
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.core.errors import InputError
from glasshelm.frames import frame_log

URL = "ws://127.0.0.1/ws"


class Page:
    """A viewer that keeps what it is told, as the page does."""

    def __init__(self, socket: WebSocketTestSession):
        self._socket = socket
        self.session: dict = {}
        self.frames: list[dict] = []
        self.now: dict = {}
        self.failures: list[str] = []
        self.answer: dict = {}

    def ask(self, type: str, **fields) -> "Page":
        self._socket.send_text(json.dumps({"type": type, **fields}))
        return self

    def hear(self) -> str:
        message = self._socket.receive_json()
        kind = message["type"]
        if kind == "session":
            self.session = message
        elif kind == "history":
            self.frames = message["frames"]
        elif kind == "frame":
            self.now = message
            self.frames.append(message["frame"])
        elif kind == "whatif":
            self.answer = message
        elif kind == "error":
            self.failures.append(message["message"])
        return kind

    def until(self, *kinds: str) -> "Page":
        """Hear until a message of each kind came, in this order; a failure is none of them."""
        for kind in kinds:
            while (heard := self.hear()) != kind:
                assert heard != "error", f"waited for {kind}: {self.failures[-1]}"
        return self

    @property
    def times(self) -> list[float]:
        return [frame["time_s"] for frame in self.frames]


@contextlib.contextmanager
def bridge(folder, source: str | None = "imazu:1", pilot: str = "straight"):
    catalogue = SourceList(LogIndex(folder))
    first = None
    if source is not None:
        first = prepare_session(Open(source, pilot, "paper"), catalogue, folder)
    app = create_app(SessionHub(catalogue, folder), AccessControl("127.0.0.1", None), first)
    with TestClient(app, base_url="http://127.0.0.1") as client:
        yield client


@contextlib.contextmanager
def page(client: TestClient):
    with client.websocket_connect(URL) as socket:
        yield Page(socket)


def test_a_voyage_is_played_paused_sought_and_logged(tmp_path):
    with bridge(tmp_path) as client, page(client) as viewer:
        assert viewer.hear() == "hello"
        viewer.until("session", "history", "frame", "alarms")
        assert viewer.session["mode"] == "simulated"
        assert viewer.session["playing"]
        assert viewer.times == [0.0]
        assert len(viewer.now["predicted_track"]) == 41
        ahead = viewer.now["predicted_track"]
        assert ahead[1] == pytest.approx([0.0, 30 * 10 * 1852 / 3600], abs=0.1)
        viewer.ask("rate", rate=60).until("frame", "frame", "frame")
        assert viewer.times == [0.0, 5.0, 10.0, 15.0]
        viewer.ask("pause").until("session")
        while viewer.session["playing"]:
            viewer.hear()
        viewer.ask("seek", time_s=1502.0).until("history", "frame")
        assert viewer.times == [5.0 * k for k in range(301)]
        assert viewer.now["encounters"]["1"] == {
            "type": "head-on",
            "role": "give-way",
            "rule": "14",
        }
        viewer.ask("seek", time_s=20.0).until("history", "frame")
        assert viewer.times == [0.0, 5.0, 10.0, 15.0, 20.0]
        assert viewer.session["seekable_to_s"] == 3600.0
        log = tmp_path / viewer.session["log"]
        whole = [json.loads(line) for line in log.read_text().splitlines()]
        assert whole[:5] == viewer.frames
        assert len(list(frame_log.read_log(log))) == 301


def test_a_late_joiner_gets_what_the_others_have_and_all_see_the_same(tmp_path):
    with bridge(tmp_path) as client, page(client) as first:
        first.until("alarms").ask("pause").until("session")
        first.ask("seek", time_s=100.0).until("history", "frame")
        with page(client) as second:
            assert second.hear() == "hello"
            second.until("session", "history", "frame", "alarms")
            assert second.frames == first.frames
            assert not second.session["playing"]
            second.ask("rate", rate=60).ask("play")
            first.until("frame", "frame")
            second.until("frame", "frame")
            assert second.frames == first.frames


def test_another_pilot_from_the_frame_shown_on_and_one_beside(tmp_path):
    with bridge(tmp_path, "imazu:2") as client, page(client) as viewer:
        viewer.until("alarms").ask("pause").until("session")
        viewer.ask("seek", time_s=50.0).until("history", "frame")
        before = list(viewer.frames)
        viewer.ask("compare", name="paper-mpc").until("history", "frame")
        assert viewer.now["compare"]["pilot"] == "paper-mpc"
        assert viewer.now["compare"]["time_s"] == 50.0
        assert viewer.session["compare"] == "paper-mpc"
        viewer.ask("pilot", name="paper-mpc").until("history", "frame")
        assert viewer.session["pilot"] == "paper-mpc"
        assert viewer.frames[:-1] == before[:-1]
        assert viewer.frames[-1]["pilot"] == "paper-mpc"
        assert viewer.frames[-1]["own"] == before[-1]["own"]
        viewer.ask("seek", time_s=600.0).until("history", "frame")
        pilots = [frame["pilot"] for frame in viewer.frames]
        assert pilots == ["straight"] * 10 + ["paper-mpc"] * 111
        assert abs(viewer.frames[-1]["own"]["heading_rad"]) > 0.1  # it gives way; straight did not
        viewer.ask("compare", name=None).until("history", "frame")
        assert "compare" not in viewer.now


def test_a_recorded_ship_keeps_her_track_while_the_pilot_advises(tmp_path):
    with bridge(tmp_path, None) as client, page(client) as viewer:
        viewer.until("hello")
        viewer.ask("seek", time_s=5.0).until("error")
        viewer.ask("open", source="gulf-of-finland", pilot="straight").until("history", "frame")
        assert viewer.session["mode"] == "recorded"
        assert viewer.now["frame"]["decision"]["applied"] is False
        viewer.ask("pause").until("session").ask("seek", time_s=120.0).until("history", "frame")
        assert len(viewer.now["frame"]["targets"]) > 30
        assert viewer.now["frame"]["time_utc"].startswith("2014-08-15")


def test_a_log_is_replayed_and_scrubbed_as_it_was(tmp_path):
    with bridge(tmp_path) as client:
        with page(client) as viewer:
            viewer.until("alarms").ask("pause").until("session")
            viewer.ask("seek", time_s=200.0).until("history", "frame")
            sailed, name = viewer.frames, viewer.session["log"]
        with page(client) as viewer:
            logs = [viewer._socket.receive_json()["catalogue"]["logs"][0]["name"]]
            assert logs == [name]
            viewer.until("alarms").ask("replay", log=name).until("session", "history", "frame")
            while viewer.session["mode"] != "replay":
                viewer.until("session", "history", "frame")
            viewer.ask("seek", time_s=1e6).until("history", "frame")
            assert viewer.frames == sailed
            assert viewer.session["end_s"] == 200.0
            viewer.ask("seek", time_s=52.0).until("history", "frame")
            assert viewer.frames == sailed[:11]
            viewer.ask("pilot", name="straight").until("error")
            viewer.ask("compare", name="straight").until("error")


SECRETS = [
    ("open", {"source": "/etc/passwd"}),
    ("open", {"source": "secret.json"}),
    ("open", {"source": "../secret.json"}),
    ("open", {"source": "random:1/../secret"}),
    ("open", {"source": "imazu:../../secret"}),
    ("open", {"source": "tcp://127.0.0.1:22"}),
    ("open", {"source": "live:secret.json"}),
    ("open", {"source": "imazu:1", "own": "1"}),
    ("open", {"source": "imazu:1", "ship": "/etc/passwd"}),
    ("open", {"source": "imazu:1", "pilot": "weights.safetensors"}),
    ("open", {"source": "imazu:1", "pilot": "os:system"}),
    ("pilot", {"name": "os:system"}),
    ("pilot", {"name": "/tmp/weights.safetensors"}),
    ("compare", {"name": "weights.safetensors"}),
    ("replay", {"log": "../secret.jsonl"}),
    ("replay", {"log": "/etc/passwd"}),
    ("acknowledge", {"id": "cpa-1"}),
]


def test_no_path_of_the_disk_is_reached_and_the_session_goes_on(tmp_path, monkeypatch):
    logs = tmp_path / "logs"
    logs.mkdir()
    monkeypatch.chdir(tmp_path)
    for name in ("secret.json", "secret.jsonl", "weights.safetensors", "random:1"):
        (tmp_path / name).write_text("secret contents")
    with bridge(logs) as client, page(client) as viewer:
        viewer.until("alarms")
        for type, fields in SECRETS:
            viewer.ask(type, **fields).until("error")
            said = viewer.failures[-1]
            assert "secret contents" not in said, fields
            assert str(tmp_path) not in said, fields
            assert "\n" not in said, fields
        assert len(viewer.failures) == len(SECRETS)
        # A generator is one, whatever files there are.
        viewer.ask("open", source="random:1", pilot="straight").until("history", "frame")
        assert viewer.session["source"] == "random:1"


def test_what_is_wrong_is_told_of_the_source_by_its_name_and_no_folder(tmp_path):
    """Of a bundled recording, and of the file of the command line, gone since it was read."""
    file = tmp_path / "private" / "traffic.csv"
    file.parent.mkdir()
    file.write_text("MMSI\n1\n")
    catalogue = SourceList(LogIndex(tmp_path), f"{file.parent}/./{file.name}")
    for source, own, line in (
        ("gulf-of-finland", "1", "gulf-of-finland: no usable report of MMSI 1"),
        ("traffic.csv", None, "traffic.csv: "),
    ):
        with pytest.raises(InputError) as told:
            prepare_session(Open(source, "straight", None, own=own), catalogue, tmp_path)
        assert str(told.value).startswith(line)
        assert "/" not in str(told.value)
    gone = SourceList(LogIndex(tmp_path), f"live:{file}")
    file.unlink()
    with pytest.raises(InputError, match=r"no feed 'traffic.csv' \(nor such a file\)"):
        gone.open_feed(None)
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"^log.jsonl: cannot write the log \(its folder"):
        FileLog(tmp_path / "file" / "log.jsonl", fresh=True)


def test_the_ship_is_the_pilot_s_own_if_none_is_named(tmp_path):
    catalogue = SourceList(LogIndex(tmp_path))
    for source, pilot, ship, sailed in (
        ("imazu:1", "large-ship-cpa", None, "large_ship"),
        ("imazu:1", "large-ship-cpa", "paper", "paper"),
        ("imazu:1", "straight", None, "paper"),
        ("gulf-of-finland", "straight", None, "paper"),
    ):
        session = prepare_session(Open(source, pilot, ship), catalogue, tmp_path)()
        assert session.info.ship == sailed
        session.close()


def test_mangled_messages_are_answered_counted_and_survived(tmp_path):
    mangled = ["", "{", "null", "[1]", '{"type":"fly"}', '{"type":"rate","rate":1e9}', "\x00"]
    with bridge(tmp_path) as client, page(client) as viewer:
        viewer.until("alarms").ask("pause").until("session")
        for text in mangled:
            viewer._socket.send_text(text)
            viewer.until("error")
        viewer._socket.send_bytes(b"\xff\x00")
        viewer.until("error")
        viewer.ask("ping", filler="x" * MAX_REQUEST_BYTES).until("error")
        assert "at most" in viewer.failures[-1]
        viewer.ask("acknowledge", id="none").until("error")
        health = client.get("/api/health").json()
        assert health["invalid_messages"] == len(mangled) + 2
        assert health["failed_messages"] == 1
        assert health["messages"] == len(mangled) + 4
        assert health["feed_counts"] is None, "nothing is heard in simulated traffic"
        viewer.ask("ping").until("pong")


def test_alarms_reach_all_viewers_and_are_acknowledged_for_all(tmp_path):
    with bridge(tmp_path) as client, page(client) as first, page(client) as second:
        first.until("alarms").ask("pause").until("session")
        second.until("alarms")
        first.ask("seek", time_s=1500.0)
        alarms = _alarms(first)
        assert [(a["target"], a["state"]) for a in alarms] == [("1", "unacknowledged")]
        assert alarms == _alarms(second)
        second.ask("acknowledge", id=alarms[0]["id"])
        for viewer in (first, second):
            assert [a["state"] for a in _alarms(viewer)] == ["acknowledged"]
        first.ask("limits", dcpa_m=1852.0, tcpa_s=60.0)
        assert _alarms(first) == []
        assert _next(second, "hello")["limits"] == {"dcpa_m": 1852.0, "tcpa_s": 60.0}


def test_a_new_session_s_log_comes_onto_the_list_of_all(tmp_path):
    with bridge(tmp_path) as client, page(client) as first, page(client) as second:
        second.until("alarms")
        first.until("alarms").ask("open", source="imazu:3")
        assert len(_next(second, "hello")["catalogue"]["logs"]) == 2


def _alarms(viewer: Page) -> list[dict]:
    return _next(viewer, "alarms")["alarms"]


def _next(viewer: Page, kind: str) -> dict:
    """The next message of a kind, whatever comes before it."""
    while True:
        message = viewer._socket.receive_json()
        if message["type"] == kind:
            return message


def test_what_if_is_answered_to_who_asked_and_changes_nothing(tmp_path):
    """Imazu 1, head-on: the CPA rule alters for her at once, and without her goes straight on."""
    with bridge(tmp_path, pilot="paper-cpa") as client, page(client) as viewer:
        viewer.until("alarms").ask("pause").until("session")
        viewer.ask("seek", time_s=120.0).until("history", "frame")
        before = viewer.frames
        viewer.ask("whatif", change="delete", ship="1").until("whatif")
        gone = viewer.answer
        assert (gone["time_s"], gone["condition"]) == (120.0, "without ship 1")
        assert gone["summary"].startswith("Without ship 1, the pilot would ")
        assert len(gone["factual"]) == len(gone["counterfactual"]) == 61
        own = before[-1]["own"]
        for track in (gone["factual"], gone["counterfactual"]):
            assert track[0] == pytest.approx([own["east_m"], own["north_m"]], abs=0.1)
        assert abs(gone["counterfactual"][-1][0]) < abs(gone["factual"][20][0]), (
            "no reason to go aside"
        )
        # As things are is what the session sails next, wherever it is looked at.
        viewer.ask("seek", time_s=420.0).until("history", "frame")
        own = viewer.frames[-1]["own"]
        assert gone["factual"][10] == pytest.approx([own["east_m"], own["north_m"]], abs=1.0)
        viewer.ask("seek", time_s=120.0).until("history", "frame")
        assert viewer.frames == before


def test_what_cannot_be_asked_fails_in_one_line_and_the_socket_stays(tmp_path):
    with bridge(tmp_path) as client, page(client) as viewer:
        viewer.until("alarms").ask("pause").until("session")
        for fields, line in (
            ({"change": "delete", "ship": "77"}, "no ship '77'"),
            ({"change": "hide"}, "which ship?"),
            ({"change": "rudder"}, "a rudder in degrees"),
            ({"change": "rudder", "rudder_deg": 30}, "own ship's goes to 5°"),
        ):
            viewer.ask("whatif", **fields).until("error")
            assert line in viewer.failures[-1]
            assert "\n" not in viewer.failures[-1]
        viewer.ask("whatif", change="keep_course").until("whatif")
        assert viewer.answer["condition"] == "if own ship kept her course"


def test_a_replayed_log_is_asked_and_one_of_other_weights_is_refused(tmp_path):
    with bridge(tmp_path) as client, page(client) as viewer:
        viewer.until("alarms").ask("pause").until("session")
        viewer.ask("seek", time_s=60.0).until("history", "frame")
        log = viewer.session["log"]
        text = (tmp_path / log).read_text()
        forged = text.replace(
            '"pilot":"straight"', '"pilot":"straight","weights_sha256":"0123abcd"'
        )
        (tmp_path / "forged.jsonl").write_text(forged)
        viewer.ask("replay", log=log).until("history", "frame", "alarms")
        viewer.ask("whatif", change="rudder", rudder_deg=-5).until("whatif")
        assert viewer.answer["counterfactual"][-1] != viewer.answer["factual"][-1]
        viewer.ask("replay", log="forged.jsonl").until("history", "frame", "alarms")
        viewer.ask("whatif", change="rudder", rudder_deg=-5).until("error")
        assert "other weights (SHA-256 0123abcd" in viewer.failures[-1]


def test_a_token_is_read_with_at_the_command_line_s_server_alone(tmp_path):
    given = SourceList(LogIndex(tmp_path), "signalk://127.0.0.1:9", signalk_token="secret")
    assert given.open_feed(None)._server._token == "secret"
    with pytest.raises(InputError, match="choose one of the catalogue"):
        prepare_session(Open("signalk://127.0.0.1:10", "straight", None), given, tmp_path)


def test_a_first_session_that_cannot_begin_ends_the_server(tmp_path):
    def first():
        raise InputError("log: cannot write the log (No space left on device)")

    hub = SessionHub(SourceList(LogIndex(tmp_path)), tmp_path)
    app = create_app(hub, AccessControl("127.0.0.1", None), first)
    with pytest.raises(InputError, match="No space left"):
        serve(app, bind("127.0.0.1", 0), "", open_browser=False, on_started=lambda: None)


def test_a_feed_that_cannot_listen_is_told_to_who_comes_later_and_on_the_console(tmp_path, caplog):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        source = f"udp://127.0.0.1:{taken.getsockname()[1]}"
        catalogue = SourceList(LogIndex(tmp_path), source)
        first = prepare_session(Open(source, "straight", None), catalogue, tmp_path)
        hub = SessionHub(catalogue, tmp_path)
        app = create_app(hub, AccessControl("127.0.0.1", None), first)
        with TestClient(app, base_url="http://127.0.0.1") as client, page(client) as viewer:
            while "in use" not in str(viewer.session.get("notes")):
                viewer.hear()
            with page(client) as later:
                later.until("session")
                assert "cannot listen: address already in use" in later.session["notes"][0]
            assert client.get("/api/health").json()["feed_counts"]["sentences"]["heard"] == 0
    assert [r.message for r in caplog.records if "cannot listen" in r.message]
