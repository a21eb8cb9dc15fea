"""The server of the Map view: maps that grow on a socket, points of them, curves over them."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
from anyio import from_thread
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from latolato.app.answers import answered, json_of, message_of
from latolato.core.errors import InputError
from latolato.io.progress import compiling

if TYPE_CHECKING:
    from latolato.app.map_cells import Maps
    from latolato.app.map_request import Map
    from latolato.app.map_shown import Shown

# Maps that are computed at the same time; further ones wait.
_MAPS = 2
_WRONG_DATA = 1007
_MOST_TOLD = 300  # characters of a message
_making = threading.Lock()


def routes() -> list[BaseRoute]:
    """Return the routes of the Map view."""
    return [
        WebSocketRoute("/ws/map", _socket),
        Route("/api/map/point", _point, methods=["POST"]),
        Route("/api/map/overlays", _overlays, methods=["POST"]),
        Route("/api/map/contours", _contours, methods=["POST"]),
        Route("/api/map/stored", _stored),
        Route("/download/map.{kind}", _file, methods=["POST"]),
    ]


async def _socket(socket: WebSocket) -> None:
    """Compute one map for a page; its end is the end of the socket."""
    await socket.accept()
    try:
        message = await socket.receive()
    except WebSocketDisconnect:
        return
    if message["type"] != "websocket.receive":
        return
    try:
        given = json.loads(message.get("text") or message.get("bytes") or b"")
    except (ValueError, RecursionError):
        await _refuse(socket, InputError("a map is asked for in JSON"))
        return
    import numpy as np

    cancel = np.zeros(1, dtype=np.int64)
    state = socket.app.state
    if state.maps is None:
        state.maps = anyio.CapacityLimiter(_MAPS)
    loop = asyncio.get_running_loop()

    def report(phase: str) -> None:
        """Tell the page, from whatever thread, what it waits for."""
        told = json.dumps({"phase": phase})
        asyncio.run_coroutine_threadsafe(_send(socket, told), loop)

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(_listen, socket, cancel)
        if state.maps.available_tokens < 1:
            report("waiting")
        try:
            await anyio.to_thread.run_sync(_work, socket, given, cancel, report, limiter=state.maps)
        finally:
            tasks.cancel_scope.cancel()
    with suppress(RuntimeError, WebSocketDisconnect):
        await socket.close()


async def _listen(socket: WebSocket, cancel: Any) -> None:
    """Stop the kernels as soon as the page goes, or says anything more."""
    with suppress(WebSocketDisconnect, RuntimeError):
        await socket.receive()
    cancel[0] = 1


async def _send(socket: WebSocket, frame: bytes | str) -> None:
    """Send a frame; that the page has gone is noticed elsewhere."""
    with suppress(RuntimeError, WebSocketDisconnect):
        if isinstance(frame, str):
            await socket.send_text(frame)
        else:
            await socket.send_bytes(frame)


async def _refuse(socket: WebSocket, error: Exception) -> None:
    """Say in one line what is wrong, and end."""
    await _send(socket, _line(error))
    with suppress(RuntimeError, WebSocketDisconnect):
        await socket.close(_WRONG_DATA)


def _line(error: Exception) -> str:
    """Return an error as a page reads it."""
    told = message_of(error)
    return json.dumps({**told, "error": told["error"][:_MOST_TOLD]})


def _work(socket: WebSocket, given: Any, cancel: Any, report: Callable[[str], None]) -> None:
    """Compute a map in a thread and send its frames one after the other."""
    from latolato.app.map_job import frames
    from latolato.sweeps.chunk import Cancelled

    def send(frame: bytes | str) -> None:
        from_thread.run(_send, socket, frame)

    try:
        if isinstance(given, dict) and "stored" in given:
            from latolato.app.map_stored import frames_of

            for frame in frames_of(_path(socket.app, given["stored"]), given):
                send(frame)
            return
        shown, choices = _map(given)
        send(json.dumps({"choices": choices}))
        with (
            compiling(lambda: report("compiling"), lambda: None),
            closing(frames(shown, cancel, cells_of(socket.app))) as result,
        ):
            for frame in result:
                send(frame)
    except Cancelled:
        return
    except Exception as error:
        if not cancel[0]:
            send(_line(error))


def cells_of(app: Any) -> Maps:
    """Return the points of maps that this server has computed."""
    from latolato.app.map_cells import Maps

    with _making:
        if app.state.map_cells is None:
            app.state.map_cells = Maps()
    result: Maps = app.state.map_cells
    return result


def _map(given: Any) -> tuple[Map, dict[str, Any]]:
    """Return the map that a page asks for, and what it may choose from, ready for JSON."""
    from latolato.app.map_request import MapRequest, make_map
    from latolato.simulation.summary import plain

    shown = make_map(MapRequest.from_json(given))
    return shown, plain(shown.choices)


def _path(app: Any, name: Any) -> Path:
    """Return the file of a stored map; only those that the command line named are opened."""
    paths: dict[str, Path] = app.state.stored
    if not isinstance(name, str) or name not in paths:
        raise InputError(f"there is no stored map {name!r}: start with latolato app --open MAP")
    return paths[name]


async def _stored(request: Request) -> Response:
    return JSONResponse(list(request.app.state.stored))


async def _point(request: Request) -> Response:
    given = await json_of(request)
    return await answered(request, _point_response, request.app, given)


def _point_response(app: Any, given: Any) -> Response:
    """Return the run of one point of a map."""
    from latolato.app.given import check_size
    from latolato.app.map_point import scenario_at
    from latolato.app.runs import block_of

    scenario = scenario_at(given, lambda name: _path(app, name))
    check_size(scenario)
    return Response(block_of(scenario), media_type="application/octet-stream")


async def _overlays(request: Request) -> Response:
    given = await json_of(request)
    return await answered(request, _overlays_response, request.app, given)


def _overlays_response(app: Any, given: Any) -> Response:
    """Return the curves and the trials over a map."""
    from latolato.app.map_point import overlays

    block = overlays(given, lambda name: _path(app, name))
    return Response(block, media_type="application/octet-stream")


async def _contours(request: Request) -> Response:
    given = await json_of(request)
    return await answered(request, _contours_response, request.app, given)


def _contours_response(app: Any, given: Any) -> Response:
    """Return the contour lines of a map."""
    from latolato.app.map_contours import contour_block

    block = contour_block(_shown(app, given), given)
    return Response(block, media_type="application/octet-stream")


def _shown(app: Any, given: Any) -> Shown:
    """Return the map that a page shows."""
    from latolato.app.map_shown import shown_of

    return shown_of(given, cells_of(app), lambda name: _path(app, name))


async def _file(request: Request) -> Response:
    given = await json_of(request)
    return await answered(request, _file_response, request.app, request.path_params["kind"], given)


def _file_response(app: Any, kind: str, given: Any) -> Response:
    """Return a file of a map."""
    from latolato.app.map_files import file_response

    return file_response(kind, given, lambda asked: _shown(app, asked))
