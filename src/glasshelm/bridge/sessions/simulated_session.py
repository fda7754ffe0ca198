"""A session that simulates: the pilot steers in simulated traffic, and advises in recorded."""

from pathlib import Path

from glasshelm.bridge.sessions.log_index import new_log_path
from glasshelm.bridge.sessions.session import PredictedTrack, Session, SessionInfo, SessionStatus
from glasshelm.bridge.sessions.session_log import FileLog
from glasshelm.encounters.types import Scenario
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.simulation.prediction import predict_track
from glasshelm.simulation.voyage import Voyage, VoyageCheckpoint, steps_of


class LoggedVoyage:
    """A voyage and its log, simulated as far as somebody has looked."""

    def __init__(self, voyage: Voyage, log_dir: Path):
        self.voyage = voyage
        path = new_log_path(log_dir, voyage.scenario.source, voyage.place.pilot.name)
        self.log = FileLog(path, fresh=True)
        #: The state of the voyage before each frame of the log.
        self.checkpoints: list[VoyageCheckpoint] = []
        self._log_dir = log_dir

    def advance_to(self, number: int) -> bool:
        """Simulate up to that frame; return whether the voyage gets there."""
        while len(self.log) <= number:
            checkpoint = self.voyage.place
            frames = self.voyage.advance()
            if not frames:
                return False
            try:
                self.log.append(frames[0])
            except BaseException:
                self.voyage.place = checkpoint  # the same step can be tried again
                raise
            self.checkpoints.append(checkpoint)
        return True

    def branch(self, number: int, pilot: Pilot) -> "LoggedVoyage":
        """Continue with another pilot from a frame on, in a new log, up to that frame.

        This voyage is closed; if the new log cannot be written it stays as it was.
        """
        checkpoint, other = self.voyage.place, None
        self.voyage.place = self.checkpoints[number]
        self.voyage.change_pilot(pilot)
        try:
            other = LoggedVoyage(self.voyage, self._log_dir)
            other.checkpoints = self.checkpoints[:number]
            for k in range(number):
                other.log.append(self.log.frame(k))
            other.advance_to(number)
        except BaseException:
            if other is not None:
                other.log.close()
            self.voyage.place = checkpoint
            raise
        self.log.close()
        return other


def _predict(voyage: Voyage, start: VoyageCheckpoint) -> PredictedTrack:
    """Predict own ship's track from a checkpoint on."""
    state, memory = start.carry.state, start.carry.memory
    own = predict_track(start.pilot, voyage.encounter, state, memory, voyage.ship, voyage.settings)
    return PredictedTrack.of(own, voyage.settings.step_s)


class SimulatedSession(Session):
    """Simulates as far as is looked; frames before are read from the log."""

    def __init__(self, scenario: Scenario, pilot: Pilot, ship: str, advise: bool, log_dir: Path):
        self._scenario, self._advise, self._log_dir = scenario, advise, log_dir
        self._n_steps = steps_of(scenario)
        self._main = LoggedVoyage(self._voyage(pilot), log_dir)
        self._compared: LoggedVoyage | None = None
        self.index = -1
        mode = "recorded" if advise else "simulated"
        end_s = self._n_steps * self.step_s
        self.info = SessionInfo(scenario.source, scenario.title, mode, ship, end_s, scenario.notes)

    @property
    def log(self) -> FileLog:
        return self._main.log

    @property
    def step_s(self) -> float:
        return self._main.voyage.settings.step_s

    def status(self) -> SessionStatus:
        compared = None if self._compared is None else self._compared.voyage.place.pilot.name
        end_s = self._main.voyage.place.final * self.step_s
        return SessionStatus(self._checkpoint.pilot.name, compared, (0.0, end_s))

    def warm_up(self, pilot: Pilot, predict: bool = True) -> None:
        voyage = self._voyage(pilot)
        voyage.advance()
        if predict:
            _predict(voyage, voyage.place)

    def next_frame(self) -> Frame | None:
        number = self.index + 1
        if not self._main.advance_to(number):
            return None
        if self._compared is not None:
            self._compared.advance_to(number)
        frame = self.log.frame(number)
        self.index = number
        return frame

    def seek(self, time_s: float) -> None:
        number = int(time_s / self.step_s + 1e-6)
        self._main.advance_to(number)
        number = min(number, len(self.log) - 1)
        if self._compared is not None:
            self._compared.advance_to(number)
        self.index = number

    def set_pilot(self, pilot: Pilot) -> None:
        number = max(self.index, 0)
        self._main = self._main.branch(number, pilot)
        self.index = number

    def compare(self, pilot: Pilot | None) -> None:
        compared = None
        if pilot is not None:
            compared = LoggedVoyage(self._voyage(pilot), self._log_dir)
            try:
                compared.advance_to(self.index)
            except BaseException:
                compared.log.close()
                raise
        if self._compared is not None:
            self._compared.log.close()
        self._compared = compared

    def compared_history(self) -> list[bytes]:
        if self._compared is None:
            return []
        return self._compared.log.history(min(max(self.index, 0), len(self._compared.log)))

    def compared_line(self) -> bytes | None:
        if self._compared is None or not 0 <= self.index < len(self._compared.log):
            return None
        return self._compared.log.line(self.index)

    def predicted_track(self) -> PredictedTrack | None:
        return None if self.index < 0 else _predict(self._main.voyage, self._checkpoint)

    def close(self) -> None:
        super().close()
        if self._compared is not None:
            self._compared.log.close()

    def _voyage(self, pilot: Pilot) -> Voyage:
        return Voyage(self._scenario, pilot, self._n_steps, self._advise)

    @property
    def _checkpoint(self) -> VoyageCheckpoint:
        """The state of the voyage before the frame shown."""
        return self._main.checkpoints[self.index] if self.index >= 0 else self._main.voyage.place
