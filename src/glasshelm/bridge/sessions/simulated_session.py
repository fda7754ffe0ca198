"""A session that sails: the pilot steers in simulated traffic, and advises in recorded."""

from pathlib import Path

from glasshelm.bridge.sessions.log_index import new_log
from glasshelm.bridge.sessions.session import Predicted, Session, SessionInfo, track_of
from glasshelm.bridge.sessions.session_log import SessionLog
from glasshelm.encounters.types import Scenario
from glasshelm.frames.schema import Frame
from glasshelm.pilots.protocols import Pilot
from glasshelm.simulation.prediction import predict_track
from glasshelm.simulation.voyage import Voyage, VoyageCheckpoint, steps_of


class LoggedVoyage:
    """A voyage and its log, sailed as far as somebody has looked."""

    def __init__(self, voyage: Voyage, logs: Path):
        self.voyage = voyage
        self.record = SessionLog(_log(logs, voyage), fresh=True)
        #: Where the voyage stood before each frame of the record.
        self.places: list[VoyageCheckpoint] = []
        self._logs = logs

    def reach(self, number: int) -> bool:
        """Sail until that frame is there; whether it is."""
        while len(self.record) <= number:
            place = self.voyage.place
            frames = self.voyage.advance()
            if not frames:
                return False
            try:
                self.record.append(frames[0])
            except BaseException:
                self.voyage.place = place  # the same step can be tried again
                raise
            self.places.append(place)
        return True

    def branch(self, number: int, pilot: Pilot) -> "LoggedVoyage":
        """The same voyage with another pilot from a frame on, that one sailed, in its own log.

        This one is closed; where the new log cannot be written it stays as it was.
        """
        place = self.voyage.place
        self.voyage.place = self.places[number]
        self.voyage.change_pilot(pilot)
        try:
            other = LoggedVoyage(self.voyage, self._logs)
            try:
                other.places = self.places[:number]
                for k in range(number):
                    other.record.append(self.record.frame(k))
                other.reach(number)
            except BaseException:
                other.record.close()
                raise
        except BaseException:
            self.voyage.place = place
            raise
        self.record.close()
        return other


def _log(logs: Path, voyage: Voyage) -> Path:
    return new_log(logs, voyage.scenario.source, voyage.place.pilot.name)


def _predicted(voyage: Voyage, place: VoyageCheckpoint) -> Predicted:
    """Own ship's track from a place of the voyage on."""
    state, memory = place.carry.state, place.carry.memory
    own = predict_track(place.pilot, voyage.encounter, state, memory, voyage.ship, voyage.settings)
    return track_of(own, voyage.settings.step_s)


class SimulatedSession(Session):
    """Sails as far as is looked; going back and forth reads the log."""

    def __init__(self, scenario: Scenario, pilot: Pilot, ship: str, advise: bool, logs: Path):
        self._scenario, self._advise, self._logs = scenario, advise, logs
        self._steps = steps_of(scenario)
        self._run = LoggedVoyage(Voyage(scenario, pilot, self._steps, advise), logs)
        self._other: LoggedVoyage | None = None
        self.at = -1
        self.card = SessionInfo(
            scenario.source,
            scenario.title,
            "recorded" if advise else "simulated",
            ship,
            self._steps * self._run.voyage.settings.step_s,
            scenario.notes,
        )

    @property
    def record(self) -> SessionLog:
        return self._run.record

    @property
    def pilot(self) -> str:
        return self._place.pilot.name

    @property
    def compared(self) -> str | None:
        return None if self._other is None else self._other.voyage.place.pilot.name

    @property
    def reach_s(self) -> tuple[float, float]:
        voyage = self._run.voyage
        return 0.0, voyage.place.final * voyage.settings.step_s

    @property
    def step_s(self) -> float:
        return self._run.voyage.settings.step_s

    def ready(self, pilot: Pilot, ahead: bool = True) -> None:
        voyage = Voyage(self._scenario, pilot, self._steps, self._advise)
        voyage.advance()
        if ahead:
            _predicted(voyage, voyage.place)

    def forward(self) -> Frame | None:
        following = self.at + 1
        if not self._run.reach(following):
            return None
        self._follow(following)
        frame = self.record.frame(following)
        self.at = following
        return frame

    def seek(self, time_s: float) -> None:
        wanted = int(time_s / self.step_s + 1e-6)
        self._run.reach(wanted)
        wanted = min(wanted, len(self.record) - 1)
        self._follow(wanted)
        self.at = wanted

    def hand_over(self, pilot: Pilot) -> None:
        number = max(self.at, 0)
        self._run = self._run.branch(number, pilot)
        self.at = number

    def compare(self, pilot: Pilot | None) -> None:
        other = None
        if pilot is not None:
            voyage = Voyage(self._scenario, pilot, self._steps, self._advise)
            other = LoggedVoyage(voyage, self._logs)
            try:
                other.reach(self.at)
            except BaseException:
                other.record.close()
                raise
        if self._other is not None:
            self._other.record.close()
        self._other = other

    def beside(self) -> list[bytes]:
        if self._other is None:
            return []
        record = self._other.record
        return record.history(min(max(self.at, 0), len(record)))

    def beside_now(self) -> bytes | None:
        if self._other is None or not 0 <= self.at < len(self._other.record):
            return None
        return self._other.record.line(self.at)

    def predicted(self) -> Predicted | None:
        if self.at < 0:
            return None
        return _predicted(self._run.voyage, self._place)

    def close(self) -> None:
        self.record.close()
        if self._other is not None:
            self._other.record.close()

    @property
    def _place(self) -> VoyageCheckpoint:
        """Where the voyage stood before the frame shown."""
        return self._run.places[self.at] if self.at >= 0 else self._run.voyage.place

    def _follow(self, number: int) -> None:
        """The compared pilot sails along."""
        if self._other is not None:
            self._other.reach(number)
