"""Scores of several pilots, the results written after each."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from glasshelm.core.compile_cache import clear_if_full
from glasshelm.core.errors import InputError
from glasshelm.core.output_dir import atomic_write
from glasshelm.core.terminal import Terminal, progress
from glasshelm.core.text import file_name
from glasshelm.evaluation.contenders import Contender
from glasshelm.evaluation.result_cache import ResultCache
from glasshelm.faithfulness.faithfulness_scores import ExplanationScores, score_explanations
from glasshelm.faithfulness.score_cache import cache_key, load_or_compute
from glasshelm.faithfulness.score_plots import scores_figure
from glasshelm.faithfulness.score_tables import scores_report
from glasshelm.figures.style import save
from glasshelm.networks.actors import AttentionActor
from glasshelm.pilots.learned import LearnedPilot

#: Encounters, scenes at most of each number of ships, numbers of ships.
ScoringSize = tuple[int, int, tuple[int, ...]]


def eligible_pilots(contenders: Sequence[Contender]) -> list[tuple[str, list[LearnedPilot]]]:
    """Each contender's name and seeds. InputError names the first that cannot be scored."""
    return [(contender.name, _seeds(contender)) for contender in contenders]


def _seeds(contender: Contender) -> list[LearnedPilot]:
    seeds = []
    for pilot in contender.pilots:
        if not isinstance(pilot, LearnedPilot):
            raise InputError(
                f"pilot {pilot.name!r} has no networks to explain, or is guarded: "
                "name a learned pilot or a .safetensors file"
            )
        if seeds and _networks(pilot) != _networks(seeds[0]):
            raise InputError(
                f"pilot {contender.name!r}: its seeds cannot be scored together: "
                f"{seeds[0].name!r} is {_networks(seeds[0])}, {pilot.name!r} is {_networks(pilot)}"
            )
        seeds.append(pilot)
    return seeds


def _networks(pilot: LearnedPilot) -> str:
    """What decides which explanations there are, in words."""
    actor = "an attention actor" if isinstance(pilot.actor, AttentionActor) else "a sum actor"
    return f"{actor} {'without a' if pilot.critic is None else 'with its'} critic"


def score_pilots(
    chosen: Sequence[tuple[str, Sequence[LearnedPilot]]],
    what: ScoringSize,
    out: Path,
    command: str,
    machine: str,
    console: Terminal,
) -> None:
    """Score the seeds of every named pilot; tables and a figure are written after each.

    The scores of each seed are kept in ``out/chunks`` and are not computed again.
    """
    text = [
        "# Faithfulness of the explanations",
        "",
        "Definitions: docs/explanation/explanations.md.",
        "",
    ]
    total, done = sum(len(seeds) for _, seeds in chosen), 0
    try:
        for name, seeds in chosen:
            scored = []
            for number, pilot in enumerate(seeds):
                result, before = _scored(name, pilot, what, out, console)
                scored.append(result)
                done += 1
                clear_if_full()
                kept = ", scored before" if before else ""
                console.say(f"{name}, seed {number}: {len(result.voyage)} scenes{kept}")
            text.append(scores_report(name, scored, command, machine))
            with atomic_write(out / "faithfulness.md") as partial:
                partial.write_text("\n".join(text), encoding="utf-8")
            save(scores_figure(scored, name), out / f"faithfulness-{file_name(name)}")
    except KeyboardInterrupt:
        console.say(
            f"interrupted: {done} of {total} pilots and seeds are kept in {out}; "
            "the same command goes on from there"
        )
        raise
    console.say(f"{out / 'faithfulness.md'}")


def _scored(
    name: str, pilot: LearnedPilot, what: ScoringSize, out: Path, console: Terminal
) -> tuple[ExplanationScores, bool]:
    with progress(console) as bar:
        task = bar.add_task(name, total=None)

        def say(doing: str, done: int, of: int) -> None:
            bar.update(task, description=doing, completed=done, total=of)

        work = partial(score_explanations, pilot, *what, say)
        return load_or_compute(work, ResultCache(out / "chunks"), cache_key(pilot, *what), pilot)
