"""Random encounters (Eq. 8-9): straight runners that would meet own ship.

``PAPER`` is the paper's distribution with the spawn rule of docs/explanation/paper.md;
``WIDE`` contains it and adds starts that the paper's never shows (ships abeam
or astern from 1.5 km, near waypoints, own ship off her course), so that a
pilot trained on it has met what Imazu cases and real traffic look like;
``CONVERGING`` is the part of it in which all ships go much the same way as own
ship and close on her slowly, from one side or from both.
"""

import dataclasses
import math
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from glasshelm.core.errors import InputError
from glasshelm.core.geometry import Vector, to_body, velocity
from glasshelm.encounters.types import Encounter, Scenario, TargetInfo, straight_track
from glasshelm.ship.domain import danger_unclipped
from glasshelm.ship.nomoto import ShipParams, ShipState


@dataclasses.dataclass(frozen=True)
class RandomEncounters:
    """The distribution of Eq. 8-9. SI units; ranges are uniform [low, high]."""

    target_speed_m_s: tuple[float, float] = (4.1, 6.2)
    collision_course_rad: tuple[float, float] = (-math.radians(150), math.radians(150))
    time_to_collision_s: tuple[float, float] = (600.0, 1800.0)
    position_noise_m: float = 1000.0
    course_noise_rad: float = math.radians(30)
    targets: tuple[int, int] = (0, 6)
    #: A spawn nearer than this many ship lengths is redrawn (7·LOA = 2.38 km).
    nearest_spawn_loa: float = 7.0
    #: A spawn is redrawn unless Eq. 13, unclipped, is below this (0: on the domain).
    spawn_danger: float = 0.0
    waypoint_m: tuple[float, float] = (46_300.0, 46_300.0)
    #: Own ship starts up to this far off the course to the waypoint.
    own_heading_rad: float = 0.0

    @property
    def slots(self) -> int:
        return self.targets[1]


PAPER = RandomEncounters()
WIDE = RandomEncounters(
    target_speed_m_s=(3.0, 7.0),
    collision_course_rad=(-math.pi, math.pi),
    time_to_collision_s=(500.0, 2000.0),
    nearest_spawn_loa=5.5,
    spawn_danger=-0.3,
    waypoint_m=(10_000.0, 46_300.0),
    own_heading_rad=math.radians(20),
)

CONVERGING = dataclasses.replace(
    WIDE,
    collision_course_rad=(-math.radians(45), math.radians(45)),
    time_to_collision_s=(900.0, 2000.0),
    position_noise_m=300.0,
    course_noise_rad=math.radians(5),
)
#: Distributions that a source string can name: ``random:7``, ``wide:7``, ``converging:7``.
FAMILIES = {"random": PAPER, "wide": WIDE, "converging": CONVERGING}
#: Seed of :func:`validation_encounters`; no training draws from it.
VALIDATION_SEED = 20_240_501


def random_encounter(
    key: PRNGKeyArray,
    ship: ShipParams,
    settings: RandomEncounters = PAPER,
    count: int | Int[Array, ""] | None = None,
) -> Encounter:
    """One random encounter of ``count`` ships (default: a draw from ``settings.targets``).

    Own ship starts at the origin on (about) north, the waypoint lies due north.
    A target is placed where it would collide with own ship after t_col if both
    kept straight on (Eq. 8), then moved by noise (Eq. 9).

    Args:
        key: Of the random numbers.
        ship: Own ship.
        settings: The distribution.
        count: Targets; at most ``settings.slots``.

    Returns:
        An encounter of ``settings.slots`` slots.

    Raises:
        InputError: ``count`` is a number that does not fit.
    """
    if isinstance(count, int) and not 0 <= count <= settings.slots:
        raise InputError(f"{count} ships: from 0 to {settings.slots} fit into these settings")
    count_key, ships_key, waypoint_key, heading_key = jax.random.split(key, 4)
    low, high = settings.targets
    if count is None:
        count = jax.random.randint(count_key, (), low, high + 1)
    off = settings.own_heading_rad
    heading = jax.random.uniform(heading_key, (), minval=-off, maxval=off)
    own = ShipState.steady(0.0, 0.0, heading, ship.speed_m_s)
    east, north, course, speed = jax.vmap(lambda k: _spawn(k, ship, own, settings))(
        jax.random.split(ships_key, high)
    )
    near, far = settings.waypoint_m
    waypoint = jax.random.uniform(waypoint_key, (1,), minval=near, maxval=far)
    return Encounter(
        own,
        Vector(jnp.zeros(1), waypoint),
        straight_track(east, north, course, speed),
        jnp.arange(high) < count,
    )


