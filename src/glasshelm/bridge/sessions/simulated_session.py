"""A session that sails: the pilot steers in simulated traffic, and advises in recorded."""

from pathlib import Path

from glasshelm.bridge.sessions.log_index import new_log_path
from glasshelm.bridge.sessions.session import PredictedTrack, Session, SessionInfo, to_track
from glasshelm.bridge.sessions.session_log import SessionLog
from glasshelm.encounters.types import Scenario
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.simulation.prediction import predicted
from glasshelm.simulation.voyage import Voyage, VoyageCheckpoint, steps_of


class LoggedVoyage:
    """A voyage and its log, sailed as far as somebody has looked."""

    def __init__(self, voyage: Voyage, logs: Path):
        self.voyage = voyage
        self.log = SessionLog(_log(logs, voyage), fresh=True)
        #: Where the voyage stood before each frame of the record.
        self.checkpoints: list[VoyageCheckpoint] = []
        self._logs = logs

    def sail_to(self, number: int) -> bool:
        """Sail until that frame is there; whether it is."""
        while len(self.log) <= number:
            place = self.voyage.place
            frames = self.voyage.sail_on()
            if not frames:
                return False
            try:
                self.log.append(frames[0])
            except BaseException:
                self.voyage.place = place  # the same step can be tried again
                raise
            self.checkpoints.append(place)
        return True

    def branch(self, number: int, pilot: Pilot) -> "LoggedVoyage":
        """The same voyage with another pilot from a frame on, that one sailed, in its own log.

        This one is closed; where the new log cannot be written it stays as it was.
        """
        place = self.voyage.place
        self.voyage.place = self.checkpoints[number]
        self.voyage.hand_over(pilot)
        try:
            other = LoggedVoyage(self.voyage, self._logs)
            try:
                other.checkpoints = self.checkpoints[:number]
                for k in range(number):
                    other.log.append(self.log.frame(k))
                other.sail_to(number)
            except BaseException:
                other.log.close()
                raise
        except BaseException:
            self.voyage.place = place
            raise
        self.log.close()
        return other


def _log(logs: Path, voyage: Voyage) -> Path:
    return new_log_path(logs, voyage.scenario.source, voyage.place.pilot.name)


def _predicted(voyage: Voyage, place: VoyageCheckpoint) -> PredictedTrack:
    """Own ship's track from a place of the voyage on."""
    state, memory = place.carry.state, place.carry.memory
    own = predicted(place.pilot, voyage.encounter, state, memory, voyage.ship, voyage.settings)
    return to_track(own, voyage.settings.step_s)


class SimulatedSession(Session):
    """Sails as far as is looked; going back and forth reads the log."""

    def __init__(self, scenario: Scenario, pilot: Pilot, ship: str, advise: bool, logs: Path):
        self._scenario, self._advise, self._logs = scenario, advise, logs
        self._steps = steps_of(scenario)
        self._main = LoggedVoyage(Voyage(scenario, pilot, self._steps, advise), logs)
        self._compared: LoggedVoyage | None = None
        self.index = -1
        self.info = SessionInfo(
            scenario.source,
            scenario.title,
            "recorded" if advise else "simulated",
            ship,
            self._steps * self._main.voyage.settings.step_s,
            scenario.notes,
        )

    @property
    def log(self) -> SessionLog:
        return self._main.log

    @property
    def pilot_name(self) -> str:
        return self._place.pilot.name

    @property
    def compared_name(self) -> str | None:
        return None if self._compared is None else self._compared.voyage.place.pilot.name

    @property
    def seekable_range_s(self) -> tuple[float, float]:
        voyage = self._main.voyage
        return 0.0, voyage.place.final * voyage.settings.step_s

    @property
    def step_s(self) -> float:
        return self._main.voyage.settings.step_s

    def warm_up(self, pilot: Pilot, ahead: bool = True) -> None:
        voyage = Voyage(self._scenario, pilot, self._steps, self._advise)
        voyage.sail_on()
        if ahead:
            _predicted(voyage, voyage.place)

    def next_frame(self) -> Frame | None:
        following = self.index + 1
        if not self._main.sail_to(following):
            return None
        self._follow(following)
        frame = self.log.frame(following)
        self.index = following
        return frame

    def seek(self, time_s: float) -> None:
        wanted = int(time_s / self.step_s + 1e-6)
        self._main.sail_to(wanted)
        wanted = min(wanted, len(self.log) - 1)
        self._follow(wanted)
        self.index = wanted

    def set_pilot(self, pilot: Pilot) -> None:
        number = max(self.index, 0)
        self._main = self._main.branch(number, pilot)
        self.index = number

    def compare(self, pilot: Pilot | None) -> None:
        other = None
        if pilot is not None:
            voyage = Voyage(self._scenario, pilot, self._steps, self._advise)
            other = LoggedVoyage(voyage, self._logs)
            try:
                other.sail_to(self.index)
            except BaseException:
                other.log.close()
                raise
        if self._compared is not None:
            self._compared.log.close()
        self._compared = other

    def compared_history(self) -> list[bytes]:
        if self._compared is None:
            return []
        record = self._compared.log
        return record.history(min(max(self.index, 0), len(record)))

    def compared_line(self) -> bytes | None:
        if self._compared is None or not 0 <= self.index < len(self._compared.log):
            return None
        return self._compared.log.line(self.index)

    def predicted_track(self) -> PredictedTrack | None:
        if self.index < 0:
            return None
        return _predicted(self._main.voyage, self._place)

    def close(self) -> None:
        self.log.close()
        if self._compared is not None:
            self._compared.log.close()

    @property
    def _place(self) -> VoyageCheckpoint:
        """Where the voyage stood before the frame shown."""
        return self._main.checkpoints[self.index] if self.index >= 0 else self._main.voyage.place

    def _follow(self, number: int) -> None:
        """The compared pilot sails along."""
        if self._compared is not None:
            self._compared.sail_to(number)
