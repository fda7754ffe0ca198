"""Accessibility of a page by axe-core."""

from pathlib import Path
from typing import Any

from tests.missing import missing

_AXE = Path(__file__).parents[3] / "web" / "node_modules" / "axe-core" / "axe.min.js"


def axe_violations(page: Any) -> list[str]:
    """Serious and critical violations, one line each."""
    if not _AXE.is_file():
        missing("axe-core is not installed: scripts/page check")
    page.add_script_tag(path=str(_AXE))
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")
    return [
        f"{v['id']}: {node['target']} {node['failureSummary']}"
        for v in found["violations"]
        if v["impact"] in ("serious", "critical")
        for node in v["nodes"]
    ]
