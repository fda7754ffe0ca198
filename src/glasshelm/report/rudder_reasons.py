"""Why the pilot did it: whose presence moves the rudder, and who would have it otherwise.

The reason of a rudder is its Shapley values: what it would be with no other ship,
and what each ship adds; together they are the rudder itself. The tests of
explanations (docs/explanation/explanations.md) found them, and attention, to describe the
pilot; danger and priority it did not, so they are no reasons here. The critic, attention
and the Rules are heard where they disagree.
"""

import numpy as np

from glasshelm.colregs.rule_text import EncounterTypes, conflicting_rule
from glasshelm.core.geometry import CPA_HORIZON_S
from glasshelm.frames.episodes import Episode
from glasshelm.frames.phrases import (
    NEGLIGIBLE,
    cpa_words,
    joined,
    miles,
    relative_bearing,
    rudder_degrees,
    side,
)
from glasshelm.frames.series import Series, ShipSeries
from glasshelm.report.guard_text import override_text, who_decides, who_has_the_helm
from glasshelm.report.rudder_shares import (
    NEGLIGIBLE_RAD,
    RudderShares,
    Share,
    largest,
    rudder_shares,
    total,
)

#: A ship whose share of the rudder is below this (0.1°) is not told with her CPA.
MIN_SHARE_RAD = float(np.radians(0.1))
#: A rudder away from a waypoint that is farther aside is not for the waypoint.
OFF_WAYPOINT_RAD = float(np.radians(5))
#: A second ship is told with her CPA if her share is at least this part of the first one's.
SHARE = 0.4
#: A ship that moves the rudder the other way is told so from this part of the rudder on.
AGAINST = 0.25


def reason_text(voyage: Series, episode: Episode, told_at: int | None = None) -> str:
    """The reason of a turn or an advice, from mean shares while the rudder was that way.

    What is said adds up to the mean rudder, but for the rounding of each number to a tenth of a
    degree. Begins with its own punctuation, to follow what was done. CPAs are those of the
    frame ``told_at``: by default of the beginning, when the decision was made.
    """
    k = episode.start if told_at is None else told_at
    at = frames_with_rudder(voyage, episode)
    another = override_text([voyage.frames[i] for i in at])
    at = _decided_by(who_decides([voyage.frames[i] for i in at]), voyage, at)
    cut = rudder_shares(voyage, at)
    if cut is None:
        return f"; {another or _nearest(voyage, k)}"
    begins = f"; {another}; " if another else ": "
    gains = _gains(cut, k, _mean(voyage.waypoint_bearing_rad, at))
    if not gains:
        return f"{begins}hardly any rudder, for nobody in particular"
    gains = gains.replace("° ", "° of rudder ", 1)
    return begins + "; ".join(part for part in (gains, _turned(cut), _held(cut, k)) if part)


def _gains(cut: RudderShares, k: int, waypoint_rad: float) -> str:
    """What moves the rudder to its side: ships, the waypoint at this relative bearing."""
    named = [
        s for s in _told(cut.supporting)[:2] if s.size_rad >= SHARE * cut.supporting[0].size_rad
    ]
    rest = cut.supporting[len(named) :]
    said = []
    if named:
        who = joined([f"{s.ship.name} ({_threat(s.ship, k)})" for s in named])
        said.append(f"{rudder_degrees(total(named))} for {who}")
    if cut.base_rad >= NEGLIGIBLE_RAD:
        away = waypoint_rad * cut.way < -OFF_WAYPOINT_RAD
        what = "also with nobody there" if away else "for the waypoint"
        said.append(f"{rudder_degrees(cut.base_rad)} {what}")
        if named and cut.base_rad > named[0].size_rad:
            said.reverse()
    if total(rest) >= NEGLIGIBLE_RAD:
        said.append(f"{rudder_degrees(total(rest))} for {_others(rest, bool(named))}")
    return ", ".join(said)


def _turned(cut: RudderShares) -> str:
    """That with no ship there the rudder would be on its other side."""
    if cut.base_rad > -NEGLIGIBLE_RAD:
        return ""
    return f"with nobody there it would be {rudder_degrees(cut.base_rad)} to {side(-cut.way)}"


def _held(cut: RudderShares, k: int) -> str:
    """Which ships move it the other way."""
    said = []
    named = [s for s in _told(cut.opposing)[:1] if s.size_rad > AGAINST * cut.rudder_rad]
    rest = cut.opposing[len(named) :]
    for one in named:
        who = f"{one.ship.name} ({_threat(one.ship, k)})"
        said.append(f"{who} holds it back by {rudder_degrees(one.size_rad)}")
    if total(rest) >= NEGLIGIBLE_RAD:
        who, much = _others(rest, bool(named or _told(cut.supporting))), rudder_degrees(total(rest))
        holds = "holds" if len(largest(rest)) == 1 else "hold"
        said.append(f"{who} by {much}" if named else f"{who} {holds} it back by {much}")
    return ", ".join(said)


