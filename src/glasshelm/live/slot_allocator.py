"""Which ship stands in which slot: the same one for as long as she is known.

Who remembers something by slot (what the pilot saw a moment ago) can so go on.
"""

from collections.abc import Sequence


class SlotAllocator:
    """A fixed number of slots.

    A slot that becomes free stays empty for one placing: nobody takes the new
    ship for the one before.
    """

    def __init__(self, count: int):
        self._ids: list[str | None] = [None] * count
        self._resting: set[int] = set()

    def __len__(self) -> int:
        return len(self._ids)

    def allocate(self, wanted: Sequence[str]) -> list[str | None]:
        """The ship of each slot; of more ships than fit, the first of ``wanted``."""
        wanted = wanted[: len(self._ids)]
        staying = set(wanted)
        left = {k for k, one in enumerate(self._ids) if one is not None and one not in staying}
        for k in left:
            self._ids[k] = None
        placed = {one for one in self._ids if one is not None}
        resting, self._resting = left | self._resting, set()
        free = (k for k, one in enumerate(self._ids) if one is None and k not in resting)
        new = (one for one in wanted if one not in placed)
        for k, one in zip(free, new, strict=False):
            self._ids[k] = one
        return list(self._ids)

    def rename(self, old: str, new: str) -> None:
        """The ship of a slot goes on under another number."""
        self._ids = [new if one == old else one for one in self._ids]

    def clear(self) -> None:
        """Begin anew, every slot resting for one placing."""
        self._resting = {k for k, one in enumerate(self._ids) if one is not None}
        self._ids = [None] * len(self._ids)
