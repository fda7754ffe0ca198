"""Why the pilot did it: whose presence moves the rudder, and who would have it otherwise.

The reason of a rudder is its Shapley values: what it would be with no other ship,
and what each ship adds; together they are the rudder itself. The examination of
explanations (docs/explanations.md) found them, and attention, to tell of the
pilot; danger and priority it did not, so they are no reasons here. The critic, attention
and the Rules are heard where they disagree.
"""

import numpy as np

from glasshelm.figures.series import Series, ShipSeries
from glasshelm.geometry import CPA_HORIZON_S
from glasshelm.report.episodes import Episode
from glasshelm.report.guarding import overruled
from glasshelm.report.rules import Kinds, rule_against
from glasshelm.report.words import NOTHING, approach, degrees, listed, miles, side, where

#: A share of the rudder below this makes no difference (0.1°).
LEAST_RAD = float(np.radians(0.1))
#: A rudder away from a waypoint that is farther aside is not for the waypoint.
ASIDE_RAD = float(np.radians(5))
#: A second ship is named if her share is at least this part of the first one's.
SHARE = 0.4
#: A ship that moves the rudder the other way is named from this part of the rudder on.
AGAINST = 0.25


def why(voyage: Series, episode: Episode, told_at: int | None = None) -> str:
    """The reason of a turn or an advice, from mean shares while the rudder was that way.

    Begins with its own punctuation, to follow what was done. CPAs are those of the
    frame ``told_at``: by default of the beginning, when the decision was made.
    """
    k = episode.start if told_at is None else told_at
    at = acting(voyage, episode)
    another = overruled([voyage.frames[i] for i in at])
    if another:
        return f"; {another}"
    at = _his_own(voyage, at)
    rudder, alone = _mean(voyage.rudder_rad, at), _mean(voyage.alone_rad, at)
    if np.isnan(alone):
        return f"; {_nearest(voyage, k)}"
    way = np.sign(rudder) or 1.0
    moving = _moving(voyage, at, way)
    said = []
    if moving:
        best = _mean(moving[0].shapley_rad, at)
        named = [s for s in moving[:2] if _mean(s.shapley_rad, at) / best >= SHARE]
        size = sum(_mean(s.shapley_rad, at) for s in named)
        who = listed([f"{s.name} ({_threat(s, k)})" for s in named])
        said.append(f"{degrees(size)} for {who}")
    if alone * way > LEAST_RAD:
        off = _mean(voyage.waypoint_bearing_rad, at) * np.sign(alone)
        what = "also with nobody there" if off < -ASIDE_RAD else "for the waypoint"
        said.append(f"{degrees(alone)} {what}")
        if not moving or alone * way > abs(_mean(moving[0].shapley_rad, at)):
            said.reverse()
    elif alone * way < -LEAST_RAD and moving:
        said.append(f"with nobody there it would be {degrees(alone)} to {side(alone)}")
    if not said:
        return ": hardly any rudder, for nobody in particular"
    said[0] = said[0].replace("° ", "° of rudder ", 1)
    back = _moving(voyage, at, -way)
    if back and abs(_mean(back[0].shapley_rad, at)) > AGAINST * abs(rudder):
        one = back[0]
        said.append(
            f"{one.name} ({_threat(one, k)}) holds it back by {degrees(_mean(one.shapley_rad, at))}"
        )
    return f": {', '.join(said)}"


def doubts(
    voyage: Series, episode: Episode, told_at: int | None = None, kinds: Kinds | None = None
) -> str:
    """Where attention (Eq. 23), the critic (Eq. 22) or the Rules say otherwise; else empty.

    Attention is mentioned where it lies with the ship that moves the rudder most, too.
    ``kinds`` are those of :func:`glasshelm.report.rules.rule_against`.
    """
    k = episode.start if told_at is None else told_at
    at = acting(voyage, episode)
    way = np.sign(_mean(voyage.rudder_rad, at)) or 1.0
    moving = _moving(voyage, at, way)
    said = [_attended(voyage, at, moving), _valued(voyage, at)]
    if moving:
        said.append(rule_against(voyage, moving[0], k, way, kinds))
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
    if np.isnan(gain) or gain >= -NOTHING:
        return ""
    return f"The critic sees no gain in it ({gain:+.2f})".replace("-", "−")


def _moving(voyage: Series, at: np.ndarray, way: float) -> list[ShipSeries]:
    """Ships that move the rudder that way, the largest first."""
    found = [s for s in voyage.ships if _mean(s.shapley_rad, at) * way > LEAST_RAD]
    return sorted(found, key=lambda s: -abs(_mean(s.shapley_rad, at)))


def _threat(ship: ShipSeries, k: int) -> str:
    """Her CPA in frame ``k``, or where she first comes into sight after it."""
    if np.isnan(ship.range_m[k]):
        k = int(np.flatnonzero(np.isfinite(ship.range_m))[0])
    words = approach(float(ship.dcpa_m[k]), float(ship.tcpa_s[k]))
    if 0 < ship.tcpa_s[k] < CPA_HORIZON_S:
        return words
    return f"{words}, {miles(float(ship.range_m[k]))} {where(float(ship.bearing_rad[k]))}"


def _nearest(voyage: Series, k: int) -> str:
    """For a pilot without shares: the ship with the nearest CPA ahead in time, as a mere fact."""
    ahead = [s for s in voyage.ships if 0 < s.tcpa_s[k] < CPA_HORIZON_S]
    if not ahead:
        return "this pilot gives no reasons, and no ship is closing"
    ship = min(ahead, key=lambda s: float(s.dcpa_m[k]))
    return f"this pilot gives no reasons; nearest is {ship.name} ({_threat(ship, k)})"


def acting(voyage: Series, episode: Episode) -> np.ndarray:
    """The frames of an episode in which the rudder is on the side of the turn; else all."""
    at = np.arange(episode.start, episode.end + 1)
    meant = at[voyage.rudder_rad[at] * episode.turn_rad > 0]
    return meant if meant.size else at


def _his_own(voyage: Series, at: np.ndarray) -> np.ndarray:
    """Those of some frames in which the pilot has the helm himself; shares are of no others."""
    decided = [voyage.frames[k].decision for k in at]
    return at[[d is None or d.overruled_rad is None for d in decided]]


def _mean(row: np.ndarray, at: np.ndarray) -> float:
    known = row[at][np.isfinite(row[at])]
    return float(known.mean()) if known.size else float("nan")
