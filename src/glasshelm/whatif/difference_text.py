"""The difference between two futures in plain words; only what was simulated is said."""

from collections.abc import Sequence

from glasshelm.frames.episodes import TURN_RAD
from glasshelm.frames.phrases import capitalised, course, degrees, duration, miles, side
from glasshelm.ship.nomoto import NAUTICAL_MILE_M
from glasshelm.whatif.changes import Change, Deleted, Hidden, KeptCourse, Rudder
from glasshelm.whatif.outcome import Alteration, Differences, Outcome, ShipOutcome

#: Tracks that are never farther apart are the same.
SAME_M = 20.0
#: Alterations alike in size (``TURN_RAD``) are one if so near in time: seconds, or a share of it.
SAME_S = 60.0
SAME_SHARE = 0.25
#: Tracks that part by more are never much the same.
MUCH_SAME_M = 0.1 * NAUTICAL_MILE_M


def describe_difference(
    condition: str, changes: Sequence[Change], fact: Outcome, other: Outcome, parted: Differences
) -> str:
    """What the changed future would be, beside the one as things are."""
    asked = capitalised(condition)
    passing = f"{_passing(fact, other)}."
    who = "own ship" if any(_orders(change) for change in changes) else "the pilot"
    if parted.diverge_s is None and parted.max_separation_m < SAME_M:
        return f"{asked}, {who} would do the same. {passing}"
    would = _would(other)
    if not _alike(fact.alteration, other.alteration):
        return f"{asked}, {who} would {would}; {_contrast(changes, fact, other)}. {passing}"
    apart = f"the tracks part by {miles(parted.max_separation_m)} at most"
    then, now = other.alteration, fact.alteration
    if then and now and not _at_one_time(now.half_s, then.half_s):
        half = f"half of it within {duration(then.half_s)} instead of {duration(now.half_s)}"
        text = f"would {_turn(then, 'return', 'alter')}, {half}"
    elif parted.max_separation_m > MUCH_SAME_M:
        change_rad = parted.max_heading_change_rad
        aside = f"{degrees(change_rad)} more to {side(change_rad)}"
        after = duration(parted.max_heading_change_s)
        text = f"would {would}, as it does as things are, but head up to {aside} after {after}"
    else:
        text = f"would do much the same: {would}"
    return f"{asked}, {who} {text}; {apart}. {passing}"


def _orders(change: Change) -> bool:
    """Whether the change takes the helm from the pilot."""
    return isinstance(change, Rudder) or (isinstance(change, KeptCourse) and change.ship is None)


def _alike(one: Alteration | None, other: Alteration | None) -> bool:
    """Alterations to the same side, alike in size and in time."""
    if one is None or other is None:
        return one is other
    near = abs(one.turn_rad - other.turn_rad) < TURN_RAD
    return near and _at_one_time(one.within_s, other.within_s)


def _at_one_time(one_s: float, other_s: float) -> bool:
    return abs(one_s - other_s) <= max(SAME_S, SAME_SHARE * max(one_s, other_s))


def _would(told: Outcome) -> str:
    return _course(told, "stay on", "return", "alter")


def _does(told: Outcome) -> str:
    return _course(told, "keeps on", "returns", "alters")


def _course(told: Outcome, stay: str, back: str, turns: str) -> str:
    """What own ship makes of her course, with the verbs in the form that is wanted."""
    turn = told.alteration
    if turn is None:
        return f"{stay} {course(told.heading_rad)}"
    return f"{_turn(turn, back, turns)} within {duration(turn.within_s)}"


def _turn(turn: Alteration, back: str, turns: str) -> str:
    what = f"{back} to course, " if turn.returns else f"{turns} "
    return f"{what}{degrees(turn.turn_rad)} to {side(turn.turn_rad)}"


def _contrast(changes: Sequence[Change], fact: Outcome, other: Outcome) -> str:
    """What is the case. A ship without which there is no such turn is named as its cause."""
    one, two = fact.alteration, other.alteration
    another = one is not None and (two is None or two.turn_rad * one.turn_rad < 0)
    if another and len(changes) == 1 and isinstance(changes[0], Deleted | Hidden):
        return f"she is why it {_does(fact)}"
    return f"as things are, it {_does(fact)}"


def _passing(fact: Outcome, other: Outcome) -> str:
    """The nearest ship of both, and the domain where either enters it."""
    then, now = other.nearest, fact.nearest
    if then is None:
        return "No other ship would be there"
    text = f"Nearest would be {then.name} at {_distance(then, other)}"
    if now is not None and (now.id != then.id or _distance(now, fact) != _distance(then, other)):
        name = "" if now.id == then.id else f"{now.name} at "
        text += f" instead of {name}{_distance(now, fact)}"
    if other.collided:
        return text
    worst = other.worst
    if worst is None:
        if fact.worst is not None and not fact.collided:
            text += f"; no ship would be in the domain, where {fact.worst.name} is as things are"
        return text
    text += f"; {worst.name} would be in the domain, danger up to {worst.danger:.2f} of 1"
    if fact.worst is None:
        return f"{text}, none as things are"
    same = abs(fact.worst.danger - worst.danger) < 0.005
    return text if same else f"{text} instead of {fact.worst.danger:.2f}"


def _distance(ship: ShipOutcome, told: Outcome) -> str:
    """How near she comes; nearer than own ship's length it is a collision, if that is known."""
    if ship.closest_m >= told.length_m:
        return miles(ship.closest_m)
    what = "a collision" if told.length_known else "less than the ship length assumed here"
    return f"{ship.closest_m:.0f} m ({what})"
