"""The time of the traffic: moves on with the reports, and is not moved by a single wrong one."""

from glasshelm.ais.cleaning import AGREEING

#: A report so much ahead of all others [s] waits until others agree.
AHEAD_S = 600.0
#: Known ships that go back by so much [s], one after another: the recording began anew.
BACK_S = 60.0


class TrafficTime:
    """The latest time heard [s since 1970], from reports of positions."""

    def __init__(self) -> None:
        self.latest_s: float | None = None
        self._ahead: list[float] = []
        self._back = 0

    def believes(self, time_s: float) -> bool:
        """Whether a time is not far ahead of the latest; ``AGREEING`` in a row are believed."""
        latest = self.latest_s
        if latest is None or time_s <= latest + AHEAD_S:
            self._ahead = []
            return True
        if self._ahead and abs(time_s - self._ahead[-1]) > AHEAD_S:
            self._ahead = []
        self._ahead.append(time_s)
        return len(self._ahead) >= AGREEING

    def began_anew(self, time_s: float, before_s: float | None) -> bool:
        """Whether this report, of a ship last heard at ``before_s``, shows the stream set back."""
        latest = self.latest_s
        if latest is None or time_s > latest - BACK_S:
            self._back = 0
        elif before_s is not None and time_s < before_s - BACK_S:
            self._back += 1
        return self._back >= AGREEING

    def advance(self, time_s: float) -> None:
        """Note a time that is believed."""
        self._ahead = []
        if self.latest_s is None or time_s > self.latest_s:
            self.latest_s = time_s

    def reset(self) -> None:
        """Forget everything: the stream begins anew."""
        self.latest_s, self._ahead, self._back = None, [], 0
