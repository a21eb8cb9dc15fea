"""The picture of a drive: height of the pivot, residuals, their correlation, and overtones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from latolato.core.quantities import QUANTITIES
from latolato.figures import style
from latolato.figures.fits import draw_correlation, draw_curve, draw_residual

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def draw(dataset: xr.Dataset) -> Figure:
    """Return height, residuals, and overtones."""
    layout = [["height", "height"], ["residual", "residual"], ["correlation", "harmonics"]]
    figure, panels = style.new_mosaic(layout, height=5.6, height_ratios=[1.4, 0.8, 1.0])
    draw_curve(panels["height"], dataset, "pivot_height", "pivot_height_fit", 1e3, "mm")
    for start in dataset.stage_start.values[1:]:
        for name in ("height", "residual"):
            panels[name].axvline(start, color=style.ORANGE, lw=style.LINE)
    panels["height"].legend(**style.ABOVE, ncols=2)
    draw_residual(panels["residual"], dataset, "pivot_height_residual", 1e3, "mm")
    draw_correlation(panels["correlation"], dataset, "pivot_height_residual")
    axes = panels["harmonics"]
    order = dataset["harmonic"].values
    axes.errorbar(
        order,
        1e3 * dataset.harmonic_amplitude,
        2e3 * dataset.harmonic_amplitude_sigma,
        fmt="o",
        ms=3.0,
        color=style.BLUE,
        label="with two standard deviations",
    )
    axes.set_xlim(order[0] - 0.5, order[-1] + 0.5)
    axes.set_xticks(order)
    axes.set_ylim(0.0)
    axes.set_xlabel(QUANTITIES["harmonic"].long_name)
    axes.set_ylabel("amplitude $A_n$ [mm]")
    axes.legend(**style.ABOVE)
    return figure
