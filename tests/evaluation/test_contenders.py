"""Contenders are named by short strings."""

import pytest
from tests.untrained import untrained, write_weights

from glasshelm.core.errors import InputError
from glasshelm.evaluation.contenders import (
    check_references,
    code_digest,
    parse_contenders,
    pilot_digest,
    ship_of,
)
from glasshelm.pilots.straight import StraightPilot


def test_a_pilot_without_a_ship_is_sailed_on_each():
    found = parse_contenders(["straight", "large-ship-mpc"])
    assert [(e.name, e.ship_name) for e in found] == [
        ("straight", "paper"), ("straight", "large_ship"), ("large-ship-mpc", "large_ship"),
    ]  # fmt: skip
    assert [e.ship_name for e in parse_contenders(["straight"], ["paper"])] == ["paper"]


def test_several_training_seeds_are_one_pilot(tmp_path):
    files = [tmp_path / f"{i}.safetensors" for i in range(2)]
    hashes = [write_weights(file)[:8] for file in files]
    (found,) = parse_contenders([f"mine={files[0]},{files[1]}"])
    assert (found.name, found.ship_name, len(found.pilots)) == ("mine", "paper", 2)
    assert found.weights == tuple(hashes)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ([], "no pilot to evaluate"),
        (["mine="], "NAME=FILE"),
        (["=a.safetensors"], "NAME=FILE"),
        (["straight", "straight"], "named twice"),
        (["nobody"], "unknown pilot 'nobody'"),
        (["mine=paper-mpc,large-ship-mpc"], "trained on large_ship and paper"),
    ],
)
def test_bad_names_are_told_in_one_line(given, says):
    with pytest.raises(InputError, match=says) as told:
        parse_contenders(given)
    assert "\n" not in str(told.value)


def test_a_reference_is_examined_too_or_is_another_pilot_that_exists():
    check_references(["straight", "paper-cpa"], parse_contenders(["straight"]))
    with pytest.raises(InputError, match="--against: unknown pilot 'nosuch'"):
        check_references(["straight", "nosuch"], parse_contenders(["straight"]))


def test_digests_tell_pilots_apart_by_what_they_are():
    one, other = untrained(seed=0), untrained(seed=1)
    assert pilot_digest(one) == pilot_digest(untrained(seed=0))
    assert pilot_digest(one) != pilot_digest(other)
    assert pilot_digest(StraightPilot()) == pilot_digest(StraightPilot())
    assert ship_of(StraightPilot()) is None
    assert len(code_digest()) == 64


def test_a_room_that_is_not_there_is_told():
    with pytest.raises(FileNotFoundError, match="no_such_room"):
        code_digest(("core", "no_such_room"))
