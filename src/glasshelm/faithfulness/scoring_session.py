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
from glasshelm.faithfulness.subjects import ManoeuvreSubject, Subject, subject_of
from glasshelm.figures.style import save
from glasshelm.networks.actors import AttentionActor
from glasshelm.pilots.protocols import Pilot

#: Encounters, scenes at most of each number of ships, numbers of ships.
ScoringSize = tuple[int, int, tuple[int, ...]]


def eligible_pilots(contenders: Sequence[Contender]) -> list[tuple[str, list[Pilot]]]:
    """Each contender's name and seeds. InputError names the first that cannot be scored."""
    return [(contender.name, _seeds(contender)) for contender in contenders]


def _seeds(contender: Contender) -> list[Pilot]:
    first, kind = contender.pilots[0].name, ""
    for pilot in contender.pilots:
        subject = subject_of(pilot)
        if subject is None:
            raise InputError(
                f"pilot {pilot.name!r} does not explain its own decisions, or is guarded: name a "
                "learned pilot, one that chooses manoeuvres (paper-glassbox) or a .safetensors file"
            )
        kind = kind or _kind(subject)
        if _kind(subject) != kind:
            raise InputError(
                f"pilot {contender.name!r}: its seeds cannot be scored together: "
                f"{first!r} is {kind}, {pilot.name!r} is {_kind(subject)}"
            )
    return [pilot for pilot in contender.pilots if isinstance(pilot, Pilot)]


def _kind(subject: Subject) -> str:
    """What decides which explanations there are, in words."""
    if isinstance(subject, ManoeuvreSubject):
        return "a pilot that chooses manoeuvres"
    actor = "an attention actor" if isinstance(subject.actor, AttentionActor) else "a sum actor"
    return f"{actor} {'without a' if subject.critic is None else 'with its'} critic"


def score_pilots(
    chosen: Sequence[tuple[str, Sequence[Pilot]]],
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
    name: str, pilot: Pilot, what: ScoringSize, out: Path, console: Terminal
) -> tuple[ExplanationScores, bool]:
    with progress(console) as bar:
        task = bar.add_task(name, total=None)

        def say(doing: str, done: int, of: int) -> None:
            bar.update(task, description=doing, completed=done, total=of)

        work = partial(score_explanations, pilot, *what, say)
        return load_or_compute(work, ResultCache(out / "chunks"), cache_key(pilot, *what), pilot)
