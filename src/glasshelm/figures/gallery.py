"""All figures of a voyage, in order, each with its caption, or the reason why it is not drawn."""

import dataclasses
from collections.abc import Callable, Iterator

from matplotlib.figure import Figure

from glasshelm.figures.coloured_tracks import attention, danger, intention, shapley_tracks
from glasshelm.figures.intention_histories import histories
from glasshelm.figures.motion import motion
from glasshelm.figures.priorities import at_instants, over_time
from glasshelm.figures.q_sweep import sweep
from glasshelm.figures.shapley_over_time import reasons
from glasshelm.figures.trajectories import absolute, relative
from glasshelm.frames.series import Frames, Series, to_series

_NO_SHIP = "there is no other ship"
_NO_CRITIC = "this pilot has no critic, so its decisions carry no values or priorities"
_NO_ATTENTION = "this pilot has no attention: only attention actors weigh the ships"
_NO_INTENTION = "the frames have no attention or no decision of the pilot's own"
_NO_SHARES = "the frames do not say what each ship does to the rudder"
_NO_SWEEP = "the frames carry no values of other rudders"


@dataclasses.dataclass(frozen=True)
class FigureSpec:
    """One figure: its file name, title, what to see in it, and why it may be missing."""

    stem: str
    title: str
    caption: str
    draw: Callable[[Frames], Figure | None]
    missing: str = ""


FIGURES = (
    FigureSpec(
        "07_tracks",
        "Tracks",
        "Tracks of all ships, north up, with markers at the same times for every ship. Own ship's "
        "markers are open and numbered in minutes; the dotted line is the closest approach.",
        absolute,
    ),
    FigureSpec(
        "08_relative",
        "Seen from own ship",
        "Tracks of the other ships as own ship sees them: her bow points up, the dashed outline "
        "is her domain (Eq. 14-15), drawn to scale.",
        relative,
        _NO_SHIP,
    ),
    FigureSpec(
        "motion",
        "Ranges, heading, rudder",
        "Range of each ship (thick while inside the domain), own heading against the course to "
        "the waypoint, and the rudder.",
        motion,
    ),
    FigureSpec(
        "09_danger",
        "Danger by the critic",
        "The tracks as seen from own ship, darker where the critic values a ship lower than one "
        "far off: where it sees danger.",
        danger,
        _NO_CRITIC,
    ),
    FigureSpec(
        "10_priorities",
        "Priorities over time",
        "Rudder and priorities (Eq. 22): how much better the chosen rudder is than rudder 0, or "
        "the chosen manoeuvre than keeping on, for the waypoint and for each ship. Dotted: the "
        "instants of the next figure.",
        over_time,
        _NO_CRITIC,
    ),
    FigureSpec(
        "11_instants",
        "Situation, action and priorities",
        "The instant of the largest collision priority and, if there is one, of the return "
        "towards the waypoint. Arrows show where each ship will be in six minutes.",
        at_instants,
        _NO_CRITIC,
    ),
    FigureSpec(
        "sweep",
        "Why not another rudder?",
        "The value of every rudder against rudder 0 at the same instants, split by task and "
        "ship. Dotted: the rudder decided.",
        sweep,
        _NO_SWEEP,
    ),
    FigureSpec(
        "13_attention",
        "Attention",
        "Tracks coloured by the share of attention (Eq. 23) that each ship gets.",
        attention,
        _NO_ATTENTION,
    ),
    FigureSpec(
        "14_intention",
        "Intention",
        "Tracks coloured by intention (Eq. 24): violet where the chosen rudder improves matters "
        "with a ship that is attended to, orange where it worsens them.",
        intention,
        _NO_INTENTION,
    ),
    FigureSpec(
        "15_histories",
        "Measures of intention over time",
        "Priorities, danger, attention and intention of each ship over time, with the colours "
        "and markers of the tracks.",
        histories,
        _NO_CRITIC,
    ),
    FigureSpec(
        "shapley",
        "What moved the rudder",
        "The rudder as a sum of what the waypoint and each ship do to it (Shapley values), and "
        "by how much it would change without each ship.",
        reasons,
        _NO_SHARES,
    ),
    FigureSpec(
        "shapley_tracks",
        "Who moved the rudder, and where",
        "Tracks coloured by what each ship does to the rudder (Shapley value): green to "
        "starboard, brown to port.",
        shapley_tracks,
        _NO_SHARES,
    ),
)


def gallery(frames: Frames) -> Iterator[tuple[FigureSpec, Figure | None]]:
    """Draw every figure in turn; the figure is None where ``spec.missing`` says why.

    A quantity of ships is missing for want of ships before it is for want of a
    critic: use :func:`why_missing` for the sentence.
    """
    voyage = to_series(frames)
    for spec in FIGURES:
        yield spec, spec.draw(voyage)


def why_missing(spec: FigureSpec, voyage: Series) -> str:
    """Why a figure was not drawn, in one line."""
    about_ships = spec.draw in (danger, attention, intention, reasons, shapley_tracks)
    why = _NO_SHIP if about_ships and not voyage.ships else spec.missing
    return f"{spec.title}: not drawn, {why}."
