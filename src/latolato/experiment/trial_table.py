"""The trial table: one row for each trial of an experiment, with its class as in sweeps."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import NOT_GIVEN, InputError, reading
from latolato.core.quantities import QUANTITIES, Quantity
from latolato.core.registry import checked_choice, suggest
from latolato.core.rules import broken_rule
from latolato.experiment.trial_statistics import class_of, is_borderline, sets_of
from latolato.physics.pendulum import GRAVITY

if TYPE_CHECKING:
    import xarray as xr

    from latolato.io.tables.source import SourceColumn

SUFFIXES = (".csv", ".nc")
# By the number that sweeps give them.
CLASSES = ("none", "weak", "strong")
_KIND = "trials"
TEXTS = {
    "set": "set of trials with the same driving amplitude",
    "source": "file from which the trial comes",
    "class": "class of motion: none, weak (settled at 45 deg) or strong (90 deg at any time)",
    "set_by": "how the set was decided: folder, amplitude or given",
    "note": "remarks about the trial",
}
COUNTS = {
    "borderline": "1 where an angle is within 3 standard deviations of a limit of its class",
    "swings": "swings in the last part",
    "balls": "number of balls",
}
COLUMNS = (
    "set", "source", "drive_amplitude", "drive_amplitude_sigma", "drive_frequency",
    "drive_frequency_sigma", "frequency_ratio", "largest_angle", "largest_angle_sigma",
    "largest_angle_after_transient", "largest_angle_after_transient_sigma", "class", "borderline",
    "swings", "balls", "length", "set_by", "note",
)  # fmt: skip
# The unit of each column of numbers, None for texts.
COLUMN_UNITS = {
    name: None if name in TEXTS else QUANTITIES[name].unit if name in QUANTITIES else "1"
    for name in COLUMNS
}
# Columns that had other names when earlier tables were written.
_FORMER = {"stabilised_angle": "largest_angle_after_transient"}
# Beyond these, numbers without a unit seem to be in the second one.
_LARGEST = (
    ("drive_amplitude", "m", 1.0, "mm"),
    ("length", "m", 10.0, "cm"),
    ("largest_angle", "rad", 6.3, "deg"),
    ("largest_angle_after_transient", "rad", 6.3, "deg"),
)
_SMALLEST_RATIO = 0.5
# Ratios differ by less than this if only the natural frequency was measured instead of computed.
_SAME_RATIO = 0.2


def trial_table(
    columns: Mapping[str, Any], attributes: Mapping[str, Any] | None = None
) -> xr.Dataset:
    """Return a trial table made of columns.

    Parameters
    ----------
    columns : mapping of str to array_like, shape (trial,)
        Named as in `COLUMNS`, in SI units. Required are `drive_amplitude`, `drive_frequency`
        or `frequency_ratio`, and `class` or both angles. Columns that follow from others are
        computed.
    attributes : mapping, optional
        ``gravity`` [m/s^2] and other numbers and texts.

    Returns
    -------
    xarray.Dataset
        On the dimension ``trial``, with every column of `COLUMNS`.

    Raises
    ------
    InputError
        For unknown, missing and unequal columns, unknown classes, and amplitudes, frequencies and
        lengths that are not positive and finite.
    """
    import xarray as xr

    for name in columns:
        if name not in COLUMNS:
            raise InputError(
                f"a trial table has no column '{name}'", way_out=suggest(name, [*COLUMNS])
            )
    arrays = {name: _values(name, values) for name, values in columns.items()}
    if (
        "drive_amplitude" not in arrays
        or not {"drive_frequency", "frequency_ratio"} & arrays.keys()
    ):
        raise broken_rule("trial_columns", value=", ".join(columns) or NOT_GIVEN)
    count = len(arrays["drive_amplitude"])
    if count == 0:
        raise InputError("a trial table needs rows")
    for name, values in arrays.items():
        if values.shape != (count,):
            raise InputError(f"column '{name}' must have {count} rows", value=values.shape)
    for name in ("drive_amplitude", "drive_frequency", "frequency_ratio", "length"):
        values = arrays.get(name, np.ones(count))
        is_good = (values > 0.0) & np.isfinite(values)
        if name == "length":  # may be unknown
            is_good |= np.isnan(values)
        bad = np.flatnonzero(~is_good)
        if bad.size:
            raise broken_rule(
                "positive_in_row",
                {"row": bad[0] + 1},
                parameter=name,
                value=float(values[bad[0]]),
            )
    attributes = {"gravity": GRAVITY, **(attributes or {})}
    gravity = float(attributes["gravity"])
    if not 0.0 < gravity < math.inf:
        raise broken_rule("positive", parameter="gravity", value=gravity)
    for name in COLUMNS:
        arrays.setdefault(name, np.full(count, "" if name in TEXTS else np.nan))
    natural = np.sqrt(gravity / arrays["length"])
    if "frequency_ratio" not in columns:
        arrays["frequency_ratio"] = arrays["drive_frequency"] / natural
    if "drive_frequency" not in columns:
        arrays["drive_frequency"] = arrays["frequency_ratio"] * natural
    largest, settled = arrays["largest_angle"], arrays["largest_angle_after_transient"]
    sigmas = arrays["largest_angle_sigma"], arrays["largest_angle_after_transient_sigma"]
    if "class" not in columns:
        if not (np.isfinite(largest) & np.isfinite(settled)).all():
            raise broken_rule("trial_extremes")
        arrays["class"] = np.array([CLASSES[i] for i in class_of(largest, settled)])
    if "borderline" not in columns:
        arrays["borderline"] = is_borderline(largest, sigmas[0], settled, sigmas[1])
    if "set" not in columns:
        sets = sets_of(arrays["drive_amplitude"], arrays["drive_amplitude_sigma"])
        arrays |= {"set": np.array(sets), "set_by": np.full(count, "amplitude")}
    elif "set_by" not in columns:
        arrays["set_by"] = np.full(count, "given")
    for name in COUNTS:
        # A count that is not known is 0, also in a column that knows others.
        arrays[name] = np.nan_to_num(arrays[name]).astype(np.int64)
    variables = {name: ("trial", arrays[name], about(name)) for name in COLUMNS}
    return xr.Dataset(
        variables,
        coords={"trial": ("trial", np.arange(1, count + 1), about("trial"))},
        attrs={"table": _KIND, **attributes},
    )


def about(name: str) -> dict[str, str]:
    """Return the attributes of a column's variable."""
    if name in QUANTITIES:
        return QUANTITIES[name].attributes
    words = {**TEXTS, **COUNTS, "trial": "number of the trial"}[name]
    return Quantity("1", "", words).attributes


