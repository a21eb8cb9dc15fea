"""What several analyses check before they begin."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, Range
from latolato.core.registry import checked_number
from latolato.physics.drives import Drive, PeriodicDrive
from latolato.physics.pendulum import System
from latolato.simulation.start import checked_periodic_drive, checked_system

Floats = NDArray[np.float64]

_TRANSIENTS = Range(0.0, 1e7)


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


def checked_transient(transient_periods: Any) -> float:
    """Return a transient in drive periods."""
    return checked_number("transient_periods", transient_periods, _TRANSIENTS, "drive periods")


def checked_span(name: str, low: Any, high: Any, unit: str) -> tuple[float, float]:
    """Return two limits of which the second is larger."""
    first, last = (checked_number(f"{name} limit", each, Range(), unit) for each in (low, high))
    if not first < last:
        raise InputError(
            f"must go from low to high, got {first:g} to {last:g}",
            parameter=name,
            way_out="swap them",
        )
    return first, last


def checked_values(
    name: str, values: Any, unit: str, allowed: Range = NON_NEGATIVE, *, default: Any = None
) -> Floats:
    """Return numbers along an axis, each of them checked; one number is an axis of one."""
    values = default if values is None else values
    if isinstance(values, (str, bytes)) or np.ndim(values) > 1 or np.size(values) == 0:
        raise InputError(f"must be a sequence of numbers in {unit}", parameter=name, value=values)
    several = values if np.ndim(values) else [values]
    return np.array([checked_number(name, value, allowed, unit) for value in several])


def checked_increasing(
    name: str, values: Any, unit: str, allowed: Range, *, default: Any, least: int = 1
) -> Floats:
    """Return so many numbers or more along an axis, each larger than the one before."""
    result = checked_values(name, values, unit, allowed, default=default)
    if len(result) < least or np.any(np.diff(result) <= 0.0):
        raise InputError(
            f"must be {least} or more values that increase", parameter=name, way_out="sort them"
        )
    return result
