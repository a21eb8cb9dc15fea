"""What several analyses check before they begin."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.core.quantities import POSITIVE, Range
from latolato.core.registry import checked_number
from latolato.observables.period import LONGEST
from latolato.physics.drives import Drive, PeriodicDrive
from latolato.physics.drives.base import check_increasing
from latolato.physics.pendulum import System
from latolato.simulation.start import checked_periodic_drive, checked_system

Floats = NDArray[np.float64]

# Drive periods before a motion is watched.
TransientPeriods = Annotated[float, Range(0.0, 1e7)]
# The longest response period that is recognised [drive periods].
LongestPeriod = Annotated[int, Range(1, LONGEST)]
# A distance at which motions are still taken for one [rad].
AngleTolerance = Annotated[float, "rad", Range(0.0, 1.0, open_low=True)]


def checked_nonlinear(system: System) -> System:
    """Return a system whose motion settles."""
    if checked_system(system).is_linear:
        raise InputError(
            "must have motion that settles, but that of the linearised Mathieu only grows or "
            "decays",
            parameter="system",
            way_out="use Pendulum, or mathieu_growth_rate",
        )
    return system


def checked_periodic(system: System, drive: Drive | None) -> PeriodicDrive:
    """Return a drive with a period, under which the motion of a system settles."""
    checked_nonlinear(system)
    result = checked_periodic_drive(drive)
    checked_number("drive_frequency", result.drive_frequency, POSITIVE, "rad/s")
    return result


def check_span(name: str, low: float, high: float) -> None:
    """Raise InputError unless the second limit is larger."""
    if not low < high:
        raise InputError(
            "must go from low to high", parameter=name, value=(low, high), way_out="swap them"
        )


def increasing(name: str, values: Any, default: Floats) -> Floats:
    """Return values along an axis, each larger than the one before."""
    result: Floats = default if values is None else values
    check_increasing(name, tuple(result))
    return result
