"""Live: one toy for each WebSocket, moved on in real time and steered by messages.

A page sends JSON texts: ``{"hello": {"scenario", "options", "controls", "state"}}`` first, then
objects with a growing number ``seq`` and one or more of ``set`` (controls), ``push`` (rad/s),
``drag`` (``{"ball", "angle"}``, null lets go), ``pause``, ``record`` (true or false), ``reset`` and
``ack`` (the number of the last frame that the page saw). The server sends a JSON text with
``ready`` once and ``error`` or ``recorded`` when there is something to tell, and sixty times a
second a frame of the numbers in `FRAME`, as little-endian doubles.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import struct
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from latolato.app.given import Asked
from latolato.app.server import field_of, in_thread
from latolato.physics.drives import CrankSlider, MeasuredPivot
from latolato.summary import plain

if TYPE_CHECKING:
    from latolato.app.recording import Kept, Recording
    from latolato.app.toy import Toy

# Numbers of a frame, in this order.
FRAME = (
    "number",  # of the frame
    "seq",  # of the last message that the frame knows
    "time",
    "angle_1",
    "angle_2",
    "velocity_1",
    "velocity_2",
    "pivot_height",
    "pivot_velocity",
    "pivot_acceleration",
    "drive_amplitude",  # as it is now; a change takes its time
    "drive_frequency",
    "phase",
    "kinetic_energy",
    "potential_energy",
    "contacts",  # since the start
    "clack",  # closing speed of the hardest contact since the last frame [rad/s]
    "recorded",  # seconds; -1 without a recording
    "flags",  # 1 paused, 2 a ball is held
)
_PACK = struct.Struct(f"<{len(FRAME)}d").pack
PAUSED, HELD = 1, 2

TICKS_PER_SECOND = 60
# Frames that a page has not seen yet; beyond that frames are left out, not queued.
MOST_UNSEEN = 60
# A server that was kept from ticking for longer goes on from where the toy is.
MOST_BEHIND = 0.25  # s
MOST_MESSAGE = 10_000  # characters
MOST_ERRORS = 100  # of one page, before it is cut off
MOST_SESSIONS = 64
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


class Session:
    """What one page does with its toy."""

    def __init__(self) -> None:
        self.toy: Toy | None = None
        self.asked: Asked | None = None
        self.seq = 0.0
        self.acked = 0
        self.number = 0
        self.paused = False
        self.finished: list[Recording] = []

    def begin(self, hello: Any) -> dict[str, Any]:
        """Make the toy that a page asks for and return what the page must know of it.

        Raises
        ------
        TypeError, ValueError
            For bad input.
        """
        from latolato.app.toy import Toy

        asked = Asked.from_json(hello)
        scenario = asked.to_scenario()
        if scenario.varied:
            raise ValueError(f"{scenario.name or 'this scenario'} is a map, not one run")
        toy = Toy(scenario, hello.get("state"))
        controls = hello.get("controls")
        if controls is not None:
            toy.set(_object("controls", controls))
            if hello.get("state") is None:
                toy.settle()
        toy.advance()  # whatever must be compiled or loaded is, before the clock runs
        self.toy, self.asked = toy, asked
        return ready(toy, scenario)

    def apply(self, message: Any) -> None:
        """Do what a message asks for.

        Raises
        ------
        TypeError, ValueError
            For bad input; nothing of the message is done then, but what stands before it.
        """
        assert self.toy is not None
        toy = self.toy
        given = _object("a message", message)
        known = ("seq", "ack", "set", "push", "drag", "pause", "record", "reset")
        for name in given:
            if name not in known:
                raise ValueError(f"unknown message '{name}': known are {', '.join(known)}")
        if "ack" in given:
            self.acked = int(_count("ack", given["ack"]))
        if "set" in given:
            toy.set(_object("set", given["set"]))
        if "push" in given:
            toy.push(given["push"])
        if "drag" in given:
            if given["drag"] is None:
                toy.release()
            else:
                drag = _object("drag", given["drag"])
                toy.hold(drag.get("ball"), drag.get("angle"))
        if "pause" in given:
            self.paused = _switch("pause", given["pause"])
        if "record" in given:
            if _switch("record", given["record"]):
                toy.record()
            else:
                self.stop_recording()
        if given.get("reset"):
            self.restart()
        if "seq" in given:
            self.seq = _count("seq", given["seq"])

    def restart(self) -> None:
        """Begin again from the start, with the controls as they are."""
        from latolato.app.toy import Toy

        assert self.toy is not None
        assert self.asked is not None
        self.stop_recording()
        fresh = Toy(self.asked.to_scenario())
        fresh.set(self.toy.controls)
        fresh.settle()
        self.toy = fresh

    def stop_recording(self) -> None:
        """End a recording, if there is one, and put it aside."""
        assert self.toy is not None
        found = self.toy.finish()
        if found is not None:
            self.finished.append(found)

    def advance(self, ticks: int) -> str | None:
        """Move the toy on; return why it had to begin again, if it had."""
        assert self.toy is not None
        try:
            for _ in range(ticks):
                self.toy.advance()
        except ArithmeticError as error:
            self.restart()
            return str(error)
        if self.toy.recording is not None and self.toy.recording.is_full:
            self.stop_recording()
        return None

    def frame(self) -> bytes | None:
        """Return the present numbers, or None while the page is behind."""
        toy = self.toy
        assert toy is not None
        if self.number - self.acked >= MOST_UNSEEN:
            return None
        self.number += 1
        state = toy.state()
        angles, velocities = (*toy.angles, 0.0)[:2], (*toy.velocities, 0.0)[:2]
        flags = PAUSED * self.paused | HELD * toy.is_held
        recorded = toy.recording.duration if toy.recording else (0.0 if toy.is_recording else -1.0)
        clack, toy.clack = toy.clack, 0.0
        return _PACK(
            self.number, self.seq, toy.time, *angles, *velocities, *toy.pivot,
            state["drive_amplitude"], state["drive_frequency"], state["phase"],
            toy.kinetic, toy.potential, toy.contacts, clack, recorded, flags,
        )  # fmt: skip


def ready(toy: Toy, scenario: Any) -> dict[str, Any]:
    """Return what a page must know of a toy beside its motion."""
    from latolato.app.given import options_of
    from latolato.app.runs import balls_of

    system = toy.system
    return {
        "balls": balls_of(scenario),
        "angles": system.angles,
        "natural_frequency": system.natural_frequency,
        "gravity": system.gravity,
        "controls": dict(toy.controls),
        "limits": {name: toy.limits[name] for name in toy.controls},
        "frame": FRAME,
        "title": scenario.title,
        "options": options_of(scenario),
        "by_cosine": not isinstance(scenario.drive, (CrankSlider, MeasuredPivot)),
    }


def _object(name: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise TypeError(f"{name} must be an object, got {_shown(value)}")
    return value


def _count(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(f"{name} must be a number, got {_shown(value)}")
    if not 0 <= value <= 2**53:
        raise ValueError(f"{name} must lie in [0, 2^53], got {_shown(value)}")
    return float(value)


def _switch(name: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{name} must be true or false, got {_shown(value)}")
    return value


def _shown(value: Any) -> str:
    return repr(value)[:60]


def parsed(text: str) -> Any:
    """Return the JSON of a message.

    Raises
    ------
    ValueError
        If it is too long or none.
    """
    if len(text) > MOST_MESSAGE:
        raise ValueError(f"a message must not exceed {MOST_MESSAGE} characters, got {len(text)}")
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise ValueError("a message must be JSON") from None


def told(error: Exception) -> str:
    """Return the frame that tells a page what was wrong."""
    message = " ".join(str(error).split())[:500]
    return json.dumps({"error": message, "field": field_of(message)})


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
        if await _greeted(socket, session):
            await _both(socket, session)
    except WebSocketDisconnect:
        pass
    except RuntimeError as error:  # what starlette raises for a socket that is gone
        if "close" not in str(error) and "disconnect" not in str(error).lower():
            raise
    finally:
        state.live_sessions -= 1


async def _text(socket: WebSocket) -> str:
    """Return the next message.

    Raises
    ------
    TypeError
        If it is binary.
    WebSocketDisconnect
        If there is none any more.
    """
    message = await socket.receive()
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1000))
    text = message.get("text")
    if not isinstance(text, str):
        raise TypeError("a message must be text, got bytes")
    return text


async def _greeted(socket: WebSocket, session: Session) -> bool:
    """Wait for a hello that can be answered; return whether there was one."""
    for _ in range(MOST_ERRORS):
        try:
            given = parsed(await _text(socket))
            hello = _object("hello", _object("a message", given).get("hello"))
            answer = await in_thread(socket, session.begin, hello)
        except (TypeError, ValueError, ArithmeticError, ModuleNotFoundError) as error:
            await socket.send_text(told(error))
            continue
        await socket.send_text(json.dumps({"ready": plain(answer)}))
        return True
    await socket.close(1008, "too many messages that make no sense")
    return False


async def _both(socket: WebSocket, session: Session) -> None:
    """Listen and move until the page goes."""
    moving = asyncio.ensure_future(_move(socket, session))
    listening = asyncio.ensure_future(_listen(socket, session))
    await asyncio.wait({moving, listening}, return_when=asyncio.FIRST_COMPLETED)
    for task in (moving, listening):
        task.cancel()
    ends = await asyncio.gather(moving, listening, return_exceptions=True)
    for end in ends:  # both may have met the end of the socket
        if isinstance(end, Exception) and not isinstance(end, WebSocketDisconnect):
            raise end


async def _listen(socket: WebSocket, session: Session) -> None:
    """Do what messages ask for."""
    errors = 0
    while errors < MOST_ERRORS:
        try:
            session.apply(parsed(await _text(socket)))
        except (TypeError, ValueError) as error:
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
        await asyncio.sleep(max(wait, 0.0))
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
        frame = session.frame()
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
    found = plain({**{key: about[key] for key in wanted}, "name": name})
    await socket.send_text(json.dumps({"recorded": found}))


def _shelf(state: Any) -> dict[str, Kept]:
    """Return the recordings that wait for a download, by name."""
    if not hasattr(state, "recordings"):
        state.recordings = {}
    found: dict[str, Kept] = state.recordings
    return found


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
    from latolato.files import save

    with tempfile.TemporaryDirectory(prefix="latolato-") as folder:
        return save(kept.run, Path(folder) / f"live.{suffix}").read_bytes()
