"""From a request to a session."""

from collections.abc import Callable
from pathlib import Path

from glasshelm.bridge.server.protocol import Open, Replay
from glasshelm.bridge.sessions.live_session import LiveSession
from glasshelm.bridge.sessions.log_index import find_log
from glasshelm.bridge.sessions.replay_session import ReplaySession
from glasshelm.bridge.sessions.session import Session
from glasshelm.bridge.sessions.session_log import SessionLog
from glasshelm.bridge.sessions.simulated_session import SimulatedSession
from glasshelm.bridge.sessions.source_list import SourceList, display_name
from glasshelm.core.errors import InputError
from glasshelm.frames import frame_log
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.pilots.pilot_resolution import DEFAULT_SHIP, ship_for


def open_session(
    asked: Open | Replay,
    catalogue: SourceList,
    logs: Path,
    progress: Callable[[float], None] = lambda share: None,
) -> Session:
    """The session that a page asks for. InputError if it is not of the catalogue.

    ``progress`` is told which share of a log has been read.
    """
    if isinstance(asked, Replay):
        return open_replay(find_log(logs, asked.log), progress)
    begin = prepare_session(
        catalogue, logs, asked.source, asked.pilot, asked.ship, asked.own, asked.at
    )
    return begin()


def prepare_session(
    catalogue: SourceList,
    logs: Path,
    source: str,
    pilot: str | None,
    ship: str | None,
    own: str | None,
    at: str | None,
) -> Callable[[], Session]:
    """A session of which everything has been read and checked, but nothing sailed yet."""
    helm = catalogue.pilot_for(ship or DEFAULT_SHIP, pilot)
    preset = ship_for(helm, ship)
    if catalogue.is_live(source) and catalogue.feed is not None:
        if at is not None:
            raise InputError(f"{source}: live traffic begins now; leave out at")
        feed, name = catalogue.open_feed(own), display_name(catalogue.feed)

        def begin() -> Session:
            live = LiveSession(name, feed, TrafficPicture(name), helm, preset, logs)
            live.warm_up(helm)
            return live

        return begin
    scenario = catalogue.scenario(source, preset, own, at)
    return lambda: SimulatedSession(scenario, helm, preset, scenario.own_track is not None, logs)


def check_log(path: Path) -> None:
    """InputError if this is no log, as far as its first frame tells."""
    if next(frame_log.read(path), None) is None:
        raise InputError(f"{path}: no frame in it; it was cut off, or is no log")


def open_replay(path: Path, progress: Callable[[float], None] = lambda share: None) -> Session:
    """A log shown again; ``progress`` is told which share of it has been read."""
    return ReplaySession(SessionLog(path, fresh=False, progress=progress))
