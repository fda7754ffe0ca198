"""Whatever a ship is called, she is shown as text: in figures, report, tables, terminal."""

import dataclasses
import io
import json
import os
import re
import subprocess
import sys

import pytest
from tests.voyages import plain

from glasshelm.cli import main
from glasshelm.core.terminal import TaskDescription, Terminal, progress
from glasshelm.core.text import MAX_NAME_LENGTH, file_name, markdown_code, markdown_text, printable
from glasshelm.encounters.dnv_situation import read_situation
from glasshelm.encounters.types import TargetInfo
from glasshelm.evaluation.tables import markdown_table
from glasshelm.frames.frame_log import read_log, write_log
from glasshelm.frames.schema import Frame
from glasshelm.pilots.registry import pilot_named
from glasshelm.report import write_report as room
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.voyage import simulate

#: Names that mean something to what draws, lays out or prints them.
NAMES = (
    r"$\X$", "$", "a_b^c{d}", "_hidden", r"\frac", "<script>alert(1)</script>", "a|b", "`x`",
    "[red]x[/red]", "[/]", "line\nbreak", "tab\there", "ret\rurn", "\x00nul", "\x1b[31mred\x1b[0m",
    "\x1b]0;title\x07", "\x9b31m", "del\x7f", "\u202eright to left", "\u2066isolate",
    "sep\u2028arated", "{0}", "%s %d", "=1+1", "../../etc/passwd", "X" * 10_000, "船" * 300,
    "", " ",
)  # fmt: skip
#: What no terminal and no page may get from outside.
ORDERS = ("\x1b", "\x00", "\x07", "\x7f", "\x9b", "\r", "\u202e", "\u2066", "\u2028")


def situation(names, title="T"):
    """A file of DNV's layout with ships of these names about own ship."""
    place = {"position": {"lat": 0.0, "lon": 0.0}, "sog": 10.0, "cog": 0.0}
    targets = [
        {
            "static": {"id": k + 2, "name": name},
            "initial": {
                "position": {"lat": 0.05 + 0.01 * k, "lon": 0.01 * (k % 3 - 1)},
                "sog": 8.0,
                "cog": 180.0,
            },
        }
        for k, name in enumerate(names)
    ]
    own = {"static": {"name": names[0]}, "initial": place}
    return json.dumps({"title": title, "ownShip": own, "targetShips": targets})


@pytest.mark.parametrize("text", NAMES)
def test_what_is_shown_is_one_line_of_text(text):
    shown = printable(text)
    assert shown.isprintable()
    assert printable(shown) == shown
    assert text.isprintable() <= (shown == text)


def test_what_people_write_stays():
    for text in ("ÅBO", "МОСКВА", "می\u200cخواهم", "船", "O'Brien & Söhne", "a b"):
        assert printable(text) == text
    assert printable("a\u00a0b\u2003c") == "a b c"
    assert printable("\ud800") == "\\ud800"  # half of a pair: no file takes it


@pytest.mark.parametrize("text", NAMES)
def test_a_file_can_have_that_name(text, tmp_path):
    (tmp_path / f"figure_worst_{file_name(text)}.png").touch()
    assert len(list(tmp_path.iterdir())) == 1


def test_file_names_of_two_things_differ():
    names = {file_name(name) for name in (*NAMES, "a/b", "a-b", "X" * 9_999, "-", "\ud800")}
    assert len(names) == len(NAMES) + 5
    assert file_name("paper-sum_1") == "paper-sum_1"


def test_markdown_reads_a_name_as_text():
    assert markdown_text("a|b`c`*d*<e>$f$") == r"a\|b\`c\`\*d\*\<e>\$f\$"
    assert markdown_text("_x_ [y](z) large_ship") == r"\_x\_ [y\](z) large_ship"
    assert markdown_text("a\nb").count("\n") == 0
    assert markdown_code("a") == "`a`"
    assert markdown_code("a`b``c") == "``` a`b``c ```"


def test_nobody_enters_with_an_order_in_her_name():
    for name in NAMES:
        info = TargetInfo(f"i{name}", name, ship_type=name)
        assert info.id.isprintable()
        assert info.name.isprintable()
        assert len(info.name) <= MAX_NAME_LENGTH
        assert (info.ship_type or "").isprintable()


def test_a_log_from_outside_is_read_as_text(tmp_path):
    log = tmp_path / "frames.jsonl"
    write_log(log, plain()[:2])
    raw = json.loads(log.read_text().splitlines()[0])
    raw["pilot"] = raw["source"] = raw["targets"][0]["name"] = raw["targets"][0]["id"] = "\x1b[2J"
    raw["outside_training"] = ["\u202efast"]
    log.write_text(json.dumps(raw) + "\n")
    frame = next(read_log(log))
    assert isinstance(frame, Frame)
    told = (frame.pilot, frame.source, frame.targets[0].name, frame.targets[0].id)
    assert set(told) == {"\\x1b[2J"}
    assert frame.outside_training == ["\\u202efast"]


