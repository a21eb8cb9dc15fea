"""Cells of a map in the colours of its quantity, which all maps share."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import style
from latolato.figures.sides import Side

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap

# The scales of maps of energy and crossings, the same for all: variable, norm, colours.
SCALES: tuple[tuple[str, Callable[[], Any], str], ...] = (
    ("mean_energy", lambda: _log_norm(0.02, 100.0), "viridis"),
    ("crossings", lambda: _log_norm(10.0, 1500.0), "viridis_r"),
)


def _log_norm(low: float, high: float) -> Any:
    """Return a logarithmic scale of colours."""
    from matplotlib.colors import LogNorm

    return LogNorm(low, high)


def draw_cells(axes: Axes, values: xr.DataArray, *, norm: Any, cmap: str | Colormap) -> Any:
    """Draw a map of amplitude (up) and frequency (to the right); zeros and NaN stay white."""
    y, x = (
        Side(str(dim), values[dim].values, values[dim].attrs, str(dim), False)
        for dim in values.dims
    )
    cells = np.ma.masked_where(~(values.values > 0.0), values.values)
    mesh = style.draw_cells(axes, x.edges, y.edges, cells, cmap=cmap, norm=norm)
    axes.set_xlim(float(x.edges[0]), float(x.edges[-1]))
    axes.set_ylim(float(y.edges[0]), float(y.edges[-1]))
    return mesh
