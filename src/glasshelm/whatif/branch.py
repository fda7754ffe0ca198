"""A branch: the world of one logged frame, rebuilt from the log alone.

What the pilot saw is rebuilt from the frame and the four before it, as it was
remembered then (Eq. 12); what a pilot keeps in mind from one decision to the
next, by letting it decide again on all frames of its watch. Targets go on as
they were logged, and straight on where the log ends: **recorded ships do not
react** to what own ship does in a branch. Numbers are those of the log, which
rounds to a micrometre and a microradian (:data:`glasshelm.simulation.frame_builder.DECIMALS`).
"""

import dataclasses
from collections.abc import Sequence
from datetime import datetime, timedelta

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector
from glasshelm.encounters.projection import LocalProjection
from glasshelm.encounters.types import Encounter, Motion, Scenario, TargetInfo, Track
from glasshelm.env.observe import FRAMES, Observation, empty_observation, observe, push_frame
from glasshelm.env.step import EnvSettings, EnvState, margins
from glasshelm.env.target_selection import MAX_TARGETS
from glasshelm.frames.frame_log import is_episode_start
from glasshelm.frames.schema import Frame, Own
from glasshelm.pilots.decide import decide_on
from glasshelm.pilots.protocols import Memory, Pilot
from glasshelm.ship.nomoto import ShipParams, ShipState
from glasshelm.simulation.explained_step import LastKnownTargets
from glasshelm.simulation.frame_builder import ship_params
from glasshelm.simulation.voyage import padded_encounter


class BranchState(eqx.Module):
    """What a future starts from; changes are made to it (:mod:`glasshelm.whatif.changes`).

    ``visible`` are the ships that the pilot sees; ``override_rad`` is the rudder of the
    first ``override_steps`` steps. Time 0 of the encounter is the instant of the branch.
    """

    encounter: Encounter
    state: EnvState
    last_known: LastKnownTargets
    memory: Memory
    visible: Bool[Array, " n"]
    override_rad: Float[Array, ""]
    override_steps: Int[Array, ""]


@dataclasses.dataclass(frozen=True, eq=False)
class Branch:
    """Where a log branches: the frame, the pilot who sails on, and the world as it was then."""

    start: Frame
    pilot: Pilot
    scenario: Scenario
    ship: ShipParams
    initial: BranchState
    settings: EnvSettings

    def slot(self, ship: str) -> int:
        """The slot of a ship by her id or her name. InputError if there is none, or several."""
        ship = str(ship)  # an id of digits may come as a number
        ids = [info.id for info in self.scenario.targets]
        if ship in ids:
            return ids.index(ship)
        named = [
            k
            for k, info in enumerate(self.scenario.targets)
            if info.name.casefold() == ship.casefold()
        ]
        if len(named) == 1:
            return named[0]
        if named:
            raise InputError(f"{len(named)} ships are called {ship!r}: name one by her id")
        known = ", ".join(ids[:12]) + (", …" if len(ids) > 12 else "")
        there = f"there are {known}" if ids else "there is none"
        raise InputError(f"no ship {ship[:100]!r} from this instant on: {there}")

    def is_present(self, slot: int) -> bool:
        """Whether the ship of a slot is there at the instant of the branch (not lost)."""
        return bool(np.asarray(self.initial.encounter.targets.start_s)[slot, 0] <= 0.0) and bool(
            np.asarray(self.initial.encounter.targets.end_s)[slot, 0] > 0.0
        )


