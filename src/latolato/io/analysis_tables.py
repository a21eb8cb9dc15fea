"""Results of analyses as text tables, and bifurcation curves read from them."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.quantities import in_brackets
from latolato.io.files import check_readable, without_complex
from latolato.io.shown_units import name_and_unit

if TYPE_CHECKING:
    import xarray as xr

_LABEL = re.compile(r"# (\w+): (.*)")
_TABLE = re.compile(r"# over (.+)")
_NAME = re.compile(r"'(\w+)'")


def to_csv(dataset: xr.Dataset) -> str:
    """Return an analysis as text: its labels, its single numbers, a table for each shape."""
    plain = without_complex(dataset)
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow
    for key, value in plain.attrs.items():
        print(f"# {key}: {' '.join(str(value).split())}", file=text)
    tables: dict[tuple[str, ...], list[str]] = {}
    for name, variable in plain.data_vars.items():
        tables.setdefault(tuple(map(str, variable.dims)), []).append(str(name))
    for dims, names in sorted(tables.items(), key=lambda item: len(item[0])):
        print(f"\n# over {', '.join(dims) or 'nothing'}", file=text)
        shape = tuple(plain.sizes[dim] for dim in dims)
        grids = np.meshgrid(*(plain[dim].values for dim in dims), indexing="ij")
        columns = [grid.ravel() for grid in grids]
        columns += [np.broadcast_to(plain[name].values, shape).ravel() for name in names]
        write([*dims, *(_headed(plain, name) for name in names)])
        for row in zip(*(column.tolist() for column in columns), strict=True):
            write(row)
    return text.getvalue()


def _headed(dataset: xr.Dataset, name: str) -> str:
    """Return the head of a column, with its unit."""
    return name + in_brackets(str(dataset[name].attrs.get("units", "1")))


def load_curves(path: Path) -> list[xr.Dataset]:
    """Return the bifurcation curves in a CSV file; see `read_curves`."""
    check_readable(path, (".csv",), "a file of curves")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"'{path}' is not a text file", way_out="save it as UTF-8 text") from None
    return read_curves(text, f"'{path}'")


def read_curves(text: str, what: str = "curves") -> list[xr.Dataset]:
    """Return the bifurcation curves in a text that `to_csv` wrote, or several of these in a row.

    Complex numbers stay in two columns. Messages call the text `what`.

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
        why = f"it has no {error}" if isinstance(error, KeyError) else error
        raise InputError(f"holds no bifurcation curve: {why}", parameter=what) from None


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
