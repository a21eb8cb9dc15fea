"""The picture of Floquet multipliers: where they lie about the unit circle."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.drawings import head, write_numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

READING = (
    "A periodic motion is found exactly, from a start near it. If all dots lie inside the "
    "circle, small disturbances die out; a red dot outside makes them grow, and an arrow "
    "points at one beyond the picture."
)
FIRST = {"period": ""}

# The picture reaches so far from zero: the unit circle is always well seen.
_REACH = 2.7
# Letters of a line in the picture.
_LINE = 10
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
    """Draw unit circle, multipliers and what happens where they leave the circle.

    Multipliers far outside are arrows at the edge of the picture.
    """
    axes.axhline(0.0, color=style.PALE_GREY, lw=style.THIN, zorder=0)
    axes.axvline(0.0, color=style.PALE_GREY, lw=style.THIN, zorder=0)
    turn = np.linspace(0.0, math.tau, 361)
    axes.fill(np.cos(turn), np.sin(turn), color=style.PALE_BLUE, lw=0.0, zorder=0)
    axes.plot(np.cos(turn), np.sin(turn), color=style.INK, lw=style.THIN)
    for place, name, ha, shift in (
        ((-1.0, 0.0), tr("period doubling"), "right", -5.0),
        ((1.0, 0.0), tr("fold or crossing"), "left", 5.0),
        ((math.cos(1.0), math.sin(1.0)), tr("torus"), "left", 5.0),
    ):
        text = textwrap.fill(name, _LINE, break_long_words=False)
        style.note(axes, text, place, (shift, 6.0), ha=ha, colour=style.GREY, va="bottom")
    for multiplier in multipliers[np.isfinite(multipliers)]:
        size = abs(multiplier)
        look: dict[str, Any] = {"color": style.RED if size > 1.0 else style.BLUE, "zorder": 3}
        if size <= _REACH:
            look |= {"ms": 5.5, "mec": style.PAPER, "mew": 0.6}
            axes.plot(multiplier.real, multiplier.imag, "o", **look)
            continue
        head, tail = ((share * _REACH * multiplier / size) for share in (1.0, 0.85))
        arrow = {"arrowstyle": "-|>", "color": look["color"], "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate("", (head.real, head.imag), (tail.real, tail.imag), arrowprops=arrow)
    axes.set_aspect("equal")
    axes.set_xlim(-_REACH, _REACH)
    axes.set_ylim(-_REACH, _REACH)
    axes.set_xlabel(r"$\mathrm{Re}\,\mu$")
    axes.set_ylabel(r"$\mathrm{Im}\,\mu$")
