"""The training loop: stages, evaluations, records, checkpoints, and stopping cleanly."""

import dataclasses
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import jax

from glasshelm.core.errors import InputError
from glasshelm.core.output_dir import locked_folder
from glasshelm.networks.actors import Actor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.ship.nomoto import ship_named
from glasshelm.training.config import TrainConfig
from glasshelm.training.init_actor import first_actor
from glasshelm.training.metrics_log import Records
from glasshelm.training.stages import Stage, State, Told, stages_of
from glasshelm.training.training_progress import Display
from glasshelm.training.training_state import (
    STATE,
    Place,
    load_snapshot,
    read_place,
    save_pilot,
    save_snapshot,
)
from glasshelm.training.validation import Score, agreement, evaluation_set, sail_set, score

BEST, FINAL = "best.safetensors", "final.safetensors"


@dataclasses.dataclass(frozen=True)
class LoopSettings:
    """What does not change the result: time budget, pace of snapshots, logs."""

    minutes: float | None = None
    #: Seconds between two snapshots; a snapshot with a large replay takes longer.
    snapshot_s: float = 60.0
    tensorboard: bool = True


class Training:
    """One training in one folder."""

    def __init__(self, config: TrainConfig, folder: Path, loop: LoopSettings, display: Display):
        self.config, self.folder, self.loop, self.display = config, folder, loop, display
        self.ship = ship_named(config.ship)
        self.stages = stages_of(config)
        self.place = Place()
        self.state: State = None
        self.kept: Actor = first_actor(config)
        self.score: Score | None = None
        self._began = time.monotonic()
        self._encounters = evaluation_set(self.ship, config.evaluation_worlds)

    def resume(self) -> None:
        """Take up the snapshot in the folder."""
        self.place, _ = read_place(self.folder)
        stage = self.stages[self.place.stage]
        like = stage.begin(self.kept)
        self.state, self.kept = load_snapshot(self.folder, like, self.kept)

    def run(self) -> bool:
        """Train to the end or the end of the time; false if it was interrupted."""
        resumed = None if self.state is None else self._step()
        records = Records(self.folder, resumed, self.loop.tensorboard)
        if self.state is None:
            self.state = self.stages[0].begin(self.kept)
        with _interrupts() as interrupted:
            try:
                while self.place.stage < len(self.stages):
                    stage = self.stages[self.place.stage]
                    whole = self._run_stage(stage, records, interrupted)
                    if interrupted.is_set():
                        self._snapshot()
                        return False
                    last = self.place.stage + 1 == len(self.stages)
                    if last:
                        self._snapshot()
                        self._finish(stage, whole)
                        return True
                    self.place = Place(self.place.stage + 1, 0, self.place.best, self.place.seconds)
                    self.state = self.stages[self.place.stage].begin(self.kept)
                    self.score = None
                    self._snapshot()
            finally:
                records.close()
        return True

    def _run_stage(self, stage: Stage, records: Records, interrupted: threading.Event) -> bool:
        """Advance until the stage is done, its time is over (false) or somebody interrupts."""
        deadline = self._deadline(stage)
        told: list[Told] = []
        self.display.begin(stage.name, stage.unit, stage.units, self.place.number)
        mark = snapshot = time.monotonic()
        while self.place.number < stage.units and not interrupted.is_set():
            self.state, news = stage.advance(self.state, self.place.number)
            told.append(news)
            number = self.place.number + 1
            self.place = dataclasses.replace(self.place, number=number)
            if number % 8 == 0:
                jax.block_until_ready(news)  # stay near the device: clock and Ctrl-C count
            self.display.advance(number)
            now = time.monotonic()
            late = deadline is not None and now > deadline
            if number % stage.evaluate_every == 0 or number == stage.units or late:
                line = stage.tell(told)
                self._evaluate(stage, line, len(told), time.monotonic() - mark, records)
                told, mark = [], time.monotonic()
            if late:
                return number == stage.units
            if now - snapshot > self.loop.snapshot_s:
                self._snapshot()
                mark += time.monotonic() - now
                snapshot = time.monotonic()
        return True

    def _deadline(self, stage: Stage) -> float | None:
        if self.loop.minutes is None:
            return None
        return self._began + 60.0 * self.loop.minutes * stage.time_share

    def _evaluate(
        self, stage: Stage, told: dict[str, float], units: int, seconds: float, records: Records
    ) -> None:
        """Measure the pilot, keep it if it is the best, write it all down.

        A file has only what depends on the pilot, so that two trainings alike leave two files
        alike, interrupted or not; the log also has the clock, and the losses since the last line.
        """
        actor, critic = stage.actor(self.state), stage.critic(self.state)
        where: dict[str, Any] = {
            "stage": stage.name,
            "number": self._step(),
            "env_steps": self.place.number * stage.env_steps_per_unit,
        }
        pace = {
            "seconds": round(self._seconds(), 1),
            "updates_per_s": units * stage.updates_per_unit / max(seconds, 1e-9),
        }
        if stage.name != "critic" or self.score is None:
            self.score = self._sail(actor)
        found = dataclasses.asdict(self.score) | {"fault": self.score.fault}
        if critic is not None:
            found |= self._agree(actor, critic)
        if self.place.best is None or self.score.fault <= self.place.best:
            self.place = dataclasses.replace(self.place, best=self.score.fault)
            self.kept = jax.tree.map(jax.numpy.copy, actor)
            self._save(BEST, actor, critic, where | found)
        line = where | pace | told | found
        records.add(line)
        self.display.show(line)

    def _finish(self, stage: Stage, whole: bool) -> None:
        actor, critic = stage.actor(self.state), stage.critic(self.state)
        if self.score is None:
            self.score = self._sail(actor)
        line = dataclasses.asdict(self.score)
        if critic is not None:
            line |= self._agree(actor, critic)
        self._save(FINAL, actor, critic, line | {"stopped_early": not whole})

    def _sail(self, actor: Actor) -> Score:
        short, long = self.config.evaluation_steps
        voyages = sail_set(actor, self._encounters, self.ship, short, long)
        return score(voyages, float(self.ship.loa_m))

    def _agree(self, actor: Actor, critic: SubTaskCritic) -> dict[str, float]:
        settings, short = self.config.ddpg, self.config.evaluation_steps[0]
        discount = settings.discount
        long = short + round(5.0 / (1.0 - discount))  # what follows later counts less than 1 %
        lapses = settings.noise if settings.follows == "lapses" else None
        found = agreement(actor, critic, self._encounters, self.ship, discount, short, long, lapses)
        return found.numbers()

    def _save(
        self, name: str, actor: Actor, critic: SubTaskCritic | None, line: dict[str, Any]
    ) -> None:
        summary = {
            "evaluation": line,
            "evaluation_worlds": self.config.evaluation_worlds,
            "units": self.place.number,
            "device": jax.devices()[0].device_kind,
        }
        save_pilot(self.folder / name, actor, critic, self.config, summary)

    def _snapshot(self) -> None:
        place = dataclasses.replace(self.place, seconds=self._seconds())
        save_snapshot(self.folder, self.state, self.kept, place, self.config)

    def _seconds(self) -> float:
        return self.place.seconds + time.monotonic() - self._began

    def _step(self) -> int:
        """Units over all stages: the x axis of the log."""
        return sum(s.units for s in self.stages[: self.place.stage]) + self.place.number


def train(
    config: TrainConfig, folder: Path, loop: LoopSettings, resume: bool, display: Display
) -> bool:
    """Train in a folder; false if interrupted (then the folder can be resumed).

    InputError if the folder holds a training and ``resume`` is false, or holds
    none and it is true, or was begun with another configuration, or another
    process is at work in it.
    """
    with locked_folder(folder):
        return _train(config, folder, loop, resume, display)


def _train(
    config: TrainConfig, folder: Path, loop: LoopSettings, resume: bool, display: Display
) -> bool:
    if resume:
        _, stored = read_place(folder)
        if stored != config:
            raise InputError(f"{folder}: begun with another configuration; resume with its own")
    elif os.path.lexists(folder / STATE):
        raise InputError(f"{folder} holds a training: --resume it, or choose another --out")
    training = Training(config, folder, loop, display)
    if resume:
        training.resume()
    return training.run()


@contextmanager
def _interrupts() -> Iterator[threading.Event]:
    """An event that Ctrl-C and SIGTERM set, instead of breaking off in the middle of a step."""
    event = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield event
        return
    signals = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(s, lambda *_: event.set()) for s in signals]
    try:
        yield event
    finally:
        for number, handler in zip(signals, before, strict=True):
            signal.signal(number, handler)
