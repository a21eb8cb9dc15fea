"""The tongues up to twice the amplitude, with the edges at one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.stored_system import system_of
from latolato.figures.analyses.tongues import draw_tongues, mark_answer, new_panel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "In the coloured tongues the smallest swing grows by itself. The dashed line marks the "
    "chosen amplitude; the dots are the edges on it."
)
FIRST = {"drive_amplitude": "", "order": "", "position": ""}

# The least A0/l that the picture reaches.
_LEAST = 0.1


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.tongue_edges`."""
    about, length = dataset.attrs, system_of(dataset).balls[0].length
    amplitude, position = about["drive_amplitude"], about["position"]
    rod = about.get("connecting_rod_length", math.inf)
    largest = min(max(2.0 * amplitude, _LEAST * length), max(0.9 * rod, amplitude))
    text = tr("{position} is unstable inside", position=tr(position))
    figure, axes = new_panel(dataset, text)
    draw_tongues(axes, dataset, largest=largest, position=position)
    height = amplitude / length
    axes.axhline(height, color=style.GREY, lw=style.THIN, ls=(0, (4, 3)), zorder=1)
    for name, side, shift in (("low", "right", -5.0), ("high", "left", 5.0)):
        edge = float(dataset[name]) or math.nan  # of a tongue that begins at zero
        mark_answer(axes, (edge, height), f"{edge:.6f}", (shift, 5.0), ha=side, va="bottom")
    return figure
