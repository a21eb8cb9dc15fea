"""A sweep as a long table: a row for each point, its parameters first."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.simulation.record import BALLS
from latolato.sweeps.chunk import STATUS
from latolato.sweeps.labels import (
    attributes_of_variables,
    coordinates_of,
    lengths_of,
    template,
)
from latolato.sweeps.plan import Plan
from latolato.sweeps.statuses import codes_of, with_words

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

POINT = "point"


def is_whole(dataset: xr.Dataset) -> bool:
    """Return whether a dataset has all points of the plan in its attributes."""
    try:
        plan = Plan.from_description(json.loads(dataset.attrs["plan"]))
    except (ValueError, KeyError):
        return False
    lengths = dict(zip(plan.dims, plan.shape, strict=True))
    return lengths == {d: n for d, n in dataset.sizes.items() if d in lengths} and all(
        set(plan.dims) <= set(variable.dims) for variable in dataset.data_vars.values()
    )


def as_table(dataset: xr.Dataset) -> xr.Dataset:
    """Return a sweep with one dimension for all of its points, in C order.

    Raises
    ------
    InputError
        If a variable has several numbers for each point, other than one for each ball.
    """
    import xarray as xr

    plan = Plan.from_description(json.loads(dataset.attrs["plan"]))
    size = plan.size
    columns: dict[str, Any] = {}
    for name, (dims, values) in coordinates_of(plan).items():
        if name == "ball":
            continue
        number = plan.dims.index(dims[0])
        shape = [1] * len(plan.dims)
        shape[number] = plan.shape[number]
        all_of_them = np.broadcast_to(np.reshape(values, shape), plan.shape).ravel()
        columns[name] = (POINT, all_of_them, dataset[name].attrs)
    for key, variable in dataset.data_vars.items():
        name = str(key)
        rest = [str(d) for d in variable.dims if d not in plan.dims]
        values = variable.transpose(*plan.dims, *rest).values
        if not rest:
            columns[name] = (POINT, values.reshape(size), variable.attrs)
        elif rest == ["ball"]:
            columns[name] = (("ball", POINT), values.reshape(size, -1).T, variable.attrs)
        else:
            raise InputError(
                f"has several numbers for each point, over {', '.join(rest)}: it fits no table",
                parameter=name,
                way_out="use .nc",
            )
    coords = {"ball": dataset["ball"]} if "ball" in dataset.dims else {}
    return xr.Dataset(columns, coords=coords, attrs=dataset.attrs)


def from_table(columns: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]) -> xr.Dataset:
    """Return the sweep whose rows these columns hold, in C order.

    Raises
    ------
    InputError
        If rows or columns do not fit the plan in the attributes.
    """
    import xarray as xr

    text = attributes["plan"]
    plan = Plan.from_description(json.loads(text) if isinstance(text, str) else text)
    lengths, about = lengths_of(plan), attributes_of_variables(plan)
    coordinates = coordinates_of(plan)
    variables: dict[str, Any] = {}
    for name, (dims, dtype, _) in template(plan).items():
        names = [f"{name}_{ball}" for ball in BALLS] if "ball" in dims else [name]
        if not set(names) <= columns.keys():
            continue
        values = np.stack([columns[each] for each in names], axis=-1)
        if name == STATUS:
            values = codes_of(values)
        if len(values) != plan.size:
            raise InputError(f"this table has {len(values)} rows, its sweep {plan.size} points")
        shape = [lengths[dim] for dim in dims]
        variables[name] = (dims, values.reshape(shape).astype(dtype), about[name])
    coords = {name: (*entry, about.get(name, {})) for name, entry in coordinates.items()}
    return with_words(xr.Dataset(variables, coords=coords, attrs=dict(attributes)))
