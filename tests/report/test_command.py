import pytest
from tests.voyages import plain

from glasshelm.cli import main
from glasshelm.frames.frame_log import read_log, write_log


@pytest.fixture
def drawn(monkeypatch):
    """Replaces drawing, which has its own tests, by writing down what was asked."""
    asked = []

    def only_write(frames, folder, title=None, notes=(), progress=None):
        asked.append((len(frames), folder, title))
        return folder / "report.html"

    monkeypatch.setattr("glasshelm.report.write_report.write_report", only_write)
    return asked


@pytest.mark.slow
def test_an_encounter_is_sailed_logged_and_told(tmp_path, drawn, capsys):
    out = tmp_path / "out"
    status = main(["explain", "imazu:1", "--pilot", "straight", "--steps", "20", "--out", str(out)])
    assert status == 0
    assert len(list(read_log(out / "frames.jsonl"))) == 21
    assert drawn == [(21, out, "Imazu case 1: 1 ship, pilot straight")]
    text = capsys.readouterr().out
    assert "No ship came nearer than" in text
    assert f"report: {out / 'report.html'}" in text


def test_a_log_is_told_without_sailing(tmp_path, drawn, capsys):
    log = tmp_path / "frames.jsonl"
    write_log(log, plain())
    assert main(["explain", str(log), "--out", str(tmp_path / "out")]) == 0
    assert drawn == [(120, tmp_path / "out", None)]
    assert "Aurora" in capsys.readouterr().out


def test_a_log_takes_no_pilot(tmp_path, drawn, capsys):
    log = tmp_path / "frames.jsonl"
    write_log(log, plain())
    assert main(["explain", str(log), "--pilot", "straight"]) == 2
    assert "a log is explained as it is" in capsys.readouterr().err


def test_an_unknown_source_is_one_line(tmp_path, drawn, capsys):
    assert main(["explain", "nowhere", "--pilot", "straight", "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_ctrl_c_keeps_the_frames(tmp_path, drawn, capsys, monkeypatch):
    def cut(*args, **kwargs):
        yield from plain()[:5]
        raise KeyboardInterrupt

    monkeypatch.setattr("glasshelm.simulation.voyage.simulate", cut)
    out = tmp_path / "out"
    assert main(["explain", "imazu:1", "--pilot", "straight", "--out", str(out)]) == 130
    assert len(list(read_log(out / "frames.jsonl"))) == 5
    assert drawn == []
