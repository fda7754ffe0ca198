"""What the documentation cites as proof is there."""

import re
from pathlib import Path

TREE = Path(__file__).parents[1]


def test_every_proof_that_is_cited_exists():
    text = (TREE / "docs" / "reliability.md").read_text(encoding="utf-8")
    cited = set(re.findall(r"(?:tests|benchmarks|requirements)/[\w/.]*", text))
    assert len(cited) > 20
    missing = [path for path in sorted(cited) if not (TREE / path).exists()]
    assert missing == []
