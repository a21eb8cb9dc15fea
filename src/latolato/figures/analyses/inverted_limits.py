"""Where the upright position is stable, over amplitude and frequency."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis import inverted_limits
from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.stored_system import drive_of, system_of
from latolato.figures.analyses.tongues import (
    answers,
    mark_answer,
    new_panel,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "In the coloured part fast driving holds the ball upright. The drive frequency runs to "
    "the right, its amplitude over the length upwards; the dashed line is Kapitza's formula."
)
FIRST = {"frequency_ratio": ""}

_SAMPLES = 31
_ENDS = ("low", "high")


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.inverted_limits`."""
    system, drive = system_of(dataset), drive_of(dataset)
    length, place = system.balls[0].length, dataset.attrs["frequency_ratio"]
    ratios = np.geomspace(min(1.5, 0.6 * place), max(20.0, 1.6 * place), _SAMPLES)
    found = answers(lambda r: inverted_limits(system, drive, frequency_ratio=r), ratios, *_ENDS)
    low, high = np.array(found) / length
    marks = [float(dataset[name]) for name in _ENDS]
    rod = dataset.attrs.get("connecting_rod_length", math.inf)
    top = 1.05 * float(np.nanmax([*low, *high, *(mark / length for mark in marks)]))
    ceiling = np.where(np.isnan(high) & ~np.isnan(low), min(top, rod / length), high)
    kapitza = math.sqrt(2.0) / ratios
    figure, axes = new_panel(dataset, tr("upright is stable inside"))
    axes.fill_between(ratios, low, ceiling, color=style.PALE_BLUE, lw=0.0)
    axes.plot(ratios, low, color=style.BLUE)
    axes.plot(ratios, high, color=style.RED)
    axes.plot(ratios, kapitza, color=style.GREY, ls=(0, (4, 3)), lw=style.THIN)
    style.note(axes, "Kapitza", (float(ratios[-1]), float(kapitza[-1])), (-4, -7), ha="right")
    for value in marks:
        mark_answer(axes, (place, value / length), f"{value:.5g} m", (6.0, 6.0))
    axes.set_xscale("log")
    axes.set_xlim(float(ratios[0]), float(ratios[-1]))
    axes.set_ylim(0.0, top)
    style.plain_ticks(axes.xaxis)
    axes.set_xlabel(style.label_of("frequency_ratio"))
    axes.set_ylabel(style.label_of("amplitude_ratio"))
    return figure
