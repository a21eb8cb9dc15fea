"""The track table: what was measured in every frame of a video, for one ball or two.

One row per decoded frame, in SI units, with the origin at the mean pivot, x to the right and y up.
Every part of the experiment chain reads and writes tables through this module.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError, Word, reading
from latolato.core.quantities import QUANTITIES
from latolato.core.registry import checked_choice, suggest
from latolato.experiment.rules import broken

if TYPE_CHECKING:
    import xarray as xr

# What a sample can be: seen; balls in contact; hidden; set by hand; carried on; given up.
FLAGS = ("ok", "collision", "occluded", "manual", "predicted", "lost")
# Of these, what the picture shows; the rest is computed by the tracker.
MEASURED = FLAGS[:4]
# Of these, what is known as well as its standard deviation says.
CLEAN = ("ok", "manual")
# Where a pivot may be known from that the picture does not contain.
OUTSIDE_SOURCES = ("declared", "arc")
SUFFIXES = (".csv", ".parquet", ".nc")
# The columns in their order; those of the second ball come with two balls only.
COLUMNS = (
    "frame", "time", "pivot_x", "pivot_y", "ball_1_x", "ball_1_y", "ball_2_x", "ball_2_y",
    "angle_1", "angle_2", "angle_sigma_1", "angle_sigma_2", "flag_1", "flag_2",
)  # fmt: skip
# Places in the picture, which a table has where no length gave a scale.
PICTURE_COLUMNS = (
    "pivot_u", "pivot_v", "pivot_2_u", "pivot_2_v", "ball_1_u", "ball_1_v", "ball_2_u", "ball_2_v",
)  # fmt: skip
# The pivot of the second ball, which a table has where each ball has a pivot of its own.
OWN_PIVOT_COLUMNS = ("pivot_2_x", "pivot_2_y")
_OPTIONAL = OWN_PIVOT_COLUMNS + PICTURE_COLUMNS
_KIND = "track"


def column_names(balls: int, columns: tuple[str, ...] = COLUMNS) -> tuple[str, ...]:
    """Return the names of a table's columns in their order, for one ball or two."""
    return tuple(name for name in columns if balls == 2 or "_2" not in name)


def track_table(
    columns: Mapping[str, Any], attributes: Mapping[str, Any] | None = None
) -> xr.Dataset:
    """Return a track table made of columns.

    Parameters
    ----------
    columns : mapping of str to array_like, shape (frame,)
        Named as in `COLUMNS` and `OWN_PIVOT_COLUMNS`, in SI units, and `PICTURE_COLUMNS`, in
        pixels. `time` is required;
        `frame` counts from 0 if it is omitted; any ``_2`` makes it a table of two balls. Omitted
        numbers are NaN; an omitted flag is "ok" where its angle is known and "lost"
        elsewhere.
    attributes : mapping, optional
        Numbers and texts that go with the table: ``source``, ``source_sha256``, ``length`` [m],
        ``radius`` [m], ``metres_per_pixel`` and so on; None is left out.

    Returns
    -------
    xarray.Dataset
        On the dimension ``frame``, with ``time`` as a second coordinate.

    Raises
    ------
    InputError
        For a missing time, unknown names, unequal lengths, no rows, times that do not increase,
        values that are not finite numbers, unknown flags, and attributes that are neither numbers
        nor texts.

    Examples
    --------
    >>> table = track_table({"time": [0.0, 0.1], "angle_1": [0.2, 0.1]}, {"length": 0.36})
    >>> table.flag_1.values.tolist()
    ['ok', 'ok']
    """
    import xarray as xr

    balls = 2 if any("_2" in name for name in columns) else 1
    names = column_names(balls)
    known = names + column_names(balls, _OPTIONAL)
    for name in columns:
        if name not in known:
            raise broken("no_target", {"name": name}, way_out=suggest(name, list(known)))
    if "time" not in columns:
        raise InputError("a track table needs the column 'time' [s]")
    arrays = {name: _values(name, value) for name, value in columns.items()}
    count = len(arrays["time"])
    if count == 0:
        raise broken("no_row")
    for name, values in arrays.items():
        if values.shape != (count,):
            raise InputError(
                f"column '{name}' must have {count} rows, like time", value=values.shape
            )
    arrays.setdefault("frame", np.arange(count))
    _check_increasing("time", arrays["time"])
    _check_increasing("frame", arrays["frame"])
    for ball in range(1, balls + 1):
        angle = arrays.setdefault(f"angle_{ball}", np.full(count, np.nan))
        arrays.setdefault(f"flag_{ball}", np.where(np.isfinite(angle), "ok", "lost"))
    variables = {
        name: (
            "frame",
            arrays.get(name, np.full(count, np.nan)),
            QUANTITIES[name].attributes,
        )
        for name in (*names, *(name for name in known[len(names) :] if name in arrays))
    }
    table = xr.Dataset(variables, attrs={"table": _KIND, **_attributes(attributes or {})})
    return table.set_coords("time")