@pytest.mark.slow
def test_a_situation_of_odd_names_is_explained(tmp_path, capsys):
    """All figures of all names are drawn, and what is printed gives no orders."""
    file, out = tmp_path / "odd.json", tmp_path / "out"
    file.write_text(situation(NAMES[:24], "\x1b[31m$\\X$<b>\u202e"))
    options = ("--pilot", "paper-attention", "--steps", "6", "--out", str(out))
    assert main(["explain", str(file), *options]) == 0
    page = (out / "report.html").read_text()
    assert "it failed" not in page
    assert "<script>" not in page
    told = capsys.readouterr()
    for order in ORDERS:
        assert order not in page + told.out + told.err, ascii(order)
    assert len(list((out / "figures").glob("*.png"))) == 12


@pytest.mark.parametrize("command", ["run", "explain"])
def test_what_is_wrong_is_said_in_one_line(tmp_path, capsys, command):
    broken = json.loads(situation(["A", "B"]))
    broken["targetShips"][1]["initial"]["position"] = {"lat": 0.0, "lon": 0.0}
    broken["targetShips"][1]["static"]["name"] = "\x1b[31m\nB"
    file = tmp_path / "near.json"
    file.write_text(json.dumps(broken))
    assert main([command, str(file), "--pilot", "straight", "--out", str(tmp_path / "o")]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "\\x1b[31m\\nB" in err


@pytest.mark.slow
def test_two_futures_of_odd_names(tmp_path, capsys):
    file, log, out = (tmp_path / name for name in ("odd.json", "log.jsonl", "out"))
    file.write_text(situation([r"$\X$", "[/]", "\x1b[31m"]))
    write_log(log, simulate(read_situation(file, SHIPS["paper"]), pilot_named("paper-sum"), 6))
    options = ("--minutes", "1", "--delete", r"$\X$", "[/]", "--out", str(out))
    assert main(["whatif", str(log), "--at", "10", *options]) == 0
    assert "[/]" in capsys.readouterr().out
    assert (out / "whatif.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_figure_that_fails_is_told_of_in_the_report(tmp_path, monkeypatch):
    def fails(voyage):
        raise ValueError("\x1b[31m<no>")

    specs = [dataclasses.replace(room.FIGURES[0], draw=fails), *room.FIGURES[2:4]]
    monkeypatch.setattr(room, "FIGURES", specs)
    page = room.write_report(plain(), tmp_path).read_text()
    assert "Tracks: not drawn, it failed (ValueError: \\x1b[31m&lt;no&gt;)." in page
    monkeypatch.setattr(room, "FIGURES", specs[:1])
    assert "What happened" in room.write_report(plain(), tmp_path).read_text()


def test_a_terminal_gets_text():
    out = io.StringIO()
    terminal = Terminal(file=out, force_terminal=True, color_system="truecolor", width=40)
    for name in NAMES:
        terminal.say(name)
    assert not any(order in out.getvalue() for order in ORDERS)
    assert "[red]x[/red]" in out.getvalue()
    bar = progress(terminal)
    for name in NAMES:
        bar.add_task(name)
    assert [TaskDescription().render(task).plain for task in bar.tasks] == [*map(printable, NAMES)]


_LOGS = """
import logging, threading, warnings
from glasshelm.core.terminal import as_program
as_program()
def fail():
    raise ValueError("\\x1b[31m\\nbad")
try:
    fail()
except ValueError:
    logging.getLogger("glasshelm.bridge").exception("the session\\nfailed")
logging.getLogger("somebody").warning("is old")
warnings.warn("overflow", RuntimeWarning)
threading.Thread(target=fail).start()
"""


def _logged(**env):
    command = [sys.executable, "-c", _LOGS]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **env})
    return done.stderr


def test_what_is_logged_is_one_line_and_libraries_are_quiet():
    failed, thread = _logged(GLASSHELM_DEBUG="").splitlines()
    why = "(ValueError: \\x1b[31m\\nbad; GLASSHELM_DEBUG=1 shows where)"
    assert failed == f"glasshelm: the session\\nfailed {why}"
    assert thread == f"glasshelm: a thread failed {why}"


def test_whoever_asks_sees_where():
    told = _logged(GLASSHELM_DEBUG="1")
    assert told.count("Traceback") == 2
    assert "RuntimeWarning: overflow" in told


def test_a_table_has_as_many_columns_whoever_is_in_it():
    table = markdown_table(["pilot", "ship"], [[name, "x"] for name in NAMES]).split("\n")
    assert len(table) == len(NAMES) + 2
    for row in table:
        assert len(re.findall(r"(?<!\\)(?:\\\\)*\|", row)) == 3, row
