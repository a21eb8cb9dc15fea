"""Work on clips: what a page may ask for, and what the job `clip` does in its own process."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from latolato.core.errors import InputError

if TYPE_CHECKING:
    from latolato.app.experiment.store import Clip, Desk, Store
    from latolato.app.jobs import Job

# The work, and which blocks it leaves for the page.
_BLOCKS = {
    "look": ("times",), "example": ("times",), "track": ("points", "model"),
    "import": ("points", "model"), "fit": ("model",), "export": (),
}  # fmt: skip


class Progress(Protocol):
    """What a job uses to report its progress."""

    def __call__(self, share: float, stage: str = ...) -> None:
        """Tell the part of a stage that is done."""


def prepare(request: Mapping[str, Any], store: Store) -> Job:
    """Return the job that a page asks for: ``{"desk", "do", "clip", ...}``.

    Raises
    ------
    InputError
        For a page or a clip that has gone, and for invalid values, before a process begins.
    """
    import anyio

    from latolato.app.blocks import pack_files
    from latolato.app.experiment.description import Description
    from latolato.app.jobs import Job

    desk, do = store.desk(request["desk"]), request["do"]
    work: dict[str, Any] = {"do": do}
    if do == "example":
        clip = anyio.from_thread.run_sync(store.admit, desk, f"{request['kind']}.mp4")
    else:
        clip = desk.clip(request["clip"])
        if not clip.is_whole:
            raise InputError(f"{clip.name} is still being uploaded")
        if not clip.about and do != "look":
            raise InputError(f"{clip.name} could not be read")
    work |= {name: request[name] for name in ("decimal", "file", "kind") if name in request}
    if do in ("track", "import", "fit"):
        work |= {"description": request["description"], **clip.about}
        Description.from_json(work["description"])
    work["name"] = clip.name

    def finish(about: dict[str, Any], folder: Path) -> bytes:
        result = about["result"]
        if do in ("look", "example"):
            sizes = {name: result[name] for name in ("width", "height") if name in result}
            clip.about = sizes or {"is_table": True}
            clip.is_whole = True
            result["clip"] = clip.key
        if do in ("track", "import"):
            clip.trial = result["trial"]
            result["trials"] = trial_rows(list(desk.clips.values()))
        return pack_files(result, {name: folder / f"{name}.bin" for name in _BLOCKS[do]})

    return Job("clip", work, finish, place=lambda: _place(desk, clip))


@contextmanager
def _place(desk: Desk, clip: Clip) -> Iterator[Path]:
    """Lend the folder of a clip to a job; explain an early end of its process."""
    from latolato.app.processes import EndedError, JobError

    try:
        with desk.work_on(clip) as folder:
            yield folder
    except EndedError as error:
        raise JobError(_reason(error.code, clip)) from None


def trial_rows(clips: list[Clip]) -> list[dict[str, Any]]:
    """Return the trials of clips with their sets, ordered by set and frequency."""
    import math

    from latolato.experiment.trial_statistics import sets_of

    def known(row: Mapping[str, Any]) -> dict[str, Any]:
        return {name: math.nan if value is None else value for name, value in row.items()}

    rows = [{**known(c.trial), "clip": c.key, "source": c.name} for c in clips if c.trial]
    if not rows:
        return []
    names = sets_of(
        [row["drive_amplitude"] for row in rows], [row["drive_amplitude_sigma"] for row in rows]
    )
    rows = [{**row, "set": s, "set_by": "amplitude"} for row, s in zip(rows, names, strict=True)]
    return sorted(rows, key=lambda row: (row["set"], row["drive_frequency"]))


def _reason(code: int, clip: Clip) -> str:
    """Return why a process ended without an answer."""
    if code == -getattr(signal, "SIGKILL", 9):
        return f"work on {clip.name} took too much memory: cut the file or scale it down"
    if code < 0:
        return f"reading {clip.name} crashed the decoder: is the file complete? Convert it to MP4"
    return f"work on {clip.name} ended without an answer: is the file complete?"


def compute(request: Mapping[str, Any], folder: Path, progress: Progress) -> dict[str, Any]:
    """Do the work on a clip that a page requested: the job `clip`, in its own process.

    Raises
    ------
    InputError
        With the reason.
    """
    from latolato.app.experiment.store import UPLOAD

    job = {**request, "folder": str(folder), "path": str(folder / UPLOAD)}
    try:
        # Here: a failure is reported as any other.
        from latolato.app.experiment.work import WORK

        return {"result": WORK[job["do"]](job, lambda stage, share: progress(share, stage))}
    except MemoryError:
        raise InputError("this file needs more memory than there is: make it smaller") from None
    except (InputError, OSError) as error:
        parameter = error.parameter if isinstance(error, InputError) else None
        raise InputError(one_line(error, job), parameter=parameter) from None


def one_line(error: Exception, job: Mapping[str, Any]) -> str:
    """Return why a job failed, in one line about the clip's name instead of its path."""
    # The page names the parameter that the error is about.
    text = error.worded("{parameter}") if isinstance(error, InputError) else str(error)
    text = " ".join(text.split()) or type(error).__name__
    for quoted in (f"'{job['path']}'", str(job["path"])):
        text = text.replace(quoted, job["name"])
    return text