@partial(jax.jit, static_argnames=("size", "settings"))
def random_encounters(
    key: PRNGKeyArray, size: int, ship: ShipParams, settings: RandomEncounters = PAPER
) -> Encounter:
    """A batch of ``size`` independent random encounters."""
    keys = jax.random.split(key, size)
    return jax.vmap(lambda k: random_encounter(k, ship, settings))(keys)


def validation_encounters(
    ship: ShipParams, size: int = 256, settings: RandomEncounters = PAPER
) -> Encounter:
    """The fixed batch of random encounters on which pilots are validated and explained."""
    return random_encounters(jax.random.key(VALIDATION_SEED), size, ship, settings)


def random_scenario(seed: int, ship: ShipParams, settings: RandomEncounters = PAPER) -> Scenario:
    """The random encounter of one seed, with names, its empty slots dropped.

    ``source`` says what draws it again (:func:`source_name`).
    """
    encounter = jax.jit(random_encounter, static_argnums=2)(jax.random.key(seed), ship, settings)
    count = int(encounter.present.sum())
    kept = jax.tree.map(lambda x: x[:count], encounter.targets)
    return Scenario(
        source=source_name(seed, settings),
        title=f"Random encounter {seed}: {count} {'ship' if count == 1 else 'ships'}",
        encounter=Encounter(encounter.own, encounter.route, kept, encounter.present[:count]),
        targets=tuple(TargetInfo(str(i + 1), f"ship {i + 1}") for i in range(count)),
        ship=ship,
        duration_s=2400.0,
    )


def source_name(seed: int, settings: RandomEncounters = PAPER) -> str:
    """What draws an encounter again: ``random:7``, ``wide:7``, ``random:7:3`` for exactly 3 ships.

    Of settings that no string names, the fields in which they differ from ``PAPER``.
    """
    ships = settings.targets[1]
    for family, named in FAMILIES.items():
        if settings == named:
            return f"{family}:{seed}"
        if settings == dataclasses.replace(named, targets=(ships, ships)):
            return f"{family}:{seed}:{ships}"
    own, paper = dataclasses.asdict(settings), dataclasses.asdict(PAPER)
    changed = ", ".join(f"{name}={own[name]}" for name in own if own[name] != paper[name])
    return f"random:{seed} with {changed}"


def _spawn(
    key: PRNGKeyArray, ship: ShipParams, own: ShipState, settings: RandomEncounters
) -> tuple[Float[Array, ""], ...]:
    """East, north, course, speed of one target, redrawn until it is far enough off."""

    def draw(k: PRNGKeyArray) -> tuple[Float[Array, ""], ...]:
        speed_key, course_key, time_key, noise_key, turn_key = jax.random.split(k, 5)
        speed = _between(speed_key, settings.target_speed_m_s)
        meeting_course = _between(course_key, settings.collision_course_rad)
        t_col = _between(time_key, settings.time_to_collision_s)
        own_v = velocity(own.heading_rad, own.speed_m_s)
        target_v = velocity(meeting_course, speed)
        noise = settings.position_noise_m * jax.random.uniform(noise_key, (2,), minval=-1, maxval=1)
        turn = settings.course_noise_rad * jax.random.uniform(turn_key, (), minval=-1, maxval=1)
        east = own.east_m + t_col * (own_v.x - target_v.x) + noise[0]  # Eq. 8 + Eq. 9
        north = own.north_m + t_col * (own_v.y - target_v.y) + noise[1]
        return east, north, meeting_course + turn, speed

    def too_near(candidate: tuple[Float[Array, ""], ...]) -> Bool[Array, ""]:
        offset = Vector(candidate[0] - own.east_m, candidate[1] - own.north_m)
        near = jnp.hypot(*offset) < settings.nearest_spawn_loa * ship.loa_m
        body = to_body(offset, own.heading_rad)
        return near | (danger_unclipped(body, ship.loa_m) > settings.spawn_danger)

    def redraw(carry: tuple[PRNGKeyArray, tuple[Float[Array, ""], ...]]):
        k, _ = carry
        next_key, draw_key = jax.random.split(k)
        return next_key, draw(draw_key)

    first_key, rest_key = jax.random.split(key)
    _, chosen = jax.lax.while_loop(
        lambda carry: too_near(carry[1]), redraw, (rest_key, draw(first_key))
    )
    return chosen


def _between(key: PRNGKeyArray, limits: tuple[float, float]) -> Float[Array, ""]:
    return jax.random.uniform(key, (), minval=limits[0], maxval=limits[1])
