"""`latolato import`: a track table from another program's table."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import ColumnOption, JsonOption, columns_of
from latolato.cli.output import print_summary
from latolato.core.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from latolato.io.tables.source import SourceTable


def import_(
    file: Annotated[
        Path, typer.Argument(help="Another program's table: text, spreadsheet, .zip or .gz.")
    ],
    column: ColumnOption = None,
    section: Annotated[
        str | None,
        typer.Option(help="Section, run, sheet or member, if the file holds several."),
    ] = None,
    decimal: Annotated[
        str | None, typer.Option(help='Decimal sign, "." or ",", where the file leaves it open.')
    ] = None,
    frame_rate: Annotated[
        str | None,
        typer.Option(help="Frames per second, in Hz, if rows are frames or count them."),
    ] = None,
    length: Annotated[str | None, typer.Option(help="Pivot to ball centre, in m.")] = None,
    radius: Annotated[str | None, typer.Option(help="Radius of the ball, in m.")] = None,
    pivot: Annotated[
        str | None,
        typer.Option(help='Where the pivot is in the file: "x, y", in m, or "x px, y px".'),
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
    preview: Annotated[
        bool, typer.Option("--preview", help="Show what was recognised and write nothing.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Convert another program's table into a track table: Tracker exports, phone sensors."""
    from latolato.experiment.importing import import_table
    from latolato.experiment.track_table import write_table
    from latolato.io.tables.source import read_source
    from latolato.scenario.units import to_si

    if preview:
        source = read_source(file, decimal=decimal)
        print(json.dumps(source.to_dict()) if as_json else preview_of(source))
        return
    if file.is_dir():
        raise IsADirectoryError(f"'{file}' is a folder; name a file in it")
    target = output or default_target(file, section)
    check_replaces_no_source(file, target)
    table = import_table(
        file,
        columns_of(column),
        section=section,
        decimal=decimal,
        frame_rate=frame_rate_of(frame_rate),
        length=to_si("length", length, "m"),
        radius=to_si("radius", radius, "m"),
        pivot=None if pivot is None else pivot_of(pivot),
        angle_from=angle_from,
        y_axis=y_axis,
        angle_sigma=to_si("angle_sigma", angle_sigma, "rad"),
    )
    if output is None:
        check_replaces_no_other(table, target)
    write_table(table, target)
    files = {"files": [str(target)]}
    print_summary(summarise(table) | files, lines_of(table), as_json=as_json)


def default_target(file: Path, section: str | None) -> Path:
    """Return the name of the track table beside a file; each section has its own.

    Examples
    --------
    >>> default_target(Path("swing.txt"), "Run #2").name
    'swing.Run-2.track.csv'
    """
    middle = "-".join(re.findall(r"\w+", section or ""))
    return file.with_suffix(f".{middle}.track.csv" if middle else ".track.csv")


def check_replaces_no_source(file: Path, target: Path) -> None:
    """Raise InputError if the track table would replace the measurement that it is made from."""
    if file.exists() and target.exists() and file.samefile(target):
        raise InputError(
            f"'{target}' is the measurement itself, which would be lost",
            way_out="name another file with --output",
        )


def check_replaces_no_other(table: xr.Dataset, target: Path) -> None:
    """Raise InputError if a table of other columns, or of something else, would be replaced."""
    from latolato.experiment.track_table import read_table

    if not target.exists():
        return
    if target.is_dir():
        raise InputError(
            f"'{target}' is a folder", way_out="name a file with --output, or rename the folder"
        )
    try:
        before = read_table(target).attrs
    except (InputError, OSError):
        before = {}
    same = ("source", "imported", "section")
    if any(before.get(name) != table.attrs.get(name) for name in same):
        raise InputError(
            f"'{target}' exists and was not imported from these columns",
            way_out=f"name another file with --output, or replace it with --output {target}",
        )


def frame_rate_of(text: str | None) -> float | None:
    """Return a number of frames per second; a bare number is one.

    Examples
    --------
    >>> frame_rate_of("240"), frame_rate_of("29.97 fps"), frame_rate_of("60 Hz")
    (240.0, 29.97, 60.0)
    """
    if text is None:
        return None
    match = re.fullmatch(r"\s*([\d.]+)\s*(?:fps|Hz|1/s|/s)?\s*", text)
    try:
        return float(match[1]) if match else _refuse_rate(text)
    except ValueError:
        return _refuse_rate(text)


def _refuse_rate(text: str) -> float:
    """Raise the error for a text that is no frame rate."""
    raise InputError("must be a number of frames per second", parameter="--frame-rate", value=text)


def pivot_of(text: str) -> Any:
    """Return the two numbers of a pivot, in m, or in pixels if the text says so.

    Examples
    --------
    >>> pivot_of("36 cm, 0 m"), pivot_of("320 px, 75 px")
    ([0.36, 0.0], [320.0, 75.0])
    """
    from latolato.scenario.units import to_si_list

    in_pixels = re.sub(r"(?<![a-z])(?:px|pixels?)\b", "pixel", text)
    return to_si_list("pivot", in_pixels, "pixel" if "pixel" in in_pixels else "m")


def preview_of(source: SourceTable) -> str:
    """Return what was recognised in a file, with the first rows of each section."""
    lines = [source.about, f"{source.encoding}, {source.delimiter}"]
    lines += [f"note: {note}" for note in source.notes]
    for section in source.sections:
        if section.name:
            lines.append(f"\n{section.name}")
        first, last = section.lines[0], section.lines[-1]
        lines.append(f"{len(section.lines)} rows, lines {first} to {last}")
        rows = section.cells(3)
        for column in section.columns:
            unit = f" [{column.unit}]" if column.unit else ""
            shown = ", ".join(row[column.position - 1] or "(empty)" for row in rows)
            lines.append(f"{column.position:>4} {column.path}{unit}: {shown} ...")
    return "\n".join(lines)


def summarise(table: xr.Dataset) -> dict[str, Any]:
    """Return what an imported table holds, as JSON knows it."""
    from latolato.simulation.summary import plain

    return {
        "rows": table.sizes["frame"],
        "attributes": {str(name): plain(value) for name, value in table.attrs.items()},
    }


def lines_of(table: xr.Dataset) -> dict[str, str]:
    """Return what an imported table holds, as texts that show a wrong unit or column."""
    from math import degrees

    from latolato.experiment.track_table import balls_of

    time = table["time"].values
    lines = {
        "recognised": table.attrs["recognised"],
        "columns": table.attrs["imported"],
        "table": f"{len(time)} rows, {time[-1] - time[0]:.6g} s",
    }
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
    notes = str(table.attrs.get("assumed", ""))
    return lines | ({"note": notes} if notes else {})
