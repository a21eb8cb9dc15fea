"""Live: one toy for each WebSocket, moved on in real time and steered by messages.

A page sends JSON texts: ``{"hello": {"scenario", "options", "controls", "state"}}`` first, then
objects with a growing number ``seq`` and one or more of ``set`` (controls), ``push`` (rad/s),
``drag`` (``{"ball", "angle"}``, null lets go), ``pause``, ``record`` (true or false), ``reset`` and
``ack`` (the number of the last frame that the page saw). The server sends a JSON text with
``ready`` once and ``error`` or ``recorded`` when there is something to tell, and sixty times a
second a frame of the numbers in `latolato.app.session.FRAME`, as little-endian doubles.
"""

from __future__ import annotations

import json
import secrets
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from latolato.app.answers import in_thread, message_of
from latolato.app.session import Session, checked_object
from latolato.app.toy import TICKS_PER_SECOND
from latolato.core.errors import InputError
from latolato.simulation.summary import plain

if TYPE_CHECKING:
    from latolato.app.recording import Kept


# A server that was kept from ticking for longer goes on from where the toy is.
MOST_BEHIND = 0.25  # s
MOST_MESSAGE = 10_000  # characters
MOST_ERRORS = 100  # of one page, before it is cut off
MOST_SESSIONS = 64
MOST_WAITED = 60.0  # s, for a greeting; it includes loading, or compiling, what computes
# While a toy stands still, one frame in so many goes out.
_PAUSED_TICKS = 6
# Recordings that wait for a download; the oldest go first.
MOST_KEPT = 8
_SUFFIXES = {
    "block": "application/octet-stream",
    "nc": "application/x-netcdf",
    "csv": "text/csv; charset=utf-8",
}


def routes() -> list[BaseRoute]:
    """Return the socket of the view, and where its recordings are fetched."""
    return [
        WebSocketRoute("/ws/live", live),
        Route("/api/recording/{name}.{suffix}", fetch),
    ]


def parsed(text: str) -> Any:
    """Return the JSON of a message.

    Raises
    ------
    InputError
        If it is too long or none.
    """
    if len(text) > MOST_MESSAGE:
        raise InputError(f"a message must not exceed {MOST_MESSAGE} characters, got {len(text)}")
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise InputError("a message must be JSON") from None


def told(error: Exception) -> str:
    """Return the frame that tells a page what was wrong."""
    answer = message_of(error)
    return json.dumps({**answer, "error": answer["error"][:500]})


async def live(socket: WebSocket) -> None:
    """Serve one page."""
    state = socket.app.state
    open_now = getattr(state, "live_sessions", 0)
    if open_now >= MOST_SESSIONS:
        await socket.close(1013, "too many toys are moving here")
        return
    state.live_sessions = open_now + 1
    try:
        await socket.accept()
        session = Session()
        greeted = False
        with anyio.move_on_after(MOST_WAITED):
            greeted = bool(await _until_gone(_greeted, socket, session))
        if not greeted:
            await _until_gone(socket.close, 1008, "no greeting that makes sense")
        else:
            async with anyio.create_task_group() as tasks:

                async def do(work: Callable[..., Any]) -> None:
                    await _until_gone(work, socket, session)
                    tasks.cancel_scope.cancel()

                tasks.start_soon(do, _move)
                tasks.start_soon(do, _listen)
    finally:
        state.live_sessions -= 1


async def _until_gone(work: Callable[..., Any], *given: Any) -> Any:
    """Return what `work` returns, None if the page went away meanwhile."""
    try:
        return await work(*given)
    except WebSocketDisconnect:
        return None
    except RuntimeError as error:  # what starlette raises for a socket that is closed
        if "close" in str(error) or "disconnect" in str(error):
            return None
        raise


async def _text(socket: WebSocket) -> str:
    """Return the next message.

    Raises
    ------
    InputError
        If it is binary.
    WebSocketDisconnect
        If there is none any more.
    """
    message = await socket.receive()
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1000))
    text = message.get("text")
    if not isinstance(text, str):
        raise InputError("a message must be text, got bytes")
    return text


