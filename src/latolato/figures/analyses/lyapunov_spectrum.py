"""The picture of a Lyapunov spectrum: its exponents, and the sum that they must have."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.drawings import head, text_of, write_numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "A red bar above zero means that neighbouring motions separate exponentially: chaos. Blue"
    " bars mean that they come together again."
)
FIRST = {"duration": "300", "transient": ""}

# What is written beside the picture.
_ROWS = ("divergence", "sum_rule_residual", "exponent_between_rests", "rests")
# Between rests a perturbation must grow or shrink by so many e-folds to forget how it began.
_RARE = 10.0


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the exponents as bars; one of minus infinity is an arrow to the bottom."""
    figure, panels = style.new_figure(1, 2, height=3.0, width_ratios=[1.0, 1.3])
    axes, text = panels[0]
    exponents = dataset["lyapunov_exponents"]
    values = exponents.values
    places = range(1, len(values) + 1)
    finite = np.where(np.isfinite(values), values, 0.0)
    reach = float(np.max(np.abs(finite))) or 1.0
    bottom = -reach if np.isneginf(values).any() else finite.min()
    axes.axhline(0.0, color=style.INK, lw=style.THIN, zorder=3)
    for place, value in zip(places, values.tolist(), strict=True):
        colour = style.RED if value > 0.0 else style.BLUE
        name = text_of("lyapunov_exponents", value, "1")
        end = bottom if value == -math.inf else np.nan_to_num(value)
        if value == -math.inf:
            arrow = {"arrowstyle": "-|>", "color": colour, "lw": 2.0 * style.LINE}
            axes.annotate("", (place, bottom), (place, 0.0), arrowprops=arrow)
        else:
            axes.bar(place, end, width=0.55, color=colour)
        side, shift = ("top", -3.0) if value < 0.0 else ("bottom", 3.0)
        style.note(axes, name, (place, end), (0.0, shift), ha="center", va=side)
    axes.set_ylim(bottom - 0.18 * reach, max(0.0, finite.max()) + 0.18 * reach)
    axes.set_xlim(0.4, len(values) + 0.6)
    axes.set_xticks(places, [rf"$\lambda_{i}$" for i in places])
    axes.tick_params(axis="x", length=0.0)
    axes.spines["bottom"].set_visible(False)
    axes.set_ylabel(style.label(exponents))
    if not np.isfinite(values).any():
        axes.set_yticks([])
    write_numbers(text, dataset, [str(each) for each in dataset if each in _ROWS])
    head(figure, dataset)
    return figure
