"""The training loop: stages, validations, log, weights and snapshots, and stopping cleanly."""

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
from glasshelm.encounters.random_encounters import validation_encounters
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.pilots.protocols import BatchPolicy
from glasshelm.ship.nomoto import ship_named
from glasshelm.training.config import TrainConfig
from glasshelm.training.critic_accuracy import critic_accuracy
from glasshelm.training.metrics_log import MetricsLog
from glasshelm.training.stages import Stage, State, initial_policy, mean_metrics, stages_of
from glasshelm.training.training_progress import TrainingProgress
from glasshelm.training.training_state import (
    STATE_FILE,
    StagePosition,
    load_snapshot,
    read_position,
    save_pilot,
    save_snapshot,
)
from glasshelm.training.validation import AnyPolicy, ValidationScore, validate

BEST_FILE, FINAL_FILE = "best.safetensors", "final.safetensors"


@dataclasses.dataclass(frozen=True)
class TrainerSettings:
    """What does not change the result: time budget, pace of snapshots, logs."""

    minutes: float | None = None
    #: Seconds between two snapshots; a snapshot with a large replay buffer takes longer.
    snapshot_s: float = 60.0
    tensorboard: bool = True

    def __post_init__(self) -> None:
        if self.minutes is not None and not self.minutes >= 0:
            raise InputError(f"{self.minutes:g} minutes of training: must be 0 or more")


