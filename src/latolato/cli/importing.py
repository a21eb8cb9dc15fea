"""`latolato import`: a track table from another program's table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from latolato.cli.options import ColumnOption, columns_of
from latolato.cli.output import in_columns

if TYPE_CHECKING:
    import xarray as xr


def import_(
    file: Annotated[Path, typer.Argument(help="Text table of another program.")],
    column: ColumnOption = None,
    length: Annotated[str | None, typer.Option(help="Pivot to ball centre, in m.")] = None,
    radius: Annotated[str | None, typer.Option(help="Radius of the ball, in m.")] = None,
    pivot: Annotated[
        str | None, typer.Option(help='Where the pivot is in the file: "x, y", in m.')
    ] = None,
    angle_from: Annotated[
        str, typer.Option(help="Direction of zero angle: down, or right (the x axis).")
    ] = "down",
    y_axis: Annotated[str, typer.Option(help="Direction of positive y: up or down.")] = "up",
    angle_sigma: Annotated[
        str | None, typer.Option(help="Uncertainty of the angles, in rad.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="Track table. Default: next to the file, as .track.csv.")
    ] = None,
) -> None:
    """Convert another program's table into a track table: Tracker exports, phone sensors."""
    from latolato.experiment.importing import import_table
    from latolato.experiment.track_table import write_table
    from latolato.scenario.units import to_si, to_si_list

    target = output or file.with_suffix(".track.csv")
    table = import_table(
        file,
        columns_of(column),
        length=to_si("length", length, "m"),
        radius=to_si("radius", radius, "m"),
        pivot=to_si_list("pivot", pivot, "m") if pivot is not None else None,
        angle_from=angle_from,
        y_axis=y_axis,
        angle_sigma=to_si("angle_sigma", angle_sigma, "rad"),
    )
    write_table(table, target)
    print(in_columns(lines_of(table, target)))


def lines_of(table: xr.Dataset, path: Path) -> dict[str, str]:
    """Return what an imported table holds, as texts that show a wrong unit or column."""
    from math import degrees

    from latolato.experiment.track_table import balls_of

    time = table["time"].values
    lines = {"table": f"{len(time)} rows, {time[-1] - time[0]:.6g} s"}
    for ball in range(1, balls_of(table) + 1):
        angle = table[f"angle_{ball}"]
        missing = int(angle.isnull().sum())
        lines[f"angle {ball}"] = (
            f"{degrees(float(angle.min())):.4g} to {degrees(float(angle.max())):.4g} deg"
            + (f", missing in {missing} rows" if missing else "")
        )
    height = table["pivot_y"]
    if height.notnull().any():
        low, high = 1e3 * float(height.min()), 1e3 * float(height.max())
        lines["pivot"] = f"{low:.4g} to {high:.4g} mm high"
    return lines | {"written": str(path)}
