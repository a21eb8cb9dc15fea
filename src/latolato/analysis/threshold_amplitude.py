"""The smallest drive that makes hanging straight down unstable."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from latolato.analysis.linear import (
    RATIOS,
    check_linear,
    checked_template,
    linearised,
    threshold,
    waveform_of,
)
from latolato.analysis.registry import analyses, labelled, warn
from latolato.core.quantities import POSITIVE
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System

if TYPE_CHECKING:
    import xarray as xr


@analyses.register("threshold_amplitude", check_linear, checked_template)
def threshold_amplitude(
    system: System,
    drive: Drive | None = None,
    *,
    frequency_ratio: Annotated[float, RATIOS] = 2.0,
    order: int | None = None,
    largest_amplitude_ratio: Annotated[float, POSITIVE] = 1.0,
) -> xr.Dataset:
    """Return the smallest drive amplitude A0 [m] above which hanging straight down is unstable.

    At w = 2 w0 it is ``l gamma/(2 w0)`` to first order (Landau & Lifshitz, Mechanics, sec. 27).

    Parameters
    ----------
    system : Pendulum, Mathieu, LatoLato or BallPair
        Balls with a radius have no hanging position; for them see `self_start`.
    drive : PeriodicDrive, optional
        Supplies the waveform; by default a cosine. Its amplitude and frequency are not used.
    frequency_ratio : float
        Driving over natural frequency, w/w0 [1], at least 0.01.
    order : int, optional
        Only this tongue; by default whichever is met first.
    largest_amplitude_ratio : float
        The search ends at this A0/l [1], positive, and at 0.95 of a crank's connecting rod.

    Returns
    -------
    xarray.Dataset
        ``drive_amplitude`` [m] and ``status``: "found", "none" (NaN), or "slackens" (NaN: the
        string of a ball that hangs still goes slack at a weaker drive).

    Raises
    ------
    InputError
        As `tongue_edges`.

    Notes
    -----
    The edges of the undamped tongues are followed on a grid of 0.01 in A0/l, and the growth inside
    them is compared with the drag. Missed is a tongue that is entered and left within one grid
    cell. Error: 1e-14 of l under a cosine.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.Pendulum(length=0.363, mass=0.10804, damping=0.00274)
    >>> result = ll.analysis.threshold_amplitude(toy, frequency_ratio=10.09 / toy.natural_frequency)
    >>> print(f"{1e3 * result.drive_amplitude:.2f} mm")
    11.39 mm
    """
    problem = linearised(system, drive)
    largest = min(largest_amplitude_ratio * problem.length, problem.largest_amplitude)
    amplitude = threshold(problem, frequency_ratio, largest, order)
    status = "none" if math.isnan(amplitude) else "found"
    if problem.slackens(frequency_ratio * problem.natural_frequency, amplitude):
        amplitude, status = math.nan, "slackens"
        warn("slack_threshold", ratio=frequency_ratio)
    if status == "none":
        warn("no_threshold", largest=largest_amplitude_ratio, ratio=frequency_ratio)
    return labelled(
        {"drive_amplitude": amplitude, "status": status},
        system=system,
        settings=waveform_of(problem.template),
    )
