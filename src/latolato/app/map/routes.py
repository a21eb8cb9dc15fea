"""The server of the view Map: opens stored maps and makes files, as jobs."""

from __future__ import annotations

from functools import partial

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from latolato.app.jobs import serve_job
from latolato.app.map import files, stored


def routes() -> list[BaseRoute]:
    """Return the routes of the view Map."""
    return [
        Route("/api/map/stored", _stored),
        WebSocketRoute("/ws/map/stored", _open),
        WebSocketRoute("/ws/map/file", _file),
    ]


async def _stored(request: Request) -> Response:
    return JSONResponse(list(request.app.state.stored))


async def _open(websocket: WebSocket) -> None:
    state = websocket.app.state
    await serve_job(websocket, partial(stored.prepare, state.stored))


async def _file(websocket: WebSocket) -> None:
    state = websocket.app.state
    await serve_job(websocket, partial(files.prepare, state.stored))
