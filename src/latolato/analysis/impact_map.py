"""The impact map: drive phase and velocity of each impact, one after the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis.checks import TransientPeriods, checked_periodic
from latolato.analysis.registry import analyses, labelled
from latolato.analysis.rules import broken_analysis
from latolato.core.errors import Word
from latolato.core.quantities import Quantity
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.simulation.run import simulate
from latolato.simulation.start import DEFAULT_REST_SPEED

if TYPE_CHECKING:
    import xarray as xr


def check_walls(system: System) -> None:
    """Raise InputError for a system without walls."""
    if not system.has_contacts:
        raise broken_analysis("walls_of_map", {"law": Word(type(system).__name__)})


@analyses.register("impact_map", checked_periodic, check_walls)
def impact_map(
    system: System,
    drive: Drive | None = None,
    *,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    periods: int = 1000,
    transient_periods: TransientPeriods = 500.0,
    tolerance: float = 1e-9,
    rest_speed: float = DEFAULT_REST_SPEED,
    contact_limit: int = 1_000_000,
) -> xr.Dataset:
    """Return the drive phase [rad] at successive impacts, and the angular velocity [rad/s] after.

    The map of a ball bouncing on a table, Holmes (1982); a Poincare section on the walls.

    Parameters
    ----------
    system, drive
        The laws; the system must have walls or two balls, the drive one period.
    periods : int
        Drive periods that are watched.
    transient_periods : float
        Drive periods before, at least 0.
    contact_limit : int
        Contacts after which the run stops, with a status.
    initial_angle, initial_angular_velocity, initial_offset, tolerance, rest_speed
        As for `latolato.simulate`.

    Returns
    -------
    xarray.Dataset
        Over ``impact``: ``impact_time`` [s], ``impact_phase`` of the drive, ``w t + drive_phase``
        modulo 2 pi [rad], ``angular_velocity_after`` [rad/s] (of two balls the opening speed),
        ``impact_side`` ("bottom" or "top"). ``impacts_per_period`` [1]; ``rests``, how often the
        balls came to rest in contact meanwhile, and ``status``: "complete", "no impacts", or that
        of a run that ended early.

    Raises
    ------
    InputError
        For bad input, a system without walls, a drive without a period.

    Notes
    -----
    Impact times are located on the solution, within its error. A cascade that ends at rest has
    infinitely many impacts; those down to `rest_speed` are listed, and their number grows with
    its logarithm. Grazing shows as points that come near velocity 0 without rest. On strings balls
    may meet while slack, nearer to the pivot: phase and velocity do not tell the whole state then.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=0.245, mass=0.106, radius=0.02, damping=0.005, restitution=0.9)
    >>> drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0)
    >>> result = impact_map(toy, drive, initial_offset=0.2, periods=3)
    >>> result.impacts_per_period.item(), result.impact_phase.values.round(2)
    (1.0, array([5.91, 5.91, 5.91]))
    """
    drive = checked_periodic(system, drive)
    period = math.tau / drive.drive_frequency
    begin, end = transient_periods * period, (transient_periods + periods) * period
    run = simulate(
        system,
        drive,
        initial_angle=initial_angle,
        initial_angular_velocity=initial_angular_velocity,
        initial_offset=initial_offset,
        times=[end],
        tolerance=tolerance,
        rest_speed=rest_speed,
        contact_limit=contact_limit,
    )
    kind = run["contact_kind"].values.astype(str)
    late = run["contact_time"].values >= begin
    keep = late & np.isin(kind, ["bottom", "top"])
    time = run["contact_time"].values[keep]
    after = run["angular_velocity_after"].values
    if system.angles == 2:
        after = after[0] - after[1]
    phase = (drive.drive_frequency * time + drive.drive_phase) % math.tau
    status = str(run.attrs["status"])
    if status == "complete" and not time.size:
        status = "no impacts"
    return labelled(
        {
            "impact_phase": (("impact",), phase),
            "angular_velocity_after": (("impact",), after[keep]),
            "impact_side": (("impact",), kind[keep]),
            "impact_time": (("impact",), time),
            "impacts_per_period": time.size / periods,
            "rests": int((late & (kind == "rest")).sum()),
            "status": status,
        },
        system=system,
        drive=drive,
        coordinates={"impact": np.arange(time.size)},
        quantities={
            "impact": Quantity("1", "j", "number of the impact"),
            "impact_phase": Quantity("rad", r"\varphi_j", "drive phase at impact"),
            "impact_time": Quantity("s", "t_j", "time of impact"),
            "impact_side": Quantity("1", "", "side of impact"),
            "impacts_per_period": Quantity("1", "N_c", "impacts per drive period"),
            "rests": Quantity("1", "", "times that contact became lasting"),
        },
    )
