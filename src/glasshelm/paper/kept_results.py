"""What a folder holds already: each result with a digest of all that it was made from."""

import hashlib
import json
from pathlib import Path

from glasshelm.core.output_dir import atomic_write

RECORD_FILE = "made.json"


class KeptResults:
    """Results in a folder by name. One whose digest is another, or whose files are gone, is made
    again.

    Args:
        folder: The folder.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        try:
            digests = json.loads((folder / RECORD_FILE).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            digests = {}
        self._digests: dict[str, str] = digests if isinstance(digests, dict) else {}

    def has(self, name: str, digest: str, *files: Path) -> bool:
        """Whether this very result is there, with its files."""
        return self._digests.get(name) == digest and all(file.is_file() for file in files)

    def add(self, name: str, digest: str) -> None:
        """Note a result whose files are written. InputError if it cannot be noted."""
        self._digests[name] = digest
        with atomic_write(self.folder / RECORD_FILE) as partial:
            partial.write_text(json.dumps(self._digests, indent=1, sort_keys=True) + "\n")


def digest_of(*parts: str) -> str:
    """One digest of several texts."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]
