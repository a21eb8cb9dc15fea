"""Lines of Python and commands that import and fit a table as a page does."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping
from pathlib import PurePath
from typing import Any

from latolato.app.experiment.tables import Import
from latolato.core.parameters import flag_of
from latolato.experiment.fits import fits
from latolato.experiment.fits.registry import Apparatus


def python_lines(
    name: str,
    choices: Import | None,
    kinds: Iterable[str],
    apparatus: Apparatus,
    part: Mapping[str, float],
) -> str:
    """Return lines of Python that read a table and print the verdicts of fits.

    Parameters
    ----------
    name : str
        The file.
    choices : Import, optional
        What it is imported with; None for a track table of this package.
    kinds : iterable of str
        The fits.
    apparatus : Apparatus
        What the fits are given.
    part : mapping of str to float
        The first and the last instant that they use [s], as far as these are given.
    """
    if choices is None:
        origin = "from latolato.experiment.track_table import read_table"
        table = [f"table = read_table({name!r})"]
    else:
        origin = "from latolato.experiment.importing import import_table"
        read = [repr(name), repr(choices.columns)]
        read += [f"{each}={value!r}" for each, value in choices.arguments.items()]
        table = ["table = import_table(", *(f"    {each}," for each in read), ")"]
    verdicts = []
    for kind in kinds:
        given = {**_known(kind, apparatus), **part}
        listed = "".join(f", {each}={value!r}" for each, value in given.items())
        verdicts.append(f"print(ll.{fits[kind].function.__name__}(table{listed}).verdict)")
    return "\n".join(["import latolato as ll", origin, "", *table, *verdicts])


def command_lines(
    name: str,
    choices: Import | None,
    kinds: Iterable[str],
    apparatus: Apparatus,
    part: Mapping[str, float],
) -> str:
    """Return commands of the shell that do the same as `python_lines`."""
    lines, table = [], name
    if choices is not None:
        table = str(PurePath(name).with_suffix(".track.csv"))
        words = ["latolato", "import", name]
        for target, column in choices.columns.items():
            words += ["--column", f"{target}={column}"]
        arguments = dict(choices.arguments)
        if "pivot" in arguments:
            unit = "px" if choices.is_in_pixels else "m"
            arguments["pivot"] = ", ".join(f"{number} {unit}" for number in arguments["pivot"])
        lines.append([*words, *_options(arguments), "--output", table])
    lines += [
        ["latolato", "fit", kind, table, *_options({**_known(kind, apparatus), **part})]
        for kind in kinds
    ]
    return "\n".join(map(shlex.join, lines))


def _known(kind: str, apparatus: Apparatus) -> dict[str, Any]:
    """The known parameters of the apparatus that a fit takes."""
    return {
        name: value
        for name, value in vars(apparatus).items()
        if name in fits[kind].parameters and value is not None
    }


def _options(arguments: Mapping[str, Any]) -> list[str]:
    """Return arguments of a function as options of a command."""
    return [word for name, value in arguments.items() for word in (flag_of(name), str(value))]
