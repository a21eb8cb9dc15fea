"""What pictures of analyses say in words: a status, what it means, and numbers below it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from latolato.figures import style
from latolato.figures.map_title import title_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Base lines of the parts below the top, and height of one row [inch].
_STATUS, _MEANING, _TABLE, _ROW = 0.22, 0.44, 0.76, 0.21
# The colours in which these are written; others are in ink.
_COLOURS = {
    style.RED: ("unstable", "chaotic", "broken"),
    style.BLUE: ("stable", "regular", "valid", "rest"),
}


def write_words(
    axes: Axes, status: str, meaning: str, rows: Sequence[tuple[str, str]], *, column: float
) -> None:
    """Write a status, its meaning and a table, whose values begin at `column` of the width."""
    axes.set_axis_off()
    colour = next((c for c, names in _COLOURS.items() if status in names), style.INK)

    def put(text: str, x: float, down: float, size: float, ink: str) -> None:
        axes.annotate(
            text, (x, 1.0), xycoords="axes fraction", xytext=(0.0, -72.0 * down),
            textcoords="offset points", va="baseline", fontsize=size, color=ink,
            annotation_clip=False,
        )  # fmt: skip

    put(status, 0.0, _STATUS, 1.4 * style.LARGE, colour)
    put(meaning, 0.0, _MEANING, style.SMALL, style.INK)
    for row, (name, value) in enumerate(rows):
        put(name, 0.0, _TABLE + _ROW * row, style.SMALL, style.GREY)
        put(value, column, _TABLE + _ROW * row, style.SMALL, style.INK)


def head(figure: Figure, dataset: xr.Dataset) -> None:
    """Write above a figure what system and drive it is of."""
    style.head(figure, "\n".join(title_of(dataset, {}, "")))


def tex_number(value: float, digits: int = 4) -> str:
    r"""Return a number as it is printed, powers of ten and infinity included.

    Examples
    --------
    >>> print(tex_number(0.25), tex_number(3e-15, 1), tex_number(float("inf")))
    0.25 $3\times10^{-15}$ ∞
    """
    if math.isnan(value):
        return "no value"
    text = f"{value:.{digits}g}"
    if "e" in text:
        return style.raised(text)
    return text.replace("inf", "∞").replace("-", "\N{MINUS SIGN}")
