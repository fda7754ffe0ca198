import re

import pytest
from tests.untrained import write_weights

from glasshelm.cli import main
from glasshelm.paper import paper_voyages, reproduce


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--pilots", "nobody"], "unknown pilot 'nobody'"),
        (["--pilots", "straight", "straight"], "named twice"),
        (["--rates", "-1"], "from 0"),
        (["--pilots", "straight", "--encounter", "nowhere"], "no source 'nowhere'"),
    ],
)
def test_bad_options_are_one_line(tmp_path, capsys, options, words):
    assert main(["paper", "--out", str(tmp_path / "out"), *options]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert words in error


def test_a_file_is_no_folder(tmp_path, capsys):
    (tmp_path / "out").write_text("")
    assert main(["paper", "--out", str(tmp_path / "out")]) == 2
    assert "a file has that name" in capsys.readouterr().err


def test_ctrl_c_says_what_is_kept(tmp_path, capsys, monkeypatch):
    def cut(*args):
        raise KeyboardInterrupt

    monkeypatch.setattr(reproduce, "reproduce", cut)
    assert main(["paper", "--out", str(tmp_path)]) == 130
    assert f"is kept in {tmp_path}" in capsys.readouterr().err


@pytest.mark.slow
def test_a_second_run_simulates_and_draws_nothing(tmp_path, capsys, monkeypatch):
    """The page holds every figure and table, and goes on from what an earlier run has kept."""
    monkeypatch.setattr(reproduce, "OTHERS", ("random:1:1",) * 5)
    monkeypatch.setattr(paper_voyages, "STEPS", 155)
    files = {kind: tmp_path / f"{kind}.safetensors" for kind in ("sum", "attention")}
    for kind, file in files.items():
        write_weights(file, kind)
    out = tmp_path / "out"
    command = ["paper", "--out", str(out), "--rates", "0", "--pilots", *map(str, files.values())]
    assert main(command) == 0
    assert f"page: {out / 'index.html'}" in capsys.readouterr().out
    page = (out / "index.html").read_text()
    for number in range(1, 16):
        article = re.search(rf'<article id="f{number}">.*?</article>', page, re.S).group()
        assert "data:image/svg+xml" in article
        assert "The paper" in article
    assert all(f'id="tA.{n}"' in page for n in range(1, 7))
    assert not re.search(r'(src|href)="(?!data:|#)', page)
    drawn = {file: file.stat().st_mtime_ns for file in (out / "figures").iterdir()}

    def never(*args, **options):
        raise AssertionError("simulated again")

    monkeypatch.setattr(paper_voyages, "simulate", never)
    assert main(command) == 0
    assert {file: file.stat().st_mtime_ns for file in drawn} == drawn
    assert (out / "index.html").read_text() == page


def test_a_voyage_that_is_too_short_for_figure_11_is_refused(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(paper_voyages, "STEPS", 10)
    monkeypatch.setattr(reproduce, "OTHERS", ())
    options = ["--rates", "0", "--pilots", "straight", "--encounter", "imazu:1"]
    assert main(["paper", "--out", str(tmp_path), *options]) == 2
    assert "Figure 11 needs 750 s" in capsys.readouterr().err
