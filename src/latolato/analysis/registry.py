"""The analyses by name, and the labels that all their datasets carry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import signature
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.quantities import QUANTITIES, Quantity
from latolato.core.registry import Registry, describe, flattened
from latolato.core.versions import version_of
from latolato.physics.drives import Drive, drives
from latolato.physics.pendulum import System, systems
from latolato.simulation.record import BALL, BALLS

if TYPE_CHECKING:
    import xarray as xr

# Every analysis takes a system (and a drive, where it has one) and gives a labelled dataset.
analyses: Registry[Callable[..., Any]] = Registry("analysis")

# What several analyses name.
COMMON = {
    "status": Quantity("1", "", "status"),
    "ball": BALL,
    "multipliers": Quantity("1", r"\mu", "Floquet multipliers"),
    "impacts": Quantity("1", "n", "impacts in one period of the orbit"),
}
# What a file can hold as an attribute.
_STORABLE = (int, float, str, tuple, list, np.generic, np.ndarray)


def labelled(
    name: str,
    variables: Mapping[str, Any],
    *,
    coordinates: Mapping[str, Any] | None = None,
    quantities: Mapping[str, Quantity] | None = None,
    system: System | None = None,
    drive: Drive | None = None,
    arguments: Mapping[str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Return the dataset of an analysis with units, names, symbols and all parameters.

    Parameters
    ----------
    name : str
        The analysis, as it is registered; becomes the attribute ``analysis``.
    variables : mapping
        Scalars, or ``(dims, values)``. Where one is over ``ball``, this coordinate is added.
    coordinates : mapping
        Values along dimensions of the same names.
    quantities : mapping of str to Quantity
        Of names that neither `quantities.QUANTITIES` nor `COMMON` knows; each needs one.
    system, drive : optional
        Their kinds and parameters become attributes.
    arguments : mapping
        The arguments of the analysis after its checks, among other names: its ``locals()``. Those
        that are no coordinates or variables become attributes.
    settings : mapping
        Further attributes, before which `arguments` give way; None is left out.
    """
    import xarray as xr

    known = {**QUANTITIES, **COMMON, **(quantities or {})}
    coordinates = {each: ((each,), values) for each, values in (coordinates or {}).items()}
    if any("ball" in value[0] for value in variables.values() if isinstance(value, tuple)):
        coordinates |= {"ball": (("ball",), list(BALLS))}
    attributes: dict[str, Any] = {
        "title": f"latolato analysis {name}",
        "analysis": name,
        "latolato_version": version_of(),
        "numpy_version": np.__version__,
    }
    for part, registry in ((system, systems), (drive, drives)):
        if part is not None:
            attributes |= {registry.kind: registry.name_of(part), **flattened(describe(part))}
    if arguments is not None:
        others = {"system", "drive", *variables, *coordinates}
        names = [each for each in signature(analyses[name]).parameters if each not in others]
        values = {each: arguments[each] for each in names}
        attributes |= flattened({k: v for k, v in values.items() if isinstance(v, _STORABLE)})

    def entry(key: str, value: Any) -> Any:
        dims, values = value if isinstance(value, tuple) else ((), value)
        return dims, values, known[key].attributes

    return xr.Dataset(
        {key: entry(key, value) for key, value in variables.items()},
        coords={key: entry(key, value) for key, value in coordinates.items()},
        attrs=attributes | flattened(settings or {}),
    )
