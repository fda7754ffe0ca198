"""A voyage in a few lines, from its frames."""

from glasshelm.frames.schema import Frame
from glasshelm.ship.nomoto import NAUTICAL_MILE_M


class Summary:
    """Adds up frames: the smallest distance, who came into the domain, the return by sub-task."""

    def __init__(self) -> None:
        self.duration_s = 0.0
        self.nearest_m: float | None = None
        self.nearest_name = ""
        #: Ships that were inside own ship's domain (Eq. 13 > 0): id -> name.
        self.intruders: dict[str, str] = {}
        self.waypoint_return = 0.0
        self.collision_return = 0.0
        self.applied = True

    def add(self, frame: Frame) -> None:
        """One more frame of the voyage, in order. Lost ships count for nothing."""
        self.duration_s = frame.time_s
        if frame.reward is not None:
            self.waypoint_return += frame.reward.waypoint
            self.collision_return += frame.reward.collision
        if frame.decision is not None:
            self.applied = frame.decision.applied
        for target in frame.targets:
            if target.lost:
                continue
            if self.nearest_m is None or target.range_m < self.nearest_m:
                self.nearest_m, self.nearest_name = target.range_m, target.name
            if target.danger > 0:
                self.intruders[target.id] = target.name

    def text(self) -> str:
        """The summary in words, in nautical units."""
        if self.nearest_m is None:
            nearest = "none: no ship was seen"
        else:
            nearest = f"{self.nearest_m / NAUTICAL_MILE_M:.2f} NM ({self.nearest_name})"
        names = ", ".join(self.intruders.values())
        total = self.waypoint_return + self.collision_return
        return "\n".join(
            [
                f"sailed            {self.duration_s:.0f} s"
                + ("" if self.applied else ", recorded track kept, pilot advising"),
                f"nearest ship      {nearest}",
                f"in the domain     {len(self.intruders)}" + (f" ({names})" if names else ""),
                f"return            {total:.2f} = waypoint {self.waypoint_return:.2f}"
                f" + collision {self.collision_return:.2f}",
            ]
        )
