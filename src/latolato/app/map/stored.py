"""Maps that were computed before and that the command line named: Zarr stores and NetCDF files."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.answers import Body
from latolato.app.forms import shown_variable, units_of
from latolato.app.jobs import Job
from latolato.app.run_request import TooLargeError, options_of
from latolato.app.worker import Result
from latolato.core.errors import InputError
from latolato.core.language import local, tr
from latolato.core.parameters import law_parameters
from latolato.core.quantities import Quantity, quantity_of
from latolato.core.registry import describe, suggest
from latolato.figures.sides import Side, spaced, values_along
from latolato.numerics.records import STATUS_NAMES
from latolato.physics.contacts import contact_laws
from latolato.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

    from latolato.figures.map import Drawing
    from latolato.sweeps.plan import Plan

    Progress = Any

MOST_CELLS = 500 * 500
_SIDES = ("right", "left")


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


def path_of(known: Mapping[str, Path], name: str) -> Path:
    """Return the file of a stored map; only those that the command line named are opened."""
    if name not in known:
        raise InputError(f"there is no stored map {name!r}: start with latolato app --open MAP")
    return known[name]


def opened(path: Path) -> xr.Dataset:
    """Return the dataset of a stored map; unfinished ones open too."""
    from latolato.io.files import load

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return load(path)


def prepare(known: Mapping[str, Path], body: Mapping[str, Any]) -> Job:
    """Return the job that opens a map.

    A page sends `stored`, the map's name, and may send `observable`, `select`, the number of the
    value to take of further dimensions, and `xlog` and `ylog`.

    Raises
    ------
    InputError
        If no such map was named.
    """
    return Job(compute, Body(body, path=path_of(known, body["stored"])))


def compute(request: Mapping[str, Any], folder: Path, progress: Progress) -> Result:
    """Open a stored map: what it is of, its axes and all its cells.

    Raises
    ------
    InputError
        If there is nothing that a map can show.
    """
    path = request["path"]
    grid = opened(path)
    variable = request.get("observable")
    names = [str(n) for n in grid.data_vars if len(_dims(grid, str(n))) >= 2]
    if not names:
        raise InputError(f"{path.name} varies less than two parameters: there is no map to show")
    if variable not in names:
        variable = names[0]
    taken, rest = _selected(grid, variable, request.get("select"))
    drawing = drawing_of(grid, variable, request)
    y, x = drawing.sides
    attributes = drawing.data.attrs
    quantity = Quantity(
        str(attributes.get("units", "1")),
        str(attributes.get("symbol", "")),
        str(attributes.get("long_name", variable)),
    )
    about = {
        "x": _axis(x),
        "y": _axis(y),
        "observable": variable,
        "statuses": [name.replace("_", " ") for name in STATUS_NAMES],
        "variables": [shown_variable(variable, quantity) | {"name": variable, "ball": None}],
        "title": grid.attrs.get("title", path.name),
        "python": f'import latolato as ll\n\ngrid = ll.load("{path.name}")',
        "command": f"latolato plot {path.name} --variable {variable}",
        **_laws(path, taken, drawing),
    }
    about["stored"] |= {
        "names": names,
        "select": rest,
        "missing": int(np.sum(drawing.status < 0)),
        "description": _description(grid, drawing),
    }
    return about, {
        "x": x.values,
        "y": y.values,
        "x_edges": x.edges,
        "y_edges": y.edges,
        "status": drawing.status.astype(np.int32).ravel(),
        "values": drawing.numbers.ravel(),
    }


def _axis(side: Side) -> dict[str, Any]:
    """Return how an axis is shown."""
    unit = str(side.attributes.get("units", "1"))
    return {
        "name": side.name,
        "label": str(side.attributes.get("long_name", side.name)),
        "symbol": str(side.attributes.get("symbol", "")),
        "unit": unit,
        "units": units_of(quantity_of(side.name, unit)),
        "log": side.is_log,
    }


def _laws(path: Path, taken: xr.Dataset, drawing: Drawing) -> dict[str, Any]:
    """Return the system's parameters that do not vary, and what the points of a map run with."""
    from latolato.io.plans import plan_from_store

    plan = plan_from_store(path)
    fixed = {
        name: float(taken[name])
        for axis in plan.axes
        for name in axis.parameters
        if name in taken.coords and not taken[name].dims
    }
    own = {p.name for p in law_parameters(plan.system, "system")}
    sets, streams = {}, {}
    for which, side in zip(("y", "x"), drawing.sides, strict=True):
        order = np.argsort(values_along(taken, side.dim), kind="stable")
        axis = next((a for a in plan.axes if a.name == side.dim), None)
        sets[which] = {} if axis is None else {
            name: np.array(values)[order].tolist()
            for name, values in zip(axis.parameters, axis.values, strict=True)
        }  # fmt: skip
        streams[which] = (order * _stride(plan, side.dim)).tolist()
    alone = not plan.continuation
    if alone and plan.own_streams:
        assert plan.noise is not None
        first = plan.noise.noise_stream + sum(
            int(np.argmin(np.abs(np.array(axis.values[0]) - fixed[axis.parameters[0]])))
            * _stride(plan, axis.name)
            for axis in plan.axes
            if axis.parameters[0] in fixed
        )
        streams["x"] = [first + each for each in streams["x"]]
    number = {
        name: value
        for name, value in {**taken.attrs, **fixed}.items()
        if name in own and isinstance(value, (int, float, np.number))
    }
    about = {"system", "drive", "contact"} | own
    about |= {p.name for p in law_parameters(plan.drive, "drive")}
    laws = {n: v for n, v in {**taken.attrs, **fixed}.items() if n in about}
    return {
        "parameters": number,
        "laws": laws,
        "has_contact": taken.attrs.get("contact", "none") != "none",
        "stored": {
            "options": _options(plan) if alone else None,
            "reason": "" if alone else (
                f"a point of this map continues from its neighbour along {plan.continuation}: it "
                "cannot run alone"
            ),
            "sets": {**sets, "all": fixed},
            "streams": streams if alone and plan.own_streams else None,
        },
    }  # fmt: skip