def checked_table(table: Any, *needed: str) -> xr.Dataset:
    """Return a track table, or raise if it is not one or a required column has no numbers.

    Raises
    ------
    InputError
        If it is not a track table, or a required column is missing or empty.
    """
    import xarray as xr

    if not isinstance(table, xr.Dataset):
        raise InputError(
            "a track table must be a dataset", value=type(table).__name__, way_out="read_table"
        )
    if table.attrs.get("table") != _KIND or "frame" not in table.dims:
        raise InputError(
            "the dataset is not a track table", way_out="make one with track_table or read_table"
        )
    for name in needed:
        if name not in table.variables:
            known = Word(QUANTITIES[name].long_name if name in QUANTITIES else name)
            raise broken("no_column", {"quantity": known, "column": name})
        if not np.any(np.isfinite(table[name].values)):
            known = Word(table[name].attrs.get("long_name", name))
            raise broken("empty_column", {"quantity": known, "column": name})
    return table


def balls_of(table: xr.Dataset) -> int:
    """Return how many balls a table describes."""
    return 2 if "angle_2" in table.variables else 1


def has_own_pivots(table: xr.Dataset) -> bool:
    """Return whether each of a table's two balls has a pivot of its own."""
    return OWN_PIVOT_COLUMNS[0] in table.variables


def table_of_ball(table: xr.Dataset, ball: int) -> xr.Dataset:
    """Return the table of one of two balls that have pivots of their own, as if it were alone.

    Raises
    ------
    InputError
        If there is no such ball.
    """
    if isinstance(ball, bool) or ball not in (1, 2):
        raise InputError("must be 1 or 2 in this table", parameter="ball", value=ball)
    columns = {
        name: table[name].values for name in (*COLUMNS, *_OPTIONAL) if name in table.variables
    }
    attributes: dict[str, Any] = {str(n): each for n, each in table.attrs.items() if n != "table"}
    parts = columns, attributes
    if ball == 2:
        for part in parts:
            part |= {_of_first(name): each for name, each in part.items() if "_2" in name}
    for part in parts:
        for name in [name for name in part if "_2" in name]:
            del part[name]
    return track_table(columns, attributes)


def _of_first(name: str) -> str:
    """The name of the same column for the first ball or its pivot."""
    first = name.replace("_2", "_1")
    is_of_ball = first in COLUMNS or first.startswith("ball_1")
    return first if is_of_ball else name.replace("_2", "")


def write_table(table: xr.Dataset, path: str | Path) -> Path:
    """Write a track table as CSV, Parquet or NetCDF by its suffix and return the path.

    The file is written completely or not at all; see `latolato.io.files.save_table`.

    Raises
    ------
    InputError
        If it is not a track table or the suffix is unknown.
        For Parquet, if the extra `parquet` is missing.
    OSError
        If the file cannot be written.
    """
    from latolato.io.files import save_table

    checked_table(table)
    columns = {
        name: (table[name].values, table[name].attrs)
        for name in COLUMNS + _OPTIONAL
        if name in table.variables
    }
    return save_table(table, columns, path, SUFFIXES, "the name of a track table")


