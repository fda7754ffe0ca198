"""Trying again: how long to wait between attempts to connect."""

import asyncio


class Backoff:
    """Waits 0.5 s, then twice as long each time up to 15 s; success sets it back."""

    FIRST_S = 0.5
    LONGEST_S = 15.0

    def __init__(self) -> None:
        self._next_s = self.FIRST_S

    async def wait(self) -> None:
        """Wait until the next attempt."""
        delay, self._next_s = self._next_s, min(2 * self._next_s, self.LONGEST_S)
        await asyncio.sleep(delay)

    def succeeded(self) -> None:
        """Something was heard: begin with the shortest wait again."""
        self._next_s = self.FIRST_S
