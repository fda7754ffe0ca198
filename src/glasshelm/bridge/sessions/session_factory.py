"""Opens the session that a request, or the command line, asks for."""

from collections.abc import Callable
from pathlib import Path

from glasshelm.bridge.server.protocol import Open, Replay
from glasshelm.bridge.sessions.live_session import LiveSession
from glasshelm.bridge.sessions.log_index import find_log
from glasshelm.bridge.sessions.replay_session import ReplaySession
from glasshelm.bridge.sessions.session import Session
from glasshelm.bridge.sessions.session_log import FileLog
from glasshelm.bridge.sessions.simulated_session import SimulatedSession
from glasshelm.bridge.sessions.source_list import SourceList, display_name
from glasshelm.core.errors import InputError
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.pilots.pilot_resolution import ship_for


def open_session(
    request: Open | Replay,
    sources: SourceList,
    log_dir: Path,
    progress: Callable[[float], None] = lambda share: None,
) -> Session:
    """Open the session a viewer asks for; ``progress`` gets the share of a log read so far.

    Raises:
        InputError: It is not in the catalogue.
    """
    if isinstance(request, Replay):
        return open_replay(find_log(log_dir, request.log), progress)
    return prepare_session(request, sources, log_dir)()


def prepare_session(request: Open, sources: SourceList, log_dir: Path) -> Callable[[], Session]:
    """Read and check everything a session needs; the result begins to simulate or to listen."""
    source = request.source
    pilot = sources.pilot_or_default(request.pilot)
    ship = ship_for(pilot, request.ship)
    if not sources.is_live(source):
        scenario = sources.scenario(source, ship, request.own, request.at)
        advise = scenario.own_track is not None
        return lambda: SimulatedSession(scenario, pilot, ship, advise, log_dir)
    if request.at is not None:
        raise InputError(f"{source}: live traffic begins now; leave out at")
    feed, name = sources.open_feed(request.own), display_name(source)

    def begin() -> Session:
        session = LiveSession(name, feed, TrafficPicture(name), pilot, ship, log_dir)
        session.warm_up(pilot)
        return session

    return begin


def open_replay(path: Path, progress: Callable[[float], None] = lambda share: None) -> Session:
    """Replay a log; ``progress`` gets the share of it read so far."""
    return ReplaySession(FileLog(path, fresh=False, progress=progress))
