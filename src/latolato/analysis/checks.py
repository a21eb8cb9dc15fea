"""What several analyses check before they begin."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, QUANTITIES, Range
from latolato.core.registry import checked_number
from latolato.physics.drives import Drive, PeriodicDrive
from latolato.physics.drives.base import check_increasing, checked_array
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
    name: str,
    values: Any,
    allowed: Range = NON_NEGATIVE,
    *,
    default: Any = None,
    quantity: str = "",
    least: int = 1,
) -> Floats:
    """Return numbers along an axis, each of them checked; one number is an axis of one."""
    values = default if values is None else values
    several = values if np.ndim(values) else [values]
    unit = QUANTITIES[quantity or name].unit
    return np.array(checked_array(name, several, allowed, least, unit=unit))


def checked_increasing(
    name: str, values: Any, allowed: Range, *, default: Any, quantity: str = "", least: int = 1
) -> Floats:
    """Return numbers as `checked_values` does, each larger than the one before."""
    result = checked_values(name, values, allowed, default=default, quantity=quantity, least=least)
    check_increasing(name, tuple(result))
    return result
