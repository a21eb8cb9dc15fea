"""How long free swings last: an analysis as it would lie in `latolato/analysis`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np

from latolato.analysis.elliptic import undriven_period
from latolato.analysis.registry import analyses, labelled
from latolato.core.quantities import POSITIVE, Quantity
from latolato.physics.pendulum import System

if TYPE_CHECKING:
    import xarray as xr


@analyses.register("swing_time")
def swing_time(
    system: System, *, largest_angle: Annotated[float, POSITIVE] = 1.0, swings: int = 5
) -> xr.Dataset:
    """Return how long free swings last over the angle that they reach [s].

    Parameters
    ----------
    system : Pendulum
        What swings, its drag left out.
    largest_angle : float
        The widest swing [rad].
    swings : int
        How many swings are looked at.

    Returns
    -------
    xarray.Dataset
        ``swing_time`` [s] over ``largest_angle``.
    """
    angles = np.linspace(0.0, largest_angle, swings + 1)[1:]
    length = system.balls[0].length
    times = [
        undriven_period(initial_angle=a, length=length, gravity=system.gravity) for a in angles
    ]
    return labelled(
        {"swing_time": ("largest_angle", times)},
        system=system,
        coordinates={"largest_angle": angles},
        quantities={"swing_time": Quantity("s", "T", "time of a swing")},
    )
