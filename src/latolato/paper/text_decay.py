"""Judges the captions of Figs. 7 and 10: the decay that the damping is read from."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis import decay_rate
from latolato.paper import measure
from latolato.paper import systems as paper
from latolato.paper.cases import Floats, quantity, stack
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Decay of free swings"
DURATION = 60.0  # s
START = 0.01  # rad, small enough for eq13
SYSTEMS = {
    "single": paper.SINGLE,
    # One ball swings while the other is held aside.
    "coupled": paper.ONE_BALL,
}


def data(quick: bool = False) -> xr.Dataset:
    """Return the free decay of both pendulums from a small angle."""
    from latolato import simulate

    times = np.arange(0.0, DURATION, 0.02)
    runs = {
        label: simulate(system, initial_angle=START, times=times)
        for label, system in SYSTEMS.items()
    }
    return stack(runs, title=TITLE, keep=("angle", "angular_velocity")).assign(
        decay_rate=quantity(
            "decay_rate", "case", [decay_rate(**paper.body(system)) for system in SYSTEMS.values()]
        )
    )


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement on decay needs."""
    result: dict[str, float] = {}
    for case in SYSTEMS:
        run = dataset.sel(case=case)
        when, sizes = measure.peaks(run.time.values, run.angle.values, run.angular_velocity.values)
        rate, misfit = _line(when, np.log(sizes))
        result |= {
            f"rate_{case}": float(run.decay_rate),
            f"fit_{case}": -rate,
            f"exponential_{case}": misfit,
            f"power_{case}": _line(np.log(when), np.log(sizes))[1],
        }
    return result


def _line(x: Floats, logarithm: Floats) -> tuple[float, float]:
    """Return the slope of a straight line and its largest relative misfit after exponentiation."""
    slope, offset = np.polyfit(x, logarithm, 1)
    return float(slope), float(np.max(np.abs(np.expm1(slope * x + offset - logarithm))))
