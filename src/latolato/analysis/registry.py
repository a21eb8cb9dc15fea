"""The analyses by name, and the labels that all their datasets carry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.quantities import QUANTITIES, Quantity
from latolato.core.registry import Registry, describe
from latolato.core.versions import version_of
from latolato.physics.drives import Drive, drives
from latolato.physics.pendulum import System, systems

if TYPE_CHECKING:
    import xarray as xr

# Every analysis takes a system (and a drive, where it has one) and gives a labelled dataset.
analyses: Registry[Callable[..., Any]] = Registry("analysis")

# What several analyses name.
COMMON = {
    "status": Quantity("1", "", "status"),
    "ball": Quantity("1", "", "ball"),
    "multipliers": Quantity("1", r"\mu", "Floquet multipliers"),
    "impacts": Quantity("1", "n", "impacts in one period of the orbit"),
}


def labelled(
    name: str,
    variables: Mapping[str, Any],
    *,
    coordinates: Mapping[str, Any] | None = None,
    quantities: Mapping[str, Quantity] | None = None,
    system: System | None = None,
    drive: Drive | None = None,
    settings: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Return the dataset of an analysis with units, names, symbols and all parameters.

    Parameters
    ----------
    name : str
        The analysis, as it is registered; becomes the attribute ``analysis``.
    variables, coordinates : mapping
        Scalars, or ``(dims, values)``.
    quantities : mapping of str to Quantity
        Of names that neither `quantities.QUANTITIES` nor `COMMON` knows; each needs one.
    system, drive : optional
        Their kinds and parameters become attributes.
    settings : mapping
        Further attributes; None is left out.
    """
    import xarray as xr

    known = {**QUANTITIES, **COMMON, **(quantities or {})}

    def entry(key: str, given: Any) -> Any:
        dims, values = given if isinstance(given, tuple) else ((), given)
        return dims, values, known[key].attributes

    attributes: dict[str, Any] = {
        "title": f"latolato analysis {name}",
        "analysis": name,
        "latolato_version": version_of(),
        "numpy_version": np.__version__,
    }
    for part, registry in ((system, systems), (drive, drives)):
        if part is None:
            continue
        attributes[registry.kind] = registry.name_of(part)
        for key, value in describe(part).items():
            if isinstance(value, Mapping):
                attributes |= {f"{key}_{inner}": number for inner, number in value.items()}
            elif value is not None:
                attributes[key] = value
    for key, value in (settings or {}).items():
        if value is not None:
            attributes[key] = int(value) if isinstance(value, bool) else value
    return xr.Dataset(
        {key: entry(key, given) for key, given in variables.items()},
        coords={key: entry(key, given) for key, given in (coordinates or {}).items()},
        attrs=attributes,
    )
