"""`latolato track`: its options, and what follows from them for each video."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

from latolato.cli.options import (
    BallOption,
    BallsOption,
    JsonOption,
    balls_of,
    pivots_of,
    pixels_of,
    place_of,
    values_of,
    with_options,
)
from latolato.cli.track_jobs import Job, run
from latolato.core.errors import InputError
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.parameters import VIDEO_PARAMETERS
from latolato.experiment.sidecar import (
    checked_correction,
    checked_region,
    checked_stick,
)
from latolato.experiment.video import Limits
from latolato.scenario.analysis_options import arguments_of, options_of


@with_options(VIDEO_PARAMETERS.values())
def track(
    videos: Annotated[list[Path], typer.Argument(help="Videos.")],
    balls: BallsOption = None,
    pivot: Annotated[
        list[str] | None,
        typer.Option(
            help="Column and row of the pivot in the clicked frame as displayed: 640,194. A pivot "
            "out of the picture must rest; 'outside' fits it to the ball's arc. Give it twice for "
            "two balls with separate pivots.",
            metavar="U,V",
        ),
    ] = None,
    ball: BallOption = None,
    region: Annotated[
        str | None,
        typer.Option(
            help="Left, top, right and bottom of the part of the picture to search for balls.",
            metavar="U,V,U,V",
        ),
    ] = None,
    stick: Annotated[
        str | None,
        typer.Option(
            help="Column and row of both ends of a stick of known length next to the swing.",
            metavar="U,V,U,V",
        ),
    ] = None,
    correct: Annotated[
        list[str] | None,
        typer.Option(
            help="Correct a ball in a frame by hand: frame, ball (1 or 2), column and row. "
            "May be given several times.",
            metavar="FRAME:BALL:U,V",
        ),
    ] = None,
    sidecar: Annotated[
        Path | None,
        typer.Option(
            help="Set-up of an earlier table; by default OUTPUT.track.toml, if it is of this video."
        ),
    ] = None,
    propose: Annotated[
        bool,
        typer.Option("--propose", help="Only find pivot and balls, and draw them on a picture."),
    ] = False,
    limit: Annotated[
        list[str] | None,
        typer.Option(
            help='Limit for videos: "duration = 2 h", "pixels = 2e7", "frames", "memory".'
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option("--workers", "--jobs", help="Videos tracked at once. Default: one per core."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            help="Table: .csv, .parquet or .nc. For several videos a folder, or a name with "
            "{name} in it.",
            rich_help_panel="Output",
        ),
    ] = None,
    overlay: Annotated[
        Path | None,
        typer.Option(help="Video with the result drawn on it: .mp4.", rich_help_panel="Output"),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(help="One page on the quality of the table: .html.", rich_help_panel="Output"),
    ] = None,
    as_json: JsonOption = False,
    **values: Any,
) -> None:
    """Measure pivot and balls in every frame of videos: angles with their errors, and flags.

    Quantities may carry a unit: "24.5 cm". The set-up is written beside the table, from which the
    same table is made again. Existing files are replaced.
    """
    places = balls_of(balls, ball)
    if sidecar is not None:
        _check_sidecar(sidecar, videos, bool(pivot or ball))
    common: dict[str, Any] = {
        "pivot": pivots_of(pivot),
        "balls": places,
        "values": _settings(values, limit) | _places(region, stick, correct or []),
        "sidecar": sidecar,
        "propose": propose,
    }
    targets = {
        "output": (output, ".proposal.png" if propose else ".csv"),
        "overlay": (overlay, ".overlay.mp4"),
        "report": (report, ".html"),
    }
    jobs = []
    for video in videos:
        files: dict[str, Any] = {
            name: _target(target, video, ending, len(videos) > 1)
            for name, (target, ending) in targets.items()
        }
        jobs.append(Job(video=video, **files, **common))
    _check_targets(jobs)
    code = run(jobs, workers, as_json=as_json)
    if code:
        raise typer.Exit(code)


def _check_sidecar(sidecar: Path, videos: Sequence[Path], is_pointed_at: bool) -> None:
    """Raise unless a set-up of its own can be used."""
    if len(videos) > 1:
        raise InputError(
            "--sidecar is about one video", way_out="leave it out to read each one's own"
        )
    if not sidecar.is_file():
        raise FileNotFoundError(f"there is no file '{sidecar}'")
    if is_pointed_at:
        raise InputError("give either --sidecar or places, not both")


def _places(region: str | None, stick: str | None, correct: Sequence[str]) -> dict[str, Any]:
    """Return the region in which balls are looked for, both ends of the stick, and corrections."""
    places: dict[str, Any] = {}
    if region is not None:
        example = "left, top, right and bottom in pixels such as 100,50,900,700"
        places["region"] = checked_region(pixels_of("--region", region, example))
    if stick is not None:
        example = "column and row of one end and of the other such as 100,200,400,210"
        one_u, one_v, other_u, other_v = pixels_of("--stick", stick, example)
        places["stick"] = checked_stick([(one_u, one_v), (other_u, other_v)])
    if correct:
        places["corrections"] = tuple(_correction(text) for text in correct)
    return places


def _correction(text: str) -> tuple[int, int, float, float]:
    """Return frame, ball and place of a ball that is set by hand."""
    frame, ball, place = ([*text.split(":"), "", ""])[:3]
    if not (frame.strip().isdigit() and ball.strip().isdigit()) or text.count(":") != 2:
        raise InputError(
            "must be frame, ball and place such as 120:1:640,300", parameter="--correct", value=text
        )
    return checked_correction((int(frame), int(ball), *place_of("--correct", place)))


def _settings(values: Mapping[str, Any], limits: Sequence[str] | None) -> dict[str, Any]:
    """Return length, radius, gravity, optics, slow motion and limits in SI units."""
    settings = arguments_of(VIDEO_PARAMETERS, values)
    optics = {f.name: settings.pop(f.name) for f in fields(Optics) if f.name in settings}
    if optics:
        settings["optics"] = Optics(**optics)
    if limits:
        settings["limits"] = Limits(**values_of("--limit", limits, options_of(Limits)))
    return settings


def _target(target: Path | None, video: Path, ending: str, several: bool) -> Path | None:
    """Return a video's own file: in a folder, or by a name with ``{name}`` in it."""
    if target is None:
        return None
    if "{name}" in target.name:
        return target.with_name(target.name.replace("{name}", video.stem))
    if target.is_dir() or (several and not target.suffix):
        return target / f"{video.stem}{ending}"
    if several:
        raise InputError(
            f"several videos need a folder or a name such as '{{name}}{target.suffix}'",
            value=str(target),
        )
    return target


def _check_targets(jobs: Sequence[Job]) -> None:
    """Raise before any work if a file cannot be written, or is wanted twice."""
    from latolato.core.atomic import check_folder
    from latolato.experiment.track_table import SUFFIXES
    from latolato.io.files import check_suffix, check_target

    owners: dict[Path, Path] = {}
    for job in jobs:
        for file in (job.output, job.overlay, job.report):
            if file is None:
                continue
            if len(jobs) > 1:
                file.parent.mkdir(parents=True, exist_ok=True)
            check_folder(file)
            path = file.resolve()
            if path in owners:
                raise InputError(
                    f"'{job.video}' and '{owners[path]}' would both be written to '{file}'"
                )
            owners[path] = job.video
            if path == job.video.resolve():
                raise InputError(f"'{file}' is the video itself", way_out="name another file")
        if job.propose and job.output is not None:
            check_suffix(job.output, (".png",), "the name of a proposal's picture")
        elif job.output is not None:
            check_suffix(job.output, SUFFIXES, "the name of a track table")
            check_target(job.output)
        if job.overlay is not None:
            check_suffix(job.overlay, (".mp4",), "the name of an overlay")
        if job.report is not None:
            check_suffix(job.report, (".html",), "the name of a report")
