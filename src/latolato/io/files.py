"""Result files: NetCDF, CSV and Parquet by extension, written whole or not at all."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.atomic import atomic_path, check_folder, checked_path, remove_leftovers
from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES, quantity_of
from latolato.core.versions import FORMAT, check_format
from latolato.io.column_files import Columns, import_pyarrow, read_columns, write_columns
from latolato.io.shown_units import SIZES, name_and_unit, read_texts, shown_texts
from latolato.simulation.record import BALL, BALLS, Record

if TYPE_CHECKING:
    import xarray as xr

SUFFIXES = (".nc", ".csv", ".parquet")
# Complex variables as NetCDF holds them: two variables with this attribute.
_PARTS = ("real", "imag")
_PART = "complex_part"


def check_suffix(path: str | Path, known: tuple[str, ...], what: str) -> str:
    """Return the suffix of a file name in lower case, or raise InputError naming what is known."""
    suffix = Path(path).suffix.lower()
    if suffix not in known:
        raise InputError(f"{what} must end in {', '.join(known)}", value=Path(path).name)
    return suffix


def check_readable(path: Path, known: tuple[str, ...], what: str) -> str:
    """Return the suffix of a file that is there, or raise; see `check_suffix`."""
    suffix = check_suffix(path, known, what)
    if path.is_dir():
        raise IsADirectoryError(f"'{path}' is a folder; name a file in it")
    if not path.is_file():
        raise FileNotFoundError(f"there is no file '{path}'")
    return suffix


def check_target(path: str | Path) -> None:
    """Raise unless `save` can write to `path`: a known suffix, its extra, an existing folder."""
    check_folder(Path(path))
    if check_suffix(path, SUFFIXES, "the name of a result file") == ".parquet":
        import_pyarrow()


def save(dataset: xr.Dataset | Record, path: str | Path) -> Path:
    """Write a dataset as NetCDF, CSV or Parquet by its suffix and return the path.

    NetCDF holds everything, sweeps and analyses too; complex variables become two, ``name_real``
    and ``name_imag``, which `load` joins. CSV and Parquet hold sweeps, one row per point, and runs,
    one row per instant. The variables of a `BallPair` are columns ``angle_right`` and
    ``angle_left``. The columns of a CSV have the units of pages and pictures: a column that is
    not in the unit of the dataset has its unit in its name, ``angle [deg]``, and `load` returns
    the same numbers. The CSV of an analysis without time holds a table for each shape, in SI
    units, for other programs; `load` does not read it. The contacts of a run, if any were
    possible, go to a second file ``<stem>.contacts.csv``, which is put in place first and
    removed when a run without them takes the place of one with them. An interrupted or failed
    call leaves no file; what a killed one left for the same path is removed by the next.

    Parameters
    ----------
    dataset : xarray.Dataset or Record
        A run or a sweep, or for NetCDF any dataset. NetCDF of a record is written without xarray.
    path : str or Path
        A name ending in ``.nc``, ``.csv`` or ``.parquet``; an existing file is replaced.

    Raises
    ------
    InputError
        If `dataset` is no dataset, for an unknown suffix, and for a dataset that fits no table.
        For Parquet, if the extra `parquet` is missing.
    OSError
        If the file cannot be written.
    """
    if not isinstance(dataset, Record):
        import xarray as xr

        if not isinstance(dataset, xr.Dataset):
            raise InputError("save needs a dataset", value=dataset)
        dataset = dataset.assign_attrs(format=FORMAT)
    path = checked_path("path", path)
    check_target(path)
    for each in (path, _contacts_path(path)):
        remove_leftovers(each)
    suffix = path.suffix.lower()
    if suffix == ".nc":
        with atomic_path(path) as unfinished:
            unfinished.write_bytes(_netcdf(dataset))
        return path
    if isinstance(dataset, Record):
        dataset = dataset.to_dataset().assign_attrs(format=FORMAT)

    def write(dataset: xr.Dataset, dimension: str, unfinished: Path) -> None:
        columns = _columns(dataset, dimension)
        if suffix == ".csv":
            columns = _shown(columns)
        write_columns(columns, dataset.attrs, unfinished, suffix)

    if is_sweep(dataset):
        from latolato.sweeps.long_table import as_table

        with atomic_path(path) as first:
            write(as_table(dataset), "point", first)
        return path
    if suffix == ".csv" and "analysis" in dataset.attrs and "time" not in dataset.dims:
        from latolato.io.analysis_tables import to_csv

        with atomic_path(path) as unfinished:
            unfinished.write_text(to_csv(dataset), encoding="utf-8")
        return path
    if "time" not in dataset.dims:
        raise InputError(
            f"{suffix} files hold runs and sweeps", way_out="use .nc for other datasets"
        )
    if _has_contacts(dataset.attrs):
        # The inner one is put in place first: the file that is asked for appears with its contacts.
        with atomic_path(path) as first, atomic_path(_contacts_path(path)) as second:
            write(dataset, "time", first)
            write(dataset, "contact", second)
    else:
        with atomic_path(path) as first:
            write(dataset, "time", first)
        _remove_contacts(_contacts_path(path), suffix)
    return path


def save_table(
    table: xr.Dataset, columns: Columns, path: str | Path, known: tuple[str, ...], what: str
) -> Path:
    """Write a table by the suffix of its name, whole or not at all, and return the path.

    Parameters
    ----------
    table : xarray.Dataset
        What NetCDF holds.
    columns : Columns
        What CSV and Parquet hold, below the attributes of the table; see `write_columns`.
    path, known, what
        The name, its suffixes, and what it is called; see `check_suffix`.
    """
    path = Path(path)
    suffix = check_suffix(path, known, what)
    check_target(path)
    if suffix == ".nc":
        return save(table, path)
    with atomic_path(path) as unfinished:
        write_columns(columns, table.attrs, unfinished, suffix)
    return path


def is_sweep(dataset: xr.Dataset) -> bool:
    """Return whether a dataset is that of a sweep, whole: not a part, nor an analysis of one."""
    from latolato.sweeps.long_table import is_whole

    return "plan" in dataset.attrs and "time" not in dataset.dims and is_whole(dataset)


# Attributes that are tables of their own, as JSON.
_DESCRIPTIONS = {"plan", "scenario", "system_description", "drive_description"}


def load(path: str | Path) -> xr.Dataset:
    """Return the dataset in a file that `save` wrote, or in the store of a sweep.

    A file is read whole; the values in a store are read on use.

    Parameters
    ----------
    path : str or Path
        A name ending in ``.nc``, ``.csv`` or ``.parquet``, or the folder of a store.

    Raises
    ------
    InputError
        For an unknown suffix or a file of something else.
    OSError
        If the file cannot be read.
    """
    path = checked_path("path", path)
    if path.is_dir():
        if not any((path / name).exists() for name in ("zarr.json", ".latolato")):
            raise IsADirectoryError(f"'{path}' is a folder; name a file in it")
        from latolato.sweeps.store import open_store

        return open_store(path)
    if path.suffix == ".zarr" and not path.exists():
        raise FileNotFoundError(f"there is no store '{path}'")
    suffix = check_readable(path, SUFFIXES, "the name of a result file")
    with reading(path):
        dataset = _read_netcdf(path) if suffix == ".nc" else _read_tables(path, suffix)
        check_format(dataset.attrs.pop("format", 1), f"'{path}'")
        for name in _DESCRIPTIONS & dataset.attrs.keys():
            text = dataset.attrs[name]  # nothing for a pivot at rest
            if text and not isinstance(json.loads(text), dict):
                raise TypeError(f"its attribute {name} is not a table")
        return dataset


def _read_tables(path: Path, suffix: str) -> xr.Dataset:
    """Return the sweep in a table, or the run in one or two of them."""
    columns, attributes = _read(path, suffix)
    if "plan" in attributes:
        from latolato.sweeps.long_table import from_table

        return from_table({name: values for name, (values, _) in columns.items()}, attributes)
    contacts: Columns = {}
    if _has_contacts(attributes):
        contacts, _ = _read(_contacts_path(path), suffix)
    return _assembled(columns, contacts, attributes)


def _read(path: Path, suffix: str) -> tuple[Columns, dict[str, Any]]:
    """Return the columns, as numbers or words, and the attributes of a run's or sweep's table."""
    columns, attributes = read_columns(path, suffix)
    if "flag_1" in columns:
        raise InputError(
            f"'{path}' is a track table, not a run", way_out="see `latolato fit --help`"
        )
    if not {"scenario", "plan", "latolato_version"} & attributes.keys():
        raise InputError(f"'{path}' is not a run of latolato: its header is missing")
    typed: Columns = {}
    for head, (values, about) in columns.items():
        name, unit = _name_and_unit(head)
        numbers = read_texts(values, unit) if unit else values
        typed[name] = (np.array(numbers, dtype=_kind(name)), _about(name) | about)
    return typed, attributes


def _shown(columns: Columns) -> Columns:
    """Return columns in the units in which people read them, which are in their names then."""
    shown: Columns = {}
    for name, (values, about) in columns.items():
        unit = quantity_of(_base(name), str(about.get("units", "1"))).shown_unit
        if unit in SIZES:
            shown[f"{name} [{unit}]"] = (shown_texts(values.tolist(), unit), about)
        else:
            shown[name] = (values, about)
    return shown


def _name_and_unit(head: str) -> tuple[str, str]:
    """Return the name of a column and the unit after it, "" without one."""
    name, unit = name_and_unit(head)
    if unit and unit not in SIZES:
        raise InputError(f"column '{head}' has an unknown unit", way_out=f"use {', '.join(SIZES)}")
    return name, unit


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Refuse a file on whose content a reader fails.

    HDF5, Arrow and FFmpeg have dozens of errors for damaged files, of many types.
    """
    try:
        yield
    except (InputError, OSError, MemoryError):
        raise
    except Exception as error:
        raise InputError(
            f"'{path}' is damaged or was not written by latolato ({error})",
            way_out="compute it again or take a copy",
        ) from error


