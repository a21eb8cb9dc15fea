"""Judges the captions of Figs. 7 and 10: the decay that the damping is read from."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis.closed_forms import decay_rate
from latolato.figures import measure, paper
from latolato.figures.cases import Floats, quantity, stack
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.physics.pendulum import Pendulum

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Decay of free swings"
DURATION = 60.0  # s
START = 0.01  # rad, small enough for eq13
SYSTEMS = {
    "single": paper.SINGLE,
    # One ball swings while the other is held aside.
    "coupled": Pendulum(
        length=paper.COUPLED_LENGTH, mass=paper.COUPLED_MASS, damping=paper.COUPLED_DAMPING
    ),
}

STATEMENTS = (
    Statement(
        name="decay-law",
        where="Figs. 7 and 10, captions",
        words=(
            "The upper envelope of the θ-t curve of the damped vibration is fitted by the power law"
        ),
        printed=(
            Limit("power_single", "largest misfit of a power law, Fig. 7, relative", high=0.05),
            Limit("power_coupled", "largest misfit of a power law, Fig. 10, relative", high=0.05),
        ),
        assumed=(
            Limit("exponential_single", "largest misfit of an exponential, Fig. 7", high=0.01),
            Limit("exponential_coupled", "largest misfit of an exponential, Fig. 10", high=0.01),
        ),
        assumption="The exponential of eq13 is meant, whose decay factor the caption uses.",
        finding=(
            "The C, m and l printed for Figs. 7 and 10 give k = C/(2ml) = {rate_single:.7f} 1/s "
            "(single) and {rate_coupled:.7f} 1/s (coupled); exponentials fitted to runs of eq7 "
            "give {fit_single:.7f} and {fit_coupled:.7f} 1/s."
        ),
        why=(
            "A power law misses the envelope of the runs by up to {power_single:.0%} and "
            "{power_coupled:.0%}, an exponential by {exponential_single:.0e} and "
            "{exponential_coupled:.0e}."
        ),
    ),
)


def data(quick: bool = False) -> xr.Dataset:
    """Return the free decay of both pendulums from a small angle."""
    from latolato.simulation.run import simulate

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
    found: dict[str, float] = {}
    for case in SYSTEMS:
        run = dataset.sel(case=case)
        when, sizes = measure.peaks(run.time.values, run.angle.values, run.angular_velocity.values)
        rate, misfit = _line(when, np.log(sizes))
        found |= {
            f"rate_{case}": float(run.decay_rate),
            f"fit_{case}": -rate,
            f"exponential_{case}": misfit,
            f"power_{case}": _line(np.log(when), np.log(sizes))[1],
        }
    return found


def _line(x: Floats, logarithm: Floats) -> tuple[float, float]:
    """Return the slope of a straight line and its largest relative misfit after exponentiation."""
    slope, offset = np.polyfit(x, logarithm, 1)
    return float(slope), float(np.max(np.abs(np.expm1(slope * x + offset - logarithm))))
