"""Lines of equal values in a map, between the borders of its cells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.analysis.boundary import contour_lines
from latolato.figures.contours import Line

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from latolato.figures.map import Drawing

    Floats = NDArray[np.float64]

# A line that stays within fewer cells than this says nothing: a single point stands out.
_TINY = 2.0
_FEW = 12  # points along a side


def lines_of(drawing: Drawing, levels: Sequence[float]) -> tuple[list[Line], int]:
    """Return the lines of a map at these levels, and how many tiny ones are left out.

    Parameters
    ----------
    drawing : Drawing
        A map over two parameters. Where only every second, fourth, ... row and column is complete,
        lines are those of that coarser map; they end at points without an answer.
    levels : sequence of float
        Values in the unit of the variable.

    Returns
    -------
    list of Line
        Straight between the borders of cells; along a logarithmic axis straight in the logarithm.
    int
        Lines that stay within two cells, as single points of chaos have them; small maps keep them.
    """
    y, x = drawing.sides
    stride = _complete(drawing.status)
    values = drawing.values[::stride, ::stride]
    along_x, along_y = (_to_scale(side.values, side.is_log)[::stride] for side in (x, y))
    if min(values.shape) < 2:
        return [], 0
    columns, rows = (np.arange(n, dtype=np.float64) for n in values.shape[::-1])
    lines, tiny = [], 0
    for level in levels:
        for line in contour_lines(columns, rows, values, level):
            if np.ptp(line, axis=0).max() < _TINY and min(values.shape) >= _FEW:
                tiny += 1
                continue
            at_x = np.interp(line[:, 0], columns, along_x)
            at_y = np.interp(line[:, 1], rows, along_y)
            lines.append(
                Line(float(level), _from_scale(at_x, x.is_log), _from_scale(at_y, y.is_log))
            )
    return lines, tiny


def _complete(status: Any) -> int:
    """Return the smallest power of two whose multiples are rows and columns that are all known."""
    stride = 1
    while stride < max(status.shape) and np.any(status[::stride, ::stride] < 0):
        stride *= 2
    return stride


def _to_scale(values: Floats, is_log: bool) -> Floats:
    return np.log(values) if is_log else values


def _from_scale(places: Floats, is_log: bool) -> Floats:
    return np.exp(places) if is_log else places
