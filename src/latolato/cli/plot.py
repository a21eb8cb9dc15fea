"""`latolato plot`: pictures and animations of stored results."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import named_values
from latolato.cli.output import Animation, Targets
from latolato.core.errors import InputError

if TYPE_CHECKING:
    import xarray as xr


def plot(
    file: Annotated[Path, typer.Argument(help="A result file or a sweep's store.")],
    output: Annotated[
        Path | None, typer.Option(help="Picture. Default: a PNG next to the file.")
    ] = None,
    animate: Annotated[Path | None, typer.Option(help="Animation of a run: .mp4 or .gif.")] = None,
    speed: Annotated[float, typer.Option(help="Playback speed; 1 is real time.")] = 1.0,
    fps: Annotated[float, typer.Option(help="Frames per second.")] = 30.0,
    variable: Annotated[
        str | None, typer.Option(help="Variable of a map or an analysis.", rich_help_panel="Maps")
    ] = None,
    log: Annotated[
        bool, typer.Option("--log", help="Logarithmic scale.", rich_help_panel="Maps")
    ] = False,
    curves: Annotated[
        bool,
        typer.Option(
            "--curves", help="Draw curves, one for each of a few values.", rich_help_panel="Maps"
        ),
    ] = False,
    select: Annotated[
        list[str] | None,
        typer.Option(help='Value of another dimension: "restitution=0.9".', rich_help_panel="Maps"),
    ] = None,
    overlay: Annotated[
        list[str] | None,
        typer.Option(
            help="Curve drawn over the map: tongue, lift_off, or a .nc or .csv file of "
            "bifurcation_curve.",
            rich_help_panel="Maps",
        ),
    ] = None,
    points: Annotated[
        Path | None,
        typer.Option(
            help="CSV of trials: drive_amplitude, drive_frequency or frequency_ratio, class.",
            rich_help_panel="Maps",
        ),
    ] = None,
) -> None:
    """Draw a run, a map or an analysis; --animate makes an animation of a run."""
    from latolato.io.files import load

    dataset = load(file)
    picture = output or file.with_suffix(".png")
    targets = Targets(plot=picture)
    targets.check("the name of a picture")
    animation = Animation(animate, speed, fps)
    animation.check()
    from latolato.figures import plot as pictures

    of_map: dict[str, Any] = {
        "variable": variable,
        "log": log,
        "curves": curves,
        "select": selection_of(select or [], dataset),
        "overlays": [each for text in overlay or [] for each in overlays_of(text)],
        "points": points,
    }
    kind = pictures.kind_of(dataset)
    if kind != "run":
        if animate is not None:
            article = "an" if kind == "analysis" else "a"
            raise InputError(f"'{file}' holds {article} {kind}: only a run can be animated")
        from latolato.figures.style import save_figure

        print(save_figure(pictures.plot(dataset, **of_map), picture))
        return
    unfit = [f"--{name.removesuffix('s')}" for name, value in of_map.items() if value]
    if unfit:
        raise InputError(f"'{file}' holds a run: {', '.join(unfit)} only fits a map")
    for path in targets.draw(dataset) + animation.write(dataset):
        print(path)


def overlays_of(text: str) -> list[xr.Dataset | str]:
    """Return the curves in a file of `bifurcation_curve`, or the name of a theory curve."""
    from latolato.io.analysis_tables import load_curves
    from latolato.io.files import load

    path = Path(text)
    if path.suffix.lower() == ".nc":
        return [load(path)]
    return [*load_curves(path)] if path.suffix.lower() == ".csv" else [text]


def selection_of(texts: Sequence[str], dataset: xr.Dataset) -> dict[str, Any]:
    """Return the values of dimensions that options name, in SI units."""
    from latolato.scenario.units import to_si

    values: dict[str, Any] = {}
    for name, value in named_values("--select", texts, "NAME=VALUE, as restitution=0.9").items():
        is_text = name not in dataset.coords or dataset[name].dtype.kind not in "iuf"
        unit = "1" if is_text else str(dataset[name].attrs.get("units", "1"))
        values[name] = value if is_text and not value.isdigit() else to_si(name, value, unit)
    return values