def branch_at(
    frames: Sequence[Frame],
    number: int,
    pilot: Pilot,
    steps: int,
    settings: EnvSettings = EnvSettings(),
) -> Branch:
    """The branch at a frame of a log, for futures of so many steps.

    InputError if the log has no such frame or its rudder is nobody's.
    """
    if not 0 <= number < len(frames):
        raise InputError(f"no frame {number}: the log has frames 0 to {len(frames) - 1}")
    start = frames[number]
    until_s = start.time_s + steps * settings.step_s
    ahead = [f for f in frames[number:] if f.time_s <= until_s + 1e-6]
    first = _first_replayed(frames, number, pilot)
    window = [*frames[first:number], *ahead]
    infos = _infos(window)
    chosen_from = any(not t.selected and not t.lost for f in window for t in f.targets)
    slots = max(len(infos), MAX_TARGETS + 1) if chosen_from else len(infos)
    places = {info.id: k for k, info in enumerate(infos)}
    track = _track(ahead, places, slots, steps, settings)
    encounter = padded_encounter(
        Encounter(_own(start.own), _route(ahead), track, jnp.asarray(np.arange(slots) < len(infos)))
    )
    wide = encounter.present.shape[0]
    ship = jax.tree.map(_scalar, ship_params(start.ship))
    known, memory = empty_observation(wide), pilot.start()
    remembers = bool(jax.tree.leaves(memory))
    for k in range(first, number + 1):
        known, memory = _replay(
            pilot,
            ship,
            known,
            memory,
            _own(frames[k].own),
            Vector(*map(_scalar, (frames[k].waypoint.east_m, frames[k].waypoint.north_m))),
            _motion(frames[k], places, wide),
            jnp.asarray(k == first),
            remembers and k < number,
        )
    state = _state_at(encounter, known, _motion(start, places, wide), ship)
    premise = BranchState(
        encounter,
        state,
        _held(frames[first : number + 1], places, wide),
        memory,
        jnp.ones(wide, bool),
        jnp.zeros(()),
        jnp.zeros((), jnp.int32),
    )
    scenario = Scenario(
        source=start.source,
        title=f"{start.source} from {start.time_s:g} s on",
        encounter=jax.device_get(encounter),
        targets=infos,
        ship=jax.device_get(ship),
        duration_s=steps * settings.step_s,
        origin=_origin(start.own),
        start=_clock_start(start),
    )
    return Branch(start, pilot, scenario, ship, premise, settings)


def _first_replayed(frames: Sequence[Frame], number: int, pilot: Pilot) -> int:
    """The first frame that still matters: five are seen; a memory reaches back to its beginning."""
    remembers = bool(jax.tree.leaves(pilot.start()))
    first = number
    while first > 0 and not is_episode_start(frames, first):
        same_watch = remembers and frames[first - 1].pilot == frames[number].pilot
        if number - first >= FRAMES - 1 and not same_watch:
            break
        first -= 1
    return first


@eqx.filter_jit
def _replay(
    pilot: Pilot,
    ship: ShipParams,
    known: Observation,
    memory: Memory,
    own: ShipState,
    waypoint: Vector,
    motion: Motion,
    first: Bool[Array, ""],
    decides: bool,
) -> tuple[Observation, Memory]:
    """What is remembered once a logged instant has been seen, and (``decides``) decided upon."""
    known = push_frame(known, observe(own, waypoint, motion, motion.present), first)
    if decides:
        _, memory, _ = decide_on(pilot, known, memory, ship)
    return known, memory


@eqx.filter_jit
def _state_at(
    encounter: Encounter, known: Observation, motion: Motion, ship: ShipParams
) -> EnvState:
    zero = jnp.zeros((), jnp.int32)
    danger = jnp.maximum(margins(encounter.own, motion, ship), 0.0)
    return EnvState(encounter.own, zero, zero, known, danger)


def _infos(window: Sequence[Frame]) -> tuple[TargetInfo, ...]:
    """All ships of some frames, in an order that each frame keeps: that of the slots."""
    order: list[str] = []
    infos: dict[str, TargetInfo] = {}
    for frame in window:
        place = 0
        for target in frame.targets:
            if target.id in infos:
                place = max(place, order.index(target.id) + 1)
            else:
                order.insert(place, target.id)
                place += 1
            infos[target.id] = TargetInfo(target.id, target.name, target.length_m)
    return tuple(infos[id] for id in order)


