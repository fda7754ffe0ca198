"""The public names: they resolve, say what they take and give, and cost nothing before use."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import glasshelm

NAMES = sorted(set(glasshelm.__all__) - {"__version__"})


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_is_there_and_documented(name):
    value = getattr(glasshelm, name)
    assert name in dir(glasshelm)
    if inspect.isfunction(value):
        text = inspect.getdoc(value) or ""
        signature = inspect.signature(value)
        assert ("Args:" in text) == bool(signature.parameters), text
        assert "Returns:" in text or "Yields:" in text, text
        assert signature.return_annotation is not inspect.Signature.empty
    elif inspect.isclass(value):
        assert len(inspect.getdoc(value) or "") > 20
    else:
        assert name == "SHIPS"


def test_type_checkers_see_the_names_that_there_are():
    tree = ast.parse(Path(glasshelm.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imported = {
        (node.module, alias.name)
        for node in ast.walk(block)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert imported == {(f"glasshelm.{home}", name) for name, home in glasshelm._HOME.items()}


def test_an_unknown_name_is_no_attribute():
    with pytest.raises(AttributeError, match="has no attribute 'lode'"):
        glasshelm.lode  # noqa: B018


def test_importing_the_package_is_quick_and_imports_no_jax():
    code = (
        "import sys, time; before = set(sys.modules); began = time.process_time(); "
        "import glasshelm; took = time.process_time() - began; dir(glasshelm); "
        "new = {name.partition('.')[0] for name in set(sys.modules) - before}; "
        "assert not new & {'jax', 'numpy', 'equinox', 'matplotlib'}, new; "
        "assert took < 0.1, took"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_an_encounter_is_explained_in_ten_lines():
    """The example of the README."""
    pilot = glasshelm.load("paper-attention")
    scenario = glasshelm.scenario("imazu:5")
    frames = list(glasshelm.simulate(scenario, pilot, steps=4))
    worst = max(frames[-1].targets, key=lambda ship: abs(ship.shapley_rad))
    state = glasshelm.reset(scenario.encounter, scenario.ship)
    decision = glasshelm.explain(pilot, state.observation)
    assert decision.rudder * scenario.ship.rudder_limit_rad == pytest.approx(
        frames[0].decision.rudder_rad, abs=1e-5
    )
    without = [glasshelm.Deleted(worst.id)]
    answer = glasshelm.what_if(frames, 2, pilot, without, minutes=0.5)
    assert "without" in answer.summary.lower()


def test_pilots_are_evaluated_in_this_process():
    found = glasshelm.evaluate([glasshelm.pilot("straight")], ["random"], 2)
    assert [len(voyages.columns["nearest_m"]) for voyages in found.results] == [2]


def test_a_pilot_is_trained_in_one_call(tmp_path):
    pilot = glasshelm.train("tiny", tmp_path / "run", settings=["validation_episodes=4"])
    assert isinstance(pilot, glasshelm.LearnedPilot)
