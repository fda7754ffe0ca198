"""The time of a stream: what it says itself, or the time of arrival."""

import time
from datetime import UTC, datetime, timedelta


class StreamClock:
    """Gives every sentence a time, also those that say none.

    A stream that tells its time (tag blocks) may be a recording played again years
    later. Its other sentences then get the latest time told, and of a live
    stream also the seconds passed since. A live stream that never tells its
    time is dated by arrival; a file that does not has no time.
    """

    def __init__(self, live: bool):
        self.live = live
        self._told: datetime | None = None
        self._told_at = 0.0

    def tell(self, told: datetime, witness: str) -> datetime | None:
        """Set the clock to a time that the stream tells."""
        self._told, self._told_at = told, time.monotonic()
        return told

    def now(self) -> datetime | None:
        """The time of a sentence that tells none."""
        if not self.live:
            return self._told
        if self._told is None:
            return datetime.now(UTC)
        try:
            return self._told + timedelta(seconds=time.monotonic() - self._told_at)
        except OverflowError:  # told in the last second of the year 9999
            return self._told


def from_epoch(seconds: float) -> datetime | None:
    """The time (UTC) so many seconds since 1970; None for a number that is no date."""
    try:
        return datetime.fromtimestamp(seconds, UTC)
    except (ValueError, OverflowError, OSError):
        return None
