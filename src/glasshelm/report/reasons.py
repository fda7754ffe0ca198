"""Why the pilot did it, as far as its own numbers say (Eq. 22-24)."""

import numpy as np

from glasshelm.figures.series import Series, ShipSeries
from glasshelm.geometry import CPA_HORIZON_S
from glasshelm.report.episodes import Episode
from glasshelm.report.words import NOTHING, amount, approach, listed, miles, where

#: A second ship is named if her priority is at least this share of the first one's.
SHARE = 0.4


def why(voyage: Series, episode: Episode, told_at: int | None = None) -> str:
    """The reason of a turn or an advice, from mean priorities while the rudder was that way.

    Begins with its own punctuation, to follow what was done. Says which ships'
    values the rudder raises, what it costs or brings for the waypoint, and says
    so when neither is positive. CPAs are those of the frame ``told_at``: by default
    of the beginning, when the decision was made.
    """
    k = episode.start if told_at is None else told_at
    at = _acting(voyage, episode)
    waypoint, ships = _mean(voyage.priority_waypoint, at), _mean(voyage.priority_collision, at)
    if np.isnan(waypoint) or np.isnan(ships):
        return f"; {_nearest(voyage, k)}"
    if ships > NOTHING:
        return f": {_for_ships(voyage, k, at, waypoint, ships)}"
    none = "" if _positive(voyage, at) else "; no ship's priority is positive"
    if waypoint <= NOTHING:
        return (
            f"; the critic does not say why: the priority of the ships is {_signed(ships)}, "
            f"that of the waypoint {_signed(waypoint)}{none}"
        )
    if ships >= -NOTHING:
        return f": {amount(waypoint)} of course value{none}"
    if waypoint > -ships:
        return f": {amount(waypoint)} of course value outweighs {amount(ships)} for the ships{none}"
    return (
        f"; the critic does not say why: {amount(waypoint)} of course value is less than the "
        f"{amount(ships)} that it costs for the ships{none}"
    )


def focus(voyage: Series, episode: Episode) -> str:
    """Where attention (Eq. 23) and intention (Eq. 24) lay meanwhile; empty without attention."""
    at = _acting(voyage, episode)
    attended = _largest(voyage, "attention", at)
    if attended is None:
        return ""
    share = _mean(attended.attention, at)
    text = f"Attention is mostly on {attended.name} ({share:.0%})"
    meant = _largest(voyage, "intention", at)
    if meant is None or _mean(meant.intention, at) <= NOTHING:
        return f"{text}; no ship has a positive intention."
    if meant.id == attended.id:
        return f"{text}, who also has the largest intention."
    return f"{text}, the largest intention belongs to {meant.name}."


def _for_ships(voyage: Series, k: int, at: np.ndarray, waypoint: float, ships: float) -> str:
    leading = _positive(voyage, at)
    best = _mean(leading[0].priority, at)
    named = [s for s in leading[:2] if _mean(s.priority, at) >= SHARE * best]
    who = listed([f"{s.name} ({_threat(s, k)})" for s in named])
    coming = 0 < named[0].tcpa_s[k] < CPA_HORIZON_S
    danger = f"danger from {who}" if coming else f"the gain with {who}"
    if waypoint > NOTHING:
        return f"{danger}; it also gains {amount(waypoint)} of course value"
    if waypoint >= -NOTHING:
        return f"{danger}, at no cost of course value"
    if ships > -waypoint:
        return f"{danger} outweighs {amount(waypoint)} of course value"
    return (
        f"{danger}, though {amount(ships)} for the ships is less than the {amount(waypoint)} "
        "of course value that it costs"
    )


def _threat(ship: ShipSeries, k: int) -> str:
    """Her CPA in frame ``k``, or where she first comes into sight after it."""
    if np.isnan(ship.range_m[k]):
        k = int(np.flatnonzero(np.isfinite(ship.range_m))[0])
    words = approach(float(ship.dcpa_m[k]), float(ship.tcpa_s[k]))
    if 0 < ship.tcpa_s[k] < CPA_HORIZON_S:
        return words
    return f"{words}, {miles(float(ship.range_m[k]))} {where(float(ship.bearing_rad[k]))}"


def _nearest(voyage: Series, k: int) -> str:
    """For a pilot without critic: the ship with the nearest CPA ahead in time, as a mere fact."""
    ahead = [s for s in voyage.ships if 0 < s.tcpa_s[k] < CPA_HORIZON_S]
    if not ahead:
        return "this pilot gives no reasons, and no ship is closing"
    ship = min(ahead, key=lambda s: float(s.dcpa_m[k]))
    return f"this pilot gives no reasons; nearest is {ship.name} ({_threat(ship, k)})"


def _acting(voyage: Series, episode: Episode) -> np.ndarray:
    """The frames of an episode in which the rudder is on the side of the turn; else all."""
    at = np.arange(episode.start, episode.end + 1)
    meant = at[voyage.rudder_rad[at] * episode.turn_rad > 0]
    return meant if meant.size else at


def _positive(voyage: Series, at: np.ndarray) -> list[ShipSeries]:
    """Ships with a positive mean priority, the largest first."""
    found = [s for s in voyage.ships if _mean(s.priority, at) > NOTHING]
    return sorted(found, key=lambda s: -_mean(s.priority, at))


def _largest(voyage: Series, field: str, at: np.ndarray) -> ShipSeries | None:
    found = [s for s in voyage.ships if not np.isnan(_mean(getattr(s, field), at))]
    return max(found, key=lambda s: _mean(getattr(s, field), at), default=None)


def _mean(row: np.ndarray, at: np.ndarray) -> float:
    known = row[at][np.isfinite(row[at])]
    return float(known.mean()) if known.size else float("nan")


def _signed(value: float) -> str:
    return "0.000" if abs(value) < NOTHING else f"{value:+.3f}".replace("-", "−")
