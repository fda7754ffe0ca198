"""Evaluation from the command line, end to end."""

import numpy as np
import pyarrow.parquet as pq
import pytest

from glasshelm.cli import main
from glasshelm.evaluation import result_cache

pytestmark = pytest.mark.slow

PILOT = '''
def starboard(seen):
    """Ten lines of somebody else: to starboard while anybody is ahead within 10 km."""
    import jax.numpy as jnp
    ahead = seen.present & (seen.targets[:, 0, 1] > 0) & (seen.targets[:, 0, 5] < 0.35)
    return jnp.where(ahead.any(), 0.3, jnp.clip(5 * seen.waypoint[0, 2], -1, 1))
'''


@pytest.fixture
def arguments(tmp_path, monkeypatch):
    (tmp_path / "somebody.py").write_text(PILOT)
    monkeypatch.chdir(tmp_path)
    return [
        "evaluate", "--pilots", "straight", "somebody:starboard", "--suites", "random",
        "--encounters", "6", "--ships", "paper", "--out", str(tmp_path / "out"), "--no-figures",
    ]  # fmt: skip


def test_report_and_tables_and_nothing_sailed_twice(arguments, tmp_path, capsys, monkeypatch):
    assert main(arguments) == 0
    text = (tmp_path / "out" / "report.md").read_text()
    for part in ("## random", "6 encounters × 1 seed", "Risk ratio against straight", "JAX"):
        assert part in text
    assert "somebody:starboard" in text
    table = pq.read_table(tmp_path / "out" / "encounters.parquet").to_pydict()
    assert len(table["suite"]) == 2 * 6
    assert set(table["pilot"]) == {"straight", "somebody:starboard"}
    # Paired: both met the same encounters.
    ships = np.reshape(table["ships"], (2, 6))
    np.testing.assert_array_equal(ships[0], ships[1])

    def never(job):
        raise AssertionError("sailed again")

    monkeypatch.setattr(result_cache, "run_job", never)
    assert main(arguments) == 0
    again = pq.read_table(tmp_path / "out" / "encounters.parquet").to_pydict()
    assert again == table


@pytest.mark.parametrize(
    ("pilot", "suite", "says"),
    [
        ("straight", "nowhere", "unknown suite 'nowhere'"),
        ("nobody", "random", "unknown pilot 'nobody'"),
    ],
)
def test_bad_input_is_one_line(pilot, suite, says, tmp_path, capsys):
    given = ["evaluate", "--pilots", pilot, "--suites", suite, "--out", str(tmp_path)]
    assert main(given) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert says in error
