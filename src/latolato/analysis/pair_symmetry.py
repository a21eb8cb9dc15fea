"""Whether two equal balls stay mirror images: where the one-ball model of the toy is valid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from latolato.analysis.registry import analyses, labelled
from latolato.analysis.rules import broken_analysis
from latolato.analysis.starts import single_start
from latolato.core.quantities import NON_NEGATIVE
from latolato.observables import LargestAngleAfterTransient
from latolato.observables.perturbations import TransverseExponent
from latolato.physics.drives import Drive
from latolato.physics.pendulum import BallPair, LatoLato, System
from latolato.simulation.start import DEFAULT_REST_SPEED, checked_drive
from latolato.sweeps.statuses import has_answer

if TYPE_CHECKING:
    import xarray as xr

QUANTITIES = {
    **TransverseExponent.variables,
    **LargestAngleAfterTransient.variables,
}
# A departure that changes by less than this factor in the observed time decides nothing.
_FACTOR = np.exp(2.0)


def as_pair(system: LatoLato) -> BallPair:
    """Return the two balls that a mirror-symmetric pair stands for."""
    ball = system.balls[0]
    shared = {f.name: getattr(system, f.name) for f in fields(BallPair) if hasattr(system, f.name)}
    return BallPair(right=ball, left=ball, **shared)


def check_mirrored(system: System) -> None:
    """Raise InputError unless one ball stands for a mirror-symmetric pair."""
    if not isinstance(system, LatoLato):
        raise broken_analysis("mirror_symmetric", parameter="system", value=type(system).__name__)


@analyses.register("pair_symmetry", check_mirrored, checked_drive)
def pair_symmetry(
    system: LatoLato,
    drive: Drive | None = None,
    *,
    initial_angle: float | None = None,
    initial_angular_velocity: float = 0.0,
    initial_offset: float | None = None,
    drive_amplitude: Annotated[Sequence[float] | None, NON_NEGATIVE] = None,
    frequency_ratio: Annotated[Sequence[float] | None, NON_NEGATIVE] = None,
    duration: float = 300.0,
    transient: Annotated[float, "s", NON_NEGATIVE] = 50.0,
    tolerance: float = 1e-6,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return the growth rate [1/s] of small departures from the mirror-symmetric motion.

    The mean angle S of two equal balls obeys a Hill equation along the motion that they share,
    ``S'' + gamma S' + (g + y0'')/l cos(angle) S = 0`` (shared physics of paper eq10 and eq11).

    Parameters
    ----------
    system : LatoLato
        The one-ball model that is questioned; the motion is that of the two balls behind it.
    drive : Drive, optional
        Any drive.
    drive_amplitude, frequency_ratio : sequence of float, optional
        For a validity map: drive amplitudes [m] and frequency ratios [1].
    duration, transient : float
        Time that is followed, and how much of it is left out at the beginning [s].
    initial_angle, initial_angular_velocity, initial_offset, tolerance, rest_speed
        As for `latolato.simulate`; the start is the right ball's, the left one's is its image.

    Returns
    -------
    xarray.Dataset
        ``transverse_exponent``, ``largest_angle_after_transient`` and ``status`` over the varied
        parameters: ``valid`` (departures die out), ``broken`` (they grow: the one-ball model
        describes a motion that the toy leaves), ``undecided`` (less than a factor e^2 in the
        observed time) or why there is no answer.

    Raises
    ------
    InputError
        For another system than a `LatoLato`: only its motion has this symmetry.

    Notes
    -----
    Without drag no departure from a regular motion can die out, the rate is at least zero then. It
    is a rate of *small* departures along one motion; a finite push may lead elsewhere. The
    computed motion is kept symmetric: it is the one-ball model's, also where that is not what two
    balls do. A toy at
    rest swings under its pivot as one pendulum: in the tongue around the ratio 2 it leaves
    symmetry without a single impact.

    Examples
    --------
    Strong shaking makes the balls leave their mirror images:

    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02)
    >>> shake = ll.Harmonic(drive_amplitude=0.3, drive_frequency=9.0)
    >>> result = pair_symmetry(toy, shake, initial_offset=0.2, duration=100.0, transient=20.0)
    >>> result.status.item()
    'broken'
    """
    from latolato.sweeps import sweep

    driven = checked_drive(drive, system)
    start = single_start(system, initial_angle, initial_angular_velocity, initial_offset)
    angle, velocity = start.angles[0], start.velocities[0]
    optional = {"drive_amplitude": drive_amplitude, "frequency_ratio": frequency_ratio}
    axes: dict[str, Any] = {n: values for n, values in optional.items() if values is not None}
    varied = list(axes)
    grid = sweep(
        as_pair(system),
        driven if drive is not None or not axes else None,
        axes=axes or {"initial_angular_velocity_right": [velocity]},
        initial_angle=(angle, -angle),
        initial_angular_velocity=(velocity, -velocity),
        duration=duration,
        transient=transient,
        tolerance=tolerance,
        rest_speed=rest_speed,
        observables=["transverse_exponent", "largest_angle_after_transient"],
    )
    if not axes:
        grid = grid.isel(initial_angular_velocity_right=0)
    rate = grid.transverse_exponent.values
    growth = rate * (duration - transient)
    status = np.where(growth > np.log(_FACTOR), "broken", "undecided")
    status = np.where(growth < -np.log(_FACTOR), "valid", status)
    status = np.where(has_answer(grid.status), status, grid.status.values.astype(str))
    dims = tuple(varied)
    return labelled(
        {
            "transverse_exponent": (dims, rate),
            "largest_angle_after_transient": (
                dims,
                grid.largest_angle_after_transient.sel(ball="right").values,
            ),
            "status": (dims, status),
        },
        system=system,
        drive=drive,
        coordinates={name: grid[name].values for name in varied},
        quantities=QUANTITIES,
        settings={"initial_angle": angle, "initial_angular_velocity": velocity},
    )
