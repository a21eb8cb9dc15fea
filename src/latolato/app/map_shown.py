"""The map that a page shows, as the library draws it: one that was computed here, or a stored one.

A page names a computed map by its `key`, the hash of its plan, and a stored one by its name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.forms import quantity_of, units_of
from latolato.app.map_cells import Maps, known_of
from latolato.core.errors import InputError
from latolato.core.registry import suggest
from latolato.figures.map import Drawing
from latolato.figures.sides import spaced

if TYPE_CHECKING:
    import xarray as xr

_BALLS = ("right", "left")


@dataclass(frozen=True)
class Shown:
    """A map on show: all its numbers, and the variable that has the colours.

    Attributes
    ----------
    grid : xarray.Dataset
        The whole sweep.
    missing : int
        Points that are not computed.
    name : str
        What files of it are called, without an ending.
    path : Path, optional
        The file or store that it comes from.
    """

    grid: xr.Dataset
    drawing: Drawing
    missing: int
    name: str
    path: Path | None = None

    @property
    def unit(self) -> tuple[str, float]:
        """The unit in which pages show the variable, and how many SI units it is."""
        name = self.drawing.name
        result = units_of(quantity_of(name, str(self.drawing.data.attrs.get("units", "1"))))
        return (result[0]["name"], result[0]["size"]) if result else ("", 1.0)


def shown_of(given: Any, maps: Maps, find: Callable[[Any], Path]) -> Shown:
    """Return the map that a page shows.

    Raises
    ------
    InputError
        If there is no such map, or no such variable of it.
    """
    if not isinstance(given, Mapping):
        raise InputError(f"a request must be an object, got {given!r}")
    variable, ball = given.get("observable"), given.get("ball")
    if not isinstance(variable, str):
        raise InputError(f"observable must be a text, got {variable!r}")
    if ball is not None and ball not in _BALLS:
        raise InputError(f"ball must be right or left, got {ball!r}")
    if given.get("stored") is not None:
        return _stored(given, find(given["stored"]), variable)
    memory = maps.by_hash(given.get("key"))
    if memory is None:
        raise InputError(
            "the server no longer has this map, for it was restarted or others took its place: "
            "compute it again"
        )
    grid = memory.dataset()
    if variable not in grid:
        raise InputError(
            f"unknown observable '{variable}': {suggest(variable, list(map(str, grid)))}"
        )
    inner = {"ball": ball or _BALLS[0], "sample": "0", "exponent": "0"}
    select = {dim: value for dim, value in inner.items() if dim in grid[variable].dims}
    right = memory.plan.axes[1].name
    drawing = Drawing(grid, variable, log=False, select=select, right=right)
    missing = int(np.sum(~known_of(memory)))
    name = f"latolato_map_{memory.plan.hash[:8]}"
    return Shown(grid, _spaced(drawing, given), missing, name)


def _stored(given: Mapping[str, Any], path: Path, variable: str) -> Shown:
    """Return a stored map."""
    from latolato.app.map_stored import drawing_of, opened

    grid = opened(path)
    drawing = drawing_of(grid, variable, given.get("select") or {})
    missing = int(np.sum(grid["status"].values < 0)) if "status" in grid else 0
    return Shown(grid, _spaced(drawing, given), missing, path.stem, path)


def _spaced(drawing: Drawing, given: Mapping[str, Any]) -> Drawing:
    """Return a drawing with the axes linear or logarithmic as the page shows them."""
    y, x = drawing.sides
    drawing.sides = [spaced(y, given.get("ylog")), spaced(x, given.get("xlog"))]
    return drawing
