"""`latolato trials`: the table of trials."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import (
    BallOption,
    BallsOption,
    JsonOption,
    balls_of,
    place_of,
    with_options,
)
from latolato.cli.output import Targets, print_summary
from latolato.experiment.trial_table import CLASSES, SUFFIXES, write_trials
from latolato.experiment.trials import collect_trials
from latolato.io.progress import bar
from latolato.scenario.analysis_options import arguments_of, options_of

if TYPE_CHECKING:
    import xarray as xr

OPTIONS = options_of(collect_trials, without=("sources", "pivot", "balls", "progress"))


@with_options(OPTIONS.values())
def trials(
    source: Annotated[list[Path], typer.Argument(help="Folders, track tables and videos.")],
    balls: BallsOption = None,
    pivot: Annotated[
        str | None,
        typer.Option(
            help="Column and row of the pivot in the first frame of all videos: 640,194.",
            metavar="U,V",
        ),
    ] = None,
    ball: BallOption = None,
    output: Annotated[
        Path | None, typer.Option(help="Trial table: .csv or .nc.", rich_help_panel="Output")
    ] = None,
    as_json: JsonOption = False,
    **values: Any,
) -> int:
    """Make the table of trials: drive, largest and settled angle, class.

    A bad file is named and left out; the exit code is then 1.
    """
    Targets(output).check("the name of a trial table", SUFFIXES)
    arguments = arguments_of(OPTIONS, values)
    arguments["balls"] = balls_of(balls, ball)
    if pivot is not None:
        arguments["pivot"] = place_of("--pivot", pivot)
    with bar("trials") as progress, warnings.catch_warnings():
        # The summary contains them.
        warnings.simplefilter("ignore", RuntimeWarning)
        table = collect_trials(source, progress=progress, **arguments)
    files = [str(write_trials(table, output))] if output is not None else []
    summary = summarise(table) | {"files": files}
    if not as_json:
        print(table_text(summary["trials"]))
    print_summary(summary, lines_of(summary), as_json=as_json)
    for text in summary["failed"]:
        print(f"latolato: {text}", file=sys.stderr)
    return 1 if summary["failed"] else 0


def summarise(table: xr.Dataset) -> dict[str, Any]:
    """Return the rows of a trial table and how many there are of each class."""
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
        "failed": [text for text in table.attrs["failed"].split(" | ") if text],
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
