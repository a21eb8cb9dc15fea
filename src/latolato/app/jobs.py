"""Long work for the pages, in processes that are ended when the page that asked for it goes.

A job lives as long as its WebSocket. The page sends one frame of JSON that says what it wants. It
gets frames of JSON that say how far the work is, and at last ``{"error": ..., "field": ...}`` or
one binary block with what was found.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import anyio
from starlette.websockets import WebSocket, WebSocketDisconnect

from latolato.app.server import field_of, in_thread

# Jobs at the same time; others wait.
MOST_JOBS = 2
MOST_SECONDS = 900.0
# Time between two frames that say how far a job is [s].
_PAUSE = 0.2
_BAD_FRAME = 1007
# What bad input raises; anything else is a fault of ours.
_REFUSED = (TypeError, ValueError, ModuleNotFoundError)


class JobError(ValueError):
    """A job that gave no answer, with the line that says why."""


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


class Worker:
    """A process that does one job after the other."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "latolato.app.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            encoding="utf-8",
        )
        self.is_ready = False

    def run(self, job: Job, folder: Path, tell: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
        """Return what a job found; its files are in `folder`.

        Raises
        ------
        JobError
            With the reason in one line.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        request = {"job": job.name, "given": job.given, "folder": str(folder)}
        with suppress(OSError):  # a process that is gone: reading tells
            self.process.stdin.write(json.dumps(request) + "\n")
            self.process.stdin.flush()
        for line in self.process.stdout:
            message = json.loads(line)
            if "done" in message:
                found: dict[str, Any] = message["done"]
                return found
            if "error" in message:
                raise JobError(message["error"])
            self.is_ready = True
            tell(message)
        raise JobError("the computation ended by itself; it may have needed too much memory")

    @property
    def is_alive(self) -> bool:
        """Whether it can take a job."""
        return self.process.poll() is None

    def kill(self) -> None:
        """End the process, whatever it does."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()


@dataclass
class Workers:
    """The processes of one server; one that is idle is kept for the next job."""

    limiter: anyio.CapacityLimiter
    idle: list[Worker] = field(default_factory=list)
    busy: set[Worker] = field(default_factory=set)
    is_closed: bool = False
    lock: threading.Lock = field(default_factory=threading.Lock)

    def take(self) -> Worker:
        """Return a process that has no job."""
        with self.lock:
            while self.idle:
                worker = self.idle.pop()
                if worker.is_alive:
                    break
                worker.kill()
            else:
                worker = Worker()
            self.busy.add(worker)
            return worker

    def give(self, worker: Worker) -> None:
        """Take back a process; end it if another one is idle or it may still have work."""
        with self.lock:
            self.busy.discard(worker)
            if not self.is_closed and not self.idle and worker.is_alive:
                self.idle.append(worker)
                return
        worker.kill()

    def discard(self, worker: Worker) -> None:
        """End a process that has work that nobody wants any more."""
        with self.lock:
            self.busy.discard(worker)
        worker.process.kill()
        threading.Thread(target=worker.kill, daemon=True).start()

    def warm(self) -> None:
        """Start a process for the job that will soon be there."""
        with self.lock:
            if not self.is_closed and not self.idle and not self.busy:
                self.idle.append(Worker())

    def close(self) -> None:
        """End all of them."""
        with self.lock:
            self.is_closed = True
            workers = [*self.idle, *self.busy]
            self.idle.clear()
        for worker in workers:
            worker.kill()


def workers_of(state: Any) -> Workers:
    """Return the processes of the server with this state."""
    if getattr(state, "jobs", None) is None:
        state.jobs = Workers(anyio.CapacityLimiter(MOST_JOBS))
    found: Workers = state.jobs
    return found


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
        await websocket.close(_BAD_FRAME, "a request must be JSON")
        return
    with suppress(WebSocketDisconnect, RuntimeError):
        try:
            job = await in_thread(websocket, prepare, given)
            block = job.ready if job.ready is not None else await _done(websocket, job)
        except _REFUSED as error:
            text = str(error)
            await websocket.send_json({"error": text, "field": field_of(text)})
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
        except _REFUSED as caught:  # as it is, not in the group of a task group
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
        if "progress" in message:
            told["progress"] = message["progress"]
        if "compiling" in message:
            told["state"] = "compiling" if message["compiling"] else "working"
        if "ready" in message:
            told["state"] = "working"

    async def report() -> None:
        while True:
            await websocket.send_json({**told, "elapsed": round(time.monotonic() - begun, 1)})
            await anyio.sleep(_PAUSE)

    folder = Path(tempfile.mkdtemp(prefix="latolato-"))
    try:
        async with anyio.create_task_group() as group:
            group.start_soon(report)
            async with workers.limiter:
                begun = time.monotonic()
                worker = await anyio.to_thread.run_sync(workers.take)
                told["state"] = "working" if worker.is_ready else "starting"
                found, error = await _found(workers, worker, job, folder, hear)
            group.cancel_scope.cancel()
        if error is not None:
            raise error
        finish = job.finish
        return await anyio.to_thread.run_sync(finish, found, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


async def _found(
    workers: Workers,
    worker: Worker,
    job: Job,
    folder: Path,
    hear: Callable[[dict[str, Any]], None],
) -> tuple[dict[str, Any], JobError | None]:
    """Return what a worker found, or why not; end it if nobody waits for it any more."""
    is_over = False
    try:
        with anyio.fail_after(MOST_SECONDS):
            found = await anyio.to_thread.run_sync(
                worker.run, job, folder, hear, abandon_on_cancel=True
            )
        is_over = True
        return found, None
    except JobError as error:
        is_over = worker.is_alive
        return {}, error
    except TimeoutError:
        return {}, JobError(f"this takes more than {MOST_SECONDS / 60:.0f} minutes: ask for less")
    finally:
        # Quick, and must happen when the task is cancelled: no thread.
        (workers.give if is_over else workers.discard)(worker)
