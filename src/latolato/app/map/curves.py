"""Bifurcation curves over maps on pages: their CSV, and those that are shipped with scenarios."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app import CURVES
from latolato.app.analyse.answer import to_csv
from latolato.core.errors import InputError
from latolato.io.shown_units import name_and_unit
from latolato.paper import curves_fig05, curves_fig09, curves_fig11

if TYPE_CHECKING:
    import xarray as xr

_LABEL = re.compile(r"# (\w+): (.*)")
_TABLE = re.compile(r"# over (.+)")
_NAME = re.compile(r"'(\w+)'")
# Amplitudes of the map of Fig. 11 reach so far [m].
_FIG11 = 0.04
# By the names of scenarios; each makes the curves over its map.
SHIPPED: dict[str, Callable[[], Sequence[xr.Dataset]]] = {
    "fig05": curves_fig05.curves,
    "fig09": curves_fig09.curves,
    "fig11": lambda: curves_fig11.curves(_FIG11),
}


def write_shipped(names: Iterable[str] = SHIPPED, folder: Path = CURVES) -> list[Path]:
    """Compute the curves that are shipped with scenarios, a file for each; return the files."""
    folder.mkdir(exist_ok=True)
    paths = []
    for name in names:
        paths.append(folder / f"{name}.csv")
        text = "\n".join(to_csv(_shortened(curve)) for curve in SHIPPED[name]())
        paths[-1].write_text(text, encoding="utf-8")
    return paths


def _shortened(curve: xr.Dataset) -> xr.Dataset:
    """Round a curve's numbers to twelve digits: with ten, motions at folds are not found again."""
    shortened = curve.copy()
    for name, variable in curve.data_vars.items():
        if variable.dtype.kind == "f":
            digits = np.array([float(f"{value:.12g}") for value in variable.values.ravel()])
            shortened[name] = variable.copy(data=digits.reshape(variable.shape))
    return shortened


def read_curves(text: str) -> list[xr.Dataset]:
    """Return the bifurcation curves in a text that `to_csv` wrote, or several of these in a row.

    Complex numbers stay in two columns.

    Raises
    ------
    InputError
        If it holds no bifurcation curves.
    """
    parts: list[tuple[dict[str, str], list[tuple[list[str], list[str]]]]] = []
    for line in text.splitlines():
        table, label = _TABLE.fullmatch(line), _LABEL.fullmatch(line)
        if table and parts:
            parts[-1][1].append((table[1].split(", "), []))
        elif label:
            if not parts or parts[-1][1]:  # labels stand above the tables of a curve
                parts.append(({}, []))
            parts[-1][0][label[1]] = label[2]
        elif line and parts and parts[-1][1]:
            parts[-1][1][-1][1].append(line)
    try:
        if not parts:
            raise ValueError("it has no labels")
        return [_curve(labels, tables) for labels, tables in parts]
    except (KeyError, ValueError, IndexError) as error:
        raise InputError(f"holds no bifurcation curve: {error}", parameter="curves") from None


def _curve(labels: dict[str, str], tables: list[tuple[list[str], list[str]]]) -> xr.Dataset:
    """Return a curve from its labels and the lines of its tables by their dimensions."""
    import xarray as xr

    if labels["analysis"] != "bifurcation_curve":
        raise ValueError(f"it is a result of {labels['analysis']}")
    attributes: dict[str, Any] = {name: _value(text) for name, text in labels.items()}
    attributes["parameters"] = _NAME.findall(labels["parameters"])
    variables: dict[str, Any] = {}
    for dims, lines in tables:
        heads, *rows = csv.reader(lines)
        dims = [dim for dim in dims if dim != "nothing"]
        sizes = [len({row[k] for row in rows}) for k in range(len(dims))]
        for k, head in enumerate(heads[len(dims) :], len(dims)):
            name, unit = name_and_unit(head)
            values = np.array([_value(row[k]) for row in rows])
            variables[name] = (dims, values.reshape(sizes), {"units": unit} if unit else {})
    return xr.Dataset(variables, attrs=attributes)


def _value(text: str) -> Any:
    """Return a number where a text is one."""
    try:
        return float(text)
    except ValueError:
        return text
