"""Long work for the pages, in processes that are ended when the page that asked for it goes.

A job lives as long as its WebSocket. The page sends one frame of JSON that says what it wants. It
gets frames of JSON that say how far the work is, and at last ``{"error": ..., "field": ...}`` or
one binary block with what was found.
"""

from __future__ import annotations

import json
import shutil
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import anyio
from starlette.websockets import WebSocket, WebSocketDisconnect

from latolato.app.answers import field_of, in_thread
from latolato.app.processes import JobError, Workers
from latolato.core.errors import said_of

# Jobs at the same time; others wait.
MOST_JOBS = 2
MOST_SECONDS = 900.0
# Time between two frames that say how far a job is [s].
_PAUSE = 0.2
_BAD_FRAME = 1007
# What starlette raises for a page that has gone.
_GONE = (WebSocketDisconnect, RuntimeError)


@dataclass(frozen=True)
class Job:
    """What a page wants.

    Attributes
    ----------
    name : str
        One of `latolato.app.worker.JOBS`.
    given : mapping
        What the job gets, as JSON knows it.
    finish : callable
        Makes the block for the page of what the job told and of the folder with its files.
    ready : bytes, optional
        The block, if it is known already.
    """

    name: str
    given: Mapping[str, Any]
    finish: Callable[[dict[str, Any], Path], bytes]
    ready: bytes | None = None


def workers_of(state: Any) -> Workers:
    """Return the processes of the server with this state."""
    if getattr(state, "jobs", None) is None:
        state.jobs = Workers(anyio.CapacityLimiter(MOST_JOBS))
    result: Workers = state.jobs
    return result


async def serve_job(websocket: WebSocket, prepare: Callable[[Any], Job]) -> None:
    """Do for a page what its first frame asks for, until it is done or the page goes.

    Parameters
    ----------
    prepare : callable
        Makes a `Job` of the frame's JSON, in a thread; raises for bad input.
    """
    await websocket.accept()
    message = await websocket.receive()
    if message["type"] == "websocket.disconnect":
        return
    try:
        given = json.loads(message.get("text") or "")
    except (ValueError, RecursionError):
        with suppress(*_GONE):
            await websocket.close(_BAD_FRAME, "a request must be JSON")
        return
    with suppress(*_GONE):
        try:
            job = await in_thread(websocket, prepare, given)
            block = job.ready if job.ready is not None else await _done(websocket, job)
        except WebSocketDisconnect:
            raise
        except Exception as error:
            # As it is: the questions of Analyse have names of their own, which their page puts.
            await websocket.send_json({"error": said_of(error), "field": field_of(error)})
        else:
            if block is None:
                return
            await websocket.send_bytes(block)
        await websocket.close()


async def _done(websocket: WebSocket, job: Job) -> bytes | None:
    """Return the block that a job ends with, None if the page goes before."""
    block: bytes | None = None
    error: Exception | None = None
    async with anyio.create_task_group() as group:

        async def until_gone() -> None:
            while (await websocket.receive())["type"] != "websocket.disconnect":
                pass
            group.cancel_scope.cancel()

        group.start_soon(until_gone)
        try:
            block = await _work(websocket, job)
        except Exception as caught:  # as it is, not in a group
            error = caught
        group.cancel_scope.cancel()
    if error is not None:
        raise error
    return block


async def _work(websocket: WebSocket, job: Job) -> bytes:
    """Return the block that a job ends with; tell the page meanwhile how far it is."""
    workers = workers_of(websocket.app.state)
    told: dict[str, Any] = {"state": "waiting"}
    begun = time.monotonic()

    def hear(message: dict[str, Any]) -> None:
        nonlocal begun
        if "progress" in message:
            told["progress"] = message["progress"]
        if "compiling" in message:
            told["state"] = "compiling" if message["compiling"] else "working"
        if "ready" in message:
            told["state"] = "working"
        if "begun" in message:
            begun = time.monotonic()
            told["state"] = "working" if message["begun"] else "starting"

    gone: WebSocketDisconnect | None = None

    async def report(scope: anyio.CancelScope) -> None:
        nonlocal gone
        try:
            while True:
                await websocket.send_json({**told, "elapsed": round(time.monotonic() - begun, 1)})
                await anyio.sleep(_PAUSE)
        except _GONE:  # nobody waits for the work any more
            gone = WebSocketDisconnect()
            scope.cancel()

    folder = Path(tempfile.mkdtemp(prefix="latolato-"))
    result: dict[str, Any] = {}
    error: Exception | None = None
    try:
        async with anyio.create_task_group() as group:
            group.start_soon(report, group.cancel_scope)
            try:
                result = await workers.do(job.name, job.given, folder, hear, seconds=MOST_SECONDS)
            except JobError as caught:  # as it is, not in the group of a task group
                error = caught
            except TimeoutError:
                error = JobError(
                    f"this takes more than {MOST_SECONDS / 60:.0f} minutes: ask for less"
                )
            group.cancel_scope.cancel()
        error = gone or error
        if error is not None:
            raise error
        return await anyio.to_thread.run_sync(job.finish, result, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
