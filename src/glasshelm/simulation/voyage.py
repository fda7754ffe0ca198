"""Simulation: a scenario and a pilot become a stream of frames."""

import dataclasses
from collections.abc import Iterator
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from glasshelm.ais.limits import LOST_SHOWN_S
from glasshelm.core.errors import InputError
from glasshelm.core.geometry import wrap_angle
from glasshelm.encounters.types import Encounter, Motion, Scenario, Track, motion_at
from glasshelm.env.padding import bucket_size
from glasshelm.env.rewards import Reward
from glasshelm.env.step import EnvSettings, EnvState, observe_step, reset, step
from glasshelm.env.target_selection import MAX_TARGETS
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Memory, Pilot, check_pilot
from glasshelm.ship.nomoto import ShipParams, ShipState
from glasshelm.simulation.explained_step import (
    ExplainedStep,
    LastKnownTargets,
    explain_step,
    no_known_targets,
)
from glasshelm.simulation.frame_builder import FrameBuilder

#: Ticks that one call of the compiled program makes: fewer calls, the same frames.
_CHUNK = 16

Tree = TypeVar("Tree")


class Carry(eqx.Module):
    """What one tick hands to the next."""

    state: EnvState
    held: LastKnownTargets
    memory: Memory


@dataclasses.dataclass(frozen=True)
class VoyageCheckpoint:
    """Where a voyage stands: before its frame ``number``, of which ``final`` is the last.

    ``pilot`` will decide there; ``reward`` is that of the step that led here.
    """

    number: int
    final: int
    pilot: Pilot
    carry: Carry
    reward: Reward | None = None


def simulate(
    scenario: Scenario,
    pilot: Pilot,
    steps: int | None = None,
    advise: bool = False,
    settings: EnvSettings = EnvSettings(),
    lost_shown_s: float = LOST_SHOWN_S,
) -> Iterator[Frame]:
    """The frames of a voyage: one at the start and one after each step.

    Of more targets than a pilot is shown, the most urgent are chosen
    (:func:`glasshelm.env.target_selection.select_targets`).

    Args:
        scenario: The encounter.
        pilot: Who decides.
        steps: By default what fits into the scenario's duration. A voyage ends early where the
            last waypoint is reached.
        advise: Own ship keeps its recorded track, and the pilot only advises; the rate of turn
            is then the difference of the courses over a step.
        settings: Of the decision process.
        lost_shown_s: How long a lost AIS target stays in the frames, where it was last.

    Returns:
        An iterator; frames are computed as it goes.

    Raises:
        InputError: There is no track to keep, steps are negative, or what the pilot is shown or
            decides is not a number.
    """
    check_pilot(pilot)
    if not isinstance(scenario, Scenario):
        raise InputError(f"{scenario!r} is no scenario: glasshelm.scenario(...) gives one")
    steps = steps_of(scenario, steps, settings)
    if advise and scenario.own_track is None:
        raise InputError(
            f"{scenario.source}: --advise needs a recorded own ship, and this source has none"
        )
    return _simulated(scenario, pilot, steps, advise, settings, lost_shown_s)


def steps_of(
    scenario: Scenario, steps: int | None = None, settings: EnvSettings = EnvSettings()
) -> int:
    """The steps that were asked for, or those that fit into the scenario's duration."""
    if steps is None:
        return int(scenario.duration_s / settings.step_s + 1e-6)
    if steps < 0:
        raise InputError(f"{steps} steps: must be 0 or more")
    return steps


def _simulated(
    scenario: Scenario,
    pilot: Pilot,
    steps: int,
    advise: bool,
    settings: EnvSettings,
    lost_shown_s: float,
) -> Iterator[Frame]:
    voyage = Voyage(scenario, pilot, steps, advise, settings, lost_shown_s)
    while frames := voyage.advance(_CHUNK):
        yield from frames


