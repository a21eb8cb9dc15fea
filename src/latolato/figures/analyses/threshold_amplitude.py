"""The tongues with the amplitude at which a frequency first meets one."""

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
    "In the coloured tongues rest is unstable. The dot shows where this frequency first meets"
    " a tongue; below it a small swing dies away."
)
FIRST = {"frequency_ratio": "", "order": ""}

# The least A0/l that the picture reaches, and where it ends without an answer.
_LEAST, _WITHOUT = 0.05, 0.5


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.threshold_amplitude`."""
    about, length = dataset.attrs, system_of(dataset).balls[0].length
    ratio, amplitude = about["frequency_ratio"], float(dataset.drive_amplitude)
    exists = not math.isnan(amplitude)
    largest = max(2.0 * amplitude, _LEAST * length) if exists else _WITHOUT * length
    largest = min(largest, 0.9 * about.get("connecting_rod_length", math.inf))
    text = tr("{position} is unstable inside", position=tr("hanging"))
    figure, axes = new_panel(dataset, text)
    draw_tongues(axes, dataset, largest=largest)
    axes.set_xlim(min(0.5, 0.8 * ratio), max(3.2, 1.1 * ratio))
    axes.axvline(ratio, color=style.GREY, lw=style.THIN, ls=(0, (4, 3)), zorder=1)
    mark_answer(axes, (ratio, amplitude / length), f"{1e3 * amplitude:.4g} mm")
    return figure
