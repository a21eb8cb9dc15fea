"""`latolato import`: a track table from another program's table."""

from __future__ import annotations

import json
import re
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import (
    ColumnOption,
    JsonOption,
    StrictCommand,
    columns_of,
    with_options,
)
from latolato.cli.output import print_summary
from latolato.core.errors import InputError, called
from latolato.experiment.importing import import_table
from latolato.experiment.track_table import balls_of, read_table, write_table
from latolato.io.tables.source import read_source
from latolato.scenario.analysis_options import arguments_of, options_of
from latolato.scenario.units import to_si_list
from latolato.simulation.summary import plain

if TYPE_CHECKING:
    import xarray as xr

    from latolato.io.tables.source import SourceTable


OPTIONS = options_of(import_table, without=("path", "notes", "questions"))


@with_options(OPTIONS.values())
def import_(
    file: Annotated[
        Path, typer.Argument(help="Another program's table: text, spreadsheet, .zip or .gz.")
    ],
    column: ColumnOption = None,
    output: Annotated[
        Path | None,
        typer.Option(
            help="Track table. Default: next to the file, as .track.csv.", rich_help_panel="Output"
        ),
    ] = None,
    preview: Annotated[
        bool, typer.Option("--preview", help="Show what was recognised and write nothing.")
    ] = False,
    as_json: JsonOption = False,
    *,
    context: typer.Context,
    **values: Any,
) -> None:
    """Convert another program's table into a track table: Tracker exports, phone sensors."""
    if preview:
        source = read_source(file, decimal=values["decimal"])
        print(json.dumps(source.to_dict()) if as_json else preview_of(source))
        return
    if file.is_dir():
        raise IsADirectoryError(f"'{file}' is a folder; name a file in it")
    target = output or default_target(file, values["section"])
    check_replaces_no_source(file, target)
    for name, read in (("frame_rate", frame_rate_of), ("pivot", pivot_of)):
        if values[name] is not None:
            values[name] = read(values[name])
    notes: list[str] = []
    questions: list[str] = []
    table = import_table(
        file,
        columns_of(column),
        **arguments_of(OPTIONS, values),
        notes=notes,
        questions=questions,
    )
    if output is None:
        check_replaces_no_other(table, target)
    write_table(table, target)
    files = {"files": [str(target)]}
    assert isinstance(context.command, StrictCommand)
    asked, told = (
        "; ".join(called(each, context.command.name_of) for each in sentences)
        for sentences in (questions, notes)
    )
    # What is asked comes before the numbers.
    lines = {"question": asked, **lines_of(table), "note": told}
    lines = {name: text for name, text in lines.items() if text}
    print_summary(summarise(table) | files, lines, as_json=as_json)


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


def frame_rate_of(text: str) -> float:
    """The number of frames per second [1/s]; a bare number is one.

    Examples
    --------
    >>> frame_rate_of("240"), frame_rate_of("29.97 fps"), frame_rate_of("60 Hz")
    (240.0, 29.97, 60.0)
    """
    match = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(?:fps|Hz|1/s|/s)?\s*", text)
    if match is None:
        raise InputError(
            "must be a number of frames per second", parameter="--frame-rate", value=text
        )
    return float(match[1])


def pivot_of(text: str) -> Any:
    """Return the two numbers of a pivot, in m, or in pixels if the text says so.

    Examples
    --------
    >>> pivot_of("36 cm, 0 m"), pivot_of("320 px, 75 px")
    ([0.36, 0.0], [320.0, 75.0])
    """
    in_pixels = re.sub(r"(?<![a-z])(?:px|pixels?)\b", "pixel", text)
    return to_si_list("pivot", in_pixels, "pixel" if "pixel" in in_pixels else "m")


def preview_of(source: SourceTable) -> str:
    """The recognised format and columns of a file, with the first rows of each section."""
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
    """The number of rows and the attributes of an imported table, as JSON knows them."""
    return {
        "rows": table.sizes["frame"],
        "attributes": {str(name): plain(value) for name, value in table.attrs.items()},
    }


def lines_of(table: xr.Dataset) -> dict[str, str]:
    """Columns and ranges of an imported table, as texts that show a wrong unit or column."""
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
    return lines
