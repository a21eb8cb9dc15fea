"""Maps that were computed before and that the command line named: Zarr stores and NetCDF files."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.blocks import pack
from latolato.app.forms import quantity_of, units_of
from latolato.app.given import TooLargeError
from latolato.app.map_job import about_variable, constants_of, sides_of
from latolato.app.map_request import MOST_CELLS
from latolato.core.errors import InputError
from latolato.core.registry import suggest
from latolato.figures.sides import spaced
from latolato.numerics.records import STATUS_NAMES

if TYPE_CHECKING:
    import xarray as xr

    from latolato.figures.map import Drawing

_BALLS = ("right", "left")


def named(paths: Sequence[Path]) -> dict[str, Path]:
    """Return maps by the name under which pages ask for them.

    Raises
    ------
    FileNotFoundError, InputError
        If one of them is no sweep.
    """
    from latolato.io.plans import plan_from_store

    result: dict[str, Path] = {}
    for path in paths:
        if not path.exists():
            raise FileNotFoundError(f"there is no file or store '{path}'")
        plan_from_store(path)
        name, number = path.name, 2
        while name in result:
            name, number = f"{path.name} ({number})", number + 1
        result[name] = path.resolve()
    return result


def opened(path: Path) -> xr.Dataset:
    """Return the dataset of a stored map; unfinished ones open too."""
    from latolato.io.files import load

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return load(path)


def frames_of(path: Path, request: Mapping[str, Any]) -> list[bytes]:
    """Return the frames of a stored map: what it is of, all its cells, and that it is done.

    Parameters
    ----------
    request : mapping
        `observable`, and `select`, the number of the value to take of further dimensions.

    Raises
    ------
    InputError
        If there is nothing that a map can show.
    """
    grid = opened(path)
    variable = request.get("observable")
    names = [str(n) for n in grid.data_vars if len(_dims(grid, str(n))) >= 2]
    if not names:
        raise InputError(f"{path.name} varies less than two parameters: there is no map to show")
    if variable not in names:
        if variable is not None and request.get("strict"):
            raise InputError(f"unknown observable '{variable}': {suggest(str(variable), names)}")
        variable = names[0]
    _, rest = _selected(grid, variable, request.get("select") or {})
    drawing = drawing_of(grid, variable, request.get("select") or {})
    y, x = drawing.sides
    x, y = spaced(x, request.get("xlog")), spaced(y, request.get("ylog"))
    about = {}
    for name, side in (("x", x), ("y", y)):
        given = side.attributes
        unit = str(given.get("units", "1"))
        about[name] = {
            "name": side.name,
            "label": str(given.get("long_name", side.name)),
            "symbol": str(given.get("symbol", "")),
            "unit": unit,
            "units": units_of(quantity_of(side.name, unit)),
            "log": side.is_log,
        }
    attributes = drawing.data.attrs
    begin = pack(
        {
            "kind": "begin",
            **about,
            "observable": variable,
            "statuses": [name.replace("_", " ") for name in STATUS_NAMES],
            "variables": [
                about_variable(
                    variable,
                    {
                        "long_name": attributes.get("long_name", variable),
                        "symbol": attributes.get("symbol", ""),
                        "units": attributes.get("units", "1"),
                    },
                    None,
                )
            ],
            "names": names,
            "select": rest,
            "points": drawing.values.size,
            "missing": int(np.sum(drawing.status < 0)),
            "description": _description(grid, drawing),
            "title": grid.attrs.get("title", path.name),
            "python": f'import latolato as ll\n\ngrid = ll.load("{path.name}")',
            "command": f"latolato plot {path.name} --variable {variable}",
            **constants_of(grid.attrs),
        },
        sides_of(x, y),
    )
    cells = pack(
        {"kind": "cells", "points": drawing.values.size, "seconds": 0.0, "rate": 0.0, "reason": ""},
        {
            "cell": np.arange(drawing.values.size, dtype=np.int32),
            "stride": np.ones(drawing.values.size, dtype=np.uint8),
            "status": drawing.status.astype(np.int32).ravel(),
            "values": drawing.values.reshape(1, -1).astype(np.float32),
        },
    )
    done = pack({"kind": "done", "points": drawing.values.size, "seconds": 0.0, "rate": 0.0}, {})
    return [begin, cells, done]


def _description(grid: xr.Dataset, drawing: Drawing) -> str:
    """Return what a map is of, symbols as TeX: what does not vary, its points, who computed it."""
    height, width = drawing.values.shape
    missing = int(np.sum(drawing.status < 0))
    told = [*drawing.title, f"{width} by {height} points"]
    if missing:
        told.append(f"{missing} of them not computed")
    version = grid.attrs.get("latolato_version")
    return ", ".join([*told, *([f"computed by latolato {version}"] if version else [])]) + "."


def arguments_at(path: Path, x: tuple[str, float], y: tuple[str, float], select: Any) -> Any:
    """Return the arguments of `simulate` that run the point nearest to these values."""
    from latolato.io.plans import plan_from_store
    from latolato.sweeps.points import arguments_of

    plan = plan_from_store(path)
    index = dict.fromkeys(plan.dims, 0) | _checked(select)
    for name, value in (x, y):
        for axis in plan.axes:
            if name in axis.parameters:
                values = np.array(axis.values[axis.parameters.index(name)])
                index[axis.name] = int(np.argmin(np.abs(values - value)))
                break
        else:
            raise InputError(f"unknown parameter '{name}': {suggest(name, list(plan.varied))}")
    place = tuple(index[dim] for dim in plan.dims)
    if not all(0 <= i < n for i, n in zip(place, plan.shape, strict=True)):
        raise InputError("this point lies outside of the map")
    return arguments_of(plan, int(np.ravel_multi_index(place, plan.shape)))


def _checked(select: Any) -> dict[str, int]:
    """Return which value of further dimensions is taken."""
    if not isinstance(select, Mapping):
        raise InputError("must be an object", parameter="select", value=select)
    for name, value in select.items():
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise InputError(f"select.{name} must be a whole number from 0, got {value!r}")
    return dict(select)


def _dims(grid: xr.Dataset, variable: str) -> list[str]:
    """Return the dimensions of a variable along which parameters vary."""
    inner = ("direction", "ball", "sample", "exponent")
    return [str(d) for d in grid[variable].dims if d not in inner]


def _selected(
    grid: xr.Dataset, variable: str, select: Any
) -> tuple[xr.Dataset, list[dict[str, Any]]]:
    """Return the part of a dataset with two dimensions, and what else may be taken."""
    given = _checked(select)
    own = _dims(grid, variable)
    rest = [str(d) for d in grid[variable].dims if str(d) not in own[-2:]]
    told = []
    for dim in rest:
        index = min(given.get(dim, 0), grid.sizes[dim] - 1)
        labels = grid[dim].values if dim in grid.coords else np.arange(grid.sizes[dim])
        about = grid[dim].attrs if dim in grid.coords else {}
        told.append(
            {
                "dim": dim,
                "index": index,
                "label": str(about.get("long_name", dim)),
                "unit": str(about.get("units", "1")),
                "values": [v if isinstance(v, str) else f"{v:.6g}" for v in labels.tolist()],
            }
        )
        grid = grid.isel({dim: index})
    return grid, told


def drawing_of(grid: xr.Dataset, variable: str, select: Any) -> Drawing:
    """Return the values of a map, sorted, NaN where there is no answer.

    Parameters
    ----------
    select : mapping
        The number of the value to take of each further dimension.
    """
    from latolato.figures.map import Drawing

    if variable not in grid:
        raise InputError(
            f"unknown observable '{variable}': {suggest(variable, list(map(str, grid)))}"
        )
    grid, _ = _selected(grid, variable, select)
    sizes = grid[variable].sizes
    if int(np.prod(list(sizes.values()))) > MOST_CELLS:
        text = " x ".join(str(n) for n in sizes.values())
        raise TooLargeError(f"this map has {text} points, the limit on a page is {MOST_CELLS}")
    return Drawing(grid, variable, log=False, select={})
