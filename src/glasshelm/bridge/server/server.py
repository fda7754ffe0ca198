"""The server as a process: it binds, says where it is, opens the browser, and runs."""

import asyncio
import contextlib
import signal
import socket
import threading
import webbrowser
from collections.abc import Awaitable, Callable
from urllib.parse import quote

import uvicorn
from starlette.applications import Starlette

from glasshelm.bridge.server import quiet_logging
from glasshelm.bridge.server.connections import ConnectionLimits, ServerConfig
from glasshelm.core.errors import InputError

#: Taken if it is free and no other is named.
DEFAULT_PORT = 8470
#: Connections that the system keeps until they are accepted.
_QUEUE = 128


def bind(host: str, port: int | None) -> socket.socket:
    """A bound socket: of the port named, or else of the default or any free one."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for candidate in (DEFAULT_PORT, 0) if port is None else (port,):
        bound = socket.socket(family)
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            bound.bind((host, candidate))
            bound.listen(_QUEUE)
        except (OSError, OverflowError) as error:
            bound.close()
            problem = getattr(error, "strerror", None) or str(error)
            if candidate != DEFAULT_PORT or port is not None:
                raise InputError(f"{host} port {candidate}: {problem}") from None
            continue
        return bound
    raise AssertionError("port 0 either binds or raises")


def page_url(bound: socket.socket, token: str | None) -> str:
    """The address to open in a browser."""
    host, port = bound.getsockname()[:2]
    name = f"[{host}]" if ":" in host else host
    return f"http://{name}:{port}/" + (f"?token={quote(token, safe='')}" if token else "")


def serve(
    app: Starlette,
    bound: socket.socket,
    url: str,
    browse: bool,
    ready: Callable[[], None],
    room: ConnectionLimits | None = None,
) -> None:
    """Run until interrupted; ``ready`` is called when the first viewer can come.

    There is nothing to serve where the first session cannot begin: what is wrong is then raised.
    """
    server = _Server(ServerConfig(app, room), app)

    async def run() -> None:
        quiet_logging.install()
        _end_with_the_terminal(server)
        task = asyncio.create_task(server.serve(sockets=[bound]))
        while not server.started and not task.done():
            await asyncio.sleep(0.02)
        if server.started:
            bound.listen(_QUEUE)  # so many may wait, though fewer are accepted at once
            with contextlib.suppress(Exception):  # nobody reads that, or there is no browser
                ready()
                if browse:
                    await asyncio.to_thread(webbrowser.open, url)
            opening: asyncio.Task[None] | None = getattr(app.state, "opening", None)
            if opening is not None:
                await asyncio.wait((task, opening), return_when=asyncio.FIRST_COMPLETED)
                if failed := _failed(opening):
                    server.should_exit = True
                    await task
                    raise failed
        await task

    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(run())


class _Server(uvicorn.Server):
    """However it is told to end, what was written elsewhere is taken back before it closes."""

    def __init__(self, config: uvicorn.Config, app: Starlette):
        super().__init__(config)
        self._app = app

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        withdraw: Callable[[], Awaitable[None]] | None = getattr(self._app.state, "withdraw", None)
        if withdraw is not None:
            await withdraw()
        await super().shutdown(sockets)


def _end_with_the_terminal(server: uvicorn.Server) -> None:
    """A terminal that is closed ends the server as Ctrl-C does, not at once."""
    hangup: signal.Signals | None = getattr(signal, "SIGHUP", None)  # not on Windows
    if hangup is None or threading.current_thread() is not threading.main_thread():
        return
    if signal.getsignal(hangup) == signal.SIG_DFL:  # not under nohup
        asyncio.get_running_loop().add_signal_handler(hangup, server.handle_exit, hangup, None)


def _failed(task: asyncio.Task[None]) -> BaseException | None:
    """What a task has failed with; None while it runs, and if it was cancelled."""
    return task.exception() if task.done() and not task.cancelled() else None


def limits_of_process() -> ConnectionLimits:
    """For how many connections this process may open files."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return ConnectionLimits()
    most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return (
        ConnectionLimits() if most == resource.RLIM_INFINITY else ConnectionLimits.for_files(most)
    )
