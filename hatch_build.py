"""Puts the bridge page into wheel and sdist; builds it first where it is missing.

Users of a wheel need no Node. An editable install goes without: ``make page``
builds the page for a clone.
"""

import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PAGE = Path("src/glasshelm/bridge/static/index.html")


class PageHook(BuildHookInterface):
    """Fails, in one line, if there is no page to package."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        root = Path(self.root)
        page, script = root / PAGE, root / "scripts" / "page"
        if not page.is_file() and script.is_file() and shutil.which("bash"):
            subprocess.run(["bash", str(script), "build"], check=False)
        if not page.is_file():
            raise RuntimeError(f"{PAGE} is missing and could not be built: run `make page` first")
