"""The picture of a decay: angle with envelope, residuals, their correlation, and the drag laws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.fits import (
    draw_correlation,
    draw_curve,
    draw_residual,
    draw_turning_points,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw(dataset: xr.Dataset) -> Figure:
    """Return angle with envelope, residuals, their correlation, and the drag laws."""
    with_laws = "law_bic" in dataset
    if "angle_fit" not in dataset:
        figure, axes = style.new_figure(1, 1, height=3.0)
        draw_turning_points(axes[0, 0], dataset)
        axes[0, 0].set_xlabel(style.label(dataset.swing_time))
        axes[0, 0].set_ylabel(style.label(dataset.swing_angle))
        return figure
    layout = [["angle", "angle"], ["residual", "residual"], ["correlation", "laws"]]
    figure, panels = style.new_mosaic(layout, height=5.6, height_ratios=[1.6, 0.8, 1.0])
    draw_curve(panels["angle"], dataset, "angle", "angle_fit")
    if "swing_time" in dataset:
        draw_turning_points(panels["angle"], dataset)
    panels["angle"].legend(**style.ABOVE, ncols=3)
    draw_residual(panels["residual"], dataset, "angle_residual")
    draw_correlation(panels["correlation"], dataset, "angle_residual")
    if with_laws:
        _draw_laws(panels["laws"], dataset)
    else:
        panels["laws"].set_visible(False)
    return figure


def _draw_laws(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw how much worse each drag law is than the best."""
    bic = dataset.law_bic.values
    order = np.argsort(bic)[::-1]
    ahead = bic[order] - bic.min()
    places = np.arange(len(order))
    axes.barh(places, np.maximum(ahead, 0.05), color=style.PALE_BLUE)
    axes.set_xscale("symlog", linthresh=10.0)
    axes.set_xlim(0.0, 20.0 * max(float(ahead.max()), 10.0))
    for place, value in zip(places, ahead, strict=True):
        style.note(
            axes,
            f"{value:.3g}" if value > 0.0 else "best",
            (float(value), float(place)),
            (4.0, 0.0),
        )
    axes.set_yticks(places, [str(dataset.law.values[i]) for i in order])
    axes.axvline(10.0, color=style.GREY, lw=style.THIN, ls="--")
    axes.set_xlabel("BIC above the best (beyond 10: excluded)")
