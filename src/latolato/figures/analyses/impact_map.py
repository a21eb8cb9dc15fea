"""The picture of an impact map: velocity against drive phase, and each against the one before."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "Every dot is a collision: its moment within the drive period to the right, its rebound "
    "speed upwards. Few dots mean a steady rhythm. On the right stands each collision against"
    " the one before."
)
FIRST = {"periods": "", "transient_periods": ""}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the impacts in the plane of phase and velocity, and the return map of the phase."""
    figure, axes = style.new_figure(1, 2, height=3.2, width_ratios=[1.2, 1.0])
    plane, returns = axes[0]
    phase, side = dataset["impact_phase"], dataset["impact_side"]
    following = phase.shift(impact=-1).assign_attrs(
        phase.attrs, long_name="drive phase at the next impact"
    )
    draw_points(plane, phase, dataset["angular_velocity_after"], side)
    draw_points(returns, phase, following.assign_attrs(symbol=r"\varphi_{j+1}"), side)
    returns.plot([0.0, math.tau], [0.0, math.tau], color=style.GREY, lw=style.THIN, zorder=0)
    for panel in (plane, returns):
        panel.set_xlim(0.0, math.tau)
    returns.set_ylim(0.0, math.tau)
    style.keep_span(plane, y=0.02 * float(np.abs(plane.get_ylim()).max()))
    rate = dataset["impacts_per_period"].item()
    style.panel_title(plane, "a", tr("{rate} impacts per drive period", rate=f"{rate:.4g}"))
    style.panel_title(returns, "b", tr("from one impact to the next"))
    if dataset.sizes["impact"]:
        figure.legend(
            *plane.get_legend_handles_labels(), loc="outside lower center", ncols=2, markerscale=2.0
        )
    else:
        style.note(
            plane, tr(str(dataset["status"].item())), (math.pi, 0.0), (0.0, 0.0), ha="center"
        )
    return figure
