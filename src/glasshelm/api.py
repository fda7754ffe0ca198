"""What the commands do, as functions; their names are at the root of the package."""

import dataclasses
import tempfile
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from glasshelm.core.errors import InputError
from glasshelm.encounters.scenario_factory import recording_settings, scenario_from
from glasshelm.encounters.types import Scenario
from glasshelm.pilots.glassbox import GlassboxPilot
from glasshelm.pilots.learned import LearnedPilot
from glasshelm.pilots.pilot_resolution import DEFAULT_SHIP, ship_of
from glasshelm.pilots.protocols import Pilot
from glasshelm.pilots.registry import load, pilot_named
from glasshelm.ship.nomoto import ShipParams, ship_named

if TYPE_CHECKING:
    from glasshelm.evaluation.contenders import Contender
    from glasshelm.evaluation.evaluation_run import EvaluationResult


def pilot(name: str | Path) -> Pilot:
    """Any pilot by its name.

    Args:
        name: A bundled name (``paper-attention``), the same followed by ``-guarded``, a pilot
            without weights (``glassbox``, ``straight``, ``large-ship-mpc``), a ``.safetensors``
            file, or ``package.module:function``, which imports and so runs that module.

    Returns:
        The pilot.

    Raises:
        InputError: There is no such pilot; the message lists those that there are.
    """
    return pilot_named(name)


def scenario(
    source: str,
    ship: str | ShipParams = DEFAULT_SHIP,
    own: int | str | None = None,
    at: str | datetime | None = None,
    minutes: float | None = None,
) -> Scenario:
    """The scenario that one string names.

    Args:
        source: ``imazu:5``, ``random:35``, ``random:7:3`` (three ships), ``wide:7``,
            ``converging:7``, a bundled recording (``gulf-of-finland``, ``new-york``), or a file:
            a DNV traffic situation (json), a table of AIS (csv, parquet), sentences (nmea).
        ship: Own ship: a preset's name or its parameters.
        own: In a recording, the MMSI of the ship to take as own ship.
        at: In a recording, the time to begin (UTC).
        minutes: In a recording, how much of it to read.

    Returns:
        The encounter, with what people want to know of it.

    Raises:
        InputError: There is no such source, or it cannot be used.
    """
    params = ship_named(ship) if isinstance(ship, str) else ship
    return scenario_from(source, params, own, at, recording_settings(minutes))


def evaluate(
    pilots: Sequence[str | Pilot],
    suites: Sequence[str] = ("random", "imazu"),
    encounters: int | None = None,
    out: str | Path | None = None,
    ship: str = DEFAULT_SHIP,
) -> "EvaluationResult":
    """Put pilots through suites of encounters, in this process.

    Args:
        pilots: Names as for :func:`pilot`, or pilots.
        suites: ``random``, ``congested``, ``imazu``, ``disturbed``, ``recorded``,
            ``recorded:FILE``, ``situations:FOLDER``.
        encounters: Of each drawn suite; by default random 10,000, others 1,000.
        out: Where finished chunks are kept, so that another call goes on from there; by default
            nothing is kept.
        ship: For pilots that have no ship of their own.

    Returns:
        The measures of every voyage, of which
        :func:`glasshelm.evaluation.result_report.markdown_report` makes tables.

    Raises:
        InputError: No pilot, an unknown pilot or suite, a pilot named twice, or one that gives no
            number.
    """
    from glasshelm.evaluation.contenders import check_contenders
    from glasshelm.evaluation.evaluation_run import evaluate as evaluate_contenders

    if isinstance(pilots, str) or isinstance(suites, str):
        raise InputError("pilots and suites are lists: write ['straight'], not 'straight'")
    contenders = check_contenders([_contender(given, ship) for given in pilots])
    with tempfile.TemporaryDirectory() as folder:
        kept = Path(folder if out is None else out)
        return evaluate_contenders(contenders, suites, kept, "glasshelm.evaluate", encounters)


def _contender(given: str | Pilot, ship: str) -> "Contender":
    from glasshelm.evaluation.contenders import contender, parse_contenders

    if isinstance(given, str):
        return parse_contenders([given], [ship])[0]
    return contender(given.name, ship_of(given) or ship, (given,))


def train(
    preset: str = "fast",
    out: str | Path = "runs/pilot",
    minutes: float | None = None,
    seed: int = 0,
    settings: Sequence[str] = (),
    resume: bool = False,
) -> LearnedPilot | GlassboxPilot:
    """Train a pilot, and write weights, logs and snapshots to a folder.

    Args:
        preset: ``fast``, ``glassbox``, ``course``, ``ddpg``, ``paper``, or ``tiny`` and its like.
        out: The folder.
        minutes: Stop cleanly after so long.
        seed: Of everything random.
        settings: Other fields of the configuration, as ``ddpg.batch_size=512``.
        resume: Continue the training that the folder holds, with its own configuration.

    Returns:
        The best pilot of the training.

    Raises:
        InputError: An unknown preset or setting, or the folder cannot be used.
        KeyboardInterrupt: It was interrupted; the folder can be resumed.
    """
    from glasshelm.core.terminal import Terminal
    from glasshelm.training.config import preset_named, with_settings
    from glasshelm.training.trainer import BEST_FILE, TrainerSettings
    from glasshelm.training.trainer import train as train_in
    from glasshelm.training.training_progress import TrainingProgress
    from glasshelm.training.training_state import read_position

    folder = Path(out)
    if resume:
        _, config = read_position(folder)
    else:
        config = with_settings(
            dataclasses.replace(preset_named(preset), seed=seed), tuple(settings)
        )
    with TrainingProgress(Terminal(stderr=True)) as progress:
        if not train_in(config, folder, TrainerSettings(minutes), resume, progress):
            raise KeyboardInterrupt
    return load(folder / BEST_FILE)