def checked_trials(trials: Any) -> xr.Dataset:
    """Return a trial table, or raise InputError if it is not one."""
    import xarray as xr

    if not isinstance(trials, xr.Dataset):
        raise InputError(
            "must be a trial table",
            parameter="trials",
            value=type(trials).__name__,
            way_out="read_trials",
        )
    if trials.attrs.get("table") != _KIND:
        raise InputError("the dataset is not a trial table: make one with collect_trials")
    return trials


def write_trials(trials: xr.Dataset, path: str | Path) -> Path:
    """Write a trial table as CSV or NetCDF by its suffix and return the path.

    Raises
    ------
    InputError
        If it is not a trial table or the suffix is unknown.
    OSError
        If the file cannot be written.
    """
    from latolato.io.files import save_table

    checked_trials(trials)
    columns = {
        name: ([_cell(value) for value in trials[name].values.tolist()], trials[name].attrs)
        for name in COLUMNS
    }
    return save_table(trials, columns, path, SUFFIXES, "the name of a trial table")


def read_trials(path: str | Path, *, decimal: str | None = None) -> xr.Dataset:
    """Return the trial table in a file.

    Any table that `latolato.io.tables.source.read_source` reads, with columns named as in
    `COLUMNS`, or NetCDF. Cells may carry units (``12 mm``, ``95 deg``), or names
    (``drive_amplitude [mm]``). Columns that do not belong to a trial table are ignored.

    Parameters
    ----------
    path : str or Path
        The file.
    decimal : {".", ","}, optional
        The decimal sign, where the file leaves it open.

    Raises
    ------
    InputError
        For files without a table, missing columns, cells that are not numbers (with trial and
        line), amplitudes and frequencies without a unit that look like mm and Hz, and anything
        `trial_table` refuses.
    OSError
        If the file cannot be read.
    """
    from latolato.io.column_files import attribute_of
    from latolato.io.files import load
    from latolato.io.tables.source import read_source

    path = Path(path)
    if path.suffix.lower() == ".nc":
        with reading(path, gives_values=True):
            return checked_trials(load(path))
    source = read_source(path, decimal=decimal)
    with reading(path, gives_values=True):
        section = source.section()
        header = dict(map(attribute_of, source.comments))
        chosen: dict[str, SourceColumn] = {}
        for column in section.columns:
            name = "_".join(column.name.lower().split())
            if name in (*COLUMNS, *_FORMER) and column.kind != "empty":
                if name in chosen:
                    raise InputError(
                        f"it has 2 columns '{name}': {chosen[name].position} and {column.position}",
                        way_out="rename or remove one",
                    )
                chosen[name] = column
        measured = [name for name in chosen if COLUMN_UNITS.get(name) is not None]
        plain = section.quantities([chosen[name] for name in measured], decimal=decimal)
        numbers = dict(zip(measured, plain, strict=True))
        cells = {
            (name, column.unit.removeprefix("1")): numbers.get(name) or section.texts(column)
            for name, column in chosen.items()
        }
        lines = section.lines.tolist()
        trials = trials_of_cells(
            cells, header, lambda trial: f"trial {trial} in line {lines[trial - 1]}"
        )
        if header.get("table") != _KIND:
            _ask_about_units(trials, cells, lines)
            _refuse_contradiction(trials, lines)
        return trials


