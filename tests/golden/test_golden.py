import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tests.golden.voyages import HERE, VOYAGES

#: What may differ between machines: a metre, a hundredth of most other things.
TOLERANCE = {"east_m": 1.0, "north_m": 1.0, "heading_deg": 0.1, "relative_bearing_deg": 0.3}


@pytest.fixture(scope="module")
def voyages() -> dict[str, Any]:
    """All of them, by programs compiled as a user's are (tests/conftest.py)."""
    root = Path(__file__).parents[2]
    path = os.pathsep.join([str(root / "src"), str(root)])
    done = subprocess.run(
        [sys.executable, "-m", "tests.golden.voyages", "--print"],
        env={**os.environ, "XLA_FLAGS": "", "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", VOYAGES)
def test_voyage_is_the_one_written_down(name, voyages):
    written = json.loads((HERE / f"{name}.json").read_text(encoding="utf-8"))
    sailed = voyages[name]
    assert written.keys() == sailed.keys()
    assert written["what"] == sailed["what"]
    assert len(written["every_minute"]) == len(sailed["every_minute"]) == 20
    for row, now in zip(written["every_minute"], sailed["every_minute"], strict=True):
        assert row.keys() == now.keys()
        assert row["time"] == now["time"]
        for key in row.keys() - {"time"}:
            difference = abs(row[key] - now[key])
            if key.endswith("bearing_deg") or key == "heading_deg":
                difference = min(difference, 360 - difference)
            assert difference <= TOLERANCE.get(key, 0.01), (row["time"], key, row[key], now[key])


def test_every_written_voyage_is_sailed():
    assert {path.stem for path in HERE.glob("*.json")} == set(VOYAGES)
