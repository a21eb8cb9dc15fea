"""The commands that make and read videos: their options, handed on."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from latolato.cli.options import JsonOption, ScenarioArgument
from latolato.cli.output import print_summary


def synthesise(
    scenario: ScenarioArgument = None,
    rerun: Annotated[
        Path | None, typer.Option("--from", help="Film the run of a result file.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="Video: .mp4.", rich_help_panel="Output")
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option(help="True track table: .csv, .parquet or .nc.", rich_help_panel="Output"),
    ] = None,
    condition: Annotated[
        str,
        typer.Option(
            help="How it is filmed: clean, texture, wood, variable, rotated, tilted, blur, "
            "lowlight, compressed, steel, occluded, rolling or lens.",
            rich_help_panel="Filming",
        ),
    ] = "clean",
    scene: Annotated[
        list[str] | None,
        typer.Option(
            help='What is seen: "ball_colour = #2b6cb0", "rod_width = 1 mm". May be given several '
            "times.",
            rich_help_panel="Filming",
        ),
    ] = None,
    camera: Annotated[
        list[str] | None,
        typer.Option(
            help='How the camera is: "fps = 120", "roll = 3 deg". May be given several times.',
            rich_help_panel="Filming",
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option(help="Of texture, noise and time stamps.", rich_help_panel="Filming")
    ] = 0,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Film a run with exactly known truth: a video to test tracking with, and its true table.

    Options replace what the scenario says. Existing files are replaced.
    """
    from latolato.cli import synthesise as synthesise_command

    summary = synthesise_command.run(
        synthesise_command.scenario_of(scenario, rerun, given),
        output,
        truth,
        condition=condition,
        scene=scene or [],
        camera=camera or [],
        seed=seed,
    )
    print_summary(summary, synthesise_command.lines_of(summary), as_json=as_json)


def track(
    videos: Annotated[list[Path], typer.Argument(help="Videos.")],
    balls: Annotated[int | None, typer.Option(help="How many balls swing: 1 or 2.")] = None,
    pivot: Annotated[
        str | None,
        typer.Option(
            help="Column and row of the pivot in the first frame as displayed: 640,194.",
            metavar="U,V",
        ),
    ] = None,
    ball: Annotated[
        list[str] | None,
        typer.Option(
            help="The same of a ball's centre; given twice for two balls. What is not pointed at "
            "is found in the video.",
            metavar="U,V",
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
            help='What a video may ask for: "duration = 2 h", "pixels = 2e7", "frames", "memory".'
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers", "--jobs", help="Videos tracked at once; by default one for each core."
        ),
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
        typer.Option(help="Video with what was found drawn on it: .mp4.", rich_help_panel="Output"),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(help="One page on how good the table is: .html.", rich_help_panel="Output"),
    ] = None,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Measure pivot and balls in every frame of videos: angles with their errors, and flags.

    Quantities may carry a unit: "24.5 cm". The set-up is written beside the table, from which the
    same table is made again. Existing files are replaced.
    """
    from latolato.cli import track as track_command

    jobs = track_command.jobs_of(
        videos,
        count=balls,
        pivot=pivot,
        balls=ball or [],
        values=given,
        limits=limit or [],
        sidecar=sidecar,
        targets={"output": output, "overlay": overlay, "report": report},
        propose=propose,
    )
    code = track_command.run(jobs, workers, as_json=as_json)
    if code:
        raise typer.Exit(code)
