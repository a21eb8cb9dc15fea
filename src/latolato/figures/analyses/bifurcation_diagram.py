"""The picture of a bifurcation diagram: stroboscopic angles and largest angles, both ways."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points
from latolato.figures.map import WAYS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "Above each value of the parameter stand the angles once per drive period. One dot: the "
    "motion repeats every period; two dots: every second one; a smear: never. Red is the way "
    "up, blue the way back down: where they differ, the past decides."
)
FIRST = {"parameter": "frequency_ratio", "low": "", "high": "", "points": "41"}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the samples above and the largest angle below, the ways up and down in two colours."""
    figure, axes = style.new_figure(2, 1, width=0.75 * style.PAGE, height=4.6, sharex=True)
    samples, largest = axes[:, 0]
    knob = dataset[dataset.attrs["parameter"]]
    angle, way = dataset["section_angle"], dataset["direction"]
    ways = [tr("way {direction}", direction=tr(each)) for each in way.values.tolist()]
    angle = angle.isel(ball=0) if "ball" in angle.dims else angle
    size = float(np.clip(120.0 / knob.size, 0.7, 2.5))
    colours = [WAYS[each] for each in way.values]
    way = way.copy(data=ways)
    look: dict[str, Any] = {"colours": colours, "short": True}
    draw_points(samples, knob, angle, way, **look, ms=size)
    angle = dataset["largest_angle_watched"]
    draw_points(largest, knob, angle, way, **look, ms=max(size, 1.2))
    if "is_hysteretic" in dataset:
        differ = dataset["is_hysteretic"].values
        for panel in (samples, largest):
            for where, text, hatch in (
                (differ == 1, tr("both ways differ"), ""),
                (np.isnan(differ), tr("undecided"), "////"),
            ):
                if where.any():
                    panel.fill_between(
                        knob, 0.0, 1.0, where, step="mid", label=text, hatch=hatch, lw=0.0,
                        transform=panel.get_xaxis_transform(), zorder=0, edgecolor=style.PALE_GREY,
                        facecolor="none" if hatch else style.PALE_GREY,
                    )  # fmt: skip
    samples.set_xlabel("")
    style.show_unit(largest.xaxis, knob)
    largest.set_xlim(float(knob[0]), float(knob[-1]))
    style.panel_title(samples, "a", tr("angle once per drive period"))
    style.panel_title(largest, "b", tr("largest angle"))
    handles = largest.get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=len(handles[0]), markerscale=2.0)
    return figure
