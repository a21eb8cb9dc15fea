"""Work on uploaded videos, in limited processes of their own (see `processes`)."""

from __future__ import annotations

import signal
from collections.abc import Callable, Coroutine, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from latolato.core.errors import InputError

if TYPE_CHECKING:
    from latolato.app.experiment.store import Allowance, Clip
    from latolato.app.processes import Workers

Tell = Callable[[str, float], Coroutine[Any, Any, None]]


class Progress(Protocol):
    """What a job is given to say how far it is."""

    def __call__(self, share: float, stage: str | None = None) -> None:
        """Tell the part of a stage that is done."""


def clip_workers_of(state: Any) -> Workers:
    """Return the processes of the server with this state that read videos."""
    import anyio

    from latolato.app.processes import Limits, Workers

    if state.clip_jobs is None:
        allowance: Allowance = state.clips.allowance
        limits = Limits(memory=allowance.memory, cpu_time=allowance.cpu_time)
        state.clip_jobs = Workers(anyio.CapacityLimiter(allowance.jobs), limits)
    workers: Workers = state.clip_jobs
    return workers


async def work(
    workers: Workers, clip: Clip, job: Mapping[str, Any], allowance: Allowance, tell: Tell
) -> dict[str, Any]:
    """Return the result of a job on a clip; its process is killed if this is cancelled.

    Parameters
    ----------
    workers : Workers
        The processes that read videos.
    clip : Clip
        What it is about.
    job : mapping
        What to ``do``, and how.
    allowance : Allowance
        What the work may take.
    tell : coroutine function of (str, float)
        Called with the stage and the part of it that is done.

    Raises
    ------
    JobError
        With the reason.
    """
    import anyio

    from latolato.app.processes import EndedError, JobError

    limits = allowance.limits
    given = {
        **job,
        "path": str(clip.upload),
        "name": clip.name,
        "limits": {name: getattr(limits, name) for name in limits.__dataclass_fields__},
    }

    def hear(message: Mapping[str, Any]) -> None:
        if "stage" in message:
            anyio.from_thread.run(tell, message["stage"], message["progress"])

    try:
        done = await workers.do("clip", given, clip.folder, hear, seconds=allowance.wall_time)
    except TimeoutError:
        raise JobError(
            f"work on {clip.name} took more than {allowance.wall_time:g} s: cut the video"
        ) from None
    except EndedError as error:
        raise JobError(_reason(error.code, clip)) from None
    result: dict[str, Any] = done["result"]
    return result


def _reason(code: int, clip: Clip) -> str:
    """Return why a process ended without an answer."""
    if code == -getattr(signal, "SIGXCPU", 24):
        return f"work on {clip.name} took too much processor time: cut the video or scale it down"
    if code == -getattr(signal, "SIGKILL", 9):
        return f"work on {clip.name} took too much memory or time: cut the video or scale it down"
    if code == -getattr(signal, "SIGXFSZ", 25):
        return f"what was made of {clip.name} is too large: cut the video or scale it down"
    if code < 0:
        return f"reading {clip.name} broke the decoder: is the file whole? Convert it to MP4"
    return f"work on {clip.name} ended without an answer: is the file whole?"


def compute(given: Mapping[str, Any], folder: Path, progress: Progress) -> dict[str, Any]:
    """Do what a page wants of a clip: what the job `clip` does in its process.

    Raises
    ------
    InputError
        With the reason.
    """
    job = {**given, "folder": str(folder)}
    try:
        # Here: with little memory it fails, which is reported as any other failure.
        from latolato.app.experiment.work import WORK

        return {"result": WORK[job["do"]](job, lambda stage, share: progress(share, stage))}
    except MemoryError:
        raise InputError("this video needs more memory than it may take: scale it down") from None
    except (InputError, OSError) as error:
        raise InputError(one_line(error, job)) from None


def one_line(error: Exception, job: Mapping[str, Any]) -> str:
    """Return why a job failed, in one line about the clip's name instead of its path."""
    text = " ".join(str(error).split()) or type(error).__name__
    for quoted in (f"'{job['path']}'", str(job["path"])):
        text = text.replace(quoted, job["name"])
    return text
