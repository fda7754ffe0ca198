import pytest

from glasshelm.cli import main


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--preset", "quick"], "unknown preset 'quick'"),
        (["--ship", "raft"], "unknown ship 'raft'"),
        (["--set", "ddpg.bach=3"], "bach"),
        (["--set", "init_from=nothing.safetensors"], "nothing.safetensors"),
        (["--resume"], "no state.safetensors to resume"),
    ],
)
def test_bad_input_is_one_line(arguments, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["train", "--out", "run", "--no-tensorboard", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("glasshelm: ")
    assert words in error
