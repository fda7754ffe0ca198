"""The time of a stream: what most of it says, or the time of arrival."""

from datetime import UTC, datetime

from glasshelm.ais.reports import Counts
from glasshelm.ais.traffic_time import TrafficTime

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class StreamClock:
    """Gives every sentence a time, also those that say none.

    A stream that tells its time (tag blocks) may be a recording played again years
    later. Its other sentences then get the latest time that is believed, and of a live
    stream also the seconds passed since. A live stream that never tells its
    time is dated by arrival; a file that does not has no time.

    ``counts``: whose sentence for people names the clocks that are not believed.
    """

    def __init__(self, live: bool, counts: Counts | None = None):
        self.live = live
        self._time = TrafficTime()
        if counts is not None:
            counts.remark = self._time.rejected_clocks

    def update(self, told: datetime, witness: str) -> datetime | None:
        """Hear the time of a report, told by a ship or ``station:NAME``; None: not believed now."""
        return told if self._time.update((told - _EPOCH).total_seconds(), witness) else None

    def now(self) -> datetime | None:
        """The time of a sentence that tells none."""
        time_s = self._time.now_s if self.live else self._time.latest_s
        if time_s is None:
            return datetime.now(UTC) if self.live else None
        return from_epoch(time_s)


def from_epoch(seconds: float) -> datetime | None:
    """The time (UTC) so many seconds since 1970; None for a number that is no date."""
    try:
        return datetime.fromtimestamp(seconds, UTC)
    except (ValueError, OverflowError, OSError):
        return None
