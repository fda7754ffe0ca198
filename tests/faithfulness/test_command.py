"""``glasshelm faithfulness`` from the command line: what is refused first, written when, kept."""

import numpy as np
import pytest
from tests.untrained import write_weights

from glasshelm.cli import main
from glasshelm.faithfulness import scoring_session
from glasshelm.faithfulness.explainers import explainers_for
from glasshelm.faithfulness.faithfulness_scores import MEASURES, ExplanationScores, randomised_top
from glasshelm.faithfulness.manoeuvre_checks import CHECKS, SURPRISES
from glasshelm.faithfulness.subjects import subject_of


def made_up(pilot, *_):
    """Scores of 40 scenes that nobody computed."""
    rng = np.random.default_rng(0)
    subject = subject_of(pilot)
    explainers = explainers_for(subject)
    measures = [*MEASURES, *(randomised_top(top) for top in range(1, subject.layers))]
    scores = {e.name: {m: rng.uniform(size=40) for m in measures} for e in explainers}
    checks = {}
    if subject.quantity == "course":
        checks = {name: np.ones(40) for name in (*CHECKS, *SURPRISES)}
    return ExplanationScores(
        pilot, subject, explainers, scores, checks, np.arange(40), np.full(40, 3),
        rng.uniform(size=40),
    )  # fmt: skip


@pytest.fixture
def asked(monkeypatch):
    """The names of the pilots that were scored; the scores are made up."""
    names = []

    def score(pilot, *what):
        names.append(pilot.name)
        return made_up(pilot)

    monkeypatch.setattr(scoring_session, "score_explanations", score)
    return names


@pytest.fixture
def weights(tmp_path):
    """Writes a file of weights and gives its path."""

    def write(name, *args, **options):
        path = tmp_path / f"{name}.safetensors"
        write_weights(path, *args, **options)
        return str(path)

    return write


def faithfulness(out, *pilots):
    return main(["faithfulness", "--pilots", *pilots, "--ships", "3", "--out", str(out)])


def one_line(capsys):
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    return said


@pytest.mark.slow
def test_the_command_writes_its_table_and_figure(tmp_path, weights):
    """The one test here in which scores are computed."""
    arguments = ["faithfulness", "--pilots", weights("small")]
    arguments += ["--encounters", "32", "--scenes", "5", "--ships", "3"]
    assert main([*arguments, "--out", str(tmp_path)]) == 0
    assert "Shapley value of the rudder" in (tmp_path / "faithfulness.md").read_text()
    assert (tmp_path / "faithfulness-small.png").stat().st_size > 10_000


def test_all_pilots_are_checked_before_any_is_scored(tmp_path, asked, capsys):
    assert faithfulness(tmp_path / "out", "paper-sum", "straight") == 2
    assert "does not explain its own decisions" in one_line(capsys)
    assert not asked
    assert not (tmp_path / "out").exists()


def test_a_pilot_that_chooses_manoeuvres_is_examined_in_its_courses(tmp_path, asked):
    assert faithfulness(tmp_path, "paper-glassbox") == 0
    text = (tmp_path / "faithfulness.md").read_text()
    assert "Ships move the course" in text
    assert "after randomising the weights, layer by layer" not in text
    for words in (*CHECKS.values(), *SURPRISES.values()):
        assert words in text
    assert "12 comparisons with DCPA and TCPA" in text


@pytest.mark.parametrize("other", [("attention", False), ("sum", True)])
def test_seeds_that_differ_in_what_they_have_are_refused_first(
    other, tmp_path, weights, asked, capsys
):
    first, second = weights("with"), weights("odd", *other)
    for order in ([first, second], [second, first]):
        assert faithfulness(tmp_path / "out", "both=" + ",".join(order)) == 2
        said = one_line(capsys)
        assert "seeds cannot be scored together" in said
        assert "'odd'" in said
    assert not asked


@pytest.mark.parametrize("command", ["faithfulness", "evaluate"])
@pytest.mark.parametrize("out", ["file", "file/below", "/proc/x"])
def test_a_folder_that_cannot_be_made_is_refused_first(command, out, tmp_path, asked, capsys):
    (tmp_path / "file").write_text("mine")
    assert main([command, "--pilots", "paper-sum", "--out", str(tmp_path / out)]) == 2
    assert f"{tmp_path / out}: cannot write there" in one_line(capsys)
    assert (tmp_path / "file").read_text() == "mine"
    assert not asked


@pytest.mark.slow
def test_each_pilot_is_written_when_it_is_done_and_not_scored_again(
    tmp_path, weights, asked, capsys, monkeypatch
):
    pilots = [weights("one"), weights("two", "sum")]
    go_on = scoring_session.score_explanations

    def interrupted(pilot, *what):
        if pilot.name == "two":
            raise KeyboardInterrupt
        return go_on(pilot, *what)

    monkeypatch.setattr(scoring_session, "score_explanations", interrupted)
    assert faithfulness(tmp_path / "out", *pilots) == 130
    assert "1 of 2 pilots and seeds are kept in" in capsys.readouterr().err.replace("\n", " ")
    text = (tmp_path / "out" / "faithfulness.md").read_text()
    assert "## one" in text
    assert (tmp_path / "out" / "faithfulness-one.png").exists()
    monkeypatch.setattr(scoring_session, "score_explanations", go_on)
    assert faithfulness(tmp_path / "out", *pilots) == 0
    assert asked == ["one", "two"]
    again = (tmp_path / "out" / "faithfulness.md").read_text()
    assert "## two" in again
    assert again.startswith(text.rstrip())
