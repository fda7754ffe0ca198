"""``glasshelm bridge``: the live page."""

import logging
import os
import threading
import time
from pathlib import Path
from typing import Annotated

import tyro

from glasshelm.cli.voyage_options import Pilots


def run(
    source: Annotated[str, tyro.conf.Positional] = "gulf-of-finland",
    *,
    pilots: Pilots,
    replay: Path | None = None,
    log_dir: Path | None = None,
    host: str = "127.0.0.1",
    port: int | None = None,
    token: str | None = None,
    viewer_token: str | None = None,
    sensor_errors: str = "10,0.5,0.1",
    write_back: bool = False,
    signalk_token: str | None = None,
    open_: Annotated[bool, tyro.conf.arg(name="open")] = True,
) -> None:
    """Serve the live page of a voyage on this machine and open it in the browser.

    In simulated traffic the pilot steers. In recorded traffic own ship keeps its track, in live
    traffic it goes its own way, and the pilot advises. The frames of every session are written to
    a log. Ctrl-C stops the server. Not for navigation.

    Args:
        source: gulf-of-finland, new-york, imazu:5, random:SEED, wide:SEED, path/to/situation.json,
            path/to/ais.csv; or live traffic: tcp://HOST:PORT or udp://HOST:PORT (NMEA 0183, AIS),
            signalk://HOST[:PORT], signalks://HOST[:PORT] (TLS), live:path/to/recording.nmea (a
            file, played as if it were now). The page can open other sources.
        pilots: The pilot and own ship.
        replay: Show this log of an earlier session instead of a source.
        log_dir: Folder for the logs (default: the user's data folder, which is printed).
        host: Address to serve on; any but this machine's own needs a token.
        port: Port to serve on (default: 8470, or any free port if that is taken).
        token: A secret that opens the page for the owner, 12 characters or more.
        viewer_token: A different secret, for those who may only watch. Both addresses are printed.
        sensor_errors: Largest sensor errors, in metres, degrees and knots, that the certified
            certified band allows for; "off" for no band.
        write_back: Write rudder, closest approaches and alarms back to the Signal K source.
        signalk_token: A token of the Signal K source, needed to write back, and to read from a
            server that nobody may read otherwise. It is sent to that server alone.
        open_: Open the page in the browser.
    """
    from glasshelm.bridge.server.access_control import AccessControl
    from glasshelm.bridge.server.app import create_app
    from glasshelm.bridge.server.protocol import Open
    from glasshelm.bridge.server.server import bind, limits_of_process, page_url, serve
    from glasshelm.bridge.server.session_hub import SessionHub
    from glasshelm.bridge.sessions.log_index import LogIndex, default_log_dir
    from glasshelm.bridge.sessions.session_factory import open_replay, prepare_session
    from glasshelm.bridge.sessions.source_list import SourceList, is_live_source
    from glasshelm.certify.sensor_error_bounds import parse_error_bounds
    from glasshelm.core.errors import InputError
    from glasshelm.core.output_dir import writable_folder
    from glasshelm.core.terminal import Terminal
    from glasshelm.feeds.feed_factory import is_signalk, signalk_server
    from glasshelm.frames.frame_log import read_log
    from glasshelm.live.signalk_writer import SignalKWriter

    console = Terminal()
    access = AccessControl(host, token, viewer_token)
    errors = None if sensor_errors == "off" else parse_error_bounds(sensor_errors)
    logs = default_log_dir() if log_dir is None else log_dir
    if replay is None or log_dir is not None:
        try:
            writable_folder(logs)
        except InputError as error:
            if not is_live_source(source) or replay is not None:
                raise
            # Live traffic is shown all the same, and logged as soon as it can be.
            console.say(f"logs:   {error}")
    if signalk_token is not None and not is_signalk(source):
        raise InputError(f"{source}: a Signal K token is for signalk://HOST[:PORT] only")
    sources = SourceList(LogIndex(logs), source, pilots.pilot, signalk_token, pilots.minutes)
    if replay is not None:
        if next(read_log(replay), None) is None:  # the rest is read when the page is served
            raise InputError(f"{replay}: no frame in it; it was cut off, or is not a log")
        open_first = lambda: open_replay(replay, hub.jobs.report_progress)  # noqa: E731
    else:
        request = Open(source, pilots.pilot, pilots.ship, pilots.own, pilots.at)
        open_first = prepare_session(request, sources, logs)
    writer = SignalKWriter(signalk_server(source, signalk_token)) if write_back else None
    bound = bind(host, port)
    url = page_url(bound, token)
    limits = limits_of_process()
    hub = SessionHub(sources, logs, writer, errors)
    app = create_app(hub, access, open_first, max_viewers=limits.viewers)

    def print_addresses() -> None:
        lines = {"bridge": url, "logs": str(logs)}
        if viewer_token is not None:
            lines = {"bridge": url, "view only": page_url(bound, viewer_token), "logs": str(logs)}
        for name, text in lines.items():
            console.say(f"{name + ':':{max(map(len, lines)) + 1}} {text}")
        console.say("Advisory research software, not for navigation. Ctrl-C stops.")

    serve(app, bound, url, open_, print_addresses, limits)
    _exit()


def _exit() -> None:
    """End the process without waiting for a thread that compiles, as it cannot be stopped.

    The logs are closed by now. Other threads have a second, so that a program being kept is
    written whole.
    """
    deadline = time.monotonic() + 1.0
    main = threading.main_thread()
    busy = [t for t in threading.enumerate() if t is not main and not t.daemon]
    for thread in busy:
        thread.join(max(deadline - time.monotonic(), 0.0))
    if any(thread.is_alive() for thread in busy):
        logging.shutdown()
        os._exit(0)
