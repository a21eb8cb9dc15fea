"""The picture of impacts: the separation, and restitution over time and closing speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def draw(dataset: xr.Dataset) -> Figure:
    """Return the separation with the impacts, and e over time and closing speed."""
    layout = [["gap", "gap"], ["time", "speed"]]
    figure, panels = style.new_mosaic(layout, height=4.2)
    axes = panels["gap"]
    axes.plot(dataset.time, dataset.separation, ".", ms=1.5, color=style.BLUE)
    axes.plot(
        dataset.contact_time, dataset.separation_at_contact, "o", ms=4.0, mfc="none",
        color=style.RED, label="impacts that count",
    )  # fmt: skip
    axes.set_xlabel(style.label(dataset.time))
    axes.set_ylabel(style.label(dataset.separation, short=True))
    axes.legend(**style.ABOVE)
    pooled, sigma = float(dataset.restitution), float(dataset.restitution_sigma)
    speeds = np.abs(dataset.angular_velocity_before)
    for name, values, text in (
        ("time", dataset.contact_time, style.label(dataset.time)),
        ("speed", speeds, "closing speed [rad/s]"),
    ):
        axes = panels[name]
        axes.axhspan(pooled - 2.0 * sigma, pooled + 2.0 * sigma, color=style.PALE_BLUE, lw=0.0)
        axes.axhline(pooled, color=style.BLUE)
        axes.errorbar(
            values, dataset.restitution_each, dataset.restitution_each_sigma, fmt="o", ms=2.5,
            lw=style.THIN, color=style.INK,
        )  # fmt: skip
        axes.set_xlabel(text)
        axes.set_ylabel(style.label(dataset.restitution_each, short=True))
        axes.margins(x=0.04)
    return figure
