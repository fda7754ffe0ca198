"""What axe-core finds wrong with a page for those who cannot see or hear it well."""

from pathlib import Path
from typing import Any

import pytest

_AXE = Path(__file__).parents[3] / "web" / "node_modules" / "axe-core" / "axe.min.js"
needs_axe = pytest.mark.skipif(
    not _AXE.is_file(), reason="axe-core is not installed: scripts/page check"
)


def faults(page: Any) -> list[str]:
    """What axe-core calls serious or critical, a line each."""
    page.add_script_tag(path=str(_AXE))
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")
    return [
        f"{v['id']}: {node['target']} {node['failureSummary']}"
        for v in found["violations"]
        if v["impact"] in ("serious", "critical")
        for node in v["nodes"]
    ]
