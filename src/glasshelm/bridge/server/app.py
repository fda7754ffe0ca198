"""The web application: the page's files, one WebSocket, and a sign of life."""

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import anyio
from starlette.applications import Starlette
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
    guard: AccessControl,
    first: Callable[[], Session] | None = None,
    static: Path = STATIC_DIR,
    most_viewers: int = MAX_VIEWERS,
) -> Starlette:
    """The application around a hub, whose clock runs as long as it does.

    ``first`` opens the session that is shown at the beginning; ``state.opening`` is the task
    that does, and tells whether it failed. A tenth of ``most_viewers`` is kept for owners.
    """
    seated: list[ViewerQueue] = []

    @contextlib.asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        tasks = [asyncio.create_task(hub.run())]
        app.state.withdraw = hub.withdraw
        if first is not None:
            app.state.opening = asyncio.create_task(hub.show(first))
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
        answer = HTMLResponse(text, headers={"Cache-Control": "no-cache"})
        token = guard.cookie_token(request)
        if token is not None:
            answer.set_cookie(TOKEN_COOKIE, token, httponly=True, samesite="strict")
        return answer

    built = StaticFiles(directory=static, check_dir=False)

    async def files(scope: Scope, receive: Receive, send: Send) -> None:
        there = static.is_dir()
        await (built if there else PlainTextResponse("Not Found", 404))(scope, receive, send)

    async def health(request: Request) -> Response:
        troubles = hub.faults
        dropped = hub.dropped + sum(viewer.dropped for viewer in hub.viewers)
        return JSONResponse(
            {
                "version": __version__,
                "status": "failing" if troubles else "ok",
                "troubles": troubles,
                "viewers": len(hub.viewers),
                "messages": hub.asked,
                "refused_messages": hub.refused,
                "failed_messages": hub.failed,
                "dropped_frames": dropped,
                "heard": hub.feed_counts,
            }
        )

    async def socket(websocket: WebSocket) -> None:
        role = guard.role(websocket) or "viewer"
        most = most_viewers if role == "owner" else most_viewers - math.ceil(most_viewers / 10)
        if len(seated) >= most:
            await websocket.close(1013, "too many viewers")
            return
        viewer = ViewerQueue(role)
        seated.append(viewer)
        try:
            await websocket.accept()
            await _serve_viewer(websocket, hub, viewer)
        finally:
            seated.remove(viewer)

    return Starlette(
        routes=[
            Route("/", index),
            Route("/index.html", index),
            Route("/api/health", health),
            WebSocketRoute("/ws", socket),
            Mount("/", files),
        ],
        middleware=[Middleware(_AccessMiddleware, guard=guard)],
        lifespan=lifespan,
    )


async def _serve_viewer(websocket: WebSocket, hub: SessionHub, viewer: ViewerQueue) -> None:
    """Serve one viewer until either side closes."""

    async def send() -> None:
        with contextlib.suppress(WebSocketDisconnect, OSError):
            while True:
                await websocket.send_text((await viewer.get()).decode())
        group.cancel_scope.cancel()

    async def read() -> None:
        await hub.join(viewer)
        while True:
            message = await websocket.receive()
            if message["type"] == "websocket.disconnect":
                break
            text = message.get("text")
            await hub.handle_message(viewer, message.get("bytes") or b"" if text is None else text)
        group.cancel_scope.cancel()

    try:
        async with anyio.create_task_group() as group:
            group.start_soon(send)
            group.start_soon(read)
    finally:
        hub.leave(viewer)


class _AccessMiddleware:
    """Asks the guard first, and adds the headers of security to every answer."""

    def __init__(self, app: ASGIApp, guard: AccessControl):
        self._app, self._guard = app, guard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        problem = self._guard.refusal(HTTPConnection(scope))
        if scope["type"] == "websocket":
            if problem is None:
                await self._app(scope, receive, send)
            else:
                await WebSocket(scope, receive, send).close(1008, problem)
            return

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                added = [(k.lower().encode(), v.encode()) for k, v in SECURITY_HEADERS.items()]
                message["headers"] = [*message.get("headers", []), *added]
            await send(message)

        if problem is None or scope["path"] == "/api/health":
            await self._app(scope, receive, send_guarded)
        else:
            answer = PlainTextResponse(f"Refused: {problem}\n", status_code=403)
            await answer(scope, receive, send_guarded)
