"""The server as a process: it binds, says where it is, opens the browser, and runs."""

import asyncio
import contextlib
import socket
import webbrowser
from collections.abc import Callable

import uvicorn
from starlette.applications import Starlette

from glasshelm.bridge.messages import LARGEST
from glasshelm.errors import InputError

#: Taken if it is free and no other is named.
PORT = 8470


def bind(host: str, port: int | None) -> socket.socket:
    """A bound socket: of the port named, or else of the default or any free one."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for candidate in (PORT, 0) if port is None else (port,):
        bound = socket.socket(family)
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            bound.bind((host, candidate))
            bound.listen(128)
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
    return f"http://{name}:{port}/" + (f"?token={token}" if token else "")


def serve(
    app: Starlette, bound: socket.socket, url: str, browse: bool, ready: Callable[[], None]
) -> None:
    """Run until interrupted; ``ready`` is called when the first viewer can come.

    There is nothing to serve where the first session cannot begin: what is wrong is then raised.
    """
    config = uvicorn.Config(
        app,
        log_level="warning",
        log_config=None,  # as everything else that this process logs
        lifespan="on",
        # Larger than what is read, so that a message a little too long is answered in words.
        ws_max_size=16 * LARGEST,
        # Compressing for each viewer alone costs more than a local network does.
        ws_per_message_deflate=False,
        # A busy computer may take long to say that it is there; the page asks more often itself.
        ws_ping_timeout=60,
        timeout_graceful_shutdown=2,
        server_header=False,
    )
    server = uvicorn.Server(config)

    async def run() -> None:
        task = asyncio.create_task(server.serve(sockets=[bound]))
        while not server.started and not task.done():
            await asyncio.sleep(0.02)
        if server.started:
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