def read_table(path: str | Path) -> xr.Dataset:
    """Return the track table in a file, checked as in `track_table`.

    Raises
    ------
    InputError
        For an unknown suffix, an empty file, a file with other content, missing columns, missing or
        different units, and anything `track_table` refuses.
    OSError
        If the file cannot be read.
    """
    from latolato.io.column_files import read_columns
    from latolato.io.files import check_readable, load

    path = Path(path)
    suffix = check_readable(path, SUFFIXES, "the name of a track table")
    with reading(path, gives_values=True):
        if path.stat().st_size == 0:
            raise InputError("it is empty")
        if suffix == ".nc":
            stored = load(path)
            parts = {str(key): (each.values, each.attrs) for key, each in stored.variables.items()}
            # Numbers that are unknown are left out.
            attributes = {str(key): each for key, each in stored.attrs.items() if each == each}
        else:
            parts, attributes = read_columns(path, suffix)
        columns = {name: _known(name, values) for name, (values, _) in parts.items()}
        if attributes.pop("table", None) != _KIND:
            raise InputError(
                "it is not a track table: it does not say 'table: track'",
                way_out="other tables are read with import_table (`latolato import`)",
            )
        balls = 2 if {"angle_2", "flag_2"} & columns.keys() else 1
        missing = [name for name in column_names(balls) if name not in columns]
        if missing:
            raise broken("lacking_columns", {"names": ", ".join(missing)})
        for name in columns:
            unit = parts[name][1].get("units", "")
            if name in QUANTITIES and unit != QUANTITIES[name].unit:
                expected = {"unit": QUANTITIES[name].unit}
                raise broken("unit_of_column", expected, parameter=name, value=unit)
        attributes = {key: _plain(value) for key, value in attributes.items()}
        known = {*column_names(balls), *_OPTIONAL}
        # A NetCDF file may hold more about its frames, as the truth of a synthetic video does.
        more = {name: columns.pop(name) for name in [*columns] if name not in known}
        if suffix != ".nc":
            columns |= more  # a misspelt name in a text file is refused
            more = {}
        table = track_table(columns, attributes)
        return table.assign({name: ("frame", values) for name, values in more.items()})


def _known(name: str, values: Any) -> Any:
    """Return a column with the empty cells of its numbers as NaN."""
    if isinstance(values, list) and not name.startswith("flag_"):
        return [value or "nan" for value in values]
    return values


def _plain(value: Any) -> Any:
    """A value as a file's attribute: a number or a text, JSON for anything else."""
    return value if isinstance(value, (int, float, str)) else json.dumps(value)


def _values(name: str, column: Any) -> Any:
    """Return a column as an array of its kind."""
    values = np.asarray(column)
    if name.startswith("flag_"):
        values = values.astype(str)
        for flag in np.unique(values):
            checked_choice(name, str(flag), FLAGS)
        return values
    try:
        numbers = values.astype(np.float64)
    except (TypeError, ValueError):
        raise broken("numbers_of_column", parameter=name, value=_first_text(values)) from None
    if np.any(np.isinf(numbers)):
        raise broken("infinite_numbers", parameter=name)
    if name == "frame":
        if not np.all(numbers == np.floor(numbers)):
            raise broken("whole_numbers_of_column", parameter=name)
        return numbers.astype(np.int64)
    return numbers


def _first_text(values: Any) -> Any:
    """Return the first value that is no number."""
    for value in values.ravel().tolist():
        try:
            float(value)
        except (TypeError, ValueError):
            return value
    return values.ravel()[0] if values.size else ""


def _check_increasing(name: str, values: Any) -> None:
    """Raise InputError unless each value is known and larger than the one before."""
    if not np.all(np.isfinite(values)):
        row = int(np.argmin(np.isfinite(values)))
        raise broken("missing_in_row", {"row": row + 1}, parameter=name)
    falls = np.flatnonzero(np.diff(values) <= 0)
    if falls.size:
        i = int(falls[0])
        place = {"last": float(values[i]), "row": i + 2}
        raise broken("falling_row", place, parameter=name, value=float(values[i + 1]))


def _attributes(entries: Mapping[str, Any]) -> dict[str, Any]:
    """Return attributes as plain numbers and texts, without those that are None."""
    attributes: dict[str, Any] = {}
    for key, value in entries.items():
        plain = value.item() if hasattr(value, "item") else value
        if plain is None:
            continue
        if not isinstance(plain, (bool, int, float, str)):
            raise InputError(f"attribute '{key}' must be a number or a text", value=value)
        attributes[str(key)] = int(plain) if isinstance(plain, bool) else plain
    return attributes
