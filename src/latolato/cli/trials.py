"""`latolato trials`: the table of trials."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import EndOption, JsonOption, StartOption, place_of
from latolato.cli.output import Targets, print_summary
from latolato.core.errors import InputError
from latolato.io.progress import bar

if TYPE_CHECKING:
    import xarray as xr

_VIDEO = "Videos without a table"


def trials(
    source: Annotated[list[Path], typer.Argument(help="Folders, track tables and videos.")],
    length: Annotated[str | None, typer.Option(help="Pivot to ball centre, in m.")] = None,
    gravity: Annotated[str | None, typer.Option(help="Gravity, in m/s^2; 9.8 by default.")] = None,
    transient: Annotated[
        str | None,
        typer.Option(
            help="Time after which the angle counts as settled, in s; by default the last "
            "third of the record counts."
        ),
    ] = None,
    start: StartOption = None,
    end: EndOption = None,
    sets: Annotated[
        str, typer.Option(help="What makes a set: auto, folder or amplitude.")
    ] = "auto",
    balls: Annotated[int | None, typer.Option(help="1 or 2.", rich_help_panel=_VIDEO)] = None,
    pivot: Annotated[
        str | None,
        typer.Option(
            help='Pivot in the first frame: "u, v" in pixels, for all videos.',
            rich_help_panel=_VIDEO,
        ),
    ] = None,
    ball: Annotated[
        list[str] | None,
        typer.Option(help="Ball in the first frame, once or twice.", rich_help_panel=_VIDEO),
    ] = None,
    radius: Annotated[
        str | None, typer.Option(help="Radius of a ball, in m.", rich_help_panel=_VIDEO)
    ] = None,
    workers: Annotated[int, typer.Option(help="Processes.")] = 1,
    output: Annotated[Path | None, typer.Option(help="Trial table: .csv or .nc.")] = None,
    as_json: JsonOption = False,
) -> int:
    """Make the table of trials: drive, largest and settled angle, class.

    A bad file is named and left out; the exit code is then 1.
    """
    from latolato.experiment.trial_table import SUFFIXES, write_trials
    from latolato.experiment.trials import collect_trials
    from latolato.scenario.units import to_si

    Targets(output).check("the name of a trial table", SUFFIXES)
    numbers = {"length": (length, "m"), "radius": (radius, "m"), "gravity": (gravity, "m/s^2"),
               "transient": (transient, "s"), "start": (start, "s"), "end": (end, "s")}  # fmt: skip
    arguments: dict[str, Any] = {
        name: to_si(name, text, unit) for name, (text, unit) in numbers.items() if text is not None
    }
    if balls is not None and ball and len(ball) != balls:
        raise InputError(f"--balls {balls} needs --ball {balls} times", value=len(ball))
    arguments["balls"] = [place_of("--ball", text) for text in ball or ()] or balls
    arguments["pivot"] = place_of("--pivot", pivot) if pivot is not None else None
    with bar("trials") as progress, warnings.catch_warnings():
        # The summary contains them.
        warnings.simplefilter("ignore", RuntimeWarning)
        table = collect_trials(source, sets=sets, workers=workers, progress=progress, **arguments)
    files = [str(write_trials(table, output))] if output is not None else []
    failed = [text for text in table.attrs["failed"].split(" | ") if text]
    summary = summarise(table)
    if not as_json:
        print(table_text(summary["trials"]))
    print_summary(summary | {"failed": failed, "files": files}, lines_of(summary), as_json=as_json)
    for text in failed:
        print(f"latolato: {text}", file=sys.stderr)
    return 1 if failed else 0


def summarise(table: xr.Dataset) -> dict[str, Any]:
    """Return the rows of a trial table and how many there are of each class."""
    from latolato.experiment.trial_table import CLASSES

    names = [str(name) for name in table.data_vars]
    rows = [
        dict(zip(names, values, strict=True))
        for values in zip(*(table[name].values.tolist() for name in names), strict=True)
    ]
    return {
        "trials": rows,
        "sets": list(dict.fromkeys(table["set"].values.tolist())),
        "classes": {name: int((table["class"] == name).sum()) for name in CLASSES},
        "borderline": int(table["borderline"].sum()),
    }


def table_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the rows of a trial table for reading."""
    from math import degrees

    lines = [f"{'set':10} {'A0 [mm]':>9} {'w/w0':>7} {'largest':>9} {'lasting':>9}  class"]
    for row in rows:
        mark = " (borderline)" if row["borderline"] else ""
        note = f", {row['note']}" if row["note"] else ""
        lines.append(
            f"{row['set']:10} {1e3 * row['drive_amplitude']:9.3f} {row['frequency_ratio']:7.4f} "
            f"{degrees(row['largest_angle']):8.1f}° "
            f"{degrees(row['largest_angle_after_transient']):8.1f}°  "
            f"{row['class']}{mark}  {row['source']}{note}"
        )
    return "\n".join(lines)


def lines_of(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return how many trials there are of each class, for reading."""
    classes = ", ".join(f"{count} {name}" for name, count in summary["classes"].items())
    trials, sets = len(summary["trials"]), len(summary["sets"])
    words = f"{trials} trial{'s' * (trials != 1)} in {sets} set{'s' * (sets != 1)}"
    return {"table": f"{words}: {classes}"}