def _stride(plan: Plan, dim: str) -> int:
    """Return by how much the number of a point grows along a dimension; 0 along none of these."""
    if dim not in plan.dims:
        return 0
    return int(np.prod(plan.shape[plan.dims.index(dim) + 1 :], dtype=int))


def _options(plan: Plan) -> dict[str, Any]:
    """Return the options of the runs of a plan, as if nothing varied."""
    start: dict[str, Any] = dict(plan.start)
    run: dict[str, Any] = {
        name: getattr(plan, name)
        for name in ("duration", "tolerance", "rest_speed", "contact_limit")
    }
    law = plan.contact
    run["contact"] = law if describe(law) else contact_laws.name_of(law)
    if not plan.system.has_contacts:
        del run["contact"]
    if plan.noise is not None:
        run["noise"] = plan.noise
    if plan.system.angles == 2:
        for name in ("initial_angle", "initial_angular_velocity"):
            run[name] = tuple(start.get(f"{name}_{side}", 0.0) for side in _SIDES)
    else:
        run |= start
    return options_of(Scenario(system=plan.system, drive=plan.drive, run=run))


def _description(grid: xr.Dataset, drawing: Drawing) -> str:
    """A map's caption, symbols as TeX: fixed parameters, points, the version that computed it."""
    height, width = drawing.values.shape
    missing = int(np.sum(drawing.status < 0))
    parts = [*map(local, drawing.title)]
    parts.append(tr("{width} by {height} points", width=width, height=height))
    if missing:
        parts.append(tr("{count} of them not computed", count=missing))
    if version := grid.attrs.get("latolato_version"):
        parts.append(f"{tr('computed by latolato')} {version}")
    return ", ".join(parts) + "."


def _dims(grid: xr.Dataset, variable: str) -> list[str]:
    """Return the dimensions of a variable along which parameters vary."""
    inner = ("direction", "ball", "sample", "exponent")
    return [str(d) for d in grid[variable].dims if d not in inner]


def _selected(
    grid: xr.Dataset, variable: str, select: Mapping[str, int] | None
) -> tuple[xr.Dataset, list[dict[str, Any]]]:
    """Return the part of a dataset with two dimensions, and what else may be taken."""
    indices = select or {}
    own = _dims(grid, variable)
    rest = [str(d) for d in grid[variable].dims if str(d) not in own[-2:]]
    choices = []
    for dim in rest:
        index = min(indices.get(dim, 0), grid.sizes[dim] - 1)
        labels = grid[dim].values if dim in grid.coords else np.arange(grid.sizes[dim])
        about = grid[dim].attrs if dim in grid.coords else {}
        choices.append(
            {
                "dim": dim,
                "index": index,
                "label": str(about.get("long_name", dim)),
                "unit": str(about.get("units", "1")),
                "values": [v if isinstance(v, str) else f"{v:.6g}" for v in labels.tolist()],
            }
        )
        grid = grid.isel({dim: index})
    return grid, choices


def drawing_of(grid: xr.Dataset, variable: str, request: Mapping[str, Any]) -> Drawing:
    """Return the values of a map, sorted, NaN where there is no answer.

    Parameters
    ----------
    request : mapping
        `select`, the number of the value to take of each further dimension, and `xlog` and `ylog`,
        whether an axis is logarithmic, None for what it is.
    """
    from latolato.figures.map import Drawing

    check_observable(grid, variable)
    grid, _ = _selected(grid, variable, request.get("select"))
    sizes = grid[variable].sizes
    if int(np.prod(list(sizes.values()))) > MOST_CELLS:
        text = " x ".join(str(n) for n in sizes.values())
        raise TooLargeError(f"a map on a page has at most {MOST_CELLS} points, this one {text}")
    return with_spacing(Drawing(grid, variable, log=False, select={}), request)


def check_observable(grid: xr.Dataset, variable: str) -> None:
    """Raise InputError unless a map has an observable."""
    if variable not in grid:
        known = suggest(variable, list(map(str, grid)))
        raise InputError(f"unknown observable '{variable}': {known}")


def with_spacing(drawing: Drawing, request: Mapping[str, Any]) -> Drawing:
    """Return a drawing whose axes are linear or logarithmic as a page asks, or as they are."""
    y, x = drawing.sides
    drawing.sides = [spaced(y, request.get("ylog")), spaced(x, request.get("xlog"))]
    return drawing
