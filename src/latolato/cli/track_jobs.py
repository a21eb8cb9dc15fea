"""The work of `latolato track`: one video, or many at once, each in a process of its own."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from math import isfinite
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.cli.output import print_summary
from latolato.core.errors import InputError
from latolato.core.faults import line_of
from latolato.core.parameters import flag_of
from latolato.io.progress import bar

if TYPE_CHECKING:
    from latolato.experiment.sidecar import Pivot

# Share of the work that is tracking where an overlay or a report follow.
_TRACKED = 0.7


@dataclass(frozen=True, kw_only=True)
class Job:
    """One video, how to track it and what to write."""

    video: Path
    pivot: Pivot | tuple[Pivot, ...] | None
    balls: int | tuple[tuple[float, float], ...] | None
    values: Mapping[str, Any]
    sidecar: Path | None
    output: Path | None
    overlay: Path | None
    report: Path | None
    propose: bool = False


def run(jobs: Sequence[Job], workers: int | None, *, as_json: bool) -> int:
    """Track the videos, print a summary of each, and return the exit code.

    With several videos a bad one does not stop the others: it is named at the end, and the code
    is 1.
    """
    if workers is not None and workers < 1:
        raise InputError("must be 1 or more", parameter="--workers", value=workers)
    if len(jobs) == 1:
        with bar("tracking") as progress:
            summary = work(jobs[0], progress)
        print_summary(summary, lines_of(summary), as_json=as_json)
        return 0
    failed: list[tuple[Path, str]] = []
    count = min(len(jobs), workers or os.cpu_count() or 1)
    results: list[dict[str, Any]] = []
    shares = dict.fromkeys(range(len(jobs)), 0.0)
    with bar(f"tracking {len(jobs)} videos") as progress, ThreadPoolExecutor(count) as pool:

        def teller_of(k: int) -> Callable[[float], None]:
            def tell(share: float) -> None:
                shares[k] = share
                if progress:
                    progress(sum(shares.values()) / len(shares))

            return tell

        futures = {pool.submit(_apart, job, teller_of(k)): job for k, job in enumerate(jobs)}
        try:
            for future in as_completed(futures):
                job = futures[future]
                try:
                    summary = future.result()
                except (InputError, OSError) as error:
                    failed.append((job.video, line_of(error)))
                    continue
                results.append(summary)
                if not as_json:
                    print_summary(summary, lines_of(summary), as_json=False)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.terminate()
            raise
    if as_json:
        ordered = {str(job.video): k for k, job in enumerate(jobs)}
        results.sort(key=lambda summary: ordered[summary["video"]])
        refused = [{"video": str(video), "error": text} for video, text in failed]
        print(json.dumps({"tracked": results, "failed": refused}))
    for video, text in failed:
        message = text if str(video) in text else f"{video}: {text}"
        print(f"latolato: {message}", file=sys.stderr)
    if failed:
        print(f"latolato: {len(failed)} of {len(jobs)} videos failed", file=sys.stderr)
    return 1 if failed else 0


def _apart(job: Job, tell: Callable[[float], None]) -> dict[str, Any]:
    """Track one video in a process of its own, which may fail without the others."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    child = context.Process(target=_child, args=(job, there), daemon=True)
    child.start()
    there.close()
    try:
        while True:
            kind, value = here.recv()
            if kind == "progress":
                tell(value)
            elif kind == "failed":
                raise InputError(value)
            else:
                tell(1.0)
                done: dict[str, Any] = value
                return done
    except EOFError:
        child.join()
        raise ChildProcessError(
            f"{job.video}: its process ended with code {child.exitcode}; was there memory enough?"
        ) from None
    finally:
        here.close()
        child.join()


def _child(job: Job, pipe: Connection) -> None:
    """Track one video and send the summary."""
    last = 0.0

    def tell(share: float) -> None:
        nonlocal last
        if share - last > 0.01:
            last = share
            pipe.send(("progress", share))

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pipe.send(("done", work(job, tell)))
    except Exception as error:
        if isinstance(error, InputError):
            error.name_of = flag_of
        pipe.send(("failed", line_of(error)))
    except KeyboardInterrupt:
        pass
    finally:
        pipe.close()


