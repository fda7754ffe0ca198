"""Suites by the names of the command line."""

from collections.abc import Callable, Sequence

from glasshelm.errors import InputError
from glasshelm.evaluation.suites.imazu import imazu_suites
from glasshelm.evaluation.suites.random import congested_suites, random_suite
from glasshelm.evaluation.types import Suite
from glasshelm.ships import ShipParams

#: Encounters where nobody gives a number: in the suite ``random``, and in every other drawn one.
RANDOM_COUNT, DRAWN_COUNT = 10_000, 1000

_Build = Callable[[ShipParams, int | None], list[Suite]]
SUITES: dict[str, _Build] = {
    "random": lambda ship, count: [random_suite(ship, count or RANDOM_COUNT)],
    "congested": lambda ship, count: congested_suites(ship, count or DRAWN_COUNT),
    "imazu": lambda ship, count: imazu_suites(ship),
}


def suites_named(
    names: Sequence[str], ship: ShipParams, encounters: int | None = None
) -> list[Suite]:
    """The suites of these names for a ship; ``encounters`` sizes those that are drawn.

    InputError names the suites if there is none of that name.
    """
    if encounters is not None and encounters < 1:
        raise InputError(f"{encounters} encounters: must be 1 or more")
    found: list[Suite] = []
    for name in dict.fromkeys(names):
        if name not in SUITES:
            raise InputError(f"unknown suite {name!r}: choose one of {', '.join(SUITES)}")
        found += SUITES[name](ship, encounters)
    if not found:
        raise InputError(f"no suite: choose one or more of {', '.join(SUITES)}")
    return found
