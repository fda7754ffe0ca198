"""Every figure of the paper: drawn, or kept from an earlier run, with what it shows in numbers."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import equinox as eqx
import jax
from matplotlib.figure import Figure

from glasshelm.core.output_dir import atomic_write
from glasshelm.core.text import file_name
from glasshelm.encounters.random_encounters import PAPER
from glasshelm.evaluation.contenders import code_digest
from glasshelm.figures.coloured_tracks import attention, intention, value_panels
from glasshelm.figures.intention_histories import histories
from glasshelm.figures.learning_curves import learning_curves
from glasshelm.figures.network_diagrams import actor_flow, critic_flow
from glasshelm.figures.priorities import at_instants, over_time
from glasshelm.figures.scene_diagrams import closest_point, domain_shape, initial_state, ship_motion
from glasshelm.figures.style import as_svg, save
from glasshelm.figures.trajectories import absolute_panels, relative_panels
from glasshelm.frames.series import Series
from glasshelm.networks.actors import AttentionActor, SumActor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.paper import findings
from glasshelm.paper.kept_results import KeptResults, digest_of
from glasshelm.paper.paper_voyages import Progress, SteeringPilot, voyage_digest
from glasshelm.paper.training_records import learning_curve, weights_path
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.config import preset_named

#: The instants of Figure 11 [s].
INSTANTS_S = (600.0, 750.0)
#: The number of what the paper does not have: how pilots learned.
LEARNING = "learning"
_CODE = ("core", "encounters", "env", "figures", "frames", "networks", "paper", "ship", "training")
_NO_CRITIC = "this pilot has no critic, so there are no values or priorities."


@dataclasses.dataclass(frozen=True)
class MadeFigure:
    """A figure that was made, or why it was not.

    Attributes:
        number: As the paper numbers it, or :data:`LEARNING`.
        stem: Name of its files.
        pilot: Who steered; None of a diagram.
        path: The SVG file; None if the pilot does not give what the figure shows.
        text: What it shows, with numbers, or why it is missing.
    """

    number: str
    stem: str
    pilot: SteeringPilot | None
    path: Path | None
    text: str


class Drawing:
    """Draws figures into files, and keeps those of which nothing has changed.

    Args:
        kept: Where the files are.
        total: How many figures there will be.
        progress: Called before each.
    """

    def __init__(self, kept: KeptResults, total: int, progress: Progress):
        self._kept, self._progress, self._total, self._done = kept, progress, total, 0
        self._code = code_digest(_CODE)

    def make(
        self,
        number: str,
        draw: Callable[[], Figure | None],
        text: Callable[[], str] = str,
        pilot: SteeringPilot | None = None,
        sources: Sequence[str] = (),
        variant: str = "",
        missing: str = _NO_CRITIC,
        depends: str = "",
    ) -> MadeFigure:
        """One figure: of a diagram, or of a pilot's voyages.

        Args:
            number: As the paper numbers it.
            draw: Draws it; None where the pilot does not give what it shows.
            text: Says what it shows.
            pilot: Who steered.
            sources: The encounters.
            variant: Where one number has several figures.
            missing: Why there may be none.
            depends: What else it depends on.
        """
        name = f"{number.zfill(2)}{variant}" + (
            "" if pilot is None else f"-{file_name(pilot.name)}"
        )
        self._progress(f"drawing figure {number}", self._done, self._total)
        self._done += 1
        path = self._kept.folder / "figures" / f"{name}.svg"
        voyages = [voyage_digest(pilot, s) for s in sources] if pilot else []
        digest = digest_of(self._code, depends, *voyages)
        if not self._kept.has(f"figures/{name}", digest, path):
            figure = draw()
            if figure is None:
                return MadeFigure(number, name, pilot, None, missing)
            save(figure, path.with_suffix(""))
            with atomic_write(path) as partial:
                partial.write_bytes(as_svg(figure))
            self._kept.add(f"figures/{name}", digest)
        return MadeFigure(number, name, pilot, path, text())


def diagrams(drawing: Drawing) -> Iterator[MadeFigure]:
    """Figures 1-6 and 12, from the numbers of the preset ``paper``."""
    preset, key = preset_named("paper"), jax.random.key(0)
    ship = SHIPS[preset.ship]
    one_ship = dataclasses.replace(PAPER, targets=(1, 1))

    def shape(kind, sizes):
        return eqx.filter_eval_shape(kind, sizes, key)

    yield drawing.make("1", lambda: ship_motion(SHIPS))
    yield drawing.make("2", lambda: initial_state(ship, one_ship))
    yield drawing.make("3", lambda: closest_point(ship))
    yield drawing.make("4", lambda: domain_shape(ship))
    yield drawing.make("5", lambda: critic_flow(shape(SubTaskCritic, preset.critic_sizes)))
    yield drawing.make("6", lambda: actor_flow(shape(SumActor, preset.actor_sizes)))
    yield drawing.make("12", lambda: actor_flow(shape(AttentionActor, preset.actor_sizes)))


def track_figures(
    drawing: Drawing,
    pilot: SteeringPilot,
    voyages: Sequence[Series],
    sources: Sequence[str],
    fourth: int,
) -> Iterator[MadeFigure]:
    """Figures 7-9 of all voyages of a pilot, 10-11 of one of them."""
    one = voyages[fourth]
    yield drawing.make(
        "7", lambda: absolute_panels(voyages), lambda: findings.of_tracks(voyages), pilot, sources
    )
    yield drawing.make("8", lambda: relative_panels(voyages), str, pilot, sources)
    yield drawing.make(
        "9", lambda: value_panels(voyages), lambda: findings.of_values(voyages), pilot, sources
    )
    yield drawing.make(
        "10", lambda: over_time(one, INSTANTS_S), str, pilot, sources[fourth : fourth + 1]
    )
    yield drawing.make(
        "11",
        lambda: at_instants(one, INSTANTS_S),
        lambda: findings.of_priorities(one, INSTANTS_S),
        pilot,
        sources[fourth : fourth + 1],
    )


def attention_figures(
    drawing: Drawing, pilot: SteeringPilot, voyage: Series, source: str
) -> Iterator[MadeFigure]:
    """Figures 13-15 of a voyage of a pilot with attention."""
    missing = "there is no other ship, or the pilot has no critic."
    figures = (
        ("13", "", lambda: attention(voyage), lambda: findings.of_attention(voyage)),
        ("14", "-increment", lambda: intention(voyage), lambda: findings.of_intention(voyage)),
        ("14", "-level", lambda: intention(voyage, level=True), str),
        ("15", "", lambda: histories(voyage), lambda: findings.of_histories(voyage)),
    )
    for number, variant, draw, text in figures:
        yield drawing.make(number, draw, text, pilot, (source,), variant, missing)


def learning_figure(
    drawing: Drawing, names: Sequence[str], pilots: Sequence[SteeringPilot]
) -> MadeFigure:
    """How the learned pilots learned; the paper has no such figure."""
    learned = [
        (n, p) for n, p in zip(names, pilots, strict=True) if isinstance(p.pilot, LearnedPilot)
    ]
    curves = [c for n, p in learned if (c := learning_curve(weights_path(n), p.name)) is not None]
    without = [p.name for p in pilots if p.name not in {c.name for c in curves}]
    text = "The last point of a line is not always the pilot: the best validation is kept."
    if without:
        text += f" No record of learning: {', '.join(without)}."
    return drawing.make(
        LEARNING,
        lambda: learning_curves(curves) if curves else None,
        lambda: text,
        missing="no pilot has a record of its learning.",
        depends=" ".join(p.digest for p in pilots),
    )
