"""Who has the helm in the pilot's place, and why, in words."""

from collections.abc import Sequence

from glasshelm.frames.phrases import duration, rudder_words
from glasshelm.frames.schema import Frame


def override_text(frames: Sequence[Frame]) -> str:
    """Why another than the pilot decides in most of these frames; empty if the pilot does.

    Of a guard: the ship that the pilot's own way brings too near, in the first frame where it does.
    """
    ruled = [
        f for f in frames if f.decision is not None and f.decision.pilot_rudder_rad is not None
    ]
    if 2 * len(ruled) <= len(frames):
        return ""
    guarded = [f for f in ruled if f.guard is not None and f.guard.steers]
    if not guarded:
        return f"ordered; the pilot himself decides: {_own(ruled[0])}"
    does = f"the guard {'steers' if _applied(guarded[0]) else 'advises'}"
    told = [text for text in map(guard_reason, guarded) if text]
    if not told:
        return f"{does} until it looks again: the pilot's own way keeps clear by now"
    return f"{does}: {told[0]}"


def guard_reason(frame: Frame) -> str:
    """The ship that the pilot's own way brings too near, and its present rudder; empty if none."""
    guard = frame.guard
    if guard is None or guard.target is None or guard.within_s is None or guard.depth is None:
        return ""
    name = next((t.name for t in frame.targets if t.id == guard.target), guard.target)
    soon = "at once" if guard.within_s < 1 else f"in {duration(guard.within_s)}"
    where = "into the domain" if guard.depth > 0 else "to the edge of the domain"
    return f"the pilot's own way ({_own(frame)}) brings {name} {where} {soon}"


def who_decides(frames: Sequence[Frame]) -> str:
    """Whose decision most of these frames tell: the pilot's or the guard's."""
    guarded = sum(f.guard is not None and f.guard.steers for f in frames)
    return "the guard" if 2 * guarded > len(frames) else "the pilot"


def who_has_the_helm(frame: Frame) -> str:
    """Whose decision a frame tells: the pilot's, the guard's, or that of an order."""
    if frame.guard is not None and frame.guard.steers:
        return "the guard"
    ordered = frame.decision is not None and frame.decision.pilot_rudder_rad is not None
    return "an order" if ordered else "the pilot"


def _applied(frame: Frame) -> bool:
    return frame.decision is None or frame.decision.applied


def _own(frame: Frame) -> str:
    """The rudder that the pilot itself decides."""
    decision = frame.decision
    if decision is None:
        return "no rudder"
    own = decision.pilot_rudder_rad
    return rudder_words(decision.rudder_rad if own is None else own)