class Voyage:
    """A voyage under way: it gives its next frames when asked, and can change pilots in between.

    ``place`` is where it stands; a place that was kept can be gone back to. The
    arguments are those of :func:`simulate`.
    """

    def __init__(
        self,
        scenario: Scenario,
        pilot: Pilot,
        steps: int,
        advise: bool = False,
        settings: EnvSettings = EnvSettings(),
        lost_shown_s: float = LOST_SHOWN_S,
    ):
        self.scenario, self.steps, self.advise, self.settings = scenario, steps, advise, settings
        #: Traced, not compiled in: recordings whose ships differ share their programs.
        self.ship: ShipParams = jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), scenario.ship)
        self._lost_shown_s = lost_shown_s
        self.encounter, self._kept = padded_encounter(scenario.encounter), None
        if advise and scenario.own_track is not None:
            self._kept = recorded_own(scenario.own_track, steps + _CHUNK, settings)
            self.encounter = eqx.tree_at(lambda e: e.own, self.encounter, _at(self._kept, 0))
        self.place = VoyageCheckpoint(
            0, steps, pilot, init_carry(self.encounter, self.ship, settings, pilot)
        )

    def change_pilot(self, pilot: Pilot) -> None:
        """From the next frame on this pilot decides, without a memory of what was before."""
        carry = self.place.carry
        fresh = Carry(carry.state, carry.held, pilot.start())
        self.place = dataclasses.replace(self.place, pilot=pilot, carry=fresh)

    def advance(self, ticks: int = 1) -> list[Frame]:
        """The next frames, at most ``ticks``; none where the voyage is over.

        One program is compiled for each number of ticks.
        """
        place = self.place
        first, left = place.number, place.final + 1 - place.number
        if left <= 0:
            return []
        own = None
        if self._kept is not None:
            own = _at(self._kept, slice(first + 1, first + 1 + ticks))
        pilot, settings = place.pilot, self.settings
        framer = FrameBuilder(self.scenario, pilot, applied=not self.advise)
        carry, told = _chunk(
            pilot, self.encounter, place.carry, own, self.ship, settings, self._lost_shown_s, ticks
        )
        told = jax.device_get(told)
        frames, reward, final = [], place.reward, place.final
        for number in range(first, first + min(ticks, left)):
            tick = _at(told, number - first)
            frames.append(framer.frame(tick.moment, number * settings.step_s, reward))
            if number == final:
                break
            reward = tick.reward
            if tick.ended:
                final = number + 1
        self.place = VoyageCheckpoint(first + len(frames), final, pilot, carry, reward)
        return frames


class _Tick(eqx.Module):
    """A moment, and what the step after it brought."""

    moment: ExplainedStep
    reward: Reward
    ended: Bool[Array, ""]


@eqx.filter_jit
def init_carry(
    encounter: Encounter, ship: ShipParams, settings: EnvSettings, pilot: Pilot
) -> Carry:
    """Before the first tick of an encounter."""
    return Carry(reset(encounter, ship, settings), no_known_targets(encounter), pilot.start())


@eqx.filter_jit
def _chunk(
    pilot: Pilot,
    encounter: Encounter,
    carry: Carry,
    own: ShipState | None,
    ship: ShipParams,
    settings: EnvSettings,
    lost_shown_s: float,
    ticks: int,
) -> tuple[Carry, _Tick]:
    """So many ticks; ``own`` [ticks] is where a recorded own ship is after each."""

    def tick(carry: Carry, own: ShipState | None) -> tuple[Carry, _Tick]:
        state = carry.state
        moment, held, memory = explain_step(
            pilot, encounter, state, carry.held, carry.memory, ship, settings, lost_shown_s
        )
        if own is None:
            rudder = moment.decision.rudder * ship.rudder_limit_rad
            outcome = step(encounter, state, rudder, ship, settings)
        else:
            outcome = observe_step(encounter, state, own, ship, settings)
        following = Carry(outcome.state, held, memory)
        return following, _Tick(moment, outcome.reward, outcome.terminated)

    return jax.lax.scan(tick, carry, own, length=ticks)


def recorded_own(track: Track, steps: int, settings: EnvSettings) -> ShipState:
    """A recorded own ship at every step [steps + 1]: dead-reckoned, also through gaps.

    Her heading is her course; her rate of turn its difference over the step
    before (at the start: the step after).
    """
    unending = eqx.tree_at(lambda t: t.end_s, track, jnp.full_like(track.end_s, jnp.inf))
    times = settings.step_s * jnp.arange(steps + 2)
    motion: Motion = jax.vmap(lambda t: motion_at(unending, t))(times)
    turn = wrap_angle(jnp.diff(motion.course_rad)) / settings.step_s
    count = steps + 1
    rate = jnp.concatenate([turn[:1], turn[: count - 1]])
    return ShipState(
        motion.east_m[:count],
        motion.north_m[:count],
        motion.course_rad[:count],
        rate,
        jnp.zeros(count),
        motion.speed_m_s[:count],
    )


def _at(tree: Tree, index: int | slice) -> Tree:
    return jax.tree.map(lambda x: x[index], tree)


def padded_encounter(encounter: Encounter) -> Encounter:
    """The same encounter with slots and legs rounded up, so that few programs are compiled.

    Added slots hold nobody, added legs never start.
    """
    slots, legs = encounter.targets.start_s.shape
    wide = bucket_size(slots)
    if slots <= MAX_TARGETS:
        wide = min(
            wide, MAX_TARGETS
        )  # so few ships are all selected; empty slots must not change that
    extra = ((0, wide - slots), (0, bucket_size(legs) - legs))

    def pad(values: Any, empty: float) -> Any:
        return jnp.asarray(np.pad(np.asarray(values), extra, constant_values=empty))

    t = encounter.targets
    track = Track(
        pad(t.start_s, np.inf),
        pad(t.end_s, np.inf),
        pad(t.east_m, 0.0),
        pad(t.north_m, 0.0),
        pad(t.course_rad, 0.0),
        pad(t.speed_m_s, 0.0),
    )
    present = jnp.asarray(np.pad(np.asarray(encounter.present), extra[0]))
    return Encounter(encounter.own, encounter.route, track, present)