class Trainer:
    """One training in one folder."""

    def __init__(
        self,
        config: TrainConfig,
        folder: Path,
        settings: TrainerSettings,
        progress: TrainingProgress,
    ):
        self.config, self.folder = config, folder
        self.settings, self.progress = settings, progress
        self.ship = ship_named(config.ship)
        self.stages = stages_of(config)
        self.position = StagePosition()
        self.state: State = None
        self.best_policy: AnyPolicy | BatchPolicy = initial_policy(config)
        self.score: ValidationScore | None = None
        self._started = time.monotonic()
        self._encounters = validation_encounters(self.ship, config.validation_episodes)

    def resume(self) -> None:
        """Continue from the snapshot in the folder."""
        self.position, _ = read_position(self.folder)
        like = self.stages[self.position.stage].start(self.best_policy)
        self.state, self.best_policy = load_snapshot(self.folder, like, self.best_policy)

    def run(self) -> bool:
        """Train to the end, or to the end of the time; false if it was interrupted."""
        resume_at = None if self.state is None else self._total_units()
        log = MetricsLog(self.folder, resume_at, self.settings.tensorboard)
        if self.state is None:
            self.state = self.stages[0].start(self.best_policy)
        with _interrupts() as interrupted:
            try:
                while True:
                    stage = self.stages[self.position.stage]
                    complete = self._run_stage(stage, log, interrupted)
                    if interrupted.is_set():
                        self._snapshot()
                        return False
                    if stage is self.stages[-1]:
                        self._snapshot()
                        self._finish(stage, complete)
                        return True
                    self.position = dataclasses.replace(
                        self.position, stage=self.position.stage + 1, units=0
                    )
                    self.state = self.stages[self.position.stage].start(self.best_policy)
                    self.score = None
                    self._snapshot()
            finally:
                log.close()

    def _run_stage(self, stage: Stage, log: MetricsLog, interrupted: threading.Event) -> bool:
        """Advance until the stage is done, its time is over (false) or a signal interrupts."""
        deadline = None
        if self.settings.minutes is not None:
            deadline = self._started + 60.0 * self.settings.minutes * stage.time_share
        metrics: list[dict[str, jax.Array]] = []
        self.progress.start_stage(stage.name, stage.unit, stage.units, self.position.units)
        last_line = last_snapshot = time.monotonic()
        while self.position.units < stage.units and not interrupted.is_set():
            self.state, latest = stage.advance(self.state, self.position.units)
            metrics.append(latest)
            units = self.position.units + 1
            self.position = dataclasses.replace(self.position, units=units)
            if units % 8 == 0:
                jax.block_until_ready(latest)  # stay near the device: clock and Ctrl-C count
            self.progress.advance(units)
            late = deadline is not None and time.monotonic() > deadline
            if units % stage.evaluate_every == 0 or units == stage.units or late:
                line = mean_metrics(metrics)
                seconds = time.monotonic() - last_line
                line["updates_per_s"] = len(metrics) * stage.updates_per_unit / max(seconds, 1e-9)
                self._validate(stage, line, log)
                metrics, last_line = [], time.monotonic()
            if late:
                return units == stage.units
            now = time.monotonic()
            if now - last_snapshot > self.settings.snapshot_s:
                self._snapshot()
                last_snapshot = time.monotonic()
                last_line += last_snapshot - now  # the pace is that of learning alone
        return True

    def _validate(self, stage: Stage, metrics: dict[str, float], log: MetricsLog) -> None:
        """Measure the policy, keep it if it is the best, write it all down.

        A weights file has only what depends on the policy, so that two equal trainings write two
        equal files, interrupted or not; the log also has the clock, and the losses since the last
        line.
        """
        policy, critic = stage.policy(self.state), stage.critic(self.state)
        where = {
            "stage": stage.name,
            "number": self._total_units(),
            "env_steps": self.position.units * stage.env_steps_per_unit,
        }
        if stage.name != "critic" or self.score is None:
            self.score = self._score(policy)
        loss = self.score.selection_loss
        result = self._results(self.score, policy, critic) | {"selection_loss": loss}
        if self.position.best_loss is None or loss <= self.position.best_loss:
            self.position = dataclasses.replace(self.position, best_loss=loss)
            self.best_policy = jax.tree.map(jax.numpy.copy, policy)
            self._save(BEST_FILE, policy, critic, where | result)
        line = where | {"seconds": round(self._seconds(), 1)} | metrics | result
        log.add(line)
        self.progress.show(line)

    def _finish(self, stage: Stage, complete: bool) -> None:
        policy, critic = stage.policy(self.state), stage.critic(self.state)
        result = self._results(self.score or self._score(policy), policy, critic)
        self._save(FINAL_FILE, policy, critic, result | {"stopped_early": not complete})

    def _score(self, policy: AnyPolicy) -> ValidationScore:
        return validate(policy, self._encounters, self.ship, self.config.validation_steps[1])

    def _results(
        self, score: ValidationScore, policy: AnyPolicy, critic: SubTaskCritic | None
    ) -> dict[str, Any]:
        if critic is None:
            return dataclasses.asdict(score)
        settings, short = self.config.ddpg, self.config.validation_steps[0]
        discount = settings.discount
        long = short + round(5.0 / (1.0 - discount))  # what follows later counts less than 1 %
        noise = settings.noise if settings.target == "sarsa" else None
        assert not isinstance(policy, BatchPolicy)  # which has no critic beside it
        accuracy = critic_accuracy(
            policy, critic, self._encounters, self.ship, discount, short, long, noise
        )
        return dataclasses.asdict(score) | accuracy.as_dict()

    def _save(
        self,
        name: str,
        policy: AnyPolicy,
        critic: SubTaskCritic | None,
        result: dict[str, Any],
    ) -> None:
        summary = {
            "validation": result,
            "validation_episodes": self.config.validation_episodes,
            "units": self.position.units,
            "device": jax.devices()[0].device_kind,
        }
        save_pilot(self.folder / name, policy, critic, self.config, summary)

    def _snapshot(self) -> None:
        position = dataclasses.replace(self.position, seconds=self._seconds())
        save_snapshot(self.folder, self.state, self.best_policy, position, self.config)

    def _seconds(self) -> float:
        return self.position.seconds + time.monotonic() - self._started

    def _total_units(self) -> int:
        """Units over all stages: the x axis of the log."""
        return sum(s.units for s in self.stages[: self.position.stage]) + self.position.units


def train(
    config: TrainConfig,
    folder: Path,
    settings: TrainerSettings,
    resume: bool,
    progress: TrainingProgress,
) -> bool:
    """Train in a folder.

    Args:
        config: What to train.
        folder: Where weights, log and snapshots are written.
        settings: Time budget and pace of snapshots.
        resume: Whether to continue the training that the folder holds.
        progress: What shows the user how far it is.

    Returns:
        False if it was interrupted; the folder can then be resumed.

    Raises:
        InputError: The folder holds a training and ``resume`` is false, or holds none and it is
            true, or was started with another configuration, or another process works in it.
    """
    with locked_folder(folder):
        if resume:
            _, stored = read_position(folder)
            if stored != config:
                raise InputError(
                    f"{folder}: started with another configuration; resume with its own"
                )
        elif os.path.lexists(folder / STATE_FILE):
            raise InputError(f"{folder} holds a training: --resume it, or choose another --out")
        trainer = Trainer(config, folder, settings, progress)
        if resume:
            trainer.resume()
        return trainer.run()


@contextmanager
def _interrupts() -> Iterator[threading.Event]:
    """An event that Ctrl-C and SIGTERM set, instead of stopping in the middle of a step."""
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
