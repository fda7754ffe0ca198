"""The voyage told in order: what own ship did and why, who passed where, what was odd."""

import dataclasses
import math

import numpy as np

from glasshelm.frames.episodes import TURN_RAD, Episode, advice_episodes, turn_episodes
from glasshelm.frames.phrases import (
    capitalised,
    clock,
    course,
    degrees,
    duration,
    miles,
    relative_bearing,
    rudder_degrees,
    side,
)
from glasshelm.frames.series import Frames, Series, to_series
from glasshelm.report.band_text import certainty_text
from glasshelm.report.guard_text import who_decides
from glasshelm.report.passages import OutsideTraining, Passage, describe, outside_training, passages
from glasshelm.report.rudder_reasons import disagreement_text, frames_with_rudder, reason_text

#: A ship that leaves the domain for no longer than this is told as staying.
REENTRY_S = 60.0
#: Steady stretches shorter than this are not told.
STEADY_S = 60.0
#: Ships that never come nearer are not told of when they pass.
NEAR_M = 3 * 1852.0
#: At most this many passages are told, the nearest ones.
MOST_PASSAGES = 8


@dataclasses.dataclass(frozen=True)
class Sentence:
    """One line of the story: when (frame and words), what kind of thing, and the text."""

    frame: int
    when: str
    kind: str
    text: str

    def __str__(self) -> str:
        return f"{self.when} — {self.text}"


def narrate(frames: Frames) -> list[Sentence]:
    """The sentences of a voyage in order of time; each says only what the frames say.

    ``kind`` is one of turn, steady, passing, domain, outside, end.
    """
    voyage = to_series(frames)
    told: list[tuple[int, str, str]] = []
    cut, tell = (turn_episodes, _of_turn) if voyage.applied else (advice_episodes, _of_advice)
    told += [tell(voyage, e) for e in cut(voyage) if e.turn_rad or _long(voyage, e) >= STEADY_S]
    found = passages(voyage)
    told += [_of_passing(voyage, p) for p in found[:MOST_PASSAGES] if _worth_telling(p)]
    for passage in found:
        told += _of_domain(voyage, passage)
    told += _of_outside(outside_training(voyage))
    told.append((len(voyage.time_s) - 1, "end", _ending(voyage)))
    order = {"outside": 0, "domain": 1, "turn": 2, "steady": 3, "passing": 4, "end": 5}
    told.sort(key=lambda item: (item[0], order[item[1]]))
    return [Sentence(k, clock(voyage, k), kind, capitalised(text)) for k, kind, text in told]


def _of_turn(voyage: Series, episode: Episode) -> tuple[int, str, str]:
    long = _long(voyage, episode)
    heading = course(float(voyage.heading_rad[episode.end]))
    if episode.turn_rad == 0:
        off = float(voyage.waypoint_bearing_rad[episode.start])
        aside = "" if abs(off) < TURN_RAD else f", {degrees(off)} {_off(off)} of the waypoint"
        return episode.start, "steady", f"steady on {heading} for {duration(long)}{aside}."
    what = f"altering {degrees(episode.turn_rad)} to {side(episode.turn_rad)}"
    if _returns(voyage, episode):
        what = f"returning to course, {degrees(episode.turn_rad)} to {side(episode.turn_rad)}"
    text = f"{what} to {heading} within {duration(long)}{reason_text(voyage, episode)}."
    return episode.start, "turn", _with(text, _judged(voyage, episode))


def _of_advice(voyage: Series, episode: Episode) -> tuple[int, str, str]:
    long = duration(_long(voyage, episode))
    kept = _kept(voyage, episode)
    who = who_decides([voyage.frames[k] for k in frames_with_rudder(voyage, episode)])
    if episode.turn_rad == 0:
        text = f"{who} would have left the rudder amidships, or nearly so, for {long}. {kept}"
        return episode.start, "steady", text
    text = (
        f"{who} would have put the rudder {rudder_degrees(episode.turn_rad)} to "
        f"{side(episode.turn_rad)} for {long}{reason_text(voyage, episode)}."
    )
    return episode.start, "turn", f"{_with(text, _judged(voyage, episode))} {kept}"


