"""Worker processes: started, fed with jobs, ended when nobody waits for the answer.

Each process runs `latolato.app.worker`, which says what is written to it and what it answers.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import anyio

from latolato.core.errors import InputError

# Longest line of an answer [characters].
_LONGEST = 4_000_000

Hear = Callable[[dict[str, Any]], None]


class JobError(InputError):
    """A job that gave no answer, with the line that says why.

    Attributes
    ----------
    told : dict or None
        The parts of the error in its process, where that was refused input.
    """

    told: dict[str, Any] | None = None


class EndedError(JobError):
    """A process that ended in the middle of its job.

    Attributes
    ----------
    code : int
        Its exit status, the negative number of a signal if that ended it.
    """

    def __init__(self, code: int) -> None:
        super().__init__("the computation ended by itself; it may have needed too much memory")
        self.code = code


class Worker:
    """A process that does one job after the other.

    Parameters
    ----------
    once : bool
        Whether it is for one job only, such as one that reads a foreign file, whose decoder may
        crash: it imports nothing before that job is there, and what it prints is not shown.
    """

    def __init__(self, *, once: bool = False) -> None:
        self.once = once
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-m", "latolato.app.worker"),
                *(["once"] if once else []),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL if once else None,
            encoding="utf-8",
            # Signals of the terminal are for the server, whose end closes the process' input.
            start_new_session=True,
        )
        self.is_ready = self.is_busy = False

    def run(self, job: str, request: Mapping[str, Any], folder: Path, hear: Hear) -> dict[str, Any]:
        """Return the result of a job; its files are in `folder`.

        Raises
        ------
        JobError
            With the reason in one line.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        line = json.dumps({"job": job, "request": request, "folder": str(folder)})
        with suppress(OSError):  # a process that is gone: reading tells
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
        while line := self.process.stdout.readline(_LONGEST):
            try:
                message = json.loads(line)
            except ValueError:
                raise JobError("the computation returned an answer that cannot be read") from None
            self.is_busy = not ("done" in message or "error" in message)
            if "done" in message:
                result: dict[str, Any] = message["done"]
                return result
            if "error" in message:
                failed = JobError(message["error"], parameter=message.get("parameter"))
                failed.told = message.get("parts")
                raise failed
            self.is_ready = True
            hear(message)
        raise EndedError(self.process.wait())

    @property
    def can_go_on(self) -> bool:
        """Whether it can take one more job."""
        return not self.once and not self.is_busy and self.process.poll() is None

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
    """Processes of one server; for one event loop.

    Attributes
    ----------
    most : int
        How many jobs run at the same time; others wait.
    once : bool
        Whether each job gets a process of its own; otherwise one that is idle is kept for the next.
    """

    most: int = 2
    once: bool = False
    idle: list[Worker] = field(default_factory=list)
    busy: set[Worker] = field(default_factory=set)
    is_closed: bool = False

    @cached_property
    def limiter(self) -> anyio.CapacityLimiter:
        """What lets so many jobs run; made where there is a loop."""
        return anyio.CapacityLimiter(self.most)

    async def do(
        self, job: str, request: Mapping[str, Any], folder: Path, hear: Hear
    ) -> dict[str, Any]:
        """Return the result of a job, when it is its turn; its process ends if this is cancelled.

        Parameters
        ----------
        job : str
            One of `latolato.app.worker.JOBS`.
        request : mapping
            What the job gets, as JSON knows it.
        folder : Path
            Where its files go.
        hear : callable
            Called, in another thread, with ``{"begun": whether its process is ready}`` and then
            with the messages of the job.

        Raises
        ------
        JobError
            With the reason in one line.
        """
        async with self.limiter:
            worker = self._take()
            worker.is_busy = True
            self.busy.add(worker)
            try:
                hear({"begun": worker.is_ready})
                return await anyio.to_thread.run_sync(
                    worker.run, job, request, folder, hear, abandon_on_cancel=True
                )
            finally:
                self.busy.discard(worker)
                if worker.can_go_on and not self.idle and not self.is_closed:
                    self.idle.append(worker)
                else:
                    with anyio.CancelScope(shield=True):
                        await anyio.to_thread.run_sync(worker.kill)

    def _take(self) -> Worker:
        """Return a process that has no job."""
        if self.is_closed:
            raise JobError("the server is shutting down")
        while self.idle:
            worker = self.idle.pop()
            if worker.can_go_on:
                return worker
            worker.kill()
        return Worker(once=self.once)

    def warm(self) -> None:
        """Start a process for the job that will soon be there."""
        if not self.is_closed and not self.idle and not self.busy:
            self.idle.append(Worker(once=self.once))

    def close(self) -> None:
        """End all of them."""
        self.is_closed = True
        for worker in [*self.idle, *self.busy]:
            worker.kill()
        self.idle.clear()