def _has_contacts(attributes: Mapping[Any, Any]) -> bool:
    """Return whether a run may have contacts: of balls, or of a string that becomes taut."""
    meets = attributes.get("contact", "none") != "none"
    return meets or attributes.get("suspension") == "string"


def _contacts_path(path: Path) -> Path:
    """Return the name of the second file, which holds the contacts."""
    return path.with_name(f"{path.stem}.contacts{path.suffix}")


def _remove_contacts(path: Path, suffix: str) -> None:
    """Remove the contacts of an earlier run; a file of anything else stays."""
    if path.is_file():
        with suppress(OSError, ValueError):
            columns, _ = _read(path, suffix)
            if "contact_time" in columns:
                path.unlink()


def _netcdf(dataset: xr.Dataset | Record) -> bytes:
    """Return everything as NetCDF-4, made in memory: HDF5 crashes when a disk is full."""
    if isinstance(dataset, Record):
        return _netcdf_of(dataset)
    from latolato.sweeps.statuses import with_codes

    # Chunks and codecs of a store would be meant for Zarr.
    plain = with_codes(without_complex(dataset.drop_encoding()))
    return bytes(plain.to_netcdf(engine="h5netcdf"))


def _netcdf_of(record: Record) -> bytes:
    """Return the same as `_netcdf` of the record's dataset, without importing xarray."""
    import h5netcdf
    import h5py

    memory = io.BytesIO()
    with h5netcdf.File(memory, "w") as file:
        for name, dimensions, values, attrs in record.described():
            for dimension, size in zip(dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.dimensions[dimension] = size
            if values.dtype.kind == "U":
                kind, fill, values = h5py.string_dtype(), None, values.astype(object)
            else:
                kind, fill = values.dtype, np.nan if values.dtype.kind == "f" else None
            made = file.create_variable(name, dimensions, kind, values, fillvalue=fill)
            made.attrs.update(attrs if fill is None else {"_FillValue": fill, **attrs})
        file.attrs.update({**record.attrs, "format": FORMAT})
        if "parameter_unit" in record:  # the name under which xarray lists further coordinates
            file.attrs["coordinates"] = "parameter_unit"
    return memory.getvalue()


def _read_netcdf(path: Path) -> xr.Dataset:
    """Return the dataset with attributes as plain Python values."""
    import xarray as xr

    from latolato.sweeps.statuses import with_words

    try:
        dataset = xr.load_dataset(path, engine="h5netcdf")
    except OSError as error:
        raise InputError(f"'{path}' is not a NetCDF-4 file: {error}") from None
    dataset.attrs = {k: v.tolist() if hasattr(v, "tolist") else v for k, v in dataset.attrs.items()}
    return with_words(_with_complex(dataset))


def without_complex(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with ``name_real`` and ``name_imag`` in place of complex variables."""
    import xarray as xr

    if all(variable.dtype.kind != "c" for variable in dataset.variables.values()):
        return dataset
    variables: dict[Any, Any] = {}
    for name, variable in dataset.data_vars.items():
        if variable.dtype.kind != "c":
            variables[name] = variable
            continue
        for part in _PARTS:
            about = {**variable.attrs, _PART: part}
            variables[f"{name}_{part}"] = (variable.dims, getattr(variable.values, part), about)
    return xr.Dataset(variables, coords=dataset.coords, attrs=dataset.attrs)


def _with_complex(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with the variables that `without_complex` parted joined again."""
    import xarray as xr

    if not any(_PART in variable.attrs for variable in dataset.data_vars.values()):
        return dataset
    variables: dict[Any, Any] = {}
    for name, variable in dataset.data_vars.items():
        part = variable.attrs.get(_PART)
        if part is None:
            variables[name] = variable
        elif part == _PARTS[0]:
            base = str(name).removesuffix(f"_{part}")
            values = variable.values.astype(complex)
            values.imag = dataset[f"{base}_{_PARTS[1]}"].values
            about = {key: value for key, value in variable.attrs.items() if key != _PART}
            variables[base] = (variable.dims, values, about)
    return xr.Dataset(variables, coords=dataset.coords, attrs=dataset.attrs)


def _columns(dataset: xr.Dataset, dimension: str) -> Columns:
    """Return the variables along a dimension as columns, one a ball where there are two."""
    result: Columns = {}
    names = [name for name in dataset.variables if dimension in dataset.variables[name].dims]
    for name in sorted(names, key=lambda name: name != dimension):  # the dimension's own first
        variable = dataset.variables[name]
        if variable.dims == (dimension,):
            result[str(name)] = (variable.values, dict(variable.attrs))
        elif variable.dims != ("ball", dimension):
            raise InputError(
                f"{name} over {', '.join(map(str, variable.dims))} fits no table",
                way_out="use .nc",
            )
        else:
            for i, ball in enumerate(dataset["ball"].values):
                result[f"{name}_{ball}"] = (variable.isel(ball=i).values, dict(variable.attrs))
    return result


def _assembled(columns: Columns, contacts: Columns, attributes: dict[str, Any]) -> xr.Dataset:
    """Return the dataset that was taken apart by `_columns`."""
    import xarray as xr

    two = f"angle_{BALLS[0]}" in columns
    variables: dict[str, Any] = {}
    for dimension, part in (("time", columns), ("contact", contacts or _no_contacts(two))):
        for name, (values, about) in part.items():
            base, _, ball = name.rpartition("_")
            if not (two and ball in BALLS):
                variables[name] = ((dimension,), values, about)
            elif ball == BALLS[0]:
                both = np.stack([part[f"{base}_{each}"][0] for each in BALLS])
                variables[base] = (("ball", dimension), both, about)
    dataset = xr.Dataset(variables, attrs=attributes).set_coords("time")
    if not two:
        return dataset
    return dataset.assign_coords(ball=("ball", list(BALLS), BALL.attributes))


def _no_contacts(two: bool) -> Columns:
    """Return the empty contact table of a system without walls."""
    names = ["contact_time", "contact_kind"]
    for name in ("angular_velocity_before", "angular_velocity_after"):
        names += [f"{name}_{ball}" for ball in BALLS] if two else [name]
    return {name: (np.array([], dtype=_kind(name)), _about(name)) for name in names}


def _about(name: str) -> dict[str, str]:
    """Return the attributes of a column's variable, as far as they are known."""
    name = _base(name)
    return QUANTITIES[name].attributes if name in QUANTITIES else {}


def _base(name: str) -> str:
    """Return the name of the variable to which a column belongs."""
    for ball in BALLS:
        name = name.removesuffix(f"_{ball}")
    return name


def _kind(name: str) -> type:
    """Return the type of a column's values."""
    if name in ("contact_kind", "direction", "status"):
        return str
    return np.int8 if _base(name) in ("slack", "contact_ball") else float
