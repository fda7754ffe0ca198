"""A manoeuvre in words: what is steered, for which ships, and how long one could wait."""

from glasshelm.frames.phrases import course, duration, joined
from glasshelm.frames.schema import Frame, Manoeuvre

#: Within so long the last safe manoeuvre is worth a word [s].
_SOON_S = 900.0
#: Differences of Q below this are none, in points of return.
_NOTHING = 0.05


def order_text(manoeuvre: Manoeuvre) -> str:
    """``060° for 7 min, then 030° for 4 min``."""
    if manoeuvre.duration_s == 0.0:
        return f"{course(manoeuvre.course_rad)} to the waypoint"
    text = f"{course(manoeuvre.course_rad)} for {duration(manoeuvre.duration_s)}"
    if manoeuvre.then_course_rad is None or manoeuvre.then_duration_s is None:
        return text
    then = f"{course(manoeuvre.then_course_rad)} for {duration(manoeuvre.then_duration_s)}"
    return f"{text}, then {then}"


def manoeuvre_reasons(frame: Frame) -> str:
    """For which ships the manoeuvre is, what it gains, and how long keeping on would be safe."""
    names = {target.id: target.name for target in frame.targets}
    needed = [names[id] for id in frame.needed or () if id in names]
    parts = []
    if needed:
        parts.append(f"for {joined(needed)}: without {'it' if len(needed) == 1 else 'them'} "
                     "another course would be steered")  # fmt: skip
    else:
        parts.append("no ship changes the course")
    gain = None if frame.priority is None else frame.priority.total
    if gain is not None and gain > _NOTHING:
        parts.append(f"worth {gain:.1f} points more than keeping on")
    if frame.last_safe_s is None:
        parts.append("no manoeuvre is safe any more")
    elif frame.last_safe_s < _SOON_S:
        parts.append(f"safe to wait for {duration(frame.last_safe_s)} at most")
    return "; ".join(parts)
