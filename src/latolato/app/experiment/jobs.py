"""Work on clips: what a page may ask for, and what the job `clip` does in its own process."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from latolato.app.answers import Body
from latolato.app.experiment.store import UPLOAD, Clip, Store
from latolato.app.jobs import Job
from latolato.app.rules import RULES
from latolato.app.worker import Result
from latolato.core.errors import InputError
from latolato.core.registry import checked_choice
from latolato.core.rules import broken_rule


class Progress(Protocol):
    """What a job uses to report its progress."""

    def __call__(self, share: float, stage: str = ...) -> None:
        """Tell the part of a stage that is done."""


def prepare(store: Store, request: Mapping[str, Any]) -> Job:
    """Return the job that a page asks for: ``{"do", "clip", ...}``.

    Raises
    ------
    InputError
        For a page or a clip that has gone.
    """
    do = request["do"]
    if do == "example":
        clip = store.admit(request["desk"], f"{request['kind']}.mp4")
    else:
        clip = store.clip(request["clip"])

    def finish(about: dict[str, Any]) -> dict[str, Any]:
        if do == "example":
            about["clip"] = clip.key
        if do in ("track", "import"):
            clip.trial = about["trial"]
            about["trials"] = trial_rows(store.of_desk(clip.desk))
        return about

    work = Body(request, name=clip.name)
    return Job(compute, work, finish, place=partial(store.work_on, clip))


def trial_rows(clips: list[Clip]) -> list[dict[str, Any]]:
    """Return the trials of clips with their sets, ordered by set and frequency."""
    from latolato.experiment.trial_statistics import sets_of

    rows = [{**c.trial, "clip": c.key, "source": c.name} for c in clips if c.trial]
    if not rows:
        return []
    names = sets_of(
        [row["drive_amplitude"] for row in rows], [row["drive_amplitude_sigma"] for row in rows]
    )
    rows = [{**row, "set": s, "set_by": "amplitude"} for row, s in zip(rows, names, strict=True)]
    return sorted(rows, key=lambda row: (row["set"], row["drive_frequency"]))


def compute(request: Mapping[str, Any], folder: Path, progress: Progress) -> Result:
    """Do the work on a clip that a page requested, in a process of its own.

    Raises
    ------
    InputError
        With the reason.
    """
    job = Body(request, folder=str(folder), path=str(folder / UPLOAD))
    try:
        # Here: a failure is reported as any other.
        from latolato.app.experiment.work import WORK

        return WORK[checked_choice("do", job["do"], list(WORK))](
            job, lambda stage, share: progress(share, stage)
        )
    except MemoryError:
        raise broken_rule("large_for_memory", table=RULES) from None
    except (InputError, OSError) as error:
        if isinstance(error, InputError):
            is_of_clip = error.where and Path(error.where).parent == folder
            error.where = job["name"] if is_of_clip else error.where
            if job["path"] not in str(error):
                raise
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