def _judged(voyage: Series, episode: Episode) -> str:
    """Who says otherwise, and whether the side is certain."""
    sure = certainty_text(voyage, frames_with_rudder(voyage, episode))
    return _with(disagreement_text(voyage, episode), f"{sure}." if sure else "")


def _long(voyage: Series, episode: Episode) -> float:
    return float(voyage.time_s[episode.end] - voyage.time_s[episode.start])


def _kept(voyage: Series, episode: Episode) -> str:
    first, last = (
        float(np.median(voyage.heading_rad[max(k - 2, 0) : k + 3]))
        for k in (episode.start, episode.end)
    )
    if abs(last - first) < TURN_RAD:
        return "The recorded ship kept her course."
    return f"The recorded ship altered {degrees(last - first)} to {side(last - first)}."


def _returns(voyage: Series, episode: Episode) -> bool:
    """Whether a turn ends with less than half of the angle off the waypoint it began with."""
    before = abs(float(voyage.waypoint_bearing_rad[episode.start]))
    after = abs(float(voyage.waypoint_bearing_rad[episode.end]))
    return before >= TURN_RAD and after <= 0.5 * before


def _off(bearing_rad: float) -> str:
    """On which side of the waypoint own ship's heading lies."""
    return "to port" if bearing_rad > 0 else "to starboard"


def _worth_telling(passage: Passage) -> bool:
    return passage.is_minimum and passage.closest_m < NEAR_M


def _of_passing(voyage: Series, passage: Passage) -> tuple[int, str, str]:
    inside = passage.ship.danger[passage.closest] > 0
    clear = "inside the domain" if inside else "clear of the domain"
    text = f"{passage.name} is at her nearest, {describe(passage)}, {clear}."
    return passage.closest, "passing", text


def _of_domain(voyage: Series, passage: Passage) -> list[tuple[int, str, str]]:
    """Every time that she enters own ship's domain; soon back in is never left."""
    ship = passage.ship
    inside = np.flatnonzero(np.nan_to_num(ship.danger) > 0)
    if not inside.size:
        return []
    breaks = np.flatnonzero(np.diff(voyage.time_s[inside]) > REENTRY_S) + 1
    told = []
    for stay in np.split(inside, breaks):
        k, end = int(stay[0]), int(stay[-1])
        long = float(voyage.time_s[min(end + 1, len(voyage.time_s) - 1)] - voyage.time_s[k])
        gone = end < len(voyage.time_s) - 1
        until = f"for {duration(long)}" if gone else "and is there at the end"
        begins = "is inside the domain from the beginning" if k == 0 else "enters the domain"
        place = f"{miles(float(ship.range_m[k]))} {relative_bearing(float(ship.bearing_rad[k]))}"
        deepest = float(np.nanmax(ship.danger[stay]))
        text = f"{ship.name} {begins} ({place}) {until}; danger up to {deepest:.2f} of 1."
        told.append((k, "domain", text))
    return told


def _of_outside(found: list[OutsideTraining]) -> list[tuple[int, str, str]]:
    """One sentence for all that begins in the same frame."""
    told = []
    for k in sorted({one.first for one in found}):
        kinds = "; ".join(f"{one.words}, {_often(one.share)}" for one in found if one.first == k)
        told.append((k, "outside", f"outside what the pilot has met in training: {kinds}."))
    return told


def _often(share: float) -> str:
    return "throughout" if share > 0.995 else f"in {max(share, 0.01):.0%} of the frames"


def _ending(voyage: Series) -> str:
    waypoint, last = voyage.frames[-1].waypoint, len(voyage.time_s) - 1
    left = math.hypot(
        waypoint.east_m - float(voyage.east_m[last]), waypoint.north_m - float(voyage.north_m[last])
    )
    bearing = float(voyage.waypoint_bearing_rad[last])
    heading = course(float(voyage.heading_rad[last]))
    way = "ahead" if abs(bearing) < TURN_RAD else f"{degrees(bearing)} to {side(bearing)}"
    on = "heading" if voyage.applied else "course"
    return f"the voyage ends on {on} {heading}, the waypoint {way} at {miles(left)}."


def _with(text: str, more: str) -> str:
    return " ".join(part for part in (text, more) if part)
