"""The web application: the page's files, one WebSocket and a health check."""

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import anyio
from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.middleware import Middleware
from starlette.requests import HTTPConnection, Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from glasshelm import __version__
from glasshelm.bridge.server.access_control import SECURITY_HEADERS, TOKEN_COOKIE, AccessControl
from glasshelm.bridge.server.session_hub import MAX_VIEWERS, SessionHub
from glasshelm.bridge.server.viewer_queue import ViewerQueue
from glasshelm.bridge.sessions.session import Session

STATIC_DIR = Path(__file__).parent.parent / "static"
_PAGE_NOT_BUILT = (
    "<!doctype html><html lang=en><meta charset=utf-8><title>Glasshelm</title>"
    "<p>The page is not built in this copy. In a clone of the repository run "
    "<code>make page</code>, then reload.</p></html>"
)


def create_app(
    hub: SessionHub,
    access: AccessControl,
    open_first: Callable[[], Session] | None = None,
    static: Path = STATIC_DIR,
    max_viewers: int = MAX_VIEWERS,
) -> Starlette:
    """Create the application that serves a hub, and runs it while the application runs.

    Args:
        hub: The session and its viewers.
        access: Who may connect.
        open_first: Opens the first session; the task that calls it is ``app.state.opening``.
        static: Folder of the built page.
        max_viewers: Viewers at once; a tenth of the places is reserved for owners.
    """
    connected: set[ViewerQueue] = set()

    @contextlib.asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        tasks = [asyncio.create_task(hub.run())]
        app.state.withdraw = hub.player.withdraw
        if open_first is not None:
            app.state.opening = asyncio.create_task(hub.show(open_first))
            tasks.append(app.state.opening)
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            hub.close()

    async def index(request: Request) -> Response:
        page = static / "index.html"
        text = page.read_text(encoding="utf-8") if page.is_file() else _PAGE_NOT_BUILT
        response = HTMLResponse(text, headers={"Cache-Control": "no-cache"})
        token = access.cookie_token(request)
        if token is not None:
            response.set_cookie(TOKEN_COOKIE, token, httponly=True, samesite="strict")
        return response

    built_files = StaticFiles(directory=static, check_dir=False)

    async def files(scope: Scope, receive: Receive, send: Send) -> None:
        app = built_files if static.is_dir() else PlainTextResponse("Not Found", 404)
        await app(scope, receive, send)

    async def health(request: Request) -> Response:
        return JSONResponse({"version": __version__, **hub.health()})

    async def socket(websocket: WebSocket) -> None:
        role = access.role(websocket) or "viewer"
        reserved = 0 if role == "owner" else math.ceil(max_viewers / 10)
        if len(connected) >= max_viewers - reserved:
            await websocket.close(1013, "too many viewers")
            return
        viewer = ViewerQueue(role)
        connected.add(viewer)
        try:
            await websocket.accept()
            await _serve_viewer(websocket, hub, viewer)
        finally:
            connected.remove(viewer)

    return Starlette(
        routes=[
            Route("/", index),
            Route("/index.html", index),
            Route("/api/health", health),
            WebSocketRoute("/ws", socket),
            Mount("/", files),
        ],
        middleware=[Middleware(_AccessMiddleware, access=access)],
        lifespan=lifespan,
    )


async def _serve_viewer(websocket: WebSocket, hub: SessionHub, viewer: ViewerQueue) -> None:
    """Serve one viewer until either side closes."""

    async def send() -> None:
        with contextlib.suppress(WebSocketDisconnect, OSError):
            while True:
                await websocket.send_text((await viewer.get()).decode())
        group.cancel_scope.cancel()

    async def receive() -> None:
        await hub.join(viewer)
        while (message := await websocket.receive())["type"] != "websocket.disconnect":
            text = message.get("text")
            await hub.handle_message(viewer, message.get("bytes") or b"" if text is None else text)
        group.cancel_scope.cancel()

    try:
        async with anyio.create_task_group() as group:
            group.start_soon(send)
            group.start_soon(receive)
    finally:
        hub.leave(viewer)


class _AccessMiddleware:
    """Refuses connections that are not admitted, and adds the security headers to responses."""

    def __init__(self, app: ASGIApp, access: AccessControl):
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._access.refusal(HTTPConnection(scope))
        if scope["type"] == "websocket":
            if refusal is None:
                await self._app(scope, receive, send)
            else:
                await WebSocket(scope, receive, send).close(1008, refusal)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(SECURITY_HEADERS)
            await send(message)

        if refusal is None or scope["path"] == "/api/health":
            await self._app(scope, receive, send_with_headers)
        else:
            response = PlainTextResponse(f"Refused: {refusal}\n", status_code=403)
            await response(scope, receive, send_with_headers)
