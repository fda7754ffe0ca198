"""What is evaluated: pilots on the ships that they steer, one or several training seeds each."""

import dataclasses
import functools
import hashlib
import importlib.metadata
from collections.abc import Sequence
from pathlib import Path

import equinox as eqx
import jax
import numpy as np

import glasshelm
from glasshelm.core.errors import InputError
from glasshelm.pilots.clairvoyant import ORACLE_PILOTS, OraclePilot
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.pilot_resolution import ship_of
from glasshelm.pilots.protocols import Pilot, for_ship
from glasshelm.pilots.registry import pilot_named
from glasshelm.ship.nomoto import SHIPS, ShipParams, ship_named

#: The code that decides the result of a rollout.
ROLLOUT_CODE = (
    "ais", "colregs", "core/fast_trig.py", "core/geometry.py", "encounters", "env", "evaluation",
    "explanation/manoeuvre_explanation.py", "networks", "pilots", "planning", "ship",
    "simulation/rollout.py", "simulation/sensor_model.py",
)  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Contender:
    """A pilot, or an oracle, on a ship. ``pilots`` holds one a training seed, in order."""

    name: str
    ship_name: str
    ship: ShipParams
    pilots: tuple[Pilot | OraclePilot, ...]

    @property
    def weights(self) -> tuple[str, ...]:
        """The first eight digits of each seed's weights' SHA-256; empty where there are none."""
        return tuple((getattr(p, "weights_sha256", None) or "")[:8] for p in self.pilots)


def parse_contenders(given: Sequence[str], ships: Sequence[str] = tuple(SHIPS)) -> list[Contender]:
    """The contenders named on a command line.

    Each is a pilot's name or file, or ``NAME=FILE,FILE,...`` for the training
    seeds of one pilot. A pilot that has a ship of its own is sailed on it, any
    other on each of ``ships``. InputError if a name is there twice, or the
    seeds of a pilot are on different ships.
    """
    contenders: list[Contender] = []
    for text in given:
        label, equals, files = text.partition("=")
        names = files.split(",") if equals else [text]
        if not label or not all(names):
            raise InputError(f"pilot {text!r}: write NAME=FILE,FILE,... or one name")
        pilots = tuple(ORACLE_PILOTS.get(name) or pilot_named(name) for name in names)
        name = label if equals else pilots[0].name
        for ship_name in _ships(name, pilots, ships):
            contenders.append(contender(name, ship_name, pilots))
    return check_contenders(contenders)


def contender(name: str, ship_name: str, pilots: tuple[Pilot | OraclePilot, ...]) -> Contender:
    """Pilots on a preset ship; those for any ship are given it as it is supposed to be."""
    ship = ship_named(ship_name)
    given = tuple(p if isinstance(p, OraclePilot) else for_ship(p, ship) for p in pilots)
    return Contender(name, ship_name, ship, given)


def check_contenders(contenders: list[Contender]) -> list[Contender]:
    """The same contenders; InputError if there is none, or a name is there twice on a ship."""
    if not contenders:
        raise InputError("no pilot to evaluate: name one or more")
    seen = set()
    for contender in contenders:
        key = contender.name, contender.ship_name
        if key in seen:
            raise InputError(
                f"pilot {contender.name!r} is named twice: give one a name with NAME=FILE"
            )
        seen.add(key)
    return contenders


def check_references(against: Sequence[str], among: Sequence[Contender]) -> None:
    """InputError if a name of ``against`` is neither of these contenders' nor of any pilot."""
    for name in against:
        if not any(e.name == name for e in among):
            try:
                parse_contenders([name])
            except InputError as error:
                raise InputError(f"--against: {error}") from None


def _ships(
    name: str, pilots: tuple[Pilot | OraclePilot, ...], ships: Sequence[str]
) -> Sequence[str]:
    own = {ship for pilot in pilots if (ship := ship_of(pilot)) is not None}
    if len(own) > 1:
        raise InputError(f"pilot {name!r}: its seeds were trained on {' and '.join(sorted(own))}")
    return sorted(own) or ships


def pilot_digest(pilot: Pilot | OraclePilot) -> str:
    """A SHA-256 that differs between pilots that may decide differently, whatever their names."""
    if isinstance(pilot, LearnedPilot | GlassboxPilot) and pilot.weights_sha256 is not None:
        return pilot.weights_sha256
    digest = hashlib.sha256(f"{type(pilot).__module__}.{pilot!r}".encode())
    for leaf in jax.tree.leaves(eqx.filter(pilot, eqx.is_array)):
        digest.update(np.asarray(leaf).tobytes())
    return digest.hexdigest()


@functools.cache
def code_digest(paths: tuple[str, ...] = ROLLOUT_CODE) -> str:
    """SHA-256 of the code that decides a result, and of what it is computed with.

    Raises:
        FileNotFoundError: a name that is not there would weaken the key in silence.
    """
    root = Path(glasshelm.__file__).parent
    digest = hashlib.sha256()
    for name in paths:
        path = root / name
        if not path.exists():
            raise FileNotFoundError(f"{path}: named as code that decides a result, and not there")
        for file in [path] if path.is_file() else sorted(path.rglob("*.py")):
            digest.update(file.relative_to(root).as_posix().encode() + file.read_bytes())
    for package in ("jax", "jaxlib"):
        digest.update(importlib.metadata.version(package).encode())
    return digest.hexdigest()