async def _greeted(socket: WebSocket, session: Session) -> bool:
    """Wait for a hello that can be answered; return whether there was one."""
    for _ in range(MOST_ERRORS):
        try:
            given = parsed(await _text(socket))
            hello = checked_object("hello", checked_object("a message", given).get("hello"))
            answer = await in_thread(socket, session.begin, hello)
        except (WebSocketDisconnect, RuntimeError):
            raise
        except Exception as error:
            await socket.send_text(told(error))
            continue
        await socket.send_text(json.dumps({"ready": plain(answer)}))
        return True
    return False


async def _listen(socket: WebSocket, session: Session) -> None:
    """Do what messages ask for."""
    errors = 0
    while errors < MOST_ERRORS:
        try:
            session.apply(parsed(await _text(socket)))
        except InputError as error:
            errors += 1
            await socket.send_text(told(error))
        if session.finished:
            await _keep(socket, session)
    await socket.close(1008, "too many messages that make no sense")


async def _move(socket: WebSocket, session: Session) -> None:
    """Tick at absolute instants and send a frame at each; what cannot be sent is left out."""
    tick = 1.0 / TICKS_PER_SECOND
    origin, done = time.monotonic(), 0
    while True:
        wait = origin + (done + 1) * tick - time.monotonic()
        await anyio.sleep(max(wait, 0.0))
        now = time.monotonic()
        due = int((now - origin) / tick + 1e-6) - done
        if due > MOST_BEHIND * TICKS_PER_SECOND:
            origin, done, due = now - tick, 0, 1
        done += due
        fault = None if session.paused else session.advance(due)
        if fault is not None:
            message = f"{fault}: the toy begins again"
            await socket.send_text(json.dumps({"error": message, "field": None}))
        if session.finished:
            await _keep(socket, session)
        frame = None if session.paused and done % _PAUSED_TICKS else session.frame()
        if frame is not None:
            await socket.send_bytes(frame)


async def _keep(socket: WebSocket, session: Session) -> None:
    """Make a run of a finished recording and tell the page its name."""
    from latolato.app.recording import keep

    recording = session.finished.pop(0)
    kept = await in_thread(socket, keep, recording)
    shelf: dict[str, Kept] = _shelf(socket.app.state)
    name = secrets.token_hex(8)
    shelf[name] = kept
    while len(shelf) > MOST_KEPT:
        del shelf[next(iter(shelf))]
    about = kept.about
    wanted = ("reproduces", "by_hand", "note", "duration", "options", "gap")
    result = plain({**{key: about[key] for key in wanted}, "name": name})
    await socket.send_text(json.dumps({"recorded": result}))


def _shelf(state: Any) -> dict[str, Kept]:
    """Return the recordings that wait for a download, by name."""
    if not hasattr(state, "recordings"):
        state.recordings = {}
    result: dict[str, Kept] = state.recordings
    return result


async def fetch(request: Request) -> Response:
    """Answer with a recording as a block, NetCDF or CSV."""
    name, suffix = request.path_params["name"], request.path_params["suffix"]
    kept = _shelf(request.app.state).get(name)
    if kept is None or suffix not in _SUFFIXES:
        raise HTTPException(404, "there is no such recording any more")
    content = await in_thread(request, _written, kept, suffix)
    headers = {"Content-Disposition": f'attachment; filename="live.{suffix}"'}
    return Response(content, media_type=_SUFFIXES[suffix], headers=headers)


def _written(kept: Kept, suffix: str) -> bytes:
    """Return the content of a file of a recording."""
    if suffix == "block":
        return kept.block()
    from latolato.io.files import save

    with tempfile.TemporaryDirectory(prefix="latolato-") as folder:
        return save(kept.run, Path(folder) / f"live.{suffix}").read_bytes()
