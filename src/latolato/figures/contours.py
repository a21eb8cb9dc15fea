"""Lines along which the values of a map are equal, and round levels for them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# About so many levels are chosen.
_USUAL = 6
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
# Steps of angles in degrees: parts of a turn.
_DEGREES = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0)
# Levels of a logarithmic scale over fewer decades are 1, 2, 5, 10 ..., over more powers of ten.
_FEW_DECADES = 2.5
# Where along a line its value may stand, and how far from others in shares of the picture.
_PLACES = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9)
_APART = np.array([0.07, 0.06])


@dataclass(frozen=True)
class Line:
    """A line of equal values in the coordinates of a map."""

    level: float
    x: Floats
    y: Floats


def round_levels(
    low: float, high: float, *, unit: tuple[str, float] = ("", 1.0), log: bool = False
) -> list[float]:
    """Return about six round numbers between two values, the ends left out.

    Parameters
    ----------
    unit : tuple of str and float
        The unit in which they are round, and how many SI units it is.

    Examples
    --------
    >>> round_levels(0.03, 2.9)
    [0.5, 1.0, 1.5, 2.0, 2.5]
    >>> [round(math.degrees(v)) for v in round_levels(0, 3, unit=("deg", math.pi / 180))]
    [30, 60, 90, 120, 150]
    >>> round_levels(0.003, 700.0, log=True)
    [0.01, 0.1, 1.0, 10.0, 100.0]
    """
    name, size = unit
    first, last = low / size, high / size
    if not (math.isfinite(first) and math.isfinite(last) and first < last):
        return []
    if log and first > 0.0:
        return [level * size for level in _powers(first, last)]
    rough = (last - first) / _USUAL
    power = 10.0 ** math.floor(math.log10(rough))
    steps = _DEGREES if name == "deg" and 0.5 < rough < 360.0 else [s * power for s in _STEPS]
    step = min(steps, key=lambda each: abs(math.log(each / rough)))
    numbers = np.arange(math.floor(first / step) + 1, math.ceil(last / step))
    # Written with few digits, so that 3 steps of 0.1 are 0.3.
    return [float(f"{number * step:.10g}") * size for number in numbers.tolist()]


def _powers(first: float, last: float) -> list[float]:
    """Return round numbers that are evenly spaced in their logarithm."""
    decades = math.log10(last / first)
    digits = (1, 2, 5) if decades < _FEW_DECADES else (1,)
    step = max(1, math.floor(decades / _USUAL + 0.5))
    powers = range(math.floor(math.log10(first)), math.ceil(math.log10(last)) + 1)
    values = [float(f"{d}e{k}") for k in powers if k % step == 0 for d in digits]
    return [value for value in values if first < value < last]


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
    tail = "" if unit[0] in ("", "1") else f" [{style.pretty_unit(unit[0])}]"
    return Line2D([], [], color=style.INK, lw=0.8, label=f"equal {label}{tail}")


def _fits(place: Any, others: Sequence[Any]) -> bool:
    """Return whether a value is inside of the picture and beside the others, in shares of it."""
    inside = bool(np.all((place > _APART / 2) & (place < 1 - _APART / 2)))
    return inside and all(np.abs((place - other) / _APART).max() > 1.0 for other in others)
