"""What several analyses check before they begin."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.rules import broken_analysis
from latolato.core.errors import name_gap
from latolato.core.quantities import POSITIVE, Range
from latolato.core.registry import check_increasing, checked_number
from latolato.observables.period import LONGEST
from latolato.physics.drives import Drive, PeriodicDrive, PlanarHarmonic, drives
from latolato.physics.pendulum import System
from latolato.simulation.start import checked_drive, checked_system

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
        raise broken_analysis("settling_motion", parameter="system")
    return system


def checked_periodic(system: System, drive: Drive | None) -> PeriodicDrive:
    """Return a drive with a period, under which the motion of a system settles."""
    checked_nonlinear(system)
    result = checked_vertical(drive)
    checked_number("drive_frequency", result.drive_frequency, POSITIVE, "rad/s")
    return result


def checked_vertical(drive: Drive | None) -> PeriodicDrive:
    """Return a drive that repeats itself and moves the pivot up and down only."""
    check_vertical(drive)
    return _periodic(drive)


def _periodic(drive: Drive | None) -> PeriodicDrive:
    """Return a drive that repeats itself."""
    checked_drive(drive)
    if not isinstance(drive, PeriodicDrive):
        name = "none" if drive is None else drives.name_of(drive)
        raise broken_analysis("repeating_drive", parameter="drive", value=name)
    return drive


def check_vertical(drive: Drive | None) -> None:
    """Raise InputError for a drive that moves the pivot sideways."""
    if checked_drive(drive).moves_across:
        raise broken_analysis("vertical_drive", parameter="drive", value=type(drive).__name__)


def checked_repeating(system: System, drive: Drive | None) -> PeriodicDrive | PlanarHarmonic:
    """Return a drive that repeats itself and suits a system."""
    if isinstance(drive, PlanarHarmonic):
        checked_drive(drive, checked_system(system))
        return drive
    return _periodic(drive)


def check_rods(system: System) -> None:
    """Raise InputError for strings where a motion is carried on by its angle and velocity."""
    if checked_system(system).suspension == "string":
        raise broken_analysis("continued_rods", parameter="suspension", value=system.suspension)


def check_drag(system: System) -> None:
    """Raise InputError for drag relative to the room, which closed forms leave out."""
    if checked_system(system).drag_frame == "lab" and any(ball.damping for ball in system.balls):
        raise broken_analysis("drag_of_pivot", parameter="drag_frame", value=system.drag_frame)


def hits_pull(system: System) -> bool:
    """Return whether a hit pulls at the strings of both balls, or at none.

    The ball on the shorter string is driven inwards if ``|l1^2 - l2^2| > (r1 + r2)^2``.
    """
    right, left = system.balls[0], system.balls[-1]
    return abs(right.length**2 - left.length**2) < (right.radius + left.radius) ** 2 or (
        right.length == left.length
    )


def check_span(low: float, high: float, kind: str = "", *, of: str = "") -> None:
    """Raise InputError unless the second limit is larger.

    `kind` begins the names of both; of several limits these are those of the parameter `of`.
    """
    if low < high:
        return
    if of:
        raise broken_analysis("low_to_high_of", {"name": name_gap(of)}, parameter="low", value=low)
    names = {"high": name_gap(f"{kind}high")}
    raise broken_analysis("low_to_high", names, parameter=f"{kind}low", value=low)


def check_no_repeat(name: str, values: Floats) -> None:
    """Raise InputError for a value that is given twice."""
    known, counts = np.unique(values, return_counts=True)
    if (counts > 1).any():
        repeated = float(known[counts > 1][0])
        raise broken_analysis("no_repeat", parameter=name, value=repeated)


def increasing(name: str, values: Any, default: Floats) -> Floats:
    """Return values along an axis, each larger than the one before."""
    result: Floats = default if values is None else values
    check_increasing(name, tuple(result))
    return result
