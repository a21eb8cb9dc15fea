"""`latolato synthesise`: a video of a run, with its true table."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli import simulate as run_command
from latolato.cli.options import (
    SAMPLE_OPTIONS,
    JsonOption,
    ScenarioArgument,
    values_of,
    with_law_options,
    with_options,
)
from latolato.cli.output import elapsed_since, print_summary
from latolato.core.errors import InputError
from latolato.core.parameters import Parameter, law_parameters
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import check_target, synthesise_video
from latolato.io.progress import bar
from latolato.scenario.analysis_options import arguments_of, options_of
from latolato.scenario.tables import ForeignParameterError

if TYPE_CHECKING:
    import xarray as xr

    from latolato.scenario.scenario import Scenario

OPTIONS = options_of(synthesise_video, without=("run", "path"))


@with_law_options(without=SAMPLE_OPTIONS)
@with_options(OPTIONS.values())
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
    scene: Annotated[
        list[str] | None,
        typer.Option(
            help='Part of the scene: "ball_colour = #2b6cb0", "rod_width = 1 mm". May be given '
            "several times.",
            rich_help_panel="Filming",
        ),
    ] = None,
    camera: Annotated[
        list[str] | None,
        typer.Option(
            help='Property of the camera: "fps = 120", "roll = 3 deg". May be given several times.',
            rich_help_panel="Filming",
        ),
    ] = None,
    as_json: JsonOption = False,
    **values: Any,
) -> None:
    """Make a synthetic video of a run, to test tracking with, and its exact table.

    Options replace what the scenario says. Existing files are replaced.
    """
    begun = time.perf_counter()
    ready = scenario_of(scenario, rerun, values)
    if output is None:
        raise InputError("name the video: --output clip.mp4")
    setting = (
        Scene(**values_of("--scene", scene, parameters_of(Scene))),
        Camera(**values_of("--camera", camera, parameters_of(Camera))),
    )
    arguments = arguments_of(OPTIONS, values)
    check_target(output, truth)
    with bar("simulating") as progress:
        motion = ready.simulate(progress=progress)
    with bar("filming") as progress:
        table = synthesise_video(
            motion, output, *setting, truth=truth, progress=progress, **arguments
        )
    summary = {
        **summarise(table),
        "wall_time": elapsed_since(begun),
        "files": [str(path) for path in (output, truth) if path is not None],
    }
    print_summary(summary, lines_of(summary), as_json=as_json)


def parameters_of(law: type) -> dict[str, Parameter]:
    """Return the parameters of a scene or a camera by name."""
    return {parameter.name: parameter for parameter in law_parameters(law, "")}


def scenario_of(source: str | None, rerun: Path | None, values: Mapping[str, Any]) -> Scenario:
    """Return the scenario to film as the command line names it."""
    try:
        return run_command.scenario_of(source, rerun, values)
    except ForeignParameterError as error:
        if error.parameter == "radius":
            error.way_out = f'draw the ball with --scene "ball_radius = {values["radius"]}"'
        raise


def summarise(table: xr.Dataset) -> dict[str, Any]:
    """Return the summary of a video: its size in time and the clicks in it."""
    attrs = table.attrs
    balls = 2 if "angle_2" in table else 1
    optics = Camera(**json.loads(attrs["camera"])).optics
    clicks = [[attrs[f"ball_{i}_pixel_{axis}"] for axis in "uv"] for i in range(1, balls + 1)]
    return {
        "frames": int(table.sizes["frame"]),
        "duration": float(table["time"][-1]),
        "balls": balls,
        "pivot": [round(attrs[f"pivot_pixel_{axis}"], 2) for axis in "uv"],
        "ball": [[round(number, 2) for number in click] for click in clicks],
        "length": attrs["length"],
        "radius": attrs["radius"],
        "metres_per_pixel": attrs["metres_per_pixel"],
        **{name: value for name, value in vars(optics).items() if value},
    }


def lines_of(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return a summary as names and texts for reading, with the command that tracks the video."""
    clicks = " ".join(f"--ball {u:g},{v:g}" for u, v in summary["ball"])
    u, v = summary["pivot"]
    declared = "".join(
        f" --{name.replace('_', '-')} {summary[name]:.9g}"
        for name in ("row_time", "lens_k1", "lens_k2")
        if name in summary
    )
    return {
        "video": f"{summary['frames']} frames, {summary['duration']:.6g} s",
        "scale": f"{1e3 * summary['metres_per_pixel']:.6g} mm a pixel",
        "track it": f"latolato track {summary['files'][0]} --balls {summary['balls']} "
        f'--pivot {u:g},{v:g} {clicks} --length "{summary["length"]:.9g} m" '
        f'--radius "{summary["radius"]:.6g} m"{declared}',
        "wall time": f"{summary['wall_time']:.2f} s",
    }
