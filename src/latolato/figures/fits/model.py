"""The picture of a fitted system: measured and fitted angles, and residuals, for each ball."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.fits import draw_curve, draw_residual

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def draw(dataset: xr.Dataset) -> Figure:
    """Return the angles with the fitted ones, and the residuals, for each ball."""
    balls = np.unique(dataset.ball_number.values)
    rows = 2 * len(balls)
    figure, axes = style.new_figure(
        rows, 1, height=2.4 * len(balls) + 0.6, sharex=True, height_ratios=[1.6, 0.8] * len(balls)
    )
    for i, ball in enumerate(balls):
        own = dataset.isel(sample=np.flatnonzero(dataset.ball_number.values == ball))
        draw_curve(axes[2 * i, 0], own, "angle", "angle_fit")
        draw_residual(axes[2 * i + 1, 0], own, "angle_residual")
        for start in dataset.window_start.values[1:]:
            axes[2 * i + 1, 0].axvline(start, color=style.GREY, lw=style.THIN)
        if len(balls) > 1:
            axes[2 * i, 0].set_title("right ball" if ball == 1 else "left ball")
        axes[2 * i, 0].set_xlabel("")
        if i < len(balls) - 1:
            axes[2 * i + 1, 0].set_xlabel("")
    axes[0, 0].legend(**style.ABOVE, ncols=2)
    return figure
