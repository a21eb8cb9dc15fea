"""The first push over frequency and phase of the drive, with the frequency of lift-off."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses import drawings

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "The drive frequency runs to the right, the smallest push that starts lasting motion "
    "upwards. At zero it starts by itself; where a point is missing, no push helps."
)
FIRST = {"frequency_ratio": "{ratios} : 16", "push": "", "largest_push": "", "scan_points": "30"}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return curves or a map of the first push, and where balls at rest lift off by themselves."""
    figure = drawings.draw(dataset)
    lift, ratio = dataset["drive_acceleration_ratio"].values, dataset["frequency_ratio"].values
    if dataset.attrs["system"] != "pendulum" and lift[0] < 1.0 < lift[-1]:
        panel, place = figure.axes[0], float(np.interp(1.0, lift, ratio))
        panel.axvline(place, color=style.ORANGE, lw=style.LINE, ls=(0, (4, 3)))
        text = tr(r"lift-off from rest ($A_0\omega^2 = g$)")
        style.note(panel, text, (place, panel.get_ylim()[1]), (-4.0, -8.0), ha="right")
    return figure
