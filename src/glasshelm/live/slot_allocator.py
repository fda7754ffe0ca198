"""Which ship is in which slot: the same one for as long as it is known.

What is remembered by slot (what the pilot observed before) so stays valid.
"""

from collections.abc import Sequence


class SlotAllocator:
    """A fixed number of slots.

    A slot that becomes free stays empty for one allocation, so that no new
    ship is taken for the one before.
    """

    def __init__(self, count: int):
        self._ids: list[str | None] = [None] * count
        self._resting: set[int] = set()

    def __len__(self) -> int:
        return len(self._ids)

    def allocate(self, wanted: Sequence[str]) -> list[str | None]:
        """The ship of each slot; of more ships than fit, the first of ``wanted``."""
        staying = set(wanted[: len(self._ids)])
        freed = {k for k, one in enumerate(self._ids) if one is not None and one not in staying}
        resting, self._resting = freed | self._resting, set()
        self._ids = [one if one in staying else None for one in self._ids]
        free = (k for k, one in enumerate(self._ids) if one is None and k not in resting)
        placed = set(self._ids)
        new = [one for one in wanted[: len(self._ids)] if one not in placed]
        for k, one in zip(list(free), new, strict=False):
            self._ids[k] = one
        return list(self._ids)

    def rename(self, old: str, new: str) -> None:
        """Continue the ship of a slot under another number."""
        self._ids = [new if one == old else one for one in self._ids]

    def clear(self) -> None:
        """Empty all slots, each resting for one allocation."""
        self._resting = {k for k, one in enumerate(self._ids) if one is not None}
        self._ids = [None] * len(self._ids)
