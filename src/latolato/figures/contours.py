"""Lines along which the values of a map are equal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# Where along a line its value may stand, and how far from others in shares of the picture.
_PLACES = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9)
_APART = np.array([0.07, 0.06])


@dataclass(frozen=True)
class Line:
    """A line of equal values in the coordinates of a map."""

    level: float
    x: Floats
    y: Floats


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
