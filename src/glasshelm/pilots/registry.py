"""Pilots by name: the bundled weights, weights files, and pilots that need none."""

from pathlib import Path

from glasshelm.core.errors import InputError
from glasshelm.networks.checkpoint import read_header
from glasshelm.pilots.course_pilot import CourseMethod, CoursePilot
from glasshelm.pilots.cpa_rule import CPA
from glasshelm.pilots.function_pilot import function_pilot
from glasshelm.pilots.fuzzy_risk import FUZZY
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.guarded import GUARDED, GuardedPilot
from glasshelm.pilots.learned import LearnedPilot, read_pilot
from glasshelm.pilots.potential_field import POTENTIAL
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.scenario_mpc import SCENARIOS
from glasshelm.pilots.straight import StraightPilot
from glasshelm.pilots.velocity_obstacles import VELOCITY, VELOCITY_COLREGS
from glasshelm.pilots.waypoint import WAYPOINT
from glasshelm.ship.nomoto import SHIPS

#: Who steers where nobody is named: it takes any ship, and its explanation is its decision.
DEFAULT_PILOT = "glassbox"
WEIGHTS = Path(__file__).parent.parent / "weights"
SUFFIX = ".safetensors"
#: Methods (docs/explanation/classical-pilots.md), each a pilot for each preset ship.
METHODS: dict[str, CourseMethod] = {
    "waypoint": WAYPOINT,
    "cpa": CPA,
    "vo": VELOCITY,
    "vo-colregs": VELOCITY_COLREGS,
    "apf": POTENTIAL,
    "fuzzy": FUZZY,
    "mpc": SCENARIOS,
}
#: Pilots without weights, by name: ``straight``, ``glassbox``, ``paper-cpa``, ``large-ship-mpc``, …
WITHOUT_WEIGHTS: dict[str, Pilot] = {
    "straight": StraightPilot(),
    "glassbox": GlassboxPilot(),
    **{
        name: CoursePilot(SHIPS[ship], name, method)
        for kind, method in METHODS.items()
        for ship, name in ((ship, f"{ship.replace('_', '-')}-{kind}") for ship in SHIPS)
    },
    **{
        name: GlassboxPilot(SHIPS[ship], name)
        for ship, name in ((ship, f"{ship.replace('_', '-')}-glassbox") for ship in SHIPS)
    },
}


def bundled_pilots() -> tuple[str, ...]:
    """Names of the learned pilots that ship inside the package."""
    return tuple(sorted(file.stem for file in WEIGHTS.glob(f"*{SUFFIX}")))


def guardable_pilots() -> tuple[str, ...]:
    """Those of them that an actor steers: a critic that steers looks ahead by itself."""
    headers = {name: read_header(WEIGHTS / f"{name}{SUFFIX}") for name in bundled_pilots()}
    return tuple(name for name, header in headers.items() if header.get("actor") is not None)


def pilot_names() -> tuple[str, ...]:
    """The names of all pilots that need no file.

    Returns:
        Those bundled, the same guarded, and those without weights.
    """
    return (*bundled_pilots(), *(name + GUARDED for name in guardable_pilots()), *WITHOUT_WEIGHTS)


def pilot_named(name: str | Path) -> Pilot:
    """Any pilot: a bundled name, one without weights, a .safetensors file, or package.module:f.

    A learned one's name or file followed by ``-guarded`` is it under guard.
    InputError lists the names that there are; CheckpointError tells what is
    wrong with a weights file.
    """
    if str(name) in WITHOUT_WEIGHTS:
        return WITHOUT_WEIGHTS[str(name)]
    if str(name).endswith(GUARDED):
        pilot = _with_weights(str(name).removesuffix(GUARDED), guardable_pilots())
        if not isinstance(pilot, LearnedPilot):
            raise InputError(f"pilot {pilot.name!r} cannot be guarded: it looks ahead by itself")
        return GuardedPilot(pilot)
    if ":" in str(name) and not str(name).endswith(SUFFIX):
        return function_pilot(str(name))
    return _with_weights(name, pilot_names())


def load(name: str | Path) -> LearnedPilot | GlassboxPilot:
    """A learned pilot: of an actor, or of a critic that steers.

    Args:
        name: A bundled name, or the path of a ``.safetensors`` file.

    Returns:
        The pilot.

    Raises:
        InputError: There is no pilot of that name; the message lists those that there are.
        CheckpointError: The weights file cannot be used.
    """
    return _with_weights(name, bundled_pilots())


def _with_weights(name: str | Path, known: tuple[str, ...]) -> LearnedPilot | GlassboxPilot:
    text = str(name)
    if text.endswith(SUFFIX):
        return read_pilot(Path(text), Path(text).stem)
    if text in pilot_names() and text not in bundled_pilots():
        raise InputError(f"pilot {text!r} is no learned one: glasshelm.pilot({text!r}) gives it")
    if text.endswith("-clairvoyant"):
        raise InputError(f"{text} knows the future: it can only be evaluated (glasshelm evaluate)")
    if text not in bundled_pilots():
        choices = ", ".join((*known, f"a path ending in {SUFFIX}"))
        raise InputError(f"unknown pilot {text!r}: choose one of {choices}")
    return read_pilot(WEIGHTS / f"{text}{SUFFIX}", text)
