"""Work on uploaded videos in processes of their own, which end with whoever waits for them."""

from __future__ import annotations

import asyncio
import json
import signal
import sys
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from latolato.app.film_store import Allowance, Film

_LINE = 4_000_000  # bytes of one answer
# How long a process may take to end by itself after its answer [s].
_GRACE = 2.0
Told = Callable[[str, float], Awaitable[None]]


class FilmError(ValueError):
    """Why work on a film failed, in one line."""


async def work(film: Film, job: dict[str, Any], allowance: Allowance, told: Told) -> dict[str, Any]:
    """Return what a job on a film found; the process is killed if this is cancelled.

    Parameters
    ----------
    film : Film
        What it is about.
    job : dict
        What to ``do``, and how.
    allowance : Allowance
        What the process may take.
    told : coroutine function of (str, float)
        Called with the stage and the part of it that is done.

    Raises
    ------
    FilmError
        With the reason.
    """
    limits = allowance.limits
    message = {
        **job,
        "path": str(film.upload),
        "folder": str(film.folder),
        "name": film.name,
        "memory": allowance.memory,
        "cpu_time": allowance.cpu_time,
        "limits": {name: getattr(limits, name) for name in limits.__dataclass_fields__},
    }
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "latolato.app.film_worker",
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL, limit=_LINE, start_new_session=True,
    )  # fmt: skip
    try:
        async with asyncio.timeout(allowance.wall_time):
            assert process.stdin is not None
            process.stdin.write(json.dumps(message).encode() + b"\n")
            await process.stdin.drain()
            return await _answer(process, film, told)
    except TimeoutError:
        raise FilmError(
            f"work on {film.name} took more than {allowance.wall_time:g} s: cut the video"
        ) from None
    except (ConnectionError, ValueError) as error:
        if isinstance(error, FilmError):
            raise
        raise FilmError(f"work on {film.name} broke off") from None
    finally:
        await asyncio.shield(_ended(process))


async def _answer(process: Any, film: Film, told: Told) -> dict[str, Any]:
    """Return what a process found, or raise its reason; tell how far it is."""
    async for line in process.stdout:
        message = json.loads(line)
        if "error" in message:
            raise FilmError(message["error"])
        if "done" in message:
            found: dict[str, Any] = message["done"]
            return found
        await told(message["stage"], message["progress"])
    raise FilmError(_reason(await process.wait(), film))


async def _ended(process: Any) -> None:
    """See that a process has ended: by itself soon, or killed."""
    if process.returncode is None:
        process.stdin.close()
        with suppress(ProcessLookupError):
            process.kill()
        async with asyncio.timeout(_GRACE):
            await process.wait()


def _reason(code: int, film: Film) -> str:
    """Return why a process ended without an answer."""
    if code == -getattr(signal, "SIGXCPU", 24):
        return f"work on {film.name} took too much processor time: cut the video or scale it down"
    if code == -getattr(signal, "SIGKILL", 9):
        return f"work on {film.name} took too much memory or time: cut the video or scale it down"
    if code == -getattr(signal, "SIGXFSZ", 25):
        return f"what was made of {film.name} is too large: cut the video or scale it down"
    if code < 0:
        return f"reading {film.name} broke the decoder: is the file whole? Convert it to MP4"
    return f"work on {film.name} ended without an answer: is the file whole?"
