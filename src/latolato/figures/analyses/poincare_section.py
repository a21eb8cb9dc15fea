"""The picture of a stroboscopic section: points of the phase plane."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# Panels are no narrower [rad]: the points of a periodic motion differ by rounding errors.
_LEAST = 1e-3


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the points of the section, of two balls in two colours."""
    figure, axes = style.new_figure(width=0.6 * style.PAGE, height=3.4)
    panel = axes[0, 0]
    two = "ball" in dataset.dims
    count = dataset.sizes["time"]
    # Few points are dots, many a cloud.
    size = float(np.clip(60.0 / math.sqrt(count), 0.6, 5.0))
    for ball in range(2 if two else 1):
        part = dataset.isel(ball=ball) if two else dataset
        panel.plot(
            part["angle"].values,
            part["angular_velocity"].values,
            "o",
            ms=size,
            mew=0.0,
            color=style.COLOURS[ball],
            label=f"{part['ball'].values} ball" if two else "",
            rasterized=count > 5000,
        )
    panel.margins(0.08)
    style.keep_span(panel, x=_LEAST, y=_LEAST * dataset.attrs["drive_frequency"])
    low, high = panel.get_xlim()
    if high - low > math.pi:
        style.pi_ticks(panel.xaxis)
    panel.set_xlabel(style.label(dataset["angle"]))
    panel.set_ylabel(style.label(dataset["angular_velocity"]))
    phase = dataset.attrs["section_phase"]
    panel.set_title(f"{count} drive periods, at drive phase {phase:.4g} rad", fontsize=style.SMALL)
    if two:
        panel.legend(loc="best", markerscale=3.0 / size if size < 3.0 else 1.0)
    return figure
