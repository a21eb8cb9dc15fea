"""The results of an analysis, as texts and as plain values."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from latolato.core.errors import as_read
from latolato.core.language import local, spoken, tr

if TYPE_CHECKING:
    import xarray as xr

# Arrays up to these sizes are shown whole, as text and as JSON.
_FEW, _MANY = 8, 1000


def summarise(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the results of an analysis as JSON.

    Complex variables are split as in files; NaN is None and infinities are texts. Of more than
    1000 values there are the least and the largest only.
    """
    from latolato.io.files import without_complex

    plain = without_complex(dataset)
    variables: dict[str, Any] = {}
    for name, variable in {**plain.coords, **plain.data_vars}.items():
        about: dict[str, Any] = {
            "units": variable.attrs.get("units", "1"),
            "dims": dict(zip(map(str, variable.dims), variable.shape, strict=True)),
        }
        if variable.size <= _MANY:
            about["values"] = _plain(variable.values)
        elif variable.dtype.kind in "iuf":
            about["range"] = _plain(list(_range(variable.values)))
        variables[str(name)] = about
    attributes = {str(key): _plain(value) for key, value in dataset.attrs.items()}
    return {"analysis": dataset.attrs["analysis"], "variables": variables, "attributes": attributes}


def as_lines(dataset: xr.Dataset) -> dict[str, str]:
    """Return the results of an analysis as texts by name."""
    drive = f", drive {dataset.attrs['drive']}" if "drive" in dataset.attrs else ""
    lines = {"analysis": f"{dataset.attrs['analysis']} of {dataset.attrs.get('system', '')}{drive}"}
    if "status" in dataset:
        lines["status"] = ""
    for name, variable in {**dataset.coords, **dataset.data_vars}.items():
        # Numbers of rows and names of balls need no line of their own.
        if name not in dataset.dims or variable.dtype.kind == "f":
            lines[str(name)] = _text_of(variable)
    if "message" in dataset.attrs:
        lines["message"] = str(dataset.attrs["message"])
    return lines


def _text_of(variable: xr.DataArray) -> str:
    """Return one variable in a line."""
    import numpy as np

    values, unit = variable.values, str(variable.attrs.get("units", "1"))
    if str(variable.attrs.get("long_name")).startswith("whether ") and values.dtype.kind in "bif":
        # Numbers answer such a question for programs only.
        values = np.select([values == 1, values == 0], ["yes", "no"], "unknown")
    tail = "" if unit == "1" else f" {unit}"
    if values.size == 0:
        return tr("none")
    if values.dtype.kind in "OUS" and values.size > _FEW:
        names, counts = np.unique(values.astype(str), return_counts=True)
        return ", ".join(f"{n} {spoken(name)}" for name, n in zip(names, counts, strict=True))
    if values.dtype.kind == "f" and np.isnan(values).all() and values.ndim == 0:
        return tr("none")
    if values.ndim == 0 or (values.size <= _FEW and values.ndim == 1):
        return ", ".join(_number(value) for value in values.ravel().tolist()) + tail
    count = " \N{MULTIPLICATION SIGN} ".join(map(str, values.shape))
    many = tr("{count} values", count=count)
    if values.dtype.kind in "OUS":
        return f"{', '.join(map(spoken, values.ravel().tolist()))} ({many})"
    lost = int(np.isnan(values).sum())
    if lost == values.size:
        return f"{tr('none')} ({many})"
    if lost:
        many += ", " + tr("{count} without value", count=lost)
    is_complex = values.dtype.kind == "c"
    low, high = map(_number, _range(np.abs(values) if is_complex else values))
    ends = tr("moduli {low} to {high}" if is_complex else "{low} to {high}", low=low, high=high)
    if low == high and not is_complex:
        ends = low
    return f"{ends}{tail} ({many})"


def _range(values: Any) -> tuple[float, float]:
    """Return the least and the largest value that is no NaN; NaN if there is none."""
    import numpy as np

    known = values[~np.isnan(values)]
    return (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)


def _number(value: Any) -> str:
    """Return one value as text."""
    if isinstance(value, complex):
        real, imaginary = as_read(f"{value.real:.6g}"), as_read(f"{abs(value.imag):.6g}")
        sign = "\N{MINUS SIGN}" if value.imag < 0.0 else "+"
        return local(f"{real} {sign} {imaginary} i" if value.imag else real)
    if isinstance(value, float):
        if math.isnan(value):
            return tr("no value")
        return local(as_read(f"{value:.6g}")).replace("inf", "\N{INFINITY}")
    return spoken(str(value))


def _plain(value: Any) -> Any:
    """Return a value as JSON knows it."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value
