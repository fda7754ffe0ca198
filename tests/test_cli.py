import importlib.util
import resource
import subprocess
import sys

import pytest

from glasshelm import __version__
from glasshelm.cli import COMMANDS, main

#: A process that has not ended after so long hangs, on any machine [s].
PATIENCE_S = 300.0
HEAVY = ("jax", "numpy", "matplotlib", "equinox", "tyro", "pyproj", "scipy")


def glasshelm(*args: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "glasshelm", *args]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)


def test_help_names_every_command(capsys):
    for args in ([], ["-h"], ["--help"]):
        assert main(args) == 0
        out = capsys.readouterr().out
        for command, line in COMMANDS.items():
            assert f"  {command}" in out
            assert line in out


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"glasshelm {__version__}\n"


def test_unknown_command_is_one_line_and_status_2(capsys):
    assert main(["fly"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("glasshelm: unknown command 'fly': choose one of ")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_exists_and_tells_its_options(command):
    assert importlib.util.find_spec(f"glasshelm.cli.{command}") is not None
    done = glasshelm(command, "--help")
    assert done.returncode == 0, done.stderr
    assert "usage: glasshelm" in done.stdout


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from glasshelm.cli import main; main(['--help']); "
        f"print([m for m in {HEAVY!r} if m in sys.modules])"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.stdout.splitlines()[-1] == "[]", done.stdout + done.stderr


def test_help_starts_fast():
    """It takes the processor less than 0.3 s, or on a slow one less than five bare starts."""

    def took_s(*args: str) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [sys.executable, *args]
        subprocess.run(command, capture_output=True, timeout=PATIENCE_S, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    bare = min(took_s("-c", "pass") for _ in range(3))
    assert min(took_s("-m", "glasshelm", "--help") for _ in range(3)) < max(0.3, 5 * bare)


@pytest.mark.parametrize(
    "args",
    [
        ("run", "nowhere:7"),
        ("run", "imazu:99"),
        ("run", "imazu:5", "--pilot", "no-such-pilot"),
        ("explain", "no/such/file.json"),
    ],
)
def test_bad_input_is_one_clear_line(args, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "glasshelm", *args],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        cwd=tmp_path,
    )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith("glasshelm: ")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("args", "line"),
    [
        (("run", "imazu:1", "--ship", "tug"), "unknown ship 'tug': choose one of paper, large"),
        (("run", "imazu:1", "--pilot", "folder.safetensors"), "a folder, not a weights file"),
        (("run", "nan.json"), "nan.json: not JSON"),
        (("run", "empty.csv"), "empty.csv: nothing is in it"),
        (("run", "new-york", "--own", "1"), "no usable report of MMSI 1"),
        (("explain", "empty.jsonl"), "empty.jsonl: no frame in it"),
        (
            ("run", "imazu:1", "--pilot", "straight", "--steps", "1", "--out", "nan.json/x"),
            "nan.json/x: cannot write the log (its folder is a file)",
        ),
        (("bridge", "imazu:1", "--log-dir", "nan.json"), "nan.json: cannot write there"),
        (
            ("bridge", "imazu:1", "--log-dir", "nan.json/x"),
            "nan.json/x: cannot write there (a file",
        ),
        (("bridge", "tcp://localhost:1", "--signalk-token", "x"), "is for signalk://HOST"),
        (("explain", "empty.jsonl", "--ship", "paper"), "leave out pilot, ship, own"),
    ],
)
def test_mistakes_are_told_by_their_cause(args, line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.safetensors").mkdir()
    for name in ("empty.csv", "empty.jsonl"):
        (tmp_path / name).touch()
    position = '{"lat": NaN, "lon": 10}'
    (tmp_path / "nan.json").write_text(f'{{"ownShip": {{"initial": {{"position": {position}}}}}}}')
    assert main(list(args)) == 2
    told = capsys.readouterr().err.splitlines()[-1]
    assert told.startswith("glasshelm: ")
    assert line in told


def test_a_reader_who_goes_away_is_no_traceback():
    command = [sys.executable, "-m", "glasshelm", "train", "--help"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    assert process.stderr.read() == ""
    assert process.wait(timeout=PATIENCE_S) == 141
