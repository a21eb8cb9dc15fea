"""Stability of the linearised driven pendulum (paper eq14) from Hill's infinite determinant."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from latolato.analysis.elliptic import checked_shaped
from latolato.analysis.hill import (
    LARGEST_CHARACTERISTIC_ROOT,
    LARGEST_MATHIEU_Q,
    Array,
    Number,
    characteristic_value,
    find_peak,
    find_root,
    first_rise,
    hill_determinant,
    own_instability,
)
from latolato.core.errors import InputError
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, Range
from latolato.core.registry import checked_count, checked_number
from latolato.physics.pendulum import GRAVITY, Mathieu


class MathieuParameters(NamedTuple):
    """Dimensionless parameters of the undamped linear equation.

    The first two belong to the standard form ``x'' + (a - 2 q cos 2z) x = 0``, where the paper
    writes b for q; the third is gamma of paper eq15.

    Examples
    --------
    >>> mathieu_parameters(drive_amplitude=0.05, drive_frequency=6.0).mathieu_q
    0.1
    """

    mathieu_a: float
    mathieu_q: float
    mathieu_strength: float


def mathieu_parameters(
    *, drive_amplitude: float, drive_frequency: float, length: float = 1.0, gravity: float = GRAVITY
) -> MathieuParameters:
    """Return a, q and the excitation strength of the undamped linear equation [1].

    Source: paper eq15 and the standard form above it.

    Parameters
    ----------
    drive_amplitude : float
        A0 [m], at least 0.
    drive_frequency : float
        Angular frequency w [rad/s], positive.
    length, gravity : float
        l [m] and g [m/s^2], positive.

    Returns
    -------
    MathieuParameters
        ``a = (2 w0/w)^2``, ``q = 2 A0/l``, ``gamma = A0 w^2/(2 g)``.

    Examples
    --------
    >>> a, q, strength = mathieu_parameters(drive_amplitude=0.05, drive_frequency=6.26)
    >>> print(f"{a:.6f} {q} {strength:.6f}")
    1.000316 0.1 0.099968
    """
    system, _ = _checked_system(length, None, 0.0, gravity)
    l, g = system.length, system.gravity
    A0 = checked_number("drive_amplitude", drive_amplitude, NON_NEGATIVE, "m")
    w = checked_number("drive_frequency", drive_frequency, POSITIVE, "rad/s")
    return MathieuParameters(4.0 * g / (l * w**2), 2.0 * A0 / l, A0 * w**2 / (2.0 * g))


def mathieu_growth_rate(
    *,
    drive_amplitude: ArrayLike,
    drive_frequency: ArrayLike,
    length: float = 1.0,
    mass: float | None = None,
    damping: float = 0.0,
    gravity: float = GRAVITY,
) -> Array:
    """Return the largest real part of the Floquet exponents of paper eq14 [1/s].

    Hill (1886), in the form of Whittaker & Watson, section 19.42, split by symmetry.

    Parameters
    ----------
    drive_amplitude, drive_frequency : array_like
        A0 [m], at least 0 and at most 25 l, and w [rad/s], positive; broadcast together.
    length, gravity : float
        l [m] and g [m/s^2], positive.
    mass, damping : float
        m [kg] and C [kg m/s]; the mass is needed only where there is damping.

    Returns
    -------
    ndarray
        Growth rate of the angle, of the broadcast shape; negative where the motion decays.

    Raises
    ------
    InputError
        For a parameter outside its range, or a drive slower than about a hundredth of w0.

    Notes
    -----
    ``theta = exp(-gamma t/2) x`` with ``gamma = C/(m l)`` removes the drag and leaves
    ``a = 4 (w0^2 - gamma^2/4)/w^2``. Of the multipliers ``exp(+-i pi nu)`` of x,
    ``S = sin^2(pi nu/2)`` and ``K = cos^2(pi nu/2)`` are products of two determinants each, and
    ``rate = (w/pi) asinh(sqrt(max(-S, -K, 0))) - gamma/2``.
    Error: below 1e-14 of w against 40 digits (``A0 <= 1.5 l``, ``a <= 30``). At an undamped edge
    the rate starts as a square root, so the last bit of w may show as 1e-8 there.

    Examples
    --------
    The rate of paper Fig. 13a:

    >>> rate = mathieu_growth_rate(
    ...     drive_amplitude=0.05, drive_frequency=6.26, length=1.0, mass=0.8, damping=0.05
    ... )
    >>> print(f"{rate:.5f}")
    0.12505
    """
    system, zeta = _checked_system(length, mass, damping, gravity)
    amplitude, frequency = np.broadcast_arrays(
        checked_shaped("drive_amplitude", drive_amplitude, NON_NEGATIVE, "m"),
        checked_shaped("drive_frequency", drive_frequency, POSITIVE, "rad/s"),
    )
    w0 = system.natural_frequency
    a = np.asarray(4.0 * (1.0 - zeta**2) * (w0 / frequency) ** 2)
    q = np.asarray(2.0 * amplitude / system.length)
    _require_range(a, q)
    growth = np.arcsinh(np.sqrt(np.maximum(_instability(a, q), 0.0)))
    return np.asarray(frequency / math.pi * growth - zeta * w0)


def mathieu_tongue_edges(
    *,
    drive_amplitude: float,
    length: float = 1.0,
    mass: float | None = None,
    damping: float = 0.0,
    gravity: float = GRAVITY,
    order: int = 1,
) -> tuple[float, float]:
    """Return the lower and upper frequency ratio w/w0 [1] between which paper eq14 is unstable.

    On an edge a Floquet multiplier is -1 (odd order) or +1 (even order); McLachlan (1947).

    Parameters
    ----------
    drive_amplitude : float
        A0 [m], at least 0 and at most 25 l.
    length, mass, damping, gravity
        As for `mathieu_growth_rate`.
    order : int
        The tongue n that starts from the ratio 2/n, at least 1.

    Returns
    -------
    low, high : float
        ``(nan, nan)`` where damping keeps the tongue closed at this amplitude, or the amplitude is
        so large that it holds no hanging pendulum any more (order 1: A0 > 3.8 l); ``high`` is
        infinite where no fast drive is stable (order 1: A0 > 0.454 l).

    Raises
    ------
    InputError
        For a parameter outside its range, or ``damping >= 2 m l w0`` (no oscillation to resonate).

    Notes
    -----
    Edges are the zeros of ``-K - sinh^2(gamma T/4)`` (odd) or ``-S - sinh^2(gamma T/4)`` (even),
    S and K as in `mathieu_growth_rate`, T the drive period; without damping those of the single
    determinants, so that narrow tongues keep their width. Error: below 1e-14. Tongues narrower than
    1e-15 cannot be resolved and are returned with equal edges, or closed if damped.

    Examples
    --------
    >>> low, high = mathieu_tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
    >>> print(f"{low:.6f} {high:.6f}")
    1.909946 2.107508
    """
    system, zeta = _checked_system(length, mass, damping, gravity)
    q = 2.0 * checked_number("drive_amplitude", drive_amplitude, NON_NEGATIVE, "m") / system.length
    order = checked_count("order", order, Range(1, LARGEST_CHARACTERISTIC_ROOT / 2))
    if zeta >= 1.0:
        raise InputError(
            f"must be below 2 m l w0 for a tongue to exist, got {system.damping:g} "
            f"({zeta:.3g} times that)",
            parameter="damping",
            way_out="use mathieu_growth_rate for overdamped cases",
        )
    _require_range(np.asarray(0.0), np.asarray(q))
    swing = math.sqrt(1.0 - zeta**2)

    def ratio(a: float) -> float:
        return 2.0 * swing / math.sqrt(a) if a > 0.0 else math.inf

    sine_edge, cosine_edge = (characteristic_value(order, q, even) for even in (False, True))
    cosine_edge = max(cosine_edge, sine_edge)  # where they differ by rounding errors only
    if cosine_edge <= 0.0:
        return math.nan, math.nan
    if zeta == 0.0 or q == 0.0:
        return (ratio(cosine_edge), ratio(sine_edge)) if zeta == 0.0 else (math.nan, math.nan)

    def excess(a: float) -> float:
        loss = math.sinh(math.pi * zeta * math.sqrt(a) / (2.0 * swing)) ** 2
        return float(own_instability(a, q, order % 2 == 1)) - loss

    start = max(sine_edge, 0.0)
    peak = find_peak(excess, start, cosine_edge)
    if excess(peak) <= 0.0:
        return math.nan, math.nan
    high = math.inf if sine_edge <= 0.0 else ratio(find_root(excess, start, peak))
    return ratio(find_root(excess, peak, cosine_edge)), high


def mathieu_threshold_amplitude(
    *,
    frequency_ratio: float = 2.0,
    length: float = 1.0,
    mass: float | None = None,
    damping: float = 0.0,
    gravity: float = GRAVITY,
    largest_amplitude_ratio: float = 1.0,
) -> float:
    """Return the smallest drive amplitude A0 [m] above which paper eq14 grows.

    At w = 2 w0 it is ``l gamma/(2 w0)`` to first order (Landau & Lifshitz, Mechanics, sec. 27).

    Parameters
    ----------
    frequency_ratio : float
        w/w0 [1], positive, w0 without damping.
    length, mass, damping, gravity
        As for `mathieu_growth_rate`.
    largest_amplitude_ratio : float
        The search ends at this A0/l [1], positive and at most 25.

    Returns
    -------
    float
        Threshold of whichever tongue is met first, ``nan`` if none is met.

    Raises
    ------
    InputError
        For a parameter outside its range.

    Notes
    -----
    Tongues are found from sign changes of the single determinants on a grid of 0.01 in A0/l, so
    also very narrow ones; missed are two zeros of the *same* determinant within one grid cell.

    Examples
    --------
    Paper Fig. 8 prints no amplitude; with its frequency growth needs at least

    >>> ratio = 10.09 / (9.8 / 0.363) ** 0.5
    >>> threshold = mathieu_threshold_amplitude(
    ...     frequency_ratio=ratio, length=0.363, mass=0.10804, damping=0.00274
    ... )
    >>> print(f"{1e3 * threshold:.2f} mm")
    11.39 mm
    """
    system, zeta = _checked_system(length, mass, damping, gravity)
    frequency_ratio = checked_number("frequency_ratio", frequency_ratio, POSITIVE, "1")
    largest_q = 2.0 * checked_number(
        "largest_amplitude_ratio", largest_amplitude_ratio, POSITIVE, "1"
    )
    a = 4.0 * (1.0 - zeta**2) / frequency_ratio**2
    _require_range(np.asarray(a), np.asarray(largest_q))
    loss = math.sinh(math.pi * zeta / frequency_ratio) ** 2

    def excess(q: float) -> float:
        return float(_instability(a, q)) - loss

    borders = _tongue_borders(a, largest_q)
    for left, right in pairwise(borders):
        if loss == 0.0:
            if excess(0.5 * (left + right)) > 0.0:
                return left * system.length / 2.0
            continue
        result = first_rise(excess, left, right)
        if not math.isnan(result):
            return result * system.length / 2.0
    return math.nan


def _checked_system(
    length: float, mass: float | None, damping: float, gravity: float
) -> tuple[Mathieu, float]:
    """Return the checked system and its damping ratio C/(2 m l w0) [1]."""
    if mass is None and damping != 0.0:
        raise InputError(
            f"must be given with damping {damping}: the drag rate is C/(m l)", parameter="mass"
        )
    # Without damping the mass drops out of eq14.
    m = 1.0 if mass is None else mass
    system = Mathieu(length=length, mass=m, damping=damping, gravity=gravity)
    m, l, C = system.mass, system.length, system.damping
    return system, C / (2.0 * m * l * system.natural_frequency)


def _require_range(a: Array, q: Array) -> None:
    """Refuse parameters for which the determinant would overflow or lose its accuracy."""
    if a.size and np.max(np.abs(a)) > LARGEST_CHARACTERISTIC_ROOT**2:
        raise InputError(
            "the drive is too slow or the damping too strong: |4 (w0^2 - gamma^2/4)/w^2| must be "
            f"at most {LARGEST_CHARACTERISTIC_ROOT**2:g}",
            value=float(np.max(np.abs(a))),
            way_out="raise drive_frequency (frequency_ratio of at least 0.01)",
        )
    if q.size and np.max(q) > LARGEST_MATHIEU_Q:
        raise InputError(
            f"must be at most {LARGEST_MATHIEU_Q / 2:g} length, got {np.max(q) / 2:g} length",
            parameter="drive_amplitude",
            way_out="lower drive_amplitude",
        )


def _instability(a: Number, q: Number) -> Number:
    """Return max(-S, -K): sinh^2 of half the growth of x per drive period where positive."""
    larger: Number = np.maximum(own_instability(a, q, True), own_instability(a, q, False))
    return larger


def _tongue_borders(a: float, largest_q: float) -> list[float]:
    """Return 0, every q below ``largest_q`` where one determinant changes sign, and largest_q."""
    grid = np.linspace(0.0, largest_q, 1 + math.ceil(largest_q / 0.02))
    borders = {0.0, largest_q}
    for is_odd in (True, False):
        for is_even_solution in (True, False):

            def value(q: Number, odd: bool = is_odd, even: bool = is_even_solution) -> Number:
                return hill_determinant(a, q, odd, even)

            values = np.asarray(value(grid))
            for i in np.flatnonzero(values[:-1] * values[1:] < 0.0):
                borders.add(find_root(value, float(grid[i]), float(grid[i + 1])))
    return sorted(borders)
