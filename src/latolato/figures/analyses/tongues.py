"""What pictures over amplitude and frequency share: tongues, labels, the answer's dot."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Literal

import numpy as np

from latolato.analysis import tongue_edges
from latolato.figures import style
from latolato.figures.analyses.stored_system import drive_of, system_of
from latolato.figures.map_title import title_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# Where the balls are at rest: below the pivot or above it.
Position = Literal["hanging", "inverted"]

_ORDERS = (1, 2, 3)
_COLOURS = {1: style.BLUE, 2: style.RED, 3: style.GREEN}
_HALVINGS = 12  # of the amplitude between a closed and an open tongue
_SAMPLES, _FEW_SAMPLES = 81, 25  # amplitudes under a cosine, and under other waveforms


def new_panel(dataset: xr.Dataset, text: str) -> tuple[Figure, Axes]:
    """Return a figure and its panel, over which stand `text` and the parameters of an analysis."""
    figure, panels = style.new_figure(width=0.7 * style.PAGE, height=3.2)
    panels[0, 0].set_title("\n".join([text, *title_of(dataset, {}, "")]), fontsize=style.SMALL)
    return figure, panels[0, 0]


def answers(
    analysis: Callable[[float], xr.Dataset], values: Iterable[float], *names: str
) -> list[Floats]:
    """Return some variables of an analysis at each value, NaN where it warns of no answer."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        found = [analysis(float(value)) for value in values]
    return [np.array([float(each[name]) for each in found]) for name in names]


def draw_tongues(
    axes: Axes, dataset: xr.Dataset, *, largest: float, position: Position = "hanging"
) -> None:
    """Fill the tongues of orders 1 to 3 up to an amplitude [m], over w/w0 and A0/l."""
    system, drive = system_of(dataset), drive_of(dataset)
    length = system.balls[0].length
    plain = drive.is_cosine and position == "hanging"
    amplitudes = np.linspace(0.0, largest, _SAMPLES if plain else _FEW_SAMPLES)[1:]
    right = 3.2 if position == "hanging" else 12.0
    for order in _ORDERS if position == "hanging" else (0, 1):

        def edges(amplitude: float, order: int = order) -> xr.Dataset:
            return tongue_edges(
                system, drive, drive_amplitude=amplitude, order=order, position=position
            )

        rows = np.array([amplitudes, *answers(edges, amplitudes, "low", "high")]).T
        is_open = np.isfinite(rows[:, 1])
        if not is_open.any():
            continue
        tip = [[0.0, 0.0, math.inf]] if order == 0 else _tip(edges, rows)
        y, low, high = np.array([*tip, *rows[is_open]]).T
        y = y / length
        colour = _COLOURS.get(order, style.GREY)
        high = np.minimum(high, 2.0 * right)
        axes.fill_betweenx(y, low, high, color=colour, alpha=0.18, lw=0.0)
        for edge in (low, high):
            axes.plot(edge, y, color=colour, lw=style.LINE)
        place = (float(np.clip(0.5 * (low[-1] + high[-1]), 0.0, 0.92 * right)), float(y[-1]))
        style.note(axes, f"n = {order}", place, (0.0, -8.0), ha="center", colour=colour)
    axes.set_xlim(0.5 if position == "hanging" else 0.0, right)
    axes.set_ylim(0.0, largest / length)
    axes.set_xlabel(style.label_of("frequency_ratio"))
    axes.set_ylabel(style.label_of("amplitude_ratio"))


def mark_answer(
    axes: Axes,
    place: tuple[float, float],
    text: str,
    shift: tuple[float, float] = (6.0, 0.0),
    *,
    ha: str = "left",
    va: str = "center",
) -> None:
    """Mark the answer of an analysis, if there is one, with a dot and its number."""
    if np.isfinite(place).all():
        axes.plot(*place, "o", ms=4.0, color=style.INK, clip_on=False)
        style.note(axes, text, place, shift, ha=ha, va=va)


def _tip(edges: Callable[[float], xr.Dataset], rows: Floats) -> list[tuple[float, ...]]:
    """Return rows of amplitude, low and high between the last closed amplitude and an open one."""
    first = int(np.argmax(np.isfinite(rows[:, 1])))
    closed, opened = (rows[first - 1, 0] if first else 0.0), rows[first, 0]
    tip: list[tuple[float, ...]] = []
    for _ in range(_HALVINGS):
        middle = 0.5 * (closed + opened)
        (low,), (high,) = answers(edges, [middle], "low", "high")
        if math.isnan(low):
            closed = middle
        else:
            opened = middle
            tip.insert(0, (middle, low, high))
    return tip