def _track(
    ahead: Sequence[Frame],
    places: dict[str, int],
    slots: int,
    steps: int,
    settings: EnvSettings,
) -> Track:
    """One leg a logged frame, the last one for ever; while a ship is away, one that has ended."""
    count = 1 if len(ahead) == 1 else max(steps + 1, len(ahead))
    start = np.full((slots, count), np.inf)
    end = np.full((slots, count), -np.inf)
    values = np.zeros((4, slots, count))
    for leg, frame in enumerate(ahead):
        start[:, leg] = frame.time_s - ahead[0].time_s
        for t in frame.targets:
            if not t.lost:
                place = places[t.id]
                end[place, leg] = np.inf
                values[:, place, leg] = t.east_m, t.north_m, t.course_rad, t.speed_m_s
    return Track(*(jnp.asarray(x, jnp.float32) for x in (start, end, *values)))


def _route(ahead: Sequence[Frame]) -> Vector:
    """The waypoints that the log steers for from here on."""
    route = [ahead[0].waypoint]
    for frame in ahead:
        if frame.waypoint != route[-1]:
            route.append(frame.waypoint)
    return Vector(
        jnp.asarray([w.east_m for w in route], jnp.float32),
        jnp.asarray([w.north_m for w in route], jnp.float32),
    )


def _motion(frame: Frame, places: dict[str, int], slots: int) -> Motion:
    """The targets of a logged frame that were not lost."""
    values, present = np.zeros((5, slots), np.float32), np.zeros(slots, bool)
    for t in frame.targets:
        if not t.lost:
            place = places[t.id]
            values[:4, place] = t.east_m, t.north_m, t.course_rad, t.speed_m_s
            present[place] = True
    return _moving(values, present)


def _moving(values: np.ndarray, present: np.ndarray) -> Motion:
    """East, north, course, speed and age [5, n] as motion."""
    east, north, course, speed, age = jnp.asarray(values)
    return Motion(east, north, course, speed, age, jnp.asarray(present))


def _held(relived: Sequence[Frame], places: dict[str, int], slots: int) -> LastKnownTargets:
    """The lost ships of the last of these frames, where and when each was last there."""
    now = relived[-1]
    values, present = np.zeros((5, slots), np.float32), np.zeros(slots, bool)
    time_s = np.zeros(slots, np.float32)
    for t in now.targets:
        if t.lost:
            place = places[t.id]
            gone_s = now.time_s - _last_there_s(relived, t.id)
            age_s = max((t.age_s or 0.0) - gone_s, 0.0)
            values[:, place] = t.east_m, t.north_m, t.course_rad, t.speed_m_s, age_s
            present[place], time_s[place] = True, -gone_s
    return LastKnownTargets(_moving(values, present), jnp.asarray(time_s))


def _last_there_s(relived: Sequence[Frame], id: str) -> float:
    """When a lost ship was last there, or else the time of the first of these frames."""
    for frame in reversed(relived):
        if any(t.id == id and not t.lost for t in frame.targets):
            return frame.time_s
    return relived[0].time_s


def _own(own: Own) -> ShipState:
    """Own ship as logged; a rudder that nobody knew is taken as amidships."""
    return ShipState(
        *map(
            _scalar,
            (
                own.east_m,
                own.north_m,
                own.heading_rad,
                own.rate_of_turn_rad_s,
                own.rudder_rad or 0.0,
                own.speed_m_s,
            ),
        )
    )


def _scalar(x: float) -> Array:
    return jnp.asarray(x, jnp.float32)


def _origin(own: Own) -> tuple[float, float] | None:
    """The origin of the plane, from own ship's place on the globe and in the plane."""
    latitude, longitude = own.latitude_deg, own.longitude_deg
    if latitude is None or longitude is None:
        return None
    here = np.array([latitude]), np.array([longitude])
    origin = here
    east, north = np.array([-own.east_m]), np.array([-own.north_m])
    for _ in range(6):  # each guess misses by a thousandth of the one before, or less
        origin = LocalProjection(float(origin[0][0]), float(origin[1][0])).to_globe(east, north)
        found = LocalProjection(float(origin[0][0]), float(origin[1][0])).to_plane(*here)
        east, north = found[0] - own.east_m, found[1] - own.north_m
    return float(origin[0][0]), float(origin[1][0])


def _clock_start(frame: Frame) -> datetime | None:
    """The clock at time 0 of the log."""
    if frame.time_utc is None:
        return None
    return datetime.fromisoformat(frame.time_utc) - timedelta(seconds=frame.time_s)
