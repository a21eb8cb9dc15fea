"""How fast a small motion about hanging or standing grows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

from latolato.analysis.linear import SLOWEST, check_linear, checked_template, linearised
from latolato.analysis.registry import analyses, labelled
from latolato.analysis.rules import broken_analysis
from latolato.core.quantities import Quantity
from latolato.physics.drives import Drive, FixedPivot, PeriodicDrive
from latolato.physics.pendulum import System
from latolato.simulation.start import checked_drive

if TYPE_CHECKING:
    import xarray as xr


def _template_of(drive: Drive | None) -> PeriodicDrive:
    """Return the drive whose waveform is meant; a `Harmonic` one for a pivot at rest."""
    return checked_template(drive if checked_drive(drive).moves else None)


@analyses.register("growth_rate", check_linear, _template_of)
def growth_rate(
    system: System,
    drive: Drive | None = None,
    *,
    position: Literal["hanging", "inverted"] = "hanging",
    method: Literal["determinant", "monodromy"] = "determinant",
) -> xr.Dataset:
    """Return the growth rate of a small motion about hanging or standing upright [1/s].

    The largest real part of the Floquet exponents of paper eq14; Hill (1886).

    Parameters
    ----------
    system : Pendulum, Mathieu, LatoLato or BallPair
        Balls with a radius have no hanging position, for they touch before.
    drive : PeriodicDrive, optional
        The drive; None is a pivot at rest.
    position : {"hanging", "inverted"}
        Where the pendulum is.
    method : {"determinant", "monodromy"}
        By Hill's method, or by the map over one period by quadrature, as a check.

    Returns
    -------
    xarray.Dataset
        ``growth_rate`` [1/s], negative where the motion decays, and ``largest_multiplier`` [1], the
        factor by which the motion grows in one drive period (NaN without a drive).

    Raises
    ------
    InputError
        As `tongue_edges`; also for a drive slower than a hundredth of w0, and where the string of a
        ball that hangs still goes slack.

    Notes
    -----
    ``angle = exp(-gamma t/2) z`` takes the drag out. The growth rate of z is the drag that would
    just hold it: a zero of Hill's determinant, with as many harmonics as the band edges need to
    settle. Error: below 1e-14 of w under a cosine; at an undamped edge, where the rate starts as a
    square root, 1e-8 of w.

    Examples
    --------
    The rate of paper Fig. 13a:

    >>> import latolato as ll
    >>> toy = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
    >>> print(f"{ll.analysis.growth_rate(toy, drive).growth_rate:.5f}")
    0.12505
    """
    is_static = not checked_drive(drive).moves
    problem = linearised(system, _template_of(drive), position)
    template: Any = problem.template
    w0, zeta = problem.natural_frequency, problem.damping_ratio
    w, amplitude = template.drive_frequency, template.drive_amplitude
    if is_static or w == 0.0 or amplitude == 0.0:
        rest = zeta**2 - problem.side
        rate = w0 * (math.sqrt(max(rest, 0.0)) - zeta)
        w = math.nan if is_static or w == 0.0 else w
    elif w < SLOWEST * w0:
        raise broken_analysis(
            "slowest_drive",
            {"share": SLOWEST, "frequency": w0},
            parameter="drive_frequency",
            value=w,
        )
    elif problem.slackens(w, amplitude):
        raise broken_analysis(
            "taut_hanging", {"frequency": w}, parameter="drive_amplitude", value=amplitude
        )
    else:
        rate = problem.growth(w, amplitude, method)
    drive = FixedPivot() if is_static else template
    return labelled(
        {"growth_rate": rate, "largest_multiplier": math.exp(rate * math.tau / w)},
        system=system,
        drive=drive,
        quantities={
            "largest_multiplier": Quantity("1", r"|\rho|", "growth in one drive period"),
        },
    )
