"""The sentence of an instant: what the pilot is doing, why, and what comes next.

The same words and reasons as in the report of a voyage, said while it goes on.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import numpy as np
from jaxtyping import Float

from glasshelm.colregs.rule_text import EncounterTypes
from glasshelm.core.geometry import CPA_HORIZON_S
from glasshelm.frames.episodes import RELEASE_RAD, TURN_RAD, Episode
from glasshelm.frames.phrases import (
    capitalised,
    course,
    cpa_words,
    degrees,
    duration,
    miles,
    relative_bearing,
    rudder_words,
    side,
)
from glasshelm.frames.schema import Frame
from glasshelm.frames.series import Series, to_series
from glasshelm.report.band_text import certainty_text, choice_text
from glasshelm.report.guard_text import override_text
from glasshelm.report.manoeuvre_text import manoeuvre_reasons, order_text
from glasshelm.report.rudder_reasons import disagreement_text, reason_text

#: So many frames are looked back upon.
LOOK_BACK_FRAMES = 60
#: A predicted heading that stays within this of its last value has been reached.
REACHED_RAD = math.radians(2)


class CurrentSentence(NamedTuple):
    """Three plain phrases without a full stop at their end; ``why`` and ``next`` may be empty."""

    what: str
    why: str
    next: str


def current_sentence(
    frames: Sequence[Frame],
    ahead: Float[np.ndarray, "steps 3"] | None = None,
    step_s: float = 5.0,
    kinds: EncounterTypes | None = None,
) -> CurrentSentence | None:
    """The sentence of the last of these frames; None where nothing is decided.

    Its reasons and CPAs are of the last frame, as the numbers beside it on a page are: the shares
    that it tells add up to the rudder shown, each rounded to a tenth of a degree. ``kinds`` are
    those of the meetings that the page shows.

    ``ahead`` is own ship's predicted track (east, north [m], heading [rad]) at
    every step, from the last frame on.
    """
    frame = frames[-1]
    if frame.decision is None:
        return None
    voyage = to_series([_short(f) for f in frames[-LOOK_BACK_FRAMES:]])
    coming = "" if ahead is None else _coming(frame, ahead, step_s)
    return CurrentSentence(_what(voyage, frame), _why(voyage, frame, kinds), coming)


def _short(frame: Frame) -> Frame:
    """The frame with only the ships that the pilot was shown."""
    return msgspec.structs.replace(frame, targets=[t for t in frame.targets if t.selected])


def _what(voyage: Series, frame: Frame) -> str:
    decision = frame.decision
    assert decision is not None
    rudder = decision.rudder_rad
    order = rudder_words(rudder)
    if frame.manoeuvre is not None:
        steered = f"Steer {order_text(frame.manoeuvre)}"
        return f"{steered} ({order})" if decision.applied else f"Advice: {steered.lower()}"
    if not decision.applied:
        # A ship that goes her own way is known by her course over ground.
        return f"Advice: {order}; course {course(frame.own.heading_rad)}"
    begin = _begun(voyage)
    turned = float(voyage.heading_rad[-1] - voyage.heading_rad[begin])
    if abs(rudder) < RELEASE_RAD or abs(turned) < TURN_RAD:
        return f"{order.capitalize()}, heading {course(frame.own.heading_rad)}"
    long = duration(float(voyage.time_s[-1] - voyage.time_s[begin]))
    done = f"{degrees(turned)} to {side(turned)} in {long}"
    return f"{order.capitalize()}, heading {course(frame.own.heading_rad)}: altered {done}"


def _why(voyage: Series, frame: Frame, kinds: EncounterTypes | None) -> str:
    last, rudder = len(voyage.rudder_rad) - 1, float(voyage.rudder_rad[-1])
    told = [override_text([frame])]
    if frame.manoeuvre is not None:
        told += [manoeuvre_reasons(frame), choice_text(frame)]
    if any(told):
        return ". ".join(capitalised(text) for text in told if text)
    if abs(rudder) < RELEASE_RAD:
        return _nearest(frame)
    present = Episode(last, last, rudder)
    reasons = reason_text(voyage, present).lstrip(":; ")
    text = capitalised(reasons)
    more = disagreement_text(voyage, present, kinds=kinds).rstrip(".")
    return ". ".join(
        part for part in (text, more, certainty_text(voyage, np.array([last]))) if part
    )


def _begun(voyage: Series) -> int:
    """The first of the frames since which the rudder is meant for the same side as now."""
    rudder = np.nan_to_num(voyage.rudder_rad)
    last = len(rudder) - 1
    way = 0.0 if abs(rudder[last]) < RELEASE_RAD else math.copysign(1.0, rudder[last])
    same = np.abs(rudder) < RELEASE_RAD if way == 0 else rudder * way >= RELEASE_RAD
    others = np.flatnonzero(~same)
    return int(others[-1]) + 1 if others.size else 0


def _nearest(frame: Frame) -> str:
    """Why nothing is done: which ship comes nearest, as a mere fact."""
    closing = [t for t in frame.targets if 0 < t.tcpa_s < CPA_HORIZON_S and not t.lost]
    if not closing:
        return "No ship is closing"
    ship = min(closing, key=lambda t: t.dcpa_m)
    return f"Nearest is {ship.name} ({cpa_words(ship.dcpa_m, ship.tcpa_s)})"


def _coming(frame: Frame, ahead: Float[np.ndarray, "steps 3"], step_s: float) -> str:
    """Where the predicted track leads, and which ship it passes nearest."""
    heading = np.unwrap(ahead[:, 2])
    parts = [_turns(heading, step_s), _passing(frame, ahead, step_s)]
    text = "; ".join(part for part in parts if part)
    return capitalised(text)


def _turns(heading: Float[np.ndarray, " steps"], step_s: float) -> str:
    """The first alteration of a predicted heading, and the one back."""
    extreme = int(np.argmax(np.abs(heading - heading[0])))
    turn = float(heading[extreme] - heading[0])
    if abs(turn) < TURN_RAD:
        return f"steady on {course(float(heading[-1]))} for {duration(step_s * (len(heading) - 1))}"
    reached = int(np.flatnonzero(np.abs(heading - heading[extreme]) <= REACHED_RAD)[0])
    text = f"to {course(float(heading[extreme]))} in {duration(step_s * reached)}"
    back = float(heading[-1] - heading[extreme])
    if abs(back) < TURN_RAD:
        return text
    home = np.flatnonzero(np.abs(heading - heading[-1]) <= REACHED_RAD)
    arrived = step_s * int(home[home > extreme][0])
    return f"{text}, back to {course(float(heading[-1]))} in {duration(arrived)}"


def _passing(frame: Frame, ahead: Float[np.ndarray, "steps 3"], step_s: float) -> str:
    """The ship that the predicted track passes nearest, if all targets keep straight on."""
    best: tuple[float, str] | None = None
    time = step_s * np.arange(len(ahead))
    for ship in frame.targets:
        if ship.lost:
            continue
        east = ship.east_m + time * ship.speed_m_s * math.sin(ship.course_rad) - ahead[:, 0]
        north = ship.north_m + time * ship.speed_m_s * math.cos(ship.course_rad) - ahead[:, 1]
        away = np.hypot(east, north)
        k = int(np.argmin(away))
        if 0 < k < len(away) - 1 and (best is None or away[k] < best[0]):
            bearing = math.atan2(east[k], north[k]) - float(ahead[k, 2])
            bearing = (bearing + math.pi) % (2 * math.pi) - math.pi
            place = (
                f"{miles(float(away[k]))} {relative_bearing(bearing)} in {duration(float(time[k]))}"
            )
            best = float(away[k]), f"{ship.name} passes {place}"
    return "" if best is None else best[1]
