"""Somebody else's function steers, whatever it is written with."""

import re
import sys

import jax
import jax.numpy as jnp
import msgspec
import numpy as np
import pytest
from tests.untrained import observation
from tests.voyages import plain

from glasshelm.bridge.server.protocol import Open
from glasshelm.bridge.sessions.log_index import LogIndex
from glasshelm.bridge.sessions.session_factory import open_session
from glasshelm.bridge.sessions.source_list import SourceList
from glasshelm.core.errors import InputError
from glasshelm.pilots.batched import BatchedPilot
from glasshelm.pilots.registry import pilot_named
from glasshelm.whatif.logged_world import pilot_of

MODULE = """
import numpy as np
import jax.numpy as jnp
from glasshelm.pilots.straight import StraightPilot

def traced(seen):
    return 0.5 * jnp.tanh(seen.waypoint[0, 2] + seen.targets[:, 0, 0].sum())

def plain(seen):
    total = 0.0
    for row, here in zip(seen.targets[:, 0], seen.present):
        if here:
            total += float(row[0])
    return 0.5 * np.tanh(float(seen.waypoint[0, 2]) + total)

def two(seen):
    return jnp.zeros(2)

def broken(seen):
    raise KeyError("no such thing")

pilot = StraightPilot()
number = 3
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    (tmp_path / "somebodys.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.mark.slow
def test_a_function_of_numpy_steers_as_one_of_jax(module):
    traced, plain = pilot_named("somebodys:traced"), pilot_named("somebodys:plain")
    assert (traced.traced, plain.traced) == (True, False)
    batch = jax.tree.map(lambda *x: jnp.stack(x), observation(3), observation(3, seed=1))
    steer = jax.jit(
        lambda seen: (BatchedPilot(traced)(seen, ())[0], BatchedPilot(plain)(seen, ())[0])
    )
    by_jax, by_numpy = steer(batch)
    np.testing.assert_allclose(by_jax, by_numpy, rtol=1e-5)
    assert abs(float(by_jax[0] - by_jax[1])) > 1e-6
    assert traced.name == "somebodys:traced"
    assert traced.source_sha256 == plain.source_sha256 is not None


def test_a_pilot_is_taken_as_it_is(module):
    assert pilot_named("somebodys:pilot").name == "straight"


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("nowhere_at_all:f", "cannot import nowhere_at_all"),
        ("somebodys:nothing", "somebodys has no nothing"),
        ("somebodys:number", "neither a function nor a pilot"),
        ("somebodys:two", "must return one number"),
        ("somebodys:broken", "fails on an observation"),
        (":f", "write package.module:function"),
    ],
)
def test_what_cannot_steer_is_told_in_one_line(module, name, says):
    with pytest.raises(InputError, match=says) as told:
        pilot_named(name)
    assert "\n" not in str(told.value)


@pytest.fixture
def trap(tmp_path, monkeypatch):
    """A module of the current folder that tells when it is imported."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trap.py").write_text("import pathlib\npathlib.Path('sprung').touch()\nsteer = 1\n")
    yield tmp_path / "sprung"
    sys.modules.pop("trap", None)


def test_no_viewer_and_no_log_can_name_code_to_run(trap, tmp_path):
    catalogue = SourceList(LogIndex(tmp_path))
    for asked in (
        lambda: catalogue.pilot("trap:steer"),
        lambda: open_session(Open("imazu:1", "trap:steer"), catalogue, tmp_path),
        lambda: open_session(Open("trap:steer"), catalogue, tmp_path),
        lambda: pilot_of(msgspec.structs.replace(plain()[0], pilot="trap:steer")),
    ):
        with pytest.raises(InputError, match="trap:steer"):
            asked()
    assert not trap.exists()
    with pytest.raises(InputError, match="neither a function nor a pilot"):
        pilot_named("trap:steer")  # who starts a command may
    assert trap.exists()


@pytest.mark.parametrize(
    ("members", "line"),
    [
        ("def decide(self, o, m): return 0.0, m", "decide must return (Decision"),
        ("def decide(self, o, m): return nothing", "fails on an observation"),
        ("def elsewhere(self): pass", "which has decide too"),
    ],
)
def test_an_object_that_is_no_pilot_says_what_it_lacks(members, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(
        f"class P:\n    name = 'p'\n    def start(self): return ()\n    {members}\np = P()\n"
    )
    monkeypatch.delitem(sys.modules, "mine", raising=False)
    with pytest.raises(InputError, match=re.escape(line)):
        pilot_named("mine:p")


@pytest.mark.parametrize("code", ["1/0", "def", "raise SyntaxError('x')", "import nowhere"])
def test_code_that_cannot_be_imported_is_one_line(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.py").write_text(code)
    monkeypatch.delitem(sys.modules, "broken", raising=False)
    with pytest.raises(InputError, match=r"pilot 'broken:steer': .*import.*broken"):
        pilot_named("broken:steer")