def trials_of_cells(
    cells: Mapping[tuple[str, str], list[str]],
    header: Mapping[str, Any],
    place: Callable[[int], str],
) -> xr.Dataset:
    """Return the trial table in the cells below each name and unit.

    `header` holds the attributes of the file, `place` names a trial by its row in messages.
    """
    from latolato.scenario.units import to_si

    for former in _FORMER:
        if any(name == former for name, _ in cells):
            raise broken_rule("renamed_column", {"former": former, "name": _FORMER[former]})
    columns: dict[str, Any] = {}
    for (name, written), values in cells.items():
        texts = [f"{value.strip()} {written}".strip() if value.strip() else "" for value in values]
        if name in COLUMNS and any(texts):
            columns[name] = _read_cells(name, texts, place)
    attributes = {}
    if "gravity" in header:
        attributes["gravity"] = float(to_si("gravity", str(header["gravity"]), "m/s^2"))
    return trial_table(columns, attributes)


def _ask_about_units(
    trials: xr.Dataset, cells: Mapping[tuple[str, str], list[str]], lines: list[int]
) -> None:
    """Refuse amplitudes and frequencies that look like mm and Hz but state no unit."""
    bare = {
        name: np.array([bool(re.fullmatch(r"[-+.\deE]*", value.strip())) for value in values])
        for (name, unit), values in cells.items()
        if not unit
    }
    for name, unit, largest, likely in _LARGEST:
        values = trials[name].values
        above = np.flatnonzero((values > largest) & bare.get(name, np.zeros(len(values), bool)))
        if above.size:
            raise InputError(
                f"{name} has no unit and would be {values[above[0]]:g} {unit} in line "
                f"{lines[above[0]]}",
                way_out=f"if it is in {likely}, call the column '{name} [{likely}]'; if not, "
                f"'[{unit}]'",
            )
    ratio = trials["frequency_ratio"].values
    known = ratio[np.isfinite(ratio)]
    if (
        "drive_frequency" in bare
        and bare["drive_frequency"].all()
        and known.size
        and float(known.max()) < _SMALLEST_RATIO
    ):
        raise InputError(
            f"drive_frequency has no unit, and in rad/s all drives would be slower than half the "
            f"natural frequency (at most {known.max():.3g} of it)",
            way_out="if it is in Hz, call the column 'drive_frequency [Hz]'; if not, '[rad/s]'",
        )


def _refuse_contradiction(trials: xr.Dataset, lines: list[int]) -> None:
    """Raise if frequency, length and frequency ratio of a trial contradict each other."""
    natural = np.sqrt(trials.attrs["gravity"] / trials["length"].values)
    stated = trials["frequency_ratio"].values
    ratio = trials["drive_frequency"].values / natural
    bad = np.flatnonzero(np.abs(ratio / stated - 1.0) > _SAME_RATIO)
    if bad.size:
        raise InputError(
            f"frequency_ratio in line {lines[bad[0]]} contradicts drive_frequency and length, "
            f"which give {ratio[bad[0]]:.4g}",
            value=float(stated[bad[0]]),
            way_out="correct one of them or leave out frequency_ratio",
        )


def is_trial_table(path: str | Path) -> bool:
    """Return whether a file looks like a trial table: its header, or columns of one."""
    from latolato.io.files import load
    from latolato.io.tables.source import read_source

    path = Path(path)
    try:
        if path.suffix.lower() == ".nc":
            return bool(load(path).attrs.get("table") == _KIND)
        if path.suffix.lower() == ".parquet":
            return False
        first = read_source(path).sections[0]
    except (OSError, InputError):
        return False
    return any("_".join(c.name.lower().split()) == "drive_amplitude" for c in first.columns)


def _values(name: str, column: Any) -> Any:
    """Return a column as an array of its kind."""
    values = np.asarray(column)
    if name in TEXTS:
        values = np.array([str(each).strip() for each in values.tolist()])
        if name == "class":
            values = np.char.lower(values)
            for each in values:
                checked_choice("class", str(each), CLASSES)
        return values
    try:
        return values.astype(np.float64)
    except (TypeError, ValueError):
        raise InputError(f"column '{name}' must hold numbers") from None


def _cell(value: Any) -> Any:
    """Return a cell of a CSV: nothing for an unknown number."""
    return "" if isinstance(value, float) and math.isnan(value) else value


def _read_cells(name: str, cells: list[str], place: Callable[[int], str]) -> list[Any]:
    """Return what a column's cells hold: texts, classes, or numbers that may have units."""
    values = []
    for number, cell in enumerate(cells, start=1):
        try:
            values.append(_read_cell(name, cell))
        except InputError as error:
            raise InputError(f"{place(number)}: {error}") from None
    return values


def _read_cell(name: str, cell: str) -> str | float:
    from latolato.scenario.units import to_si

    unit = COLUMN_UNITS[name]
    if name == "class":
        return checked_choice(name, cell.lower(), CLASSES)
    if unit is None:
        return cell
    return float(to_si(name, cell, unit)) if cell else math.nan
