"""The frame: situation, decision and explanation of one instant, for everything that people see.

One schema for a line of the log, a message to the page and the input of a
figure. SI units, radians clockwise from north, east/north of the scenario's
origin. What a pilot or a source does not have is *absent* (``None`` here, not
written there), never a zero. Field names are fixed: others build on them.
Text of a frame can be shown as it is, wherever the frame comes from (:mod:`glasshelm.core.text`).
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime

import msgspec

from glasshelm.core.text import printable, safe_name


class _Part(msgspec.Struct, frozen=True, omit_defaults=True):
    """Fields left at ``None`` are not written."""

    def _clean(self, clean: Callable[[str], str], *fields: str) -> None:
        for field in fields:
            text = getattr(self, field)
            if text is not None and (shown := clean(text)) != text:
                msgspec.structs.force_setattr(self, field, shown)


class Ship(_Part, frozen=True):
    """Own ship's parameters (Eq. 6, 14-15)."""

    loa_m: float
    beam_m: float
    K_1_s: float
    T_s: float
    rudder_limit_rad: float
    speed_m_s: float
    rudder_rate_rad_s: float | None = None  # absent: at once


class Own(_Part, frozen=True):
    """Own ship's motion. ``rudder_rad`` is absent where no sensor gives it."""

    east_m: float
    north_m: float
    heading_rad: float
    speed_m_s: float
    rate_of_turn_rad_s: float
    rudder_rad: float | None = None
    latitude_deg: float | None = None
    longitude_deg: float | None = None


class Waypoint(_Part, frozen=True):
    east_m: float
    north_m: float


class Decision(_Part, frozen=True):
    """The rudder that the pilot commands, or (``applied`` false) would command. + = starboard.

    ``base_rad`` is what it would be with no other ship: with every target's
    ``shapley_rad`` it adds up to ``rudder_rad``. ``pilot_rudder_rad`` is the rudder that the
    pilot itself decided where an order or its guard has the helm. The shares are then those of
    the guard's rudder; those of an order are absent.
    """

    rudder_rad: float
    applied: bool = True
    base_rad: float | None = None
    pilot_rudder_rad: float | None = None


class Guard(_Part, frozen=True):
    """What a guard sees on the pilot's own way if every target keeps straight on.

    ``steers``: it has the helm, since its last look. ``target`` is who comes first into own ship's
    domain or to its edge on the pilot's own way, ``within_s`` when, ``depth`` how deep (Eq. 13,
    unclipped: above 0 inside). Absent where that way keeps clear.
    """

    steers: bool
    target: str | None = None
    within_s: float | None = None
    depth: float | None = None

    def __post_init__(self) -> None:
        self._clean(printable, "target")


class BySubTask(_Part, frozen=True):
    """One number a sub-task (Eq. 16-19, 22). ``helm``: what a manoeuvre itself costs."""

    waypoint: float
    collision: float
    total: float | None = None
    helm: float | None = None


class Manoeuvre(_Part, frozen=True):
    """The manoeuvre that the pilot chose: true courses, each held for a time.

    After the last of them own ship steers for the waypoint; ``duration_s`` 0: at once.
    """

    course_rad: float
    duration_s: float
    then_course_rad: float | None = None
    then_duration_s: float | None = None


class Alternative(_Part, frozen=True):
    """A manoeuvre that was compared with the chosen one, and what it is worth.

    ``course_rad`` is the true course that it begins with; ``by_target`` is Q_ca of each target,
    by its id: they add up to ``value.collision``.
    """

    name: str
    course_rad: float
    value: BySubTask
    by_target: dict[str, float]

    def __post_init__(self) -> None:
        self._clean(printable, "name")


class Sweep(_Part, frozen=True):
    """Q over the rudder range, split by sub-task; each target carries its own row ``q_sweep``."""

    rudder_rad: list[float]
    waypoint: list[float]
    collision: list[float]


class TargetBand(_Part, frozen=True):
    """What a target can cost on the chosen manoeuvre, and how near it can come.

    ``q_low`` and ``q_high`` hold Q_ca; ``depth`` is the deepest Eq. 13 (unclipped: above 0 inside
    own ship's domain), ``range_m`` the least range, both until the horizon.
    """

    id: str
    q_low: float
    q_high: float
    depth: float
    range_m: float

    def __post_init__(self) -> None:
        self._clean(printable, "id")


class AlternativeBand(_Part, frozen=True):
    """What the chosen manoeuvre is worth more than another, at least and at most."""

    name: str
    gain_low: float
    gain_high: float

    def __post_init__(self) -> None:
        self._clean(printable, "name")


class ManoeuvreBand(_Part, frozen=True):
    """What is certain of the chosen manoeuvre, if every target keeps course and speed.

    ``low`` and ``high`` hold its value and each part of it. ``courses_rad`` are all true courses
    with which the best manoeuvre can begin, from port to starboard, the chosen one among them.
    ``keeps_clear``: it brings no target into own ship's domain until the horizon.
    """

    low: BySubTask
    high: BySubTask
    targets: list[TargetBand]
    alternatives: list[AlternativeBand]
    courses_rad: list[float]
    keeps_clear: bool


