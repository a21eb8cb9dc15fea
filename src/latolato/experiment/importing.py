"""Import tables of other programs: exports of Tracker, phone sensors, spreadsheets."""

from __future__ import annotations

import csv
import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, reading
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, QUANTITIES
from latolato.core.registry import checked_choice, checked_number, suggest
from latolato.experiment.track_table import column_names, track_table
from latolato.scenario.units import to_si

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

# What people call the columns, in small letters and without units; used where no column is named.
_USUAL = {
    "time": ("t", "time"),
    "angle_1": ("theta", "angle", "θ", "angle_1"),
    "ball_1_x": ("x", "ball_1_x"),
    "ball_1_y": ("y", "ball_1_y"),
}
# What may be imported: the table's numbers.
TARGETS = tuple(n for n in column_names(2) if n != "frame" and not n.startswith("flag"))
_WITH_UNIT = re.compile(r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))\s*")
# What a gyroscope measures; it becomes the angle.
_RATE = "angular_velocity_1"
# Files beyond this size are taken for mistakes [bytes].
_LARGEST = 500_000_000


@dataclass(frozen=True)
class _Text:
    """A text table: names of its columns, and rows of cells."""

    names: list[str]
    columns: list[list[str]]
    decimal_comma: bool


def import_table(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    *,
    length: float | None = None,
    radius: float | None = None,
    pivot: Sequence[float] | None = None,
    angle_from: str = "down",
    y_axis: str = "up",
    angle_sigma: float | None = None,
) -> xr.Dataset:
    """Return a track table from a text file of another program.

    Parameters
    ----------
    path : str or Path
        A table of numbers below a line of names, with cells separated by tabs, semicolons,
        commas or blanks. Further lines above, and comments, are skipped; numbers may have decimal
        commas unless commas separate the cells.
    columns : mapping of str to str, optional
        For each column of the track table, the column of the file:
        ``{"time": "t [s]", "angle_1": "theta [deg]"}``.
        The unit is given in brackets, here or in the file's own names, as in
        "Time (s)". By default columns called t, theta, x and y are used. Instead of an angle
        you may give ``angular_velocity_1``, a gyroscope's rate about the axis of the swing.
    length, radius : float, optional
        Pivot to ball centre and the ball's radius [m], kept with the table.
    pivot : pair of float, optional
        Position of the pivot in the file's coordinates [m], if angles come from positions and the
        file has no pivot.
    angle_from : {"down", "right"}
        Direction from which the file counts angles, counter-clockwise: "right" is the x axis.
    y_axis : {"up", "down"}
        Direction in which the file's y increases.
    angle_sigma : float, optional
        Standard deviation of the angles [rad], if the file has none.

    Returns
    -------
    xarray.Dataset
        A track table, see `latolato.experiment.track_table`. Angles are computed from positions
        where the file has none; cells without a number are NaN and flagged lost.

    Raises
    ------
    InputError
        For missing or duplicate columns, missing or unsuitable units, cells that are not numbers,
        times that do not increase, and positions without a pivot.
    OSError
        If the file cannot be read.
    """
    path = Path(path)
    checked_choice("angle_from", angle_from, ("down", "right"))
    checked_choice("y_axis", y_axis, ("up", "down"))
    if not path.is_file():
        raise FileNotFoundError(f"there is no file '{path}'")
    with reading(path):
        if path.stat().st_size > _LARGEST:
            raise InputError(f"it is larger than {_LARGEST // 1_000_000} MB", way_out="cut it")
        raw = path.read_bytes()
        text = _split(raw)
        mapping = _usual(text.names) if columns is None else dict(columns)
        if "time" not in mapping:
            raise InputError("which column is the time?", way_out="name it, as in time = 't [s]'")
        series = {target: _column(text, target, name) for target, name in mapping.items()}
        if y_axis == "down":
            series = {name: -v if name.endswith("_y") else v for name, v in series.items()}
            pivot = None if pivot is None else (pivot[0], -pivot[1])
        if _RATE in series:
            if "angle_1" in series:
                raise InputError(f"give angle_1 or {_RATE}, not both")
            series["angle_1"] = _integrated(series["time"], series.pop(_RATE))
        _place_angles(series, pivot, angle_from)
        for ball in (1, 2):
            if angle_sigma is not None and f"angle_{ball}" in series:
                sigma = checked_number("angle_sigma", angle_sigma, POSITIVE, "rad")
                series.setdefault(f"angle_sigma_{ball}", np.full(len(series["time"]), sigma))
        attributes: dict[str, Any] = {
            "source": path.name,
            "source_sha256": hashlib.sha256(raw).hexdigest(),
            "imported": "; ".join(f"{target} = {name}" for target, name in mapping.items()),
        }
        if length is not None:
            attributes["length"] = checked_number("length", length, POSITIVE, "m")
        if radius is not None:
            attributes["radius"] = checked_number("radius", radius, NON_NEGATIVE, "m")
        return track_table(series, attributes)


