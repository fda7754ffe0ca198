"""The server as a process: it binds, says where it is, opens the browser, and runs."""

import asyncio
import contextlib
import socket
import webbrowser
from collections.abc import Callable
from urllib.parse import quote

import uvicorn
from starlette.applications import Starlette

from glasshelm.bridge import quiet
from glasshelm.bridge.connections import Config, Room
from glasshelm.errors import InputError

#: Taken if it is free and no other is named.
PORT = 8470
#: Connections that the system keeps until they are accepted.
_QUEUE = 128


def bind(host: str, port: int | None) -> socket.socket:
    """A bound socket: of the port named, or else of the default or any free one."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for candidate in (PORT, 0) if port is None else (port,):
        bound = socket.socket(family)
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            bound.bind((host, candidate))
            bound.listen(_QUEUE)
        except (OSError, OverflowError) as error:
            bound.close()
            problem = getattr(error, "strerror", None) or str(error)
            if candidate != PORT or port is not None:
                raise InputError(f"{host} port {candidate}: {problem}") from None
            continue
        return bound
    raise AssertionError("port 0 either binds or raises")


def address(bound: socket.socket, token: str | None) -> str:
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
    room: Room | None = None,
) -> None:
    """Run until interrupted; ``ready`` is called when the first viewer can come.

    There is nothing to serve where the first session cannot begin: what is wrong is then raised.
    """
    server = uvicorn.Server(Config(app, room))

    async def run() -> None:
        quiet.begin()
        task = asyncio.create_task(server.serve(sockets=[bound]))
        while not server.started and not task.done():
            await asyncio.sleep(0.02)
        if server.started:
            bound.listen(_QUEUE)  # so many may wait, though fewer are accepted at once
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


def _failed(task: asyncio.Task[None]) -> BaseException | None:
    """What a task has failed with; None while it runs, and if it was cancelled."""
    return task.exception() if task.done() and not task.cancelled() else None


def room_here() -> Room:
    """For how many connections this process may open files."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return Room()
    most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return Room() if most == resource.RLIM_INFINITY else Room.for_files(most)
