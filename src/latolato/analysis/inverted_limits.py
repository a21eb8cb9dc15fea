"""Between which drive amplitudes a pendulum stands upright (Kapitza)."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated

from latolato.analysis.linear import (
    RATIOS,
    Linear,
    check_linear,
    checked_template,
    linearised,
    waveform_of,
)
from latolato.analysis.registry import analyses, labelled, warn
from latolato.analysis.roots import find_root
from latolato.core.quantities import POSITIVE, Quantity
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System

if TYPE_CHECKING:
    import xarray as xr

# The search begins at this share of Kapitza's limit and goes on in these steps.
_BEGIN, _STEP = 0.2, 1.1
_SCALE = 1.3


@analyses.register("inverted_limits", partial(check_linear, position="inverted"), checked_template)
def inverted_limits(
    system: System,
    drive: Drive | None = None,
    *,
    frequency_ratio: Annotated[float, RATIOS],
    largest_amplitude_ratio: Annotated[float, POSITIVE] = 2.0,
) -> xr.Dataset:
    """Return the drive amplitudes [m] between which standing upright is stable.

    Stephenson (1908); for a fast drive the lower limit tends to ``sqrt(2) l w0/w`` (Kapitza 1951).

    Parameters
    ----------
    system : Pendulum, LatoLato or BallPair
        Balls with a radius have no upright position, for they touch before.
    drive : PeriodicDrive, optional
        Supplies the waveform; by default a cosine. Its amplitude and frequency are not used.
    frequency_ratio : float
        Driving over natural frequency, w/w0 [1], at least 0.01.
    largest_amplitude_ratio : float
        The search ends at this A0/l [1], positive, and at 0.95 of a crank's connecting rod.

    Returns
    -------
    xarray.Dataset
        ``low`` and ``high`` [m] and ``status``: "found", "no upper limit" (high is NaN: not
        reached within the search) or "never stable" (both NaN).

    Raises
    ------
    InputError
        As `tongue_edges`; a `Mathieu` system has no inverted position.

    Notes
    -----
    Below `low` the pendulum falls over: a multiplier passes +1. Above `high` it swings about the
    upright position with twice the drive's period: a multiplier passes -1. Both are zeros of
    Hill's determinants with drag, as in `tongue_edges`; under a cosine without drag they are
    Mathieu's a_0 and b_1 at ``a = -4 (w0/w)^2``. Sought in steps of 10 %. Error: 1e-12 of l.

    Examples
    --------
    >>> import latolato as ll
    >>> rod = ll.Pendulum(length=1.0, mass=0.8)
    >>> limits = ll.analysis.inverted_limits(rod, frequency_ratio=20.0)
    >>> print(f"{limits.low:.6f} {limits.high:.6f}; Kapitza {2**0.5 / 20.0:.6f}")
    0.070788 0.458219; Kapitza 0.070711
    """
    problem = linearised(system, drive, "inverted")
    largest = min(largest_amplitude_ratio * problem.length, problem.largest_amplitude)
    low, high = _limits(problem, 1.0 / frequency_ratio, largest)
    status = (
        "never stable" if math.isnan(low) else "no upper limit" if math.isnan(high) else "found"
    )
    if status != "found":
        warn("no_lower_limit" if math.isnan(low) else "no_upper_limit", largest=largest)
    return labelled(
        {"low": low, "high": high, "status": status},
        system=system,
        quantities={
            "low": Quantity("m", "A_{low}", "least amplitude that holds it upright"),
            "high": Quantity("m", "A_{high}", "largest amplitude that holds it upright"),
        },
        settings=waveform_of(problem.template),
    )


def _limits(problem: Linear, slowness: float, largest: float) -> tuple[float, float]:
    """Return the lower and the upper limit [m]; NaN where not found."""

    def excess(amplitude: float, is_odd: bool) -> float:
        # Their number is settled once for all amplitudes up to the next of a coarse scale.
        above = _SCALE ** math.ceil(math.log(amplitude) / math.log(_SCALE))
        harmonics = problem.harmonics(min(above, problem.largest_amplitude), is_odd, 3)
        return problem.excess(slowness, amplitude, is_odd, harmonics)

    def falls(amplitude: float) -> float:
        return excess(amplitude, False)

    def swings(amplitude: float) -> float:
        return excess(amplitude, True)

    def grows(amplitude: float) -> float:
        return max(falls(amplitude), swings(amplitude))

    left = _BEGIN * math.sqrt(2.0) * slowness * problem.length
    low = math.nan
    while left < largest:
        right = min(left * _STEP, largest)
        if math.isnan(low):
            if falls(right) < 0.0:
                low = find_root(falls, left, right)
                if swings(low) > 0.0:
                    return math.nan, math.nan
                if grows(right) > 0.0:
                    return low, find_root(swings, low, right)
        elif grows(right) > 0.0:
            return low, find_root(grows, left, right)
        left = right
    return low, math.nan
