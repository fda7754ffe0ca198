"""What a run of our own shows, in sentences with its numbers."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from glasshelm.figures.situation_maps import describe_rudder
from glasshelm.frames.series import Series, ShipSeries, ships_of_note
from glasshelm.ship.domain import AHEAD_LOA
from glasshelm.ship.nomoto import NAUTICAL_MILE_M

#: A ship is near within so many times the longest axis of the domain.
NEAR_AXES = 1.5


def of_tracks(voyages: Sequence[Series]) -> str:
    """Figures 7-8: whether any ship came into the domain, and how near."""
    met = [voyage for voyage in voyages if voyage.ships]
    entered = [v for v in met if max(float(np.nanmax(s.danger)) for s in v.ships) > 0]
    nearest = min(float(np.nanmin(s.range_m)) for v in met for s in v.ships)
    text = f"A ship entered the domain in {len(entered)} of {len(met)} encounters"
    if entered:
        deepest = max(float(np.nanmax(s.danger)) for v in entered for s in v.ships)
        text += f" (danger up to {deepest:.3f})"
    return f"{text}; the nearest came to {nearest / NAUTICAL_MILE_M:.2f} NM."


def of_values(voyages: Sequence[Series]) -> str:
    """Figure 9: whether ships that are near and close in are valued lower than the others."""
    near, rest = [], []
    for voyage in voyages:
        reach = NEAR_AXES * AHEAD_LOA * voyage.frames[0].ship.loa_m
        for ship in voyage.ships:
            closing = (ship.tcpa_s > 0) & (ship.range_m < reach)
            known = np.isfinite(ship.q)
            near.append(ship.q[known & closing])
            rest.append(ship.q[known & ~closing])
    a, b = np.concatenate(near), np.concatenate(rest)
    if not a.size or not b.size:
        return "No ship came near while it closed in: nothing to compare."
    lower = float(np.mean(np.median(b) > a))
    return (
        f"Mean Q of ships that close in within {NEAR_AXES * AHEAD_LOA:.1f} LOA: "
        f"{_points(a.mean())}; of all others: {_points(b.mean())}. {lower:.0%} of the former lie "
        "below the median of the latter."
    )


def of_priorities(voyage: Series, times_s: Sequence[float]) -> str:
    """Figures 10-11: action and priorities at the instants that the paper names."""
    parts = []
    for time in times_s:
        k = voyage.at(time)
        parts.append(
            f"At {time:g} s {describe_rudder(voyage, k)}, priority of avoiding "
            f"{_points(voyage.priority_collision[k])}, of the waypoint "
            f"{_points(voyage.priority_waypoint[k])}."
        )
    return " ".join([*parts, _agreement(voyage, times_s)])


def _agreement(voyage: Series, times_s: Sequence[float]) -> str:
    """Whether avoiding and return have the priorities that the paper describes."""
    away, back = (voyage.at(time) for time in times_s)
    avoids = voyage.rudder_rad[away] > 0 and voyage.priority_collision[away] > 0
    returns = (
        voyage.rudder_rad[back] * voyage.waypoint_bearing_rad[back] > 0
        and voyage.priority_waypoint[back] > 0
    )
    falls = voyage.priority_collision[back] < voyage.priority_collision[away]
    if avoids and returns and falls:
        still = voyage.priority_collision[back] > voyage.priority_waypoint[back]
        return "As the paper describes it" + (
            ", though avoiding still has the higher priority then." if still else "."
        )
    lacks = [
        what
        for what, is_so in (
            ("a turn to starboard for the ships first", avoids),
            ("a turn back for the waypoint then", returns),
            ("a falling priority of avoiding", falls),
        )
        if not is_so
    ]
    return f"Unlike the paper: no sign of {' nor '.join(lacks)}."


def of_attention(voyage: Series) -> str:
    """Figure 13: who is attended to most, in which order, and what is left at the end."""
    ships = ships_of_note(voyage)
    shares = np.array([ship.attention for ship in ships])
    first = np.nanargmax(np.nan_to_num(shares, nan=-1.0), axis=0)
    order = [first[0], *(b for a, b in itertools.pairwise(first) if a != b)]
    names = ", ".join(ships[k].name for k in order[:8]) + (", …" if len(order) > 8 else "")
    last = ships[int(first[-1])]
    return (
        f"Most attention goes to, in turn: {names}. At the end {last.name} has "
        f"{last.attention[-1]:.0%} of it at {last.range_m[-1] / NAUTICAL_MILE_M:.1f} NM, "
        f"{'closing in' if last.tcpa_s[-1] > 0 else 'past'}."
    )


def of_intention(voyage: Series) -> str:
    """Figure 14: how far both readings of Eq. 24 agree, and who drops out."""
    ships = [s for s in ships_of_note(voyage) if s.has("intention") and s.has("intention_level")]
    increment = {s.name: float(np.nanmean(np.abs(s.intention))) for s in ships}
    level = {s.name: float(np.nanmean(np.abs(s.intention_level))) for s in ships}
    least = " and ".join(sorted({min(increment, key=increment.__getitem__),
                                 min(level, key=level.__getitem__)}))  # fmt: skip
    a = np.concatenate([s.intention for s in ships])
    b = np.concatenate([s.intention_level for s in ships])
    r = _correlation(np.abs(a), np.abs(b))
    return (
        f"Sizes of the two readings correlate with r = {r:.2f} over all ships and instants. "
        f"Least intention: {least}."
    )


def of_histories(voyage: Series) -> str:
    """Figure 15: how priority and intention go together, early and about 600 s."""
    ships = [s for s in ships_of_note(voyage) if s.has("priority")]
    parts = [
        f"{name}: r = {_within(voyage, ships, low, high):.2f}"
        for name, low, high in (("200 to 500 s", 200.0, 500.0), ("500 to 700 s", 500.0, 700.0))
    ]
    return (
        "Correlation of priority with Q × attention over ships and instants, "
        f"{', '.join(parts)}. The increment times attention is a priority weighted with attention "
        "by definition."
    )


def _within(voyage: Series, ships: Sequence[ShipSeries], low: float, high: float) -> float:
    part = (voyage.time_s >= low) & (voyage.time_s <= high)
    a = np.concatenate([s.priority[part] for s in ships])
    return _correlation(a, np.concatenate([s.intention_level[part] for s in ships]))


def _correlation(a: np.ndarray, b: np.ndarray) -> float:
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < 3 or a[known].std() == 0 or b[known].std() == 0:
        return math.nan
    return float(np.corrcoef(a[known], b[known])[0, 1])


def _points(value: float) -> str:
    """A value of Q in a few digits."""
    if not math.isfinite(value):
        return "none"
    digits = 3 if abs(value) < 1 else 1
    return f"{value:+.{digits}f}".replace("-", "−")


def held(voyages: Sequence[Series]) -> dict[str, str]:
    """What frames of this run show of equations, recomputed from their own parts.

    Returns:
        By the number of the equation, the largest deviation.
    """
    frames = [frame for voyage in voyages for frame in voyage.frames]
    targets = [(frame, target) for frame in frames for target in frame.targets]
    danger = [abs(_danger(f.ship.loa_m, t.range_m, t.bearing_rad) - t.danger) for f, t in targets]
    valued = [f for f in frames if f.value is not None and f.priority is not None]
    sums = [
        abs(f.value.waypoint + sum(t.q or 0.0 for t in f.targets) + (f.value.helm or 0.0)
            - (f.value.total or 0.0)) / max(1.0, abs(f.value.total or 0.0))
        for f in valued if f.value is not None
    ]  # fmt: skip
    priorities = [
        abs(f.priority.collision - sum(t.priority or 0.0 for t in f.targets))
        / max(1.0, abs(f.priority.collision))
        for f in valued if f.priority is not None
    ]  # fmt: skip
    attended = [f for f in frames if any(t.attention is not None for t in f.targets)]
    shares = [abs(sum(t.attention or 0.0 for t in f.targets) - 1.0) for f in attended]
    both = [t for _, t in targets if t.intention is not None and t.intention_level is not None]
    products = [
        max(
            abs((t.priority or 0.0) * (t.attention or 0.0) - (t.intention or 0.0)),
            abs((t.q or 0.0) * (t.attention or 0.0) - (t.intention_level or 0.0)),
        )
        for t in both
    ]
    found = {
        "13": (danger, "danger from range and bearing against the frame"),
        "19": (sums, "sum of the parts against Q, relative"),
        "22": (priorities, "sum over ships against the sub-task's, relative"),
        "23": (shares, "sum of attention against 1"),
        "24": (products, "both products against the frame"),
    }
    return {
        number: f"{what}: at most {max(errors):.0e} off in {len(errors):,} cases"
        for number, (errors, what) in found.items()
        if errors
    }


def _danger(loa_m: float, range_m: float, bearing_rad: float) -> float:
    """Eq. 13 from range and bearing, apart from the code that the simulator uses."""
    x, y = range_m * math.sin(bearing_rad), range_m * math.cos(bearing_rad)
    a = (3.2 if x >= 0 else 1.6) * loa_m
    b = (6.4 if y >= 0 else 1.6) * loa_m
    return max(1.0 - math.hypot(x / a, y / b), 0.0)
