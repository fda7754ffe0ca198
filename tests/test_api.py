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


#: Wrong arguments, and what the error says of each.
WRONG = """
simulate("imazu:5", pilot("straight"))  # is no scenario
simulate(scenario("imazu:5"), "paper-sum")  # is a name: glasshelm.pilot
simulate(scenario("imazu:5"), 3)  # int is no pilot
explain("paper-sum", None)  # is a name
what_if(FRAMES, 0, pilot("straight"), [])  # nothing is asked
what_if(FRAMES, 0, "straight", [Deleted("1")])  # is a name
what_if(FRAMES, 0, pilot("straight"), ["1"])  # is no change
why_not(FRAMES, 0, pilot("straight"), 0.0)  # compares no courses
evaluate([])  # no pilot to evaluate
evaluate("straight")  # are lists
evaluate(["straight"], "random")  # are lists
evaluate(["straight", "straight"])  # named twice
load("paper-sum-guarded")  # is no learned one
GuardedPilot(pilot("straight"))  # cannot be guarded
train(minutes=-1, out=OUT)  # must be 0 or more
random_encounter(None, SHIPS["paper"], count=99)  # 99 ships
select_targets(None, 0)  # room for 0 targets
"""


def test_a_wrong_argument_is_one_clear_line(tmp_path):
    """In a process of its own: here, annotations are checked before any line of ours runs."""
    code = (
        "import glasshelm, sys\n"
        "names = {name: getattr(glasshelm, name) for name in glasshelm.__all__}\n"
        "at = names['scenario']('imazu:1')\n"
        "names['FRAMES'] = [*names['simulate'](at, names['pilot']('straight'), 1)]\n"
        "names['OUT'] = sys.argv[2]\n"
        "for line in sys.argv[1].strip().splitlines():\n"
        "    call, wanted = line.split('  # ')\n"
        "    try:\n"
        "        eval(call, dict(names))\n"
        "    except glasshelm.InputError as error:\n"
        "        said = str(error)\n"
        "        assert wanted in said and '\\n' not in said, (call, said)\n"
        "    else:\n"
        "        raise AssertionError(call)\n"
    )
    command = [sys.executable, "-c", code, WRONG, str(tmp_path / "run")]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr


def test_pilots_are_evaluated_in_this_process():
    found = glasshelm.evaluate([glasshelm.pilot("straight")], ["random"], 2)
    assert [len(voyages.columns["nearest_m"]) for voyages in found.results] == [2]


def test_a_pilot_is_trained_in_one_call(tmp_path):
    pilot = glasshelm.train("tiny", tmp_path / "run", settings=["validation_episodes=4"])
    assert isinstance(pilot, glasshelm.LearnedPilot)
