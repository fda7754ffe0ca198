"""Everything that ``glasshelm explain`` leaves behind: figures as files and the report."""

from collections.abc import Callable, Sequence
from pathlib import Path

from glasshelm.core.errors import InputError
from glasshelm.core.output_dir import atomic_write
from glasshelm.core.text import printable
from glasshelm.figures.gallery import FIGURES, why_missing
from glasshelm.figures.style import as_svg, save
from glasshelm.frames.series import Frames, to_series
from glasshelm.report.html_page import html_page
from glasshelm.report.narrative import narrate


def write_report(
    frames: Frames,
    folder: Path,
    title: str | None = None,
    notes: Sequence[str] = (),
    progress: Callable[[str, float], None] = lambda name, share: None,
) -> Path:
    """Write ``figures/*.pdf``, ``figures/*.png`` and ``report.html`` into a folder.

    Returns the report's path. A figure that fails is listed under "Not drawn". ``progress``
    receives the figure being drawn and the share done. InputError if the folder cannot be
    written or there are no frames.
    """
    voyage = to_series(frames)
    drawn, missing = [], []
    try:
        (folder / "figures").mkdir(parents=True, exist_ok=True)
        for number, spec in enumerate(FIGURES):
            progress(spec.title, number / len(FIGURES))
            try:
                figure = spec.draw(voyage)
                if figure is None:
                    missing.append(why_missing(spec, voyage))
                    continue
                save(figure, folder / "figures" / spec.stem)
                drawn.append((spec, as_svg(figure), float(figure.get_figwidth())))
            except OSError:
                raise
            except Exception as error:  # the other figures and the story are worth having
                why = f"{type(error).__name__}: {error}"
                missing.append(printable(f"{spec.title}: not drawn, it failed ({why})."))
        first = voyage.frames[0]
        told = html_page(
            voyage,
            title or f"{first.source}, steered by {first.pilot}",
            narrate(voyage),
            drawn,
            missing,
            notes,
        )
        path = folder / "report.html"
        with atomic_write(path) as partial:
            partial.write_text(told, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{folder}: cannot write the report there ({error.strerror})") from None
    progress("report", 1.0)
    return path
