"""Lines along which the values of a map are equal, between the borders of its cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.analysis.boundary import contour_lines
from latolato.core.language import tr
from latolato.core.quantities import in_brackets
from latolato.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from latolato.figures.sides import Side

    Floats = NDArray[np.float64]

# A line that stays within fewer cells than this says nothing: a single point stands out.
_TINY = 2.0
_FEW = 12  # points along a side
# Where along a line its value may stand, and how far from others in shares of the picture.
_PLACES = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9)
_APART = np.array([0.07, 0.06])


@dataclass(frozen=True)
class Line:
    """A line of equal values in the coordinates of a map."""

    level: float
    x: Floats
    y: Floats


def lines_of(
    values: Floats, status: Any, *, sides: Sequence[Side], levels: Sequence[float]
) -> list[Line]:
    """Return the lines of a map at these levels.

    Parameters
    ----------
    values, status : ndarray
        Of shape (y, x); a status below 0 marks a point that is not computed. Where only every
        second, fourth, ... row and column is complete, lines are those of that coarser map; they
        end at points without an answer.
    sides : sequence of Side
        The parameters upwards and to the right.
    levels : sequence of float
        Values in the unit of the variable.

    Returns
    -------
    list of Line
        Straight between the borders of cells; along a logarithmic axis straight in the logarithm.
        Lines that stay within two cells, as single points of chaos have them, are left out; small
        maps keep them.
    """
    y, x = sides
    stride = _complete(status)
    values = values[::stride, ::stride]
    along_x, along_y = (_to_scale(side.values, side.is_log)[::stride] for side in (x, y))
    if min(values.shape) < 2:
        return []
    columns, rows = (np.arange(n, dtype=np.float64) for n in values.shape[::-1])
    lines = []
    for level in levels:
        for line in contour_lines(columns, rows, values, level):
            if np.ptp(line, axis=0).max() < _TINY and min(values.shape) >= _FEW:
                continue
            at_x = np.interp(line[:, 0], columns, along_x)
            at_y = np.interp(line[:, 1], rows, along_y)
            lines.append(
                Line(float(level), _from_scale(at_x, x.is_log), _from_scale(at_y, y.is_log))
            )
    return lines


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


def draw(axes: Axes, lines: Sequence[Line], unit: tuple[str, float], label: str) -> Any:
    """Draw lines with their values on dark and light cells and return their legend entry.

    Values are in the unit of this name and size; `label` is what they are of.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import Normal, Stroke

    limits = axes.get_xlim(), axes.get_ylim()
    axes.set_xlim(limits[0])
    axes.set_ylim(limits[1])
    shares = axes.transScale + axes.transLimits
    used: list[Any] = []
    labelled: set[float] = set()
    for line in sorted(lines, key=lambda each: -len(each.x)):
        axes.plot(
            line.x,
            line.y,
            color=style.INK,
            lw=0.8,
            path_effects=[Stroke(linewidth=2.0, foreground=style.PAPER, alpha=0.7), Normal()],
        )
        # The longest line of each level bears its value.
        if line.level in labelled or len(line.x) < 3:
            continue
        places = shares.transform(np.stack([line.x, line.y], axis=1))
        free = (
            i for i in (round(p * (len(line.x) - 1)) for p in _PLACES) if _fits(places[i], used)
        )
        middle = next(free, None)
        if middle is None:
            continue
        labelled.add(line.level)
        used.append(places[middle])
        text = axes.annotate(
            f"{line.level / unit[1]:.4g}",
            (line.x[middle], line.y[middle]),
            ha="center",
            va="center",
            fontsize=style.SMALL,
            color=style.INK,
            annotation_clip=True,
        )
        text.set_path_effects([Stroke(linewidth=2.2, foreground=style.PAPER), Normal()])
    tail = in_brackets(style.pretty_unit(unit[0]))
    return Line2D(
        [],
        [],
        color=style.INK,
        lw=0.8,
        label=tr("equal {quantity}", quantity=style.named(label)) + tail,
    )


def _fits(place: Any, others: Sequence[Any]) -> bool:
    """Return whether a value is inside of the picture and beside the others, in shares of it."""
    inside = bool(np.all((place > _APART / 2) & (place < 1 - _APART / 2)))
    return inside and all(np.abs((place - other) / _APART).max() > 1.0 for other in others)
