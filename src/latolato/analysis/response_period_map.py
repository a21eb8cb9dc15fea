"""Maps of the response period, and the share of each class of motion with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import (
    AngleTolerance,
    LongestPeriod,
    TransientPeriods,
    check_no_repeat,
    checked_periodic,
)
from latolato.analysis.registry import analyses, labelled
from latolato.analysis.stroboscopic import QUANTITIES_HERE, settled_cases, wilson_interval
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, Quantity
from latolato.physics.drives import Drive, Harmonic, PeriodicDrive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED

if TYPE_CHECKING:
    import xarray as xr

_MAPPED = ("response_period", "rotation_number", "mirror_residual", "largest_angle_watched")


def _checked(system: System, drive: Drive | None) -> PeriodicDrive:
    """Return the drive that a map varies, by default a `Harmonic` one."""
    usual = Harmonic(drive_amplitude=0.0, drive_frequency=1.0)
    return checked_periodic(system, usual if drive is None else drive)


@analyses.register("response_period_map", _checked)
def response_period_map(
    system: System,
    drive: Drive | None = None,
    *,
    drive_amplitude: Annotated[Sequence[float], NON_NEGATIVE],
    frequency_ratio: Annotated[Sequence[float], POSITIVE],
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    transient_periods: TransientPeriods = 500.0,
    longest: LongestPeriod = 16,
    angle_tolerance: AngleTolerance = 1e-4,
    tolerance: float = 1e-6,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return the response period [1] over drive amplitude and frequency, and classes' shares [1].

    Stroboscopic map; intervals by Wilson (1927).

    Parameters
    ----------
    system, drive
        The laws; amplitude and frequency of the drive are replaced. None means a harmonic drive.
    drive_amplitude : sequence of float
        A0 [m], at least 0.
    frequency_ratio : sequence of float
        Driving over natural frequency, w/w0 [1], positive.
    initial_angle, initial_angular_velocity, initial_offset, tolerance, rest_speed
        As in `response_period`, the same for all cells.
    transient_periods : float
        Drive periods before the motion is watched, at least 0.
    longest : int
        Longest response period that is recognised, 1 to 64 drive periods; three times as many
        drive periods are watched.
    angle_tolerance : float
        Distance below which two samples agree [rad], in (0, 1].

    Returns
    -------
    xarray.Dataset
        ``response_period``, ``rotation_number``, ``mirror_residual``, ``largest_angle_watched``
        and ``status`` over (drive_amplitude, frequency_ratio), as in `response_period`.
        Over ``motion`` ("rest", "period 1", ... , "grazing", "aperiodic", "not settled", and
        "slackens" where it occurs): the number of ``cells``, their ``share`` of all cells with an
        answer and ``active_share`` of those not at rest, with the ends of 95 % intervals,
        ``share_low`` and so on.

    Raises
    ------
    InputError
        As `response_period`.

    Notes
    -----
    The intervals are those of as many cells drawn at random from the same region. Cells of a
    regular grid lie in patches of one motion, so that a share is mostly known better than its
    interval says; it depends on the region and on the start more than on either.
    Frequencies are run by octaves: every cell has at least `transient_periods` of transient, the
    faster ones up to twice that. See `response_period` for what it can miss.

    Examples
    --------
    >>> import latolato as ll
    >>> system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> result = response_period_map(
    ...     system, drive_amplitude=[0.05], frequency_ratio=[1.7, 2.0], initial_angle=0.1
    ... )
    >>> result.response_period.values
    array([[1., 2.]])
    """
    drive = _checked(system, drive)
    amplitudes, ratios = np.array(drive_amplitude), np.array(frequency_ratio)
    check_no_repeat("drive_amplitude", amplitudes)
    check_no_repeat("frequency_ratio", ratios)
    amplitude, ratio = np.broadcast_arrays(amplitudes[:, None], ratios)
    motion = settled_cases(
        system,
        drive,
        {"drive_amplitude": amplitude.ravel(), "frequency_ratio": ratio.ravel()},
        ratio.ravel() * system.natural_frequency,
        initial_angle=initial_angle,
        initial_angular_velocity=initial_angular_velocity,
        initial_offset=initial_offset,
        longest=longest,
        angle_tolerance=angle_tolerance,
        transient_periods=transient_periods,
        tolerance=tolerance,
        rest_speed=rest_speed,
    )
    result = {name: motion[name].reshape(ratio.shape) for name in (*_MAPPED, "status")}
    names, shares = shares_of(result["response_period"], result["status"], longest)
    dims = ("drive_amplitude", "frequency_ratio")
    return labelled(
        {name: (dims, values) for name, values in result.items()}
        | {name: (("motion",), values) for name, values in shares.items()},
        system=system,
        drive=drive,
        coordinates={"drive_amplitude": amplitudes, "frequency_ratio": ratios, "motion": names},
        quantities=QUANTITIES_HERE | _SHARES,
    )


_SHARES: dict[str, Quantity] = {
    "motion": Quantity("1", "", "class of motion"),
    "cells": Quantity("1", "N", "number of cells"),
    **{
        f"{head}share{end}": Quantity("1", "", f"share of {of}{text}")
        for head, of in (("", "all cells"), ("active_", "the cells not at rest"))
        for end, text in (("", ""), ("_low", ", low end"), ("_high", ", high end"))
    },
}


def shares_of(
    period: NDArray[Any], status: NDArray[Any], longest: int
) -> tuple[list[str], dict[str, NDArray[Any]]]:
    """Return the classes of motion, and their counts and shares with 95 % intervals."""
    masks = {"rest": status == "rest"}
    for p in range(1, longest + 1):
        masks[f"period {p}"] = (status == "periodic") & (period == p)
    others = ["grazing", "aperiodic", "not settled"]
    others += ["slackens"] if (status == "slackens").any() else []  # on strings only
    masks |= {name: status == name for name in others}
    cells = np.array([int(mask.sum()) for mask in masks.values()])
    shares: dict[str, NDArray[Any]] = {"cells": cells}
    active = np.where(np.arange(len(cells)) == 0, 0, cells)
    for head, counts in (("", cells), ("active_", active)):
        for end, values in zip(
            ("", "_low", "_high"), wilson_interval(counts, counts.sum()), strict=True
        ):
            if head:
                values[0] = np.nan  # rest is not active
            shares[f"{head}share{end}"] = values
    return list(masks), shares
