"""What pictures over amplitude and frequency share: tongues, labels, the answer's dot."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Literal

import numpy as np

from latolato.analysis import tongue_edges
from latolato.figures import style
from latolato.figures.map_title import in_words
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

# Where the balls are at rest: below the pivot or above it.
Position = Literal["hanging", "inverted"]

RATIO_LABEL = r"driving over natural frequency $\omega/\omega_0$"
LENGTH_LABEL = "driving amplitude over length $A_0/l$"
_ORDERS = (1, 2, 3)
_COLOURS = {1: style.BLUE, 2: style.RED, 3: style.GREEN}
_HALVINGS = 12  # of the amplitude between a closed and an open tongue
_SAMPLES, _FEW_SAMPLES = 81, 25  # amplitudes under a cosine, and under other waveforms


def draw_tongues(
    axes: Axes, system: System, drive: Drive, *, largest: float, position: Position = "hanging"
) -> None:
    """Fill the tongues of orders 1 to 3 up to an amplitude [m], over w/w0 and A0/l."""
    length = system.balls[0].length
    plain = drive.is_cosine and position == "hanging"
    amplitudes = np.linspace(0.0, largest, _SAMPLES if plain else _FEW_SAMPLES)[1:]
    right = 3.2 if position == "hanging" else 12.0
    for order in _ORDERS if position == "hanging" else (0, 1):
        rows = [(a, *_edges(system, drive, a, order, position)) for a in amplitudes]
        first = next((i for i, row in enumerate(rows) if np.isfinite(row[1])), None)
        if first is None:
            continue
        closed = float(amplitudes[first - 1]) if first else 0.0
        tip = _tip(system, drive, order, position, closed, rows[first])
        y, low, high = np.array([*tip, *rows[first:]]).T
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
    axes.set_xlabel(RATIO_LABEL)
    axes.set_ylabel(LENGTH_LABEL)


def mark_answer(
    axes: Axes, place: tuple[float, float], text: str, shift: tuple[float, float] = (6.0, 0.0)
) -> None:
    """Mark the answer of an analysis with a dot and its number."""
    axes.plot(*place, "o", ms=4.0, color=style.INK, clip_on=False)
    style.note(axes, text, place, shift)


def _tip(
    system: System,
    drive: Drive,
    order: int,
    position: Position,
    closed: float,
    row: tuple[float, ...],
) -> list[tuple[float, ...]]:
    """Return rows of amplitude, low and high between a closed amplitude and an open one."""
    if order == 0:
        return [(0.0, 0.0, math.inf)]
    rows: list[tuple[float, ...]] = []
    opened = row[0]
    for _ in range(_HALVINGS):
        middle = 0.5 * (closed + opened)
        edges = _edges(system, drive, middle, order, position)
        if math.isnan(edges[0]):
            closed = middle
        else:
            opened = middle
            rows.insert(0, (middle, *edges))
    return rows


def _edges(
    system: System, drive: Drive, amplitude: float, order: int, position: Position
) -> tuple[float, float]:
    """Return the edges, NaN where closed, without a word."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        edges = tongue_edges(
            system, drive, drive_amplitude=float(amplitude), order=order, position=position
        )
    return float(edges.low), float(edges.high)


def parameters_in_words(dataset: xr.Dataset, *names: str) -> str:
    """Return parameters other than zero in words, such as ``C = 0.05 kg m/s``."""
    values = {name: dataset.attrs.get(name) for name in names}
    return ", ".join(in_words(dataset, name, value) for name, value in values.items() if value)
