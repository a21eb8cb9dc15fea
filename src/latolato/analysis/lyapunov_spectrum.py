"""Lyapunov exponents of one motion, through impacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import numpy as np

from latolato.analysis.registry import analyses, labelled
from latolato.analysis.starts import single_start, start_columns
from latolato.core.quantities import NON_NEGATIVE, Quantity
from latolato.observables.perturbations import LyapunovExponent, LyapunovSpectrum, SumRuleResidual
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED, checked_drive, checked_system

if TYPE_CHECKING:
    import xarray as xr

QUANTITIES = {
    **LyapunovExponent.variables,
    **LyapunovSpectrum.variables,
    **SumRuleResidual.variables,
    "divergence": Quantity("1/s", r"\langle\nabla f\rangle", "mean divergence of flow and impacts"),
    "exponent": Quantity("1", "", "number of the exponent"),
}


@analyses.register("lyapunov_spectrum", checked_system)
def lyapunov_spectrum(
    system: System,
    drive: Drive | None = None,
    *,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    duration: float = 1000.0,
    transient: Annotated[float | None, "s", NON_NEGATIVE] = None,
    contact: str | None = "exact",
    tolerance: float = 1e-9,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return all Lyapunov exponents [1/s] of the motion that a start leads to.

    Benettin, Galgani, Giorgilli & Strelcyn, Meccanica 15 (1980) 9; named ``lyapunovspectrum`` in
    DynamicalSystems.jl.

    Parameters
    ----------
    system, drive
        Any system and drive.
    duration, transient : float
        Time that is followed, and how much of it is left out at the beginning [s]; by default a
        tenth, at most 100 s.
    initial_angle, initial_angular_velocity, initial_offset, contact, tolerance, rest_speed
        As for `latolato.simulate`. Contact must not be clamped.

    Returns
    -------
    xarray.Dataset
        ``lyapunov_exponents`` over ``exponent``, largest first, 2 or 4; ``sum_rule_residual``,
        their sum minus ``divergence``, the mean divergence of the flow (-gamma for linear drag)
        plus ``2 f ln e`` at f impacts per second; ``rests``, how often the motion forgets its past
        because it rests or meets a wall without rebound, and ``exponent_between_rests``, the
        growth in the time between them, without rests the largest exponent; ``status``: ``regular``
        (the largest is below zero), ``chaotic`` (above zero by more than (5 + ln(w0 t))/t),
        ``marginal``, ``rest`` (exponents of minus infinity, even after a single rest) or why there
        is no answer.

    Raises
    ------
    InputError
        For a start inside a wall, clamped contact, a transient not below the duration.

    Notes
    -----
    The vectors are stretched by the exact derivative of the integrator's steps and made
    orthonormal after each. Convergence is as 1/time for regular and 1/sqrt(time) for chaotic
    motion: compare two durations. The exponent between rests begins again with one perturbation
    after each rest; where rests are not rare, it depends on which one. The same numbers as a
    map: ``latolato.sweep(..., observables=["lyapunov_exponent"])``.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    >>> shake = ll.Harmonic(drive_amplitude=0.15, drive_frequency=6.0)
    >>> result = lyapunov_spectrum(toy, shake, initial_angle=0.6, duration=300.0)
    >>> result.status.item(), abs(result.sum_rule_residual.item()) < 1e-12
    ('chaotic', True)
    """
    from latolato.sweeps import sweep

    if transient is None:
        transient = min(100.0, 0.1 * duration)
    drive = checked_drive(drive)
    start = single_start(system, initial_angle, initial_angular_velocity, initial_offset, contact)
    grid = sweep(
        system,
        drive,
        axes={"case": start_columns(system, start.angles, start.velocities)},
        duration=duration,
        transient=transient,
        contact=contact,
        tolerance=tolerance,
        rest_speed=rest_speed,
        observables=["lyapunov_exponent", "lyapunov_spectrum", "sum_rule_residual"],
    ).isel(case=0)
    exponents = grid.lyapunov_exponents.values
    residual = float(grid.sum_rule_residual)
    status = str(grid.status.item())
    total = float(np.sum(exponents))
    if np.all(np.isfinite(exponents)):
        # Neighbours on tori part linearly in time, and the vectors turn: ln(t)/t and 1/t.
        observed = duration - transient
        margin = (5.0 + math.log(max(observed * system.natural_frequency, 1.0))) / observed
        status = "marginal"
        if abs(exponents[0]) > margin:
            status = "regular" if exponents[0] < 0.0 else "chaotic"
    elif not np.any(np.isnan(exponents)):
        status = "rest"
    return labelled(
        {
            "lyapunov_exponents": ("exponent", exponents),
            "divergence": total - residual if math.isfinite(total) else total,
            "sum_rule_residual": residual,
            "exponent_between_rests": float(grid.exponent_between_rests),
            "rests": int(grid.rests) if math.isfinite(grid.rests) else math.nan,
            "status": status,
        },
        system=system,
        drive=drive,
        coordinates={"exponent": np.arange(1, len(exponents) + 1)},
        quantities=QUANTITIES,
        settings={"transient": transient},
    )
