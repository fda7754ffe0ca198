"""Every file that a command takes may be anything: one line, status 2, never a traceback."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save
from tests.voyages import plain

from glasshelm.cli import main
from glasshelm.frames.frame_log import write_log
from glasshelm.networks.checkpoint import FORMAT, read_header
from glasshelm.pilots.registry import WEIGHTS

DEEP = 100_000
JUNK = np.random.default_rng(0).bytes(3000)
FRAME = b'{"time_s":0,"pilot":"x","source":"y"'

#: What a file may hold in place of JSON or a table.
TEXTS = {
    "empty": b"",
    "junk": JUNK,
    "not UTF-8": b'{"ownShip": "\xff\xfe"}\n',
    "zeros": b"\0" * 1000,
    "NaN": b'{"ownShip": {"initial": {"position": {"lat": NaN, "lon": 1}}}}\n',
    "Infinity": b'{"ownShip": {"initial": {"sog": 1e999}}}\n',
    "huge number": b'{"ownShip": {"initial": {"sog": ' + b"9" * 5000 + b"}}}\n",
    "deep": b"[" * DEEP + b"\n",
    "deep in a field nobody reads": b'{"x": ' + b"[" * DEEP + b"\n",
    "deep in a field that is read": b'{"ownShip": {"static": ' + b'{"a":' * DEEP + b"\n",
    "half a surrogate": b'{"title": "\\ud800", "ownShip": {}}\n',
    "a list": b"[]\n",
    "null": b"null\n",
    "text": b'"text"\n',
    "a frame cut off": FRAME + b"\n",
    "frames of odd types": b'{"time_s":"0","targets":{}}\n' * 2,
}


def header(**parts):
    """A header of bundled weights with some parts changed."""
    return json.dumps(read_header(WEIGHTS / "paper-sum.safetensors") | parts)


def actor(**sizes):
    return header(actor=read_header(WEIGHTS / "paper-sum.safetensors")["actor"] | sizes)


#: Headers of weights files; every one stands before a single tensor.
HEADERS = {
    "no header": None,
    "half a header": "{",
    "deep header": "[" * DEEP,
    "deep part": '{"actor": ' + '{"a":' * DEEP + "1" + "}" * DEEP + "}",
    "huge number in it": '{"actor": ' + "9" * 5000 + "}",
    "no parts": "{}",
    "no layers": actor(encoder=[]),
    "wide layers": actor(encoder=[10**6, 10**6]),
    "wider layers": actor(encoder=[10**30]),
    "layers as wide as allowed": actor(encoder=[65_536, 65_536]),
    "a million layers": actor(encoder=[8] * 10**6),
    "width 0": actor(head=[0]),
    "width -1": actor(head=[-1]),
    "widths in words": actor(head=["wide"]),
    "width 1.5": actor(head=[1.5]),
    "NaN width": actor(head=[float("nan")]),
    "no such kind": actor(kind="sum and more"),
    "kind is a list": actor(kind=["sum"]),
    "no such lens": actor(lens="telescope"),
    "unknown field": actor(depth=3),
    "actor is a list": header(actor=[]),
    "critic is a number": header(critic=3),
    "no such ship": header(ship="tug"),
    "ship is a list": header(ship=[1]),
    "ship is in words": header(ship={"gain_1_s": "much"}),
    "ship lacks all": header(ship={}),
    "config is a list": header(config=[1]),
    "config of odd types": header(config={"preset": 3}),
    "other tensors": header(),
}


def weights(name: str) -> bytes:
    metadata = {"format": FORMAT} | ({} if HEADERS[name] is None else {"header": HEADERS[name]})
    return save({"x": np.zeros(3, np.float32)}, metadata)


WHOLE = (WEIGHTS / "paper-sum.safetensors").read_bytes()
FILES = {
    "empty": b"",
    "junk": JUNK,
    "a length and no more": b"\xff" * 8,
    "a header longer than the file": (2**40).to_bytes(8, "little") + b"{}",
    "a header of junk": (100).to_bytes(8, "little") + JUNK,
    "cut in the header": WHOLE[:500],
    "cut in the weights": WHOLE[:-4],
    "not ours": save({"x": np.zeros(3)}),
    **{name: weights(name) for name in HEADERS},
}

LONG = "x" * 300
#: A place that is none: (what is put there, the name asked for).
PLACES = {"missing": "missing", "folder": "folder", "long name": LONG, "long path": f"a/{LONG}/b"}

#: Commands that read a text (the suffix it may have), as FILE.
READ = [
    ("run FILE", ".json"),
    ("run FILE", ""),
    ("run FILE", ".csv"),
    ("run FILE", ".csv.gz"),
    ("run FILE", ".nmea"),
    ("explain FILE", ".json"),
    ("explain FILE", ".jsonl"),
    ("whatif FILE --at 0", ".jsonl"),
    ("bridge FILE --no-open --port 0", ".json"),
    ("bridge --no-open --port 0 --replay FILE", ".jsonl"),
    ("evaluate --pilots straight --ships paper --suites situations:FILE", ".json"),
    ("evaluate --pilots straight --ships paper --suites recorded:FILE", ".csv"),
]
#: Commands that take weights, as FILE.
SAIL = [
    "run imazu:1 --pilot FILE",
    "run imazu:1 --pilot FILE-guarded",
    "explain imazu:1 --pilot FILE",
    "whatif log.jsonl --at 0 --pilot FILE",
    "bridge imazu:1 --no-open --port 0 --pilot FILE",
    "evaluate --pilots FILE",
    "evaluate --pilots mine=FILE,FILE",
    "faithfulness --pilots FILE",
    "train --preset tiny --set start=FILE",
]
#: Commands that write into a place, as FILE.
WRITE = [
    "run imazu:1 --pilot straight --steps 0 --out FILE",
    "run imazu:1 --pilot straight --steps 0 --parquet FILE",
    "explain log.jsonl --out FILE",
    "explain imazu:1 --pilot straight --steps 0 --out FILE",
    "whatif log.jsonl --at 0 --pilot straight --minutes 0.1 --out FILE",
    "bridge imazu:1 --no-open --port 0 --log-dir FILE",
    "evaluate --pilots straight --ships paper --suites imazu --out FILE",
    "faithfulness --pilots paper-sum --out FILE",
    "train --preset tiny --out FILE",
    "train --resume --out FILE",
]


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("GLASSHELM_DEBUG", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


def told(command: str, file: str, capsys) -> str:
    """What a command that must fail says on standard error."""
    args = [word.replace("FILE", file) for word in command.split()]
    assert main(args) == 2, capsys.readouterr()
    err = capsys.readouterr().err
    assert "Traceback" not in err
    assert err.splitlines()[-1].startswith("glasshelm: ")
    return err


@pytest.mark.slow
@pytest.mark.parametrize("content", TEXTS)
@pytest.mark.parametrize(("command", "suffix"), READ)
def test_texts(command, suffix, content, capsys):
    Path(f"file{suffix}").write_bytes(TEXTS[content])
    assert told(command, f"file{suffix}", capsys).count("\n") == 1


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("command", "suffix"), READ)
def test_places_of_texts(command, suffix, place, capsys):
    Path(f"folder{suffix}").mkdir()
    assert told(command, f"{PLACES[place]}{suffix}", capsys).count("\n") == 1


@pytest.mark.parametrize("content", FILES)
def test_weights(content, capsys):
    Path("file.safetensors").write_bytes(FILES[content])
    assert told(SAIL[0], "file.safetensors", capsys).count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("content", ["empty", "junk", "no layers", "wide layers", "deep header"])
@pytest.mark.parametrize("command", SAIL[1:])
def test_weights_of_every_command(command, content, capsys):
    write_log("log.jsonl", plain()[:3])
    Path("file.safetensors").write_bytes(FILES[content])
    assert told(command, "file.safetensors", capsys).count("\n") == 1


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("command", SAIL)
def test_places_of_weights(command, place, capsys):
    write_log("log.jsonl", plain()[:3])
    Path("folder.safetensors").mkdir()
    assert told(command, f"{PLACES[place]}.safetensors", capsys).count("\n") == 1


@pytest.mark.parametrize("place", [LONG, f"a/{LONG}/b", "file/below"])
@pytest.mark.parametrize("command", WRITE)
def test_places_to_write(command, place, capsys):
    write_log("log.jsonl", plain()[:3])
    Path("file").touch()
    told(command, place, capsys)


@pytest.mark.skipif(os.name != "posix", reason="names of bytes are of Unix")
@pytest.mark.parametrize(
    "command", ["run FILE.json", "explain FILE.jsonl", "evaluate --pilots FILE"]
)
def test_names_that_are_no_text(command, capsys):
    name = os.fsdecode(b"\xff\x1b[31m")
    assert told(command, name, capsys).count("\n") == 1


@pytest.mark.parametrize("content", ["empty", "junk", "no parts", "deep header", "other tensors"])
def test_the_state_of_a_training(content, capsys):
    Path("state.safetensors").write_bytes(FILES[content])
    assert told("train --resume --out FILE", ".", capsys).count("\n") == 1


@pytest.mark.parametrize(
    "error", [TypeError("\x1b[31m\nbad"), MemoryError(), RecursionError("deep"), KeyError("x")]
)
def test_what_nobody_foresaw_is_one_line(error, monkeypatch, capsys):
    def fails(*args):
        raise error

    monkeypatch.setattr("glasshelm.encounters.scenario_factory.scenario_from", fails)
    assert main(["run", "imazu:1", "--pilot", "straight"]) == 70
    err = capsys.readouterr().err
    assert err.startswith(f"glasshelm: internal error: {type(error).__name__}: ")
    assert err.count("\n") == 1
    assert "\x1b" not in err
    monkeypatch.setenv("GLASSHELM_DEBUG", "1")
    with pytest.raises(type(error)):
        main(["run", "imazu:1", "--pilot", "straight"])


def test_a_full_disk_is_one_line(monkeypatch, capsys):
    def full(*args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("glasshelm.frames.frame_log.FrameLog.write", full)
    assert main(["run", "imazu:1", "--pilot", "straight", "--steps", "1"]) == 2
    assert capsys.readouterr().err.endswith("glasshelm: No space left on device\n")
