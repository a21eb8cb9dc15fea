"""The axes of pictures of sweeps: what labels a dimension, its cells and its scale."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.language import spoken, tr
from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axis import Axis
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# How closely a spacing must keep its ratio or its difference to count as even.
_EVEN = 1e-6


@dataclass(frozen=True)
class Side:
    """One axis of a picture: its dimension, the coordinate that labels it, cells and scale.

    A coordinate of text has its `words`, and their places 0, 1, ... as `values`.
    """

    dim: str
    values: Floats
    attributes: Mapping[str, Any]
    name: str
    is_log: bool
    words: tuple[str, ...] = ()

    def label(self, axis: Axis) -> None:
        """Label an axis of matplotlib."""
        import xarray as xr

        about = {"long_name": self.name, **self.attributes}
        style.show_unit(axis, xr.DataArray(self.values, name=self.name, attrs=about))
        if self.words:
            axis.set_ticks(self.values, [tr(word) for word in self.words])

    def name_of(self, index: int) -> str:
        """Return a value in words: ``$A_0$ = 20 mm``, or the text itself."""
        if self.words:
            return self.words[index]
        symbol = self.attributes.get("symbol", "")
        head = f"${symbol}$" if symbol else spoken(self.name)
        unit = str(self.attributes.get("units", "1"))
        return f"{head} = {style.shown_value(self.name, float(self.values[index]), unit)}"

    @property
    def edges(self) -> Floats:
        """Borders of the cells, midway between values; of amounts, never below zero."""
        values = np.log(self.values) if self.is_log else self.values
        ends = style.edges_of(values)
        if self.is_log:
            return np.asarray(np.exp(ends))
        return np.maximum(ends, 0.0) if values[0] >= 0.0 and not self.words else ends


def values_along(grid: xr.Dataset, dim: str) -> Floats:
    """Return the numbers along a dimension: its own, those of its first parameter, or 0, 1, ..."""
    values: Floats = grid[_label_of(grid, dim)].values
    return values if values.dtype.kind in "iuf" else np.arange(float(len(values)))


def _label_of(grid: xr.Dataset, dim: str) -> str:
    """Return the coordinate that labels a dimension."""
    if dim in grid.coords:
        return dim
    own = [str(name) for name, c in grid.coords.items() if c.dims == (dim,)]
    usable = [name for name in own if len(np.unique(grid[name].values)) == grid.sizes[dim]]
    return usable[0] if usable else dim


def is_geometric(values: Floats) -> bool:
    """Return whether increasing values keep their ratio and not their difference.

    Examples
    --------
    >>> is_geometric(np.geomspace(0.01, 3.0, 7)), is_geometric(np.linspace(0.01, 3.0, 7))
    (True, False)
    """
    if len(values) < 3 or not values[0] > 0.0:
        return False
    steps, ratios = np.diff(values), values[1:] / values[:-1]
    return bool(np.ptp(ratios) < _EVEN * ratios[0] and np.ptp(steps) > _EVEN * steps[0])


def side_of(grid: xr.Dataset, dim: str) -> Side:
    """Return an axis of the picture."""
    name = _label_of(grid, dim)
    values = np.sort(np.asarray(values_along(grid, dim), dtype=np.float64))
    is_log = is_geometric(values)
    labels = grid[name].values
    words = () if labels.dtype.kind in "iuf" else tuple(map(str, labels))
    about = grid[name].attrs if name in grid.coords else {}
    others = [str(n) for n, c in grid.coords.items() if c.dims == (dim,) and n != name]
    if others:
        long_name = tr(
            "{name} (and {others})",
            name=tr(str(about.get("long_name", name))),
            others=", ".join(map(spoken, others)),
        )
        about = {**about, "long_name": long_name}
    return Side(dim, values, about, name, is_log, words)


def spaced(side: Side, log: Any) -> Side:
    """Return an axis drawn linear or logarithmic, or as it is if `log` is None.

    Raises
    ------
    InputError
        If an axis that does not begin above zero is to be logarithmic.
    """
    if log is None or log == side.is_log:
        return side
    if not isinstance(log, bool):
        raise InputError("log of {parameter} must be true or false", parameter=side.name, value=log)
    if log and not side.values[0] > 0.0:
        label = str(side.attributes.get("long_name", side.name))
        raise InputError(
            f"{label}: a logarithmic axis must begin above zero", value=float(side.values[0])
        )
    return replace(side, is_log=log)