def _split(raw: bytes) -> _Text:
    """Return the cells of a text table below its line of names."""
    if not raw.strip():
        raise InputError("it is empty")
    for encoding in ("utf-8-sig", "utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "cp1252"):
        try:
            lines = raw.decode(encoding).splitlines()
            break
        except UnicodeDecodeError:
            continue
    else:
        raise InputError("it is not a text file; save it as UTF-8 text")
    if "\0" in lines[0]:
        raise InputError("it is not a text file; save it as UTF-8 text")
    for delimiter in ("\t", ";", ",", None):
        rows = _rows(lines, delimiter)
        body = next((i for i, row in enumerate(rows) if _is_numbers(row, delimiter)), None)
        if body is not None:
            break
    else:
        raise InputError("it has no rows of numbers below a line of column names")
    width = len(rows[body])
    while body > 0 and _is_sparse(rows[body - 1], width, delimiter):
        body -= 1
    named = [row for row in rows[:body] if len(row) == width and any(row)]
    if not named:
        raise InputError(
            f"it has no names above its {width} columns: add a header line such as 't [s]'"
        )
    names = [name.strip().lstrip("#%").strip().strip('"') for name in named[-1]]
    numbers = [row for row in rows[body:] if any(row)]
    for i, row in enumerate(numbers):
        if len(row) != width:
            raise InputError(f"row {i + 1} has {len(row)} cells, but there are {width} names")
    return _Text(names, [list(cells) for cells in zip(*numbers, strict=True)], delimiter != ",")


def _rows(lines: list[str], delimiter: str | None) -> list[list[str]]:
    """Return the cells of every line."""
    if delimiter is None:
        return [line.split() for line in lines]
    return [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]


def _is_numbers(row: list[str], delimiter: str | None) -> bool:
    """Return whether a row holds at least two numbers and nothing but numbers and empty cells."""
    known = [_number(cell, delimiter != ",") for cell in row if cell]
    return len(known) >= 2 and None not in known


def _is_sparse(row: list[str], width: int, delimiter: str | None) -> bool:
    """Return whether a row above the numbers is one of them, with all cells empty but one."""
    known = [_number(cell, delimiter != ",") for cell in row if cell]
    return len(row) == width and len(known) == 1 and known[0] is not None


def _number(cell: str, decimal_comma: bool) -> float | None:
    """Return a cell's number, None if it holds something else."""
    plain = cell.strip('"').replace(",", ".") if decimal_comma else cell.strip('"')
    try:
        return float(plain) if plain else float("nan")
    except ValueError:
        return float("nan") if plain.lower() in ("-", "na", "n/a", "none", "null") else None


def _name_and_unit(name: str) -> tuple[str, str]:
    """Return a column's name and its unit, which may be empty."""
    match = _WITH_UNIT.fullmatch(name)
    if match is None:
        return name.strip(), ""
    unit = match["square"] if match["square"] is not None else match["round"]
    return match["name"].strip(), unit.strip()


def _usual(names: list[str]) -> dict[str, str]:
    """Return the columns that are called as usual."""
    plain = {_name_and_unit(name)[0].lower(): name for name in reversed(names)}
    mapping = {
        target: next(plain[word] for word in words if word in plain)
        for target, words in _USUAL.items()
        if any(word in plain for word in words)
    }
    if "angle_1" in mapping:
        mapping = {k: v for k, v in mapping.items() if k in ("time", "angle_1")}
    if "time" not in mapping or len(mapping) < 2:
        raise InputError(f"name its columns, as in time = 't [s]'; it has {', '.join(names)}")
    return mapping


def _column(text: _Text, target: str, column: str) -> Floats:
    """Return a column of the file in SI units."""
    if target not in (*TARGETS, _RATE):
        known = [*TARGETS, _RATE]
        raise InputError(f"a track table has no column '{target}': {suggest(target, known)}")
    index, unit = _locate(text.names, column)
    quantity = QUANTITIES["angular_velocity" if target == _RATE else target]
    if not unit:
        raise InputError(
            f"the unit of column '{column}' is missing; write it in brackets, as in "
            f"{target} = '{column} [{quantity.unit}]'"
        )
    try:
        factor = to_si(target, f"1 {unit}", quantity.unit)
    except InputError:
        raise InputError(
            f"column '{column}' is in [{unit}], which is not a unit of {target} [{quantity.unit}]"
        ) from None
    numbers = []
    for row, cell in enumerate(text.columns[index]):
        number = _number(cell, text.decimal_comma)
        if number is None:
            raise InputError(f"row {row + 1} of column '{column}' holds {cell!r}")
        numbers.append(number)
    values: Floats = factor * np.array(numbers)
    return values


def _locate(names: list[str], column: str) -> tuple[int, str]:
    """Return the place and the unit of the column that `column` means, with its unit or without."""
    name, unit = _name_and_unit(column)
    matches = [i for i, each in enumerate(names) if each == column]
    if not matches:
        matches = [i for i, each in enumerate(names) if each == name]
    if not matches:
        matches = [i for i, each in enumerate(names) if _name_and_unit(each)[0] == name]
    if not matches:
        known = ", ".join(names)
        raise InputError(f"it has no column '{name}'; it has {known}")
    if len(matches) > 1:
        raise InputError(f"it has {len(matches)} columns '{name}': rename them")
    own = _name_and_unit(names[matches[0]])[1]
    if unit and own and unit != own:
        raise InputError(f"column '{name}' is in [{own}] itself, not in [{unit}]")
    return matches[0], unit or own


def _place_angles(
    columns: dict[str, Floats], pivot: Sequence[float] | None, angle_from: str
) -> None:
    """Put the origin at the mean pivot and add the angles that positions tell."""
    for ball in (1, 2):
        if f"angle_{ball}" in columns and angle_from == "right":
            columns[f"angle_{ball}"] = columns[f"angle_{ball}"] + 0.5 * np.pi
    placed = [b for b in (1, 2) if f"ball_{b}_x" in columns and f"ball_{b}_y" in columns]
    for ball in (1, 2):
        half = {f"ball_{ball}_x", f"ball_{ball}_y"} & columns.keys()
        if len(half) == 1:
            raise InputError(f"{half.pop()} needs its other coordinate too")
    if pivot is not None:
        if len(pivot) != 2:
            raise InputError("must be two numbers x, y [m]", parameter="pivot", value=pivot)
        if "pivot_x" in columns or "pivot_y" in columns:
            raise InputError("give the pivot either as numbers or as columns, not both")
        columns["pivot_x"] = np.full(len(columns["time"]), float(pivot[0]))
        columns["pivot_y"] = np.full(len(columns["time"]), float(pivot[1]))
    if placed and not {"pivot_x", "pivot_y"} <= columns.keys():
        if any(f"angle_{b}" not in columns for b in placed):
            raise InputError(
                "angles from positions need the pivot: give pivot = (x, y) in m, or its "
                "columns pivot_x and pivot_y"
            )
        return
    for axis in ("x", "y"):
        if f"pivot_{axis}" in columns:
            origin = float(np.nanmean(columns[f"pivot_{axis}"]))
            for name in (f"pivot_{axis}", *(f"ball_{b}_{axis}" for b in placed)):
                columns[name] = columns[name] - origin
    for ball in placed:
        if f"angle_{ball}" not in columns:
            x = columns[f"ball_{ball}_x"] - columns["pivot_x"]
            y = columns[f"ball_{ball}_y"] - columns["pivot_y"]
            columns[f"angle_{ball}"] = _unwrapped(np.arctan2(x, -y))


def _integrated(time: Floats, rate: Floats) -> Floats:
    """Return the angle whose rate a gyroscope measured, swinging about zero.

    The gyroscope's bias and the unknown first angle are a straight line under the swing: that
    through the middles of its turning points is taken off.
    """
    from scipy.interpolate import CubicSpline

    from latolato.experiment.fits.swings import crossings

    known = np.isfinite(rate) & np.isfinite(time)
    if known.sum() < 8 or np.any(np.diff(time[known]) <= 0.0):
        raise InputError(f"{_RATE} needs at least 8 numbers at increasing times")
    spline = CubicSpline(time[known], rate[known]).antiderivative()
    turns = crossings(time[known], rate[known] - np.median(rate[known]))
    if len(turns) < 6:
        raise InputError(
            f"an angle from {_RATE} needs a swing with at least 6 turning points",
            value=len(turns),
        )
    tops = spline(turns)
    middles = 0.25 * (tops[:-2] + 2.0 * tops[1:-1] + tops[2:])
    line = np.polyfit(turns[1:-1], middles, 1)
    angle: Floats = np.where(known, spline(time) - np.polyval(line, time), np.nan)
    return angle


def _unwrapped(angle: Floats) -> Floats:
    """Return an angle without jumps of a turn, also across samples without a number."""
    out = angle.copy()
    known = np.isfinite(angle)
    out[known] = np.unwrap(angle[known])
    return out
