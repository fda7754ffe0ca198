"""The server process: it binds, prints its address, opens the browser, and runs."""

import asyncio
import contextlib
import signal
import socket
import threading
import webbrowser
from collections.abc import Callable
from urllib.parse import quote

import uvicorn
from starlette.applications import Starlette

from glasshelm.bridge.server import quiet_logging
from glasshelm.bridge.server.connections import ConnectionLimits, ServerConfig
from glasshelm.core.errors import InputError

#: Used if it is free and no other port is given.
DEFAULT_PORT = 8470
#: Connections that the system keeps until they are accepted.
_BACKLOG = 128


def bind(host: str, port: int | None) -> socket.socket:
    """Bind a socket to the given port, or else to the default port or any free one."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for candidate in (DEFAULT_PORT, 0) if port is None else (port,):
        bound = socket.socket(family)
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            bound.bind((host, candidate))
            bound.listen(_BACKLOG)
        except (OSError, OverflowError) as error:
            bound.close()
            if candidate != DEFAULT_PORT or port is not None:
                problem = getattr(error, "strerror", None) or str(error)
                raise InputError(f"{host} port {candidate}: {problem}") from None
            continue
        return bound
    raise AssertionError("port 0 either binds or raises")


def page_url(bound: socket.socket, token: str | None) -> str:
    """Return the address to open in a browser."""
    host, port = bound.getsockname()[:2]
    name = f"[{host}]" if ":" in host else host
    return f"http://{name}:{port}/" + (f"?token={quote(token, safe='')}" if token else "")


def serve(
    app: Starlette,
    bound: socket.socket,
    url: str,
    open_browser: bool,
    on_started: Callable[[], None],
    limits: ConnectionLimits = ConnectionLimits(),
) -> None:
    """Run the server until it is interrupted.

    Args:
        app: The application.
        bound: The socket to serve on.
        url: The address of the page.
        open_browser: Open the page in the browser.
        on_started: Called when viewers can connect.
        limits: How many connections are served.

    Raises:
        Exception: Why the first session cannot be opened; there is nothing to serve then.
    """
    server = _Server(ServerConfig(app, limits), app)

    async def run() -> None:
        quiet_logging.install()
        _exit_on_hangup(server)
        serving = asyncio.create_task(server.serve(sockets=[bound]))
        while not server.started and not serving.done():
            await asyncio.sleep(0.02)
        if server.started:
            bound.listen(_BACKLOG)  # so many may wait, though fewer are accepted at once
            with contextlib.suppress(Exception):  # nobody reads the output, or no browser
                on_started()
                if open_browser:
                    await asyncio.to_thread(webbrowser.open, url)
            opening: asyncio.Task[None] | None = getattr(app.state, "opening", None)
            if opening is not None:
                await asyncio.wait((serving, opening), return_when=asyncio.FIRST_COMPLETED)
                if opening.done() and not opening.cancelled() and (error := opening.exception()):
                    server.should_exit = True
                    await serving
                    raise error
        await serving

    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(run())


class _Server(uvicorn.Server):
    """However it is stopped, what was written back is withdrawn before the sockets close."""

    def __init__(self, config: uvicorn.Config, app: Starlette):
        super().__init__(config)
        self._app = app

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        if hasattr(self._app.state, "withdraw"):
            await self._app.state.withdraw()
        await super().shutdown(sockets)


def _exit_on_hangup(server: uvicorn.Server) -> None:
    """Let a closed terminal stop the server as Ctrl-C does, not at once."""
    hangup: signal.Signals | None = getattr(signal, "SIGHUP", None)  # not on Windows
    if hangup is None or threading.current_thread() is not threading.main_thread():
        return
    if signal.getsignal(hangup) == signal.SIG_DFL:  # not under nohup
        asyncio.get_running_loop().add_signal_handler(hangup, server.handle_exit, hangup, None)


def limits_of_process() -> ConnectionLimits:
    """Return for how many connections this process may open files."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return ConnectionLimits()
    max_files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if max_files == resource.RLIM_INFINITY:
        return ConnectionLimits()
    return ConnectionLimits.for_files(max_files)
