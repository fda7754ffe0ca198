"""``glasshelm bridge``: the live page."""

import logging
import os
import threading
import time
from pathlib import Path
from typing import Annotated

import tyro


def run(
    source: Annotated[str, tyro.conf.Positional] = "gulf-of-finland",
    pilot: str | None = None,
    ship: str | None = None,
    own: str | None = None,
    at: str | None = None,
    minutes: float | None = None,
    replay: Path | None = None,
    log: Path | None = None,
    host: str = "127.0.0.1",
    port: int | None = None,
    token: str | None = None,
    viewer_token: str | None = None,
    errors: str = "10,0.5,0.1",
    write_back: bool = False,
    signalk_token: str | None = None,
    open_: Annotated[bool, tyro.conf.arg(name="open")] = True,
) -> None:
    """Serve the live page of a voyage on this machine and open it in the browser.

    In simulated traffic the pilot steers; in recorded traffic own ship keeps
    her track, in live traffic she goes her own way, and the pilot advises. Every
    session's frames are written to a log.
    Ctrl-C stops the server. Not for navigation.

    Args:
        source: gulf-of-finland, new-york, imazu:5, random:SEED, wide:SEED, path/to/situation.json,
            path/to/ais.csv; or live traffic: tcp://HOST:PORT or udp://HOST:PORT (NMEA 0183, AIS),
            signalk://HOST[:PORT], signalks://HOST[:PORT] (TLS), live:path/to/recording.nmea (a
            file, as if it were now). The page can open others of its menu.
        pilot: A bundled pilot (by default the ship's), straight, a planner (paper-planner,
            large-ship-planner), or a .safetensors file; a learned one followed by -guarded is
            that pilot under guard (paper-sum-guarded).
        ship: Own ship: paper or large_ship (default: the pilot's own, or else paper).
        own: In recorded and live traffic, the MMSI to take as own ship; "recorded" is the recorder
            of recorded traffic. Live, she is known without it by her AIVDO or sensors (NMEA 0183)
            or as the server's self (Signal K).
        at: In recorded traffic, when to begin (UTC, ISO 8601 or a time of day).
        minutes: In recorded traffic, how long from then (default: as long as own ship is heard).
        replay: Show this log of an earlier session instead of a source.
        log: Folder for the logs (default: the user's data folder, which is printed).
        host: Address to serve on; any but this machine's own needs a token.
        port: Port to serve on (default: 8470, or a free one if it is taken).
        token: A secret that its owner must know to open the page, 12 characters or more.
        viewer_token: Another one, for those who may only look on: they change nothing that others
            see. Both addresses are printed.
        errors: Largest errors of the sensors, in metres, degrees and knots, for which the certified
            rudder band of a sum pilot is shown; "off" for no band.
        write_back: Write rudder target, closest approaches and alarms back to the Signal K source.
        signalk_token: A token of the Signal K source: for reading, where it lets nobody read
            without, and needed for writing back. It is sent to that server alone.
        open_: Open the page in the browser.
    """
    from glasshelm.core.compile_cache import enable_compile_cache

    enable_compile_cache()
    from glasshelm.bridge.server.access_control import AccessControl
    from glasshelm.bridge.server.app import application
    from glasshelm.bridge.server.server import address, bind, room_here, serve
    from glasshelm.bridge.server.session_hub import SessionHub
    from glasshelm.bridge.sessions.log_index import LogIndex, default_logs
    from glasshelm.bridge.sessions.session_factory import check_log, prepared, replayed
    from glasshelm.bridge.sessions.source_list import SourceList, is_feed
    from glasshelm.certify.sensor_error_bounds import parse_error_bounds
    from glasshelm.core.errors import InputError
    from glasshelm.core.output_dir import writable_folder
    from glasshelm.core.terminal import Terminal
    from glasshelm.feeds.feed_factory import is_signalk, signalk_server
    from glasshelm.live.signalk_writer import SignalKWriter

    console = Terminal()
    guard = AccessControl(host, token, viewer_token)
    bounds = None if errors == "off" else parse_error_bounds(errors)
    logs = default_logs() if log is None else log
    if replay is None or log is not None:
        try:
            writable_folder(logs)
        except InputError as error:
            if not is_feed(source) or replay is not None:
                raise
            # Live traffic is watched all the same, and logged as soon as it can be.
            console.print(f"logs:   {error}", markup=False, highlight=False, soft_wrap=True)
    if signalk_token is not None and not is_signalk(source):
        raise InputError(f"{source}: a Signal K token is for signalk://HOST[:PORT] only")
    catalogue = SourceList(LogIndex(logs), source, pilot, signalk_token, minutes)
    if replay is not None:
        check_log(replay)
        first = lambda: replayed(replay, conductor.preparing.share)  # noqa: E731
    else:
        first = prepared(catalogue, logs, source, pilot, ship, own, at)
    writer = SignalKWriter(signalk_server(source, signalk_token)) if write_back else None
    bound = bind(host, port)
    url = address(bound, token)
    room = room_here()
    conductor = SessionHub(catalogue, logs, writer, bounds)
    app = application(conductor, guard, first, most_viewers=room.viewers)

    def ready() -> None:
        said = {"bridge": url, "logs": logs}
        if viewer_token is not None:
            said = {"bridge": url, "view only": address(bound, viewer_token), "logs": logs}
        for name, what in said.items():
            console.say(f"{name + ':':{max(map(len, said)) + 1}} {what}")
        console.say("Advisory research software, not for navigation. Ctrl-C stops.")

    serve(app, bound, url, open_, ready, room)
    _leave()


def _leave() -> None:
    """End the process, not waiting for a thread that compiles: it cannot be stopped.

    The logs are closed by now. Threads that are nearly done have a second: a program that is being
    kept is written whole.
    """
    patience = time.monotonic() + 1.0
    main = threading.main_thread()
    busy = [t for t in threading.enumerate() if t is not main and not t.daemon]
    for thread in busy:
        thread.join(max(patience - time.monotonic(), 0.0))
    if any(thread.is_alive() for thread in busy):
        logging.shutdown()
        os._exit(0)