def _told(some: list[Share]) -> list[Share]:
    """Those whose share is large enough to be named with their CPA."""
    return [one for one in some if one.size_rad > MIN_SHARE_RAD]


def _others(rest: list[Share], after_some: bool) -> str:
    """The name of the one, or how many they are; ``after_some``: ships are named before."""
    count = len(largest(rest))
    if count == 1:
        return rest[0].ship.name
    return f"{count} {'others' if after_some else 'ships'}"


def disagreement_text(
    voyage: Series,
    episode: Episode,
    told_at: int | None = None,
    kinds: EncounterTypes | None = None,
) -> str:
    """Where attention (Eq. 23), the critic (Eq. 22) or the Rules say otherwise; else empty.

    Attention is mentioned where it lies with the ship that moves the rudder most, too.
    ``kinds`` are those of :func:`glasshelm.colregs.rule_text.conflicting_rule`.
    """
    k = episode.start if told_at is None else told_at
    at = frames_with_rudder(voyage, episode)
    at = _decided_by(who_decides([voyage.frames[i] for i in at]), voyage, at)
    cut = rudder_shares(voyage, at)
    moving = [] if cut is None else [one.ship for one in _told(cut.supporting)]
    said = [_attended(voyage, at, moving), _valued(voyage, at)]
    if cut is not None and moving:
        said.append(conflicting_rule(voyage, moving[0], k, cut.way, kinds))
    return " ".join(f"{text}." for text in said if text)


def _attended(voyage: Series, at: np.ndarray, moving: list[ShipSeries]) -> str:
    found = [s for s in voyage.ships if not np.isnan(_mean(s.attention, at))]
    if len(found) < 2:
        return ""  # all of it is hers
    most = max(found, key=lambda s: _mean(s.attention, at))
    share = f"{_mean(most.attention, at):.0%}"
    if not moving:
        return f"Attention is mostly on {most.name} ({share})"
    if moving[0].id == most.id:
        return f"Attention is mostly on {most.name} too ({share})"
    return f"But attention is mostly on {most.name} ({share})"


def _valued(voyage: Series, at: np.ndarray) -> str:
    gain = _mean(voyage.priority_waypoint, at) + _mean(voyage.priority_collision, at)
    if np.isnan(gain) or gain >= -NEGLIGIBLE:
        return ""
    return "The critic rates the rudder amidships better"


def _threat(ship: ShipSeries, k: int) -> str:
    """Her CPA in frame ``k``, or where she first comes into sight after it."""
    if np.isnan(ship.range_m[k]):
        k = int(np.flatnonzero(np.isfinite(ship.range_m))[0])
    words = cpa_words(float(ship.dcpa_m[k]), float(ship.tcpa_s[k]))
    if 0 < ship.tcpa_s[k] < CPA_HORIZON_S:
        return words
    return (
        f"{words}, {miles(float(ship.range_m[k]))} {relative_bearing(float(ship.bearing_rad[k]))}"
    )


def _nearest(voyage: Series, k: int) -> str:
    """For a pilot without shares: the ship with the nearest CPA ahead in time, as a mere fact."""
    ahead = [s for s in voyage.ships if 0 < s.tcpa_s[k] < CPA_HORIZON_S]
    if not ahead:
        return "this pilot gives no reasons, and no ship is closing"
    ship = min(ahead, key=lambda s: float(s.dcpa_m[k]))
    return f"this pilot gives no reasons; nearest is {ship.name} ({_threat(ship, k)})"


def frames_with_rudder(voyage: Series, episode: Episode) -> np.ndarray:
    """The frames of an episode in which the rudder is on the side of the turn; else all."""
    at = np.arange(episode.start, episode.end + 1)
    meant = at[voyage.rudder_rad[at] * episode.turn_rad > 0]
    return meant if meant.size else at


def _decided_by(who: str, voyage: Series, at: np.ndarray) -> np.ndarray:
    """Those of some frames in which the pilot, or its guard, has the helm."""
    return at[[who_has_the_helm(voyage.frames[k]) == who for k in at]]


def _mean(row: np.ndarray, at: np.ndarray) -> float:
    known = row[at][np.isfinite(row[at])]
    return float(known.mean()) if known.size else float("nan")
