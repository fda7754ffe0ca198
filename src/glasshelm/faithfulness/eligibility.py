"""Who can be examined: learned pilots, whose training seeds give the same explanations."""

from collections.abc import Sequence

from glasshelm.core.errors import InputError
from glasshelm.evaluation.contenders import Contender
from glasshelm.networks.actors import AttentionActor
from glasshelm.pilots.learned import LearnedPilot


def eligible_pilots(entrants: Sequence[Contender]) -> list[tuple[str, list[LearnedPilot]]]:
    """Each entrant's name and seeds. InputError names the first that cannot be examined."""
    return [(entrant.name, _seeds(entrant)) for entrant in entrants]


def _seeds(entrant: Contender) -> list[LearnedPilot]:
    seeds = []
    for pilot in entrant.pilots:
        if not isinstance(pilot, LearnedPilot):
            raise InputError(
                f"pilot {pilot.name!r} has no networks to explain, or is guarded: "
                "name a learned pilot or a .safetensors file"
            )
        if seeds and _made_of(pilot) != _made_of(seeds[0]):
            raise InputError(
                f"pilot {entrant.name!r}: its seeds cannot be examined together: "
                f"{seeds[0].name!r} is {_made_of(seeds[0])}, {pilot.name!r} is {_made_of(pilot)}"
            )
        seeds.append(pilot)
    return seeds


def _made_of(pilot: LearnedPilot) -> str:
    """What decides which explanations there are, in words."""
    actor = "an attention actor" if isinstance(pilot.actor, AttentionActor) else "a sum actor"
    return f"{actor} {'without a' if pilot.critic is None else 'with its'} critic"