def work(job: Job, progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Track one video, write its files and return the summary."""
    from latolato.experiment.sidecar import own_sidecar, sidecar_path, write_sidecar
    from latolato.experiment.task import prepare
    from latolato.experiment.track import run
    from latolato.experiment.track_table import write_table

    tell = progress or (lambda share: None)
    more = job.overlay is not None or job.report is not None
    part = _TRACKED if more else 1.0
    sidecar = job.sidecar
    is_pointed_at = job.pivot is not None or isinstance(job.balls, tuple)
    if sidecar is None and job.output is not None and not (job.propose or is_pointed_at):
        sidecar = own_sidecar(job.output, job.video)
    task = prepare(
        job.video, job.pivot, job.balls, dict(job.values), sidecar, lambda share: tell(part * share)
    )
    if job.propose:
        return _proposed(job, task)
    table = run(task, lambda share: tell(part * share))
    files: list[Path] = []
    if job.output is not None:
        files.append(write_table(table, job.output))
        files.append(write_sidecar(task.setup, job.video, sidecar_path(job.output)))
    if job.overlay is not None:
        from latolato.experiment.overlay import write_overlay

        files.append(
            write_overlay(
                table,
                task.video,
                job.overlay,
                progress=lambda share: tell(part + (1.0 - part) * share),
            )
        )
    if job.report is not None:
        from latolato.report.track_page import write_track_report

        files.append(write_track_report(table, task.video, job.report))
    return {
        "video": str(job.video),
        "setup_file": None if task.setup_file is None else str(task.setup_file),
        **summarise(table),
        "files": [str(file) for file in files],
    }


def _proposed(job: Job, task: Any) -> dict[str, Any]:
    """Write a picture of the proposal and return the summary."""
    from latolato.experiment.overlay import draw_proposal
    from latolato.experiment.tracking.propose import options_of

    picture = job.output or job.video.with_name(f"{job.video.stem}.proposal.png")
    setup = task.setup
    return {
        "video": str(job.video),
        "setup_file": None if task.setup_file is None else str(task.setup_file),
        "pivot": [setup.pivot, setup.pivot_2] if setup.has_own_pivots else setup.pivot,
        "ball": list(setup.balls),
        "options": options_of(setup),
        "is_proposed": setup.is_proposed,
        "files": [str(draw_proposal(task.video, setup, picture, task.radius))],
    }


def summarise(table: Any) -> dict[str, Any]:
    """Return the numbers of a table that a summary contains."""
    from latolato.experiment.period import period_of_ball
    from latolato.experiment.quality import flag_shares, pivot_numbers, typical_sigma
    from latolato.experiment.track_table import balls_of

    attrs = table.attrs
    numbers: dict[str, Any] = {
        "frames": int(table.sizes["frame"]),
        "duration": float(table["time"][-1] - table["time"][0]),
        "balls": balls_of(table),
        "geometry": attrs["geometry"],
        "flags": flag_shares(table),
        "angle_sigma": typical_sigma(table),
        **pivot_numbers(table),
    }
    for name in (
        "slow_motion",
        "capture_rate",
        "shown_rate",
        "exposure",
        "circle_residual",
        "metres_per_pixel",
        "scale_source",
        "length",
        "length_sigma",
        "gravity_source",
        "angle_offset_sigma",
        "pivot_source",
        "angle_scale_sigma",
        "origin_u",
        "origin_v",
    ):
        if name in attrs:
            numbers[name] = attrs[name]
    for ball in range(1, balls_of(table) + 1):
        ending = "" if ball == 1 else f"_{ball}"
        period, sigma = period_of_ball(table, ball)
        numbers[f"period{ending}"] = period if isfinite(period) else None
        numbers[f"period{ending}_sigma"] = sigma if isfinite(sigma) else None
    numbers["warnings"] = attrs["warnings"].split("; ") if attrs.get("warnings") else []
    return numbers


def lines_of(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return a summary as names and texts for reading."""
    from latolato.experiment.quality import clock_text, pivot_text

    if "is_proposed" in summary:
        places = summary["options"]
        return {"video": summary["video"], **_setup_file(summary), "places": places}
    shares = ", ".join(f"{100.0 * share:.3g} % {name}" for name, share in summary["flags"].items())
    lines = {
        "video": f"{summary['video']}, {summary['frames']} frames, {summary['duration']:.6g} s",
        **_setup_file(summary),
        "balls": f"{summary['balls']}, {shares}",
    }
    if clock := clock_text(summary):
        lines["slow motion"] = clock
    if summary["angle_sigma"] is not None:
        lines["angle sigma"] = f"{1e3 * summary['angle_sigma']:.3g} mrad"
    if summary["geometry"] == "unknown":
        lines["geometry"] = "unknown: positions in pixels, no angles"
    elif summary["geometry"] == "angles":
        lines["geometry"] = "angles only: positions in pixels"
    if "length_sigma" in summary:
        length, sigma = (1e2 * summary[name] for name in ("length", "length_sigma"))
        by = f"by the scale of the {summary['scale_source']}"
        lines["length"] = f"{length:.5g} cm, sigma {sigma:.2g} cm, {by}"
    for ball in range(1, summary["balls"] + 1):
        ending = "" if ball == 1 else f"_{ball}"
        name = "period" if summary["balls"] == 1 else f"period of ball {ball}"
        period, sigma = summary[f"period{ending}"], summary[f"period{ending}_sigma"]
        lines[name] = "none: fewer than three swings were seen"
        if period is not None:
            lines[name] = f"{period:.6g} s, sigma {sigma:.2g} s"
    if summary["geometry"] != "unknown":
        lines["pivot"] = pivot_text(summary)
    if "exposure" in summary:
        lines["exposure"] = f"{100.0 * summary['exposure']:.0f} % of the time between frames"
    for k, text in enumerate(summary["warnings"]):
        lines["warning" if k == 0 else f"warning {k + 1}"] = text
    return lines


def _setup_file(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return the line that names the file of the set-up, if it was read from one."""
    return {"set-up read from": summary["setup_file"]} if summary["setup_file"] else {}
