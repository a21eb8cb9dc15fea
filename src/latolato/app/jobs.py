"""Long work for the pages, in processes that are ended when the page that asked for it goes.

A job lives as long as its WebSocket. The page sends one frame of JSON with its request. It
gets frames ``{"state": word, "elapsed": seconds, "progress": share}``, and at last either
``{"error": text, "field": option, "parts": its parts}`` or one binary block with the result.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import anyio
from anyio import to_process, to_thread
from starlette.websockets import WebSocket, WebSocketDisconnect

from latolato.app.answers import Body, body_of, message_of
from latolato.app.blocks import pack
from latolato.app.rules import RULES
from latolato.app.worker import STATUS, Compute, Result, run_apart, stand_back, status_in
from latolato.core.rules import broken_rule

# Time between two frames that say how far a job is [s].
_PAUSE = 0.2
# What starlette raises for a page that has gone.
GONE = (WebSocketDisconnect, RuntimeError)


def _temporary_folder() -> AbstractContextManager[str]:
    return tempfile.TemporaryDirectory(prefix="latolato-", ignore_cleanup_errors=True)


@dataclass(frozen=True)
class Job:
    """What a page asks for.

    Attributes
    ----------
    compute : callable
        Makes the result in a process of its own, which imports it by its name.
    request : mapping
        What it gets.
    finish : callable
        Returns the header for the page from that of the result.
    place : callable
        Returns a context manager that gives the folder for files, by default one that goes
        with the job.
    """

    compute: Compute
    request: Mapping[str, Any]
    finish: Callable[[dict[str, Any]], dict[str, Any]] = dict
    place: Callable[[], AbstractContextManager[str | Path]] = _temporary_folder


async def serve_job(websocket: WebSocket, prepare: Callable[[Body], Job]) -> None:
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
    with suppress(*GONE):
        try:
            job = await to_thread.run_sync(prepare, body_of(message.get("text") or ""))
            block = await _done(websocket, job)
        except Exception as error:
            await websocket.send_json(message_of(error))
        else:
            if block is None:
                return
            await websocket.send_bytes(block)
        await websocket.close()


async def _done(websocket: WebSocket, job: Job) -> bytes | None:
    """Return the block that a job ends with, None if the page goes before."""
    begun = time.monotonic()
    block: bytes | None = None
    error: Exception | None = None
    with job.place() as place:
        folder = Path(place)
        (folder / STATUS).unlink(missing_ok=True)  # of the job before
        async with anyio.create_task_group() as group:

            async def listen() -> None:
                while (await websocket.receive())["type"] != "websocket.disconnect":
                    pass
                group.cancel_scope.cancel()

            async def report() -> None:
                with suppress(*GONE):
                    while True:
                        elapsed = round(time.monotonic() - begun, 1)
                        await websocket.send_json({**status_in(folder), "elapsed": elapsed})
                        await anyio.sleep(_PAUSE)
                group.cancel_scope.cancel()

            group.start_soon(listen)
            group.start_soon(report)
            try:
                about, arrays = await _result(job, folder)
                block = await to_thread.run_sync(lambda: pack(job.finish(about), arrays))
            except Exception as caught:  # as it is, not in a group
                error = caught
            group.cancel_scope.cancel()
        if error is not None:
            raise error
    return block


async def _result(job: Job, folder: Path) -> Result:
    """Return the result of a job, when there is a process for it; it ends if this is cancelled."""
    try:
        # A process that is cancelled while it starts would be left behind, so that it starts first.
        with anyio.CancelScope(shield=True):
            await to_process.run_sync(stand_back)
        return await to_process.run_sync(
            run_apart, job.compute, job.request, folder, cancellable=True
        )
    except (anyio.BrokenWorkerProcess, ProcessLookupError):  # the latter of one that just started
        raise broken_rule("ended_by_itself", table=RULES) from None
