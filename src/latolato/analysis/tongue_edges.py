"""The edges of the instability tongues of hanging or standing, for any periodic drive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from latolato.analysis.linear import (
    check_linear,
    check_oscillates,
    checked_template,
    linearised,
    tongue,
    waveform_of,
)
from latolato.analysis.registry import analyses, labelled, warn
from latolato.core.quantities import NON_NEGATIVE, Quantity, Range
from latolato.core.registry import checked_count
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System

if TYPE_CHECKING:
    import xarray as xr

_LARGEST_ORDER = 100
QUANTITIES_OF_EDGES = {
    "low": Quantity("1", r"\omega_{low}/\omega_0", "lower edge of the tongue"),
    "high": Quantity("1", r"\omega_{high}/\omega_0", "upper edge of the tongue"),
}


@analyses.register("tongue_edges", check_linear, checked_template)
def tongue_edges(
    system: System,
    drive: Drive | None = None,
    *,
    drive_amplitude: Annotated[float, NON_NEGATIVE],
    order: Annotated[int, Range(0, _LARGEST_ORDER)] = 1,
    position: Literal["hanging", "inverted"] = "hanging",
    method: Literal["determinant", "monodromy"] = "determinant",
) -> xr.Dataset:
    """Return the frequency ratios w/w0 [1] between which hanging straight down is unstable.

    Hill (1886): an edge is where the motion is periodic (even orders) or antiperiodic (odd).

    Parameters
    ----------
    system : Pendulum, Mathieu, LatoLato or BallPair
        Balls with a radius have no hanging position, for they touch before.
    drive : PeriodicDrive, optional
        Supplies the waveform; by default a cosine. Its amplitude and frequency are not used.
    drive_amplitude : float
        A0 [m], at least 0.
    order : int
        The tongue n that starts from the ratio 2/n; 0, of the inverted position, is the region
        below Kapitza's limit, where the drive is too slow to hold the pendulum upright.
    position : {"hanging", "inverted"}
        Where the pendulum is.
    method : {"determinant", "monodromy"}
        By Hill's determinant, or by the map over one period by quadrature, as a check.

    Returns
    -------
    xarray.Dataset
        ``low`` and ``high`` [1] and ``status``: "found", "no upper edge" (high is infinite: no
        fast drive is stable), "closed" (both NaN: the drag keeps the tongue closed at this
        amplitude, or the tongue holds no pendulum in this position), or "slackens" (a ball that
        hangs still on its string falls behind the pivot before this edge, which is NaN).

    Raises
    ------
    InputError
        For bad input, balls with a radius or a restitution below 1, Coulomb friction, which holds
        every ball near the position, drag relative to the room, and balls that stand on strings.

    Notes
    -----
    The determinant of the (anti)periodic Fourier system with drag, whose harmonics are doubled
    until nothing changes by more than 1e-12. Error: below 1e-14 under a cosine. The monodromy
    agrees to 1e-12 where the tongue is wider than 1e-3, and loses as the width shrinks, for it sees
    its square. Quadratic drag has no linear part and does not matter here. A string is a rod as
    long as the downward acceleration of the pivot stays below gravity.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> edges = ll.analysis.tongue_edges(toy, drive_amplitude=0.05)
    >>> print(f"{edges.low:.8f} {edges.high:.8f}")
    1.90994630 2.10750817
    """
    problem = linearised(system, drive, position)
    if position == "hanging":
        checked_count("order", order, Range(1, _LARGEST_ORDER))
        check_oscillates(problem)
    if drive_amplitude == 0.0:
        low, high = _edges_at_rest(order, problem.side, problem.damping)
    else:
        low, high = tongue(problem, drive_amplitude, order, method)
    status = "closed" if math.isnan(low) else "no upper edge" if math.isinf(high) else "found"
    w0 = problem.natural_frequency
    if any(problem.slackens(edge * w0, drive_amplitude) for edge in (low, high)):
        low = math.nan if problem.slackens(low * w0, drive_amplitude) else low
        high, status = math.nan, "slackens"
        warn("slack_tongue", amplitude=drive_amplitude)
    if status == "closed":
        warn("closed_tongue", order=order, amplitude=drive_amplitude)
    return labelled(
        {"low": low, "high": high, "status": status},
        system=system,
        quantities=QUANTITIES_OF_EDGES,
        settings=waveform_of(problem.template),
    )


def _edges_at_rest(order: int, side: float, damping: float) -> tuple[float, float]:
    """Return the edges without drive: the tip of a tongue."""
    if side < 0.0:
        return (0.0, math.inf) if order == 0 else (math.nan, math.nan)
    return (2.0 / order, 2.0 / order) if damping == 0.0 else (math.nan, math.nan)
