"""Stroboscopic Poincare sections at any phase of the drive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import numpy as np

from latolato.analysis.checks import TransientPeriods, checked_periodic
from latolato.analysis.registry import analyses, labelled
from latolato.analysis.rules import broken_analysis
from latolato.core.quantities import Quantity, Range
from latolato.observables.period import wrapped
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.simulation.record import ON_STRINGS
from latolato.simulation.run import simulate
from latolato.simulation.start import DEFAULT_REST_SPEED

if TYPE_CHECKING:
    import xarray as xr


@analyses.register("poincare_section", checked_periodic)
def poincare_section(
    system: System,
    drive: Drive | None = None,
    *,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    section_phase: Annotated[float, "rad"] = 0.0,
    periods: Annotated[int, Range(1, 1_000_000)] = 1000,
    transient_periods: TransientPeriods = 500.0,
    tolerance: float = 1e-9,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return angle [rad] and angular velocity [rad/s] once per drive period, at one drive phase.

    Poincare surface of section (``poincaresos``) or stroboscopic map of DynamicalSystems.jl
    (Datseris, 2018).

    Parameters
    ----------
    system, drive
        The laws; the drive must have one period (harmonic or crank slider).
    section_phase : float
        Phase of the drive at which the state is read [rad]: ``w t + drive_phase`` modulo
        2 pi. At 0 a harmonic pivot is at its top.
    periods : int
        Points of the section, 1 to 1000000.
    transient_periods : float
        Drive periods before the first point, at least 0.
    initial_angle, initial_angular_velocity, initial_offset, tolerance, rest_speed
        As for `latolato.simulate`.

    Returns
    -------
    xarray.Dataset
        ``angle`` modulo 2 pi, in [-pi, pi), and ``angular_velocity`` over ``time`` (and ``ball``),
        with ``status``, that of the run; points after its end are NaN. On strings also
        ``distance``, ``radial_velocity`` and ``slack``, without which a slack ball is not known.

    Raises
    ------
    InputError
        For bad input, a drive without a period, and the linearised pendulum.

    Notes
    -----
    Points are read from the solution's dense output, whose error is that of the run. A periodic
    motion of response period p shows p points, a quasiperiodic one closed curves, a chaotic one
    a fractal set. In chaotic motion single points cannot be trusted, only their distribution.
    At rest all points are one.

    Examples
    --------
    >>> import latolato as ll
    >>> system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
    >>> section = poincare_section(system, drive, initial_angle=0.1, periods=4)
    >>> abs(section.angle.values).round(3)
    array([0.091, 0.091, 0.091, 0.091])
    """
    drive = checked_periodic(system, drive)
    lead = ((section_phase - drive.drive_phase) / math.tau) % 1.0
    first = math.ceil(transient_periods - lead)
    numbers = np.arange(first, first + periods, dtype=np.float64)
    times = np.asarray((numbers + lead) * (math.tau / drive.drive_frequency), dtype=np.float64)
    if periods == 1 and times[0] == 0.0:
        raise broken_analysis("points_of_section")
    run = simulate(
        system,
        drive,
        initial_angle=initial_angle,
        initial_angular_velocity=initial_angular_velocity,
        initial_offset=initial_offset,
        times=times,
        tolerance=tolerance,
        rest_speed=rest_speed,
    )
    dims = ("ball", "time") if system.angles == 2 else ("time",)
    return labelled(
        {
            "angle": (dims, wrapped(run["angle"].values)),
            "angular_velocity": (dims, run["angular_velocity"].values),
            **{name: (dims, run[name].values) for name in ON_STRINGS if name in run},
            "status": str(run.attrs["status"]),
        },
        system=system,
        drive=drive,
        coordinates={"time": times},
        quantities={"status": Quantity("1", "", "status of the run")},
    )
