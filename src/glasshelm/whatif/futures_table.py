"""The two futures side by side, as a table for the terminal."""

from collections.abc import Callable

from rich.table import Table
from rich.text import Text

from glasshelm.frames.phrases import course, degrees, duration, miles, side
from glasshelm.whatif.ask import WhatIfAnswer
from glasshelm.whatif.outcome import Alteration, Outcome


def futures_table(answer: WhatIfAnswer) -> Table:
    """Alteration, nearest ship, danger and return by sub-task of both futures."""
    start = answer.factual.branch.start
    clock = f" ({start.time_utc})" if start.time_utc else ""
    pilot = answer.factual.branch.pilot.name
    # Names are whatever a ship calls herself: never read as markup.
    out = Table(title=Text(f"{start.source} from {start.time_s:g} s on{clock}, pilot {pilot}"))
    out.add_column("")
    out.add_column("as things are")
    out.add_column(Text(answer.counterfactual.condition))
    both = answer.factual_outcome, answer.counterfactual_outcome
    rows: dict[str, Callable[[Outcome], str]] = {
        "own ship": _course,
        "nearest": _nearest,
        "worst danger": _danger,
        "in the domain": lambda outcome: duration(outcome.inside_s),
        "return: waypoint": lambda outcome: f"{outcome.reward.waypoint:.2f}",
        "return: collision": lambda outcome: f"{outcome.reward.collision:.2f}",
        "sailed": lambda outcome: duration(outcome.duration_s),
    }
    for name, tell in rows.items():
        out.add_row(name, *(Text(tell(outcome)) for outcome in both))
    parted = answer.differences
    when = "never" if parted.diverge_s is None else f"from {parted.diverge_s:g} s on"
    out.caption = (
        f"The rudders part {when}, by {degrees(parted.rudder_rad)} at most; "
        f"the tracks by {miles(parted.max_separation_m)}."
    )
    return out


def _course(outcome: Outcome) -> str:
    turn = outcome.alteration
    return f"keeps on {course(outcome.heading_rad)}" if turn is None else _turn(turn)


def _turn(turn: Alteration) -> str:
    size = f"{degrees(turn.turn_rad)} to {side(turn.turn_rad)} within {duration(turn.within_s)}"
    return f"returns to course, {size}" if turn.returns else size


def _nearest(outcome: Outcome) -> str:
    ship = outcome.nearest
    if ship is None:
        return "–"
    return f"{miles(ship.closest_m)} {ship.name}, at {ship.closest_s:g} s"


def _danger(outcome: Outcome) -> str:
    ship = outcome.worst
    return "none" if ship is None else f"{ship.danger:.2f} {ship.name}"
