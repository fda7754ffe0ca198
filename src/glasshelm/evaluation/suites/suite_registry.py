"""Suites by the names of the command line."""

from collections.abc import Callable, Sequence
from pathlib import Path

from glasshelm.core.errors import InputError
from glasshelm.evaluation.suites.disturbed_suite import disturbed_suites
from glasshelm.evaluation.suites.dnv_suite import situation_suite
from glasshelm.evaluation.suites.imazu_suite import imazu_suites
from glasshelm.evaluation.suites.random_suite import congested_suites, random_suite
from glasshelm.evaluation.suites.recorded_suite import recorded_suites
from glasshelm.evaluation.types import Suite
from glasshelm.ship.nomoto import ShipParams

#: Encounters where nobody gives a number: in the suite ``random``, and in every other drawn one.
RANDOM_COUNT, DRAWN_COUNT = 10_000, 1000

NAMES = "random, congested, imazu, disturbed, recorded, recorded:FILE, situations:FOLDER"


def build_suites(
    names: Sequence[str], ship: ShipParams, encounters: int | None = None
) -> list[Suite]:
    """The suites of these names for a ship; ``encounters`` sizes those that are drawn.

    ``situations:FOLDER`` takes every DNV situation of a folder, ``recorded:FILE`` an AIS
    recording (``recorded`` alone those that come with the package). InputError names
    the suites if there is none of that name.
    """
    if encounters is not None and encounters < 1:
        raise InputError(f"{encounters} encounters: must be 1 or more")
    suites: list[Suite] = []
    for name in dict.fromkeys(names):
        suites += _built(name, ship, encounters)
    if not suites:
        raise InputError(f"no suite: choose one or more of {NAMES}")
    repeated = [s.name for s in suites if [t.name for t in suites].count(s.name) > 1]
    if repeated:
        raise InputError(f"two suites are called {repeated[0]!r}: evaluate them in two folders")
    return suites


def _built(name: str, ship: ShipParams, encounters: int | None) -> list[Suite]:
    kind, colon, path = name.partition(":")
    if colon and path and kind == "situations":
        return [situation_suite(Path(path), ship)]
    if colon and path and kind == "recorded":
        return recorded_suites([Path(path)], ship)
    drawn = encounters or DRAWN_COUNT
    builds: dict[str, Callable[[], list[Suite]]] = {
        "random": lambda: [random_suite(ship, encounters or RANDOM_COUNT)],
        "congested": lambda: congested_suites(ship, drawn),
        "imazu": lambda: imazu_suites(ship),
        "disturbed": lambda: disturbed_suites(ship, drawn),
        "recorded": lambda: recorded_suites([], ship),
    }
    if name not in builds:
        raise InputError(f"unknown suite {name!r}: choose one of {NAMES}")
    return builds[name]()
