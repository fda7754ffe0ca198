"""A voyage cut into episodes: turns and steady stretches, by heading or by advised rudder.

Both cuts have hysteresis, so that a rudder that trembles does not make a story:
a turn is a swing of the heading of at least ``TURN_RAD`` between two extremes;
an advice begins above one rudder angle and ends below a smaller one.
"""

import dataclasses
import itertools
import math

import numpy as np

from glasshelm.frames.series import Series, TimeSeries

#: A heading that swings by less is steady.
TURN_RAD = math.radians(4)
#: A turn that rests for this long is two turns ...
REST_S = 90.0
#: ... where resting is to turn by no more than this meanwhile.
REST_RAD = math.radians(1)
#: An advised rudder counts from here ...
ADVICE_RAD = math.radians(1)
#: ... until it falls below here. Shorter than this it does not count ...
RELEASE_RAD = math.radians(0.5)
ADVICE_S = 15.0
#: ... and two to the same side are one if no more than this lies between them.
PAUSE_S = 30.0


@dataclasses.dataclass(frozen=True)
class Episode:
    """From frame ``start`` to frame ``end``; ``turn_rad`` > 0 to starboard, 0 for steady.

    For advice ``turn_rad`` is the mean advised rudder.
    """

    start: int
    end: int
    turn_rad: float = 0.0


def turn_episodes(voyage: Series) -> list[Episode]:
    """Turns and the steady stretches between them, in order, by what the heading did."""
    swings = [
        part
        for start, end in _swings(voyage.heading_rad, TURN_RAD)
        for part in _without_rests(voyage, start, end)
    ]
    heading = voyage.heading_rad
    found = [Episode(a, b, float(heading[b] - heading[a])) for a, b in swings]
    return _fill(voyage, [e for e in found if abs(e.turn_rad) >= TURN_RAD])


def advice_episodes(voyage: Series) -> list[Episode]:
    """Stretches of advised rudder to one side, and of none, in order."""
    rudder = np.nan_to_num(voyage.rudder_rad)
    state, states = 0.0, []
    for angle in rudder:
        if state and (abs(angle) < RELEASE_RAD or np.sign(angle) != state):
            state = 0.0
        if not state and abs(angle) >= ADVICE_RAD:
            state = float(np.sign(angle))
        states.append(state)
    runs, start = [], 0
    for k in range(1, len(states) + 1):
        if k == len(states) or states[k] != states[start]:
            if states[start]:
                runs.append((start, k - 1, states[start]))
            start = k
    found = [_advised(rudder, a, b, way) for a, b, way in _joined(voyage.time_s, runs)]
    return _fill(
        voyage, [e for e in found if voyage.time_s[e.end] - voyage.time_s[e.start] >= ADVICE_S]
    )


def _joined(time_s: TimeSeries, runs: list[tuple[int, int, float]]) -> list[tuple[int, int, float]]:
    """Runs to the same side with a short pause between them made one."""
    out: list[tuple[int, int, float]] = []
    for run in runs:
        if out and out[-1][2] == run[2] and time_s[run[0]] - time_s[out[-1][1]] <= PAUSE_S:
            out[-1] = (out[-1][0], run[1], run[2])
        else:
            out.append(run)
    return out


def _advised(rudder: TimeSeries, start: int, end: int, way: float) -> Episode:
    """The advice of a run: its rudder is the mean of those to its side."""
    angles = rudder[start : end + 1]
    return Episode(start, end, float(angles[angles * way > 0].mean()))


def _swings(heading: TimeSeries, threshold: float) -> list[tuple[int, int]]:
    """Pairs of frames between which the heading goes from one extreme to the next."""
    corners, low, high, rising = [0], 0, 0, 0
    for k in range(1, len(heading)):
        low = k if heading[k] < heading[low] else low
        high = k if heading[k] > heading[high] else high
        if rising <= 0 and heading[k] - heading[low] >= threshold:
            if rising < 0 or low != corners[-1]:
                corners.append(low)
            rising, high = 1, k
        elif rising >= 0 and heading[high] - heading[k] >= threshold:
            if rising > 0 or high != corners[-1]:
                corners.append(high)
            rising, low = -1, k
    corners.append(high if rising > 0 else low if rising < 0 else len(heading) - 1)
    return [(a, b) for a, b in itertools.pairwise(corners) if b > a]


def _without_rests(voyage: Series, start: int, end: int) -> list[tuple[int, int]]:
    """The parts of a swing between rests; flat beginnings and ends are cut off."""
    time, heading = voyage.time_s, voyage.heading_rad
    resting = np.zeros(len(time), bool)
    for a in range(start, end):
        b = min(int(np.searchsorted(time, time[a] + REST_S)), end)
        if time[b] - time[a] >= REST_S and np.ptp(heading[a : b + 1]) <= REST_RAD:
            resting[a:b] = True
    parts, begin = [], None
    for k in range(start, end + 1):
        moving = k < end and not resting[k]
        if moving and begin is None:
            begin = k
        if not moving and begin is not None:
            parts.append(_trim(heading, begin, k))
            begin = None
    return parts


def _trim(heading: TimeSeries, start: int, end: int) -> tuple[int, int]:
    """The middle 90 % of a turn, so that slow tails do not stretch it."""
    edge = min(0.05 * abs(heading[end] - heading[start]), REST_RAD)
    left = np.flatnonzero(np.abs(heading[start : end + 1] - heading[start]) > edge)
    right = np.flatnonzero(np.abs(heading[start : end + 1] - heading[end]) > edge)
    if not left.size or not right.size:
        return start, end
    return start + max(int(left[0]) - 1, 0), start + min(int(right[-1]) + 1, end - start)


def _fill(voyage: Series, found: list[Episode]) -> list[Episode]:
    """The episodes with steady ones between, before and after them."""
    out, at = [], 0
    last = len(voyage.time_s) - 1
    for episode in found:
        if episode.start > at:
            out.append(Episode(at, episode.start))
        out.append(episode)
        at = episode.end
    if at < last or not out:
        out.append(Episode(at, last))
    return out