class Band(_Part, frozen=True):
    """The certified band: the pilot's rudder is in it while no sensor errs by more.

    The errors are bounds for own ship and every target alike: of positions on
    each axis, of heading and courses, of speeds. ``turn`` is the side that is
    certain, ``starboard`` or ``port``; absent where neither is. ``manoeuvre`` is there for a pilot
    that chooses manoeuvres; the rudder is then that of any manoeuvre that can be the best.
    """

    low_rad: float
    high_rad: float
    position_m: float
    course_rad: float
    speed_m_s: float
    turn: str | None = None
    manoeuvre: ManoeuvreBand | None = None

    def __post_init__(self) -> None:
        self._clean(printable, "turn")


class Target(_Part, frozen=True):
    """A target: where it is, how near it will come, what the pilot makes of it.

    ``danger`` is Eq. 13, clipped. ``q`` is Q_ca of the decided rudder (lower =
    more dangerous), ``q_far`` the same head's value of a ship far off and
    opening: the zero of danger. ``priority`` is Eq. 22, ``attention`` Eq. 23,
    ``intention`` Eq. 24 with the increment (journal), ``intention_level`` with
    the level (preprint). ``shapley_rad`` is its share of the rudder, + to starboard;
    ``shapley_error_rad`` its standard error, if it was sampled. ``leave_one_out_rad`` is the rudder
    less what it would be without this ship, ``shapley_value`` its share of Q.
    ``shapley_pairs_rad`` is how far it moves the rudder together with each target of the frame,
    beyond each alone (absent where none matters). ``course_shapley_rad`` and
    ``course_leave_one_out_rad`` are the same of the course that a manoeuvre begins with.
    ``selected`` is false for a target seen but
    not shown to the pilot. ``age_s`` is the time since it was last heard;
    ``lost`` says that this is too long ago: its position is the last dead-reckoned one.
    """

    id: str
    name: str
    east_m: float
    north_m: float
    course_rad: float
    speed_m_s: float
    range_m: float
    bearing_rad: float  # relative to own heading, starboard positive, in [−π, π)
    dcpa_m: float
    tcpa_s: float
    danger: float
    q: float | None = None
    q_far: float | None = None
    q_sweep: list[float] | None = None
    priority: float | None = None
    attention: float | None = None
    intention: float | None = None
    intention_level: float | None = None
    shapley_rad: float | None = None
    shapley_error_rad: float | None = None
    leave_one_out_rad: float | None = None
    shapley_value: float | None = None
    shapley_pairs_rad: list[float] | None = None
    course_shapley_rad: float | None = None
    course_leave_one_out_rad: float | None = None
    length_m: float | None = None
    selected: bool = True
    lost: bool = False
    age_s: float | None = None
    latitude_deg: float | None = None
    longitude_deg: float | None = None

    def __post_init__(self) -> None:
        self._clean(printable, "id")
        self._clean(safe_name, "name")


class Frame(_Part, frozen=True):
    """One instant.

    ``reward`` is of the step that led here (absent in the first frame);
    ``value`` is Q of the decided rudder; ``priority`` Q of it minus Q of
    rudder 0 (Eq. 22). Of a pilot that chooses a ``manoeuvre`` they are of that, against keeping
    course and speed, and ``alternatives`` are what it was compared with. ``needed`` holds the ids
    of a smallest set of targets without which another course would be steered. ``last_safe_s`` is
    how long course and speed can still be kept before the last manoeuvre that brings no target
    into the domain; it is absent if there is none even now. ``outside_training`` names what lies
    outside the training distribution, in words. ``band`` is there where it was asked for, ``guard``
    with a guarded pilot.
    """

    time_s: float
    pilot: str
    source: str
    ship: Ship
    own: Own
    waypoint: Waypoint
    targets: list[Target]
    decision: Decision | None = None
    weights_sha256: str | None = None
    time_utc: str | None = None
    reward: BySubTask | None = None
    value: BySubTask | None = None
    priority: BySubTask | None = None
    sweep: Sweep | None = None
    outside_training: list[str] | None = None
    band: Band | None = None
    guard: Guard | None = None
    manoeuvre: Manoeuvre | None = None
    alternatives: list[Alternative] | None = None
    needed: list[str] | None = None
    last_safe_s: float | None = None

    def __post_init__(self) -> None:
        self._clean(printable, "pilot", "source", "weights_sha256", "time_utc")
        if self.outside_training is not None and not all(
            map(str.isprintable, self.outside_training)
        ):
            msgspec.structs.force_setattr(
                self, "outside_training", [*map(printable, self.outside_training)]
            )
        if self.time_utc is not None:
            datetime.fromisoformat(self.time_utc)  # to who reads JSON: not a frame
