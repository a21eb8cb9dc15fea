"""The picture of Floquet multipliers: where they lie about the unit circle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.drawings import head, write_numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

READING = (
    "A periodic motion is found exactly, from a start near it. If all dots lie inside the "
    "circle, small disturbances die out; a red dot outside makes them grow."
)
FIRST = {"period": ""}

_MARGIN = 1.75
# What is written beside the picture.
_ROWS = (
    "multipliers", "growth_rate", "response_period", "impacts", "turns", "slowest_impact",
    "multiplier_error", "defect",
)  # fmt: skip


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the multipliers in the complex plane, and beside it what is known of the orbit."""
    figure, panels = style.new_figure(1, 2, height=3.1, width_ratios=[1.0, 1.2])
    plane, text = panels[0]
    _draw_plane(plane, dataset["multipliers"].values)
    write_numbers(text, dataset, _ROWS)
    head(figure, dataset)
    return figure


def _draw_plane(axes: Axes, multipliers: np.ndarray) -> None:
    """Draw unit circle, multipliers and what happens where they leave the circle."""
    known = multipliers[np.isfinite(multipliers)]
    reach = _MARGIN * max(1.0, float(np.max(np.abs(known), initial=0.0)))
    axes.axhline(0.0, color=style.PALE_GREY, lw=style.THIN, zorder=0)
    axes.axvline(0.0, color=style.PALE_GREY, lw=style.THIN, zorder=0)
    turn = np.linspace(0.0, math.tau, 361)
    axes.fill(np.cos(turn), np.sin(turn), color=style.PALE_BLUE, lw=0.0, zorder=0)
    axes.plot(np.cos(turn), np.sin(turn), color=style.INK, lw=style.THIN)
    if reach < 3.0:
        for place, name, ha, shift in (
            ((-1.0, 0.0), "period\ndoubling", "right", -5.0),
            ((1.0, 0.0), "fold or\ncrossing", "left", 5.0),
            ((math.cos(1.0), math.sin(1.0)), "torus", "left", 5.0),
        ):
            style.note(axes, name, place, (shift, 6.0), ha=ha, colour=style.GREY, va="bottom")
    for multiplier in known:
        is_out = abs(multiplier) > 1.0
        axes.plot(
            multiplier.real, multiplier.imag, "o", ms=5.5, mec=style.PAPER, mew=0.6, zorder=3,
            color=style.RED if is_out else style.BLUE,
        )  # fmt: skip
    axes.set_aspect("equal")
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_xlabel(r"$\mathrm{Re}\,\mu$")
    axes.set_ylabel(r"$\mathrm{Im}\,\mu$")
