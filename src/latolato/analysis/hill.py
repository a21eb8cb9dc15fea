"""Hill's infinite determinant of the Mathieu equation, to the last digits.

``x'' + (a - 2 q cos 2z) x = 0`` has the multipliers ``exp(+-i pi nu)``. Whittaker & Watson, section
19.42, give ``sin^2(pi nu/2)`` as one determinant that converges slowly and has poles at
``a = 4, 16, ...``. Here the rows are divided so that it has none, the even and odd solutions are
parted, ``cos^2(pi nu/2)`` gets a pair of its own, and the tail beyond a harmonic is summed.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Number = float | Array

# Outside these limits the intermediate products of the determinant leave the range of float64.
LARGEST_CHARACTERISTIC_ROOT = 200.0
LARGEST_MATHIEU_Q = 50.0


def own_instability(a: Number, q: Number, is_odd: bool) -> Number:
    """Return -cos^2(pi nu/2) for odd tongues, -sin^2(pi nu/2) for even ones."""
    scale = 1.0 if is_odd else math.pi**2 / 4.0
    return -scale * hill_determinant(a, q, is_odd, True) * hill_determinant(a, q, is_odd, False)


def hill_determinant(a: Number, q: Number, is_odd: bool, is_even_solution: bool) -> Number:
    """Return one of Hill's four determinants, rows divided by minus the squared harmonic.

    Harmonics are 1, 3, 5, ... or (0), 2, 4, ...; the solution is a cosine (even) or a sine series.
    """
    if is_odd:
        harmonic = 1
        before, now = 1.0 + 0.0 * a, 1.0 - a + (q if is_even_solution else -q)
    elif is_even_solution:
        harmonic = 2
        before, now = a + 0.0 * q, a * (1.0 - a / 4.0) + q**2 / 2.0
    else:
        harmonic = 2
        before, now = 1.0 + 0.0 * a, 1.0 - a / 4.0 + 0.0 * q
    reach = float(np.max(np.sqrt(np.abs(a)))) if np.size(a) else 0.0
    # The tail below is of third order in (reach/last)^2 and of first order in q^2/last^3: both
    # leave less than 1e-15.
    last = 2 * math.ceil(100.0 + 5.0 * reach + 30.0 * float(np.max(q, initial=0.0)))
    while harmonic < last:
        harmonic += 2
        coupling = (q / (harmonic * (harmonic - 2))) ** 2
        before, now = now, (1.0 - a / harmonic**2) * now - coupling * before
    complete: Number = now * np.exp(_log_tail(a, q, harmonic))
    return complete


def _log_tail(a: Number, q: Number, last: int) -> Number:
    """Return the logarithm of the rest of the determinant beyond the harmonic ``last``."""
    from scipy.special import zeta as hurwitz

    powers = np.arange(1, 9)
    diagonal = 0.0 * a
    for j, total in zip(powers, hurwitz(2 * powers, last / 2.0 + 1.0), strict=True):
        diagonal = diagonal - (a / 4.0) ** j * (total / j)
    # 1/((h^2-a)((h+2)^2-a)) in powers of 1/(h+1), summed over h = last, last+2, ...
    fourth, sixth, eighth = (hurwitz(p, (last + 1) / 2.0) / 2.0**p for p in (4, 6, 8))
    coupling = fourth + 2.0 * (1.0 + a) * sixth + (4.0 * (1.0 + a) ** 2 - (1.0 - a) ** 2) * eighth
    tail: Number = diagonal - q**2 * coupling
    return tail


def characteristic_value(order: int, q: float, is_even_solution: bool) -> float:
    """Return Mathieu's a_n(q) (even solution) or b_n(q) (odd solution)."""
    from scipy.linalg import eigvalsh_tridiagonal

    is_odd = order % 2 == 1
    size = order // 2 + 12 + math.ceil(2.0 * math.sqrt(q))
    lowest = 1 if is_odd else (0 if is_even_solution else 2)
    diagonal = (lowest + 2.0 * np.arange(size)) ** 2
    beside = np.full(size - 1, q)
    if is_odd:
        diagonal[0] += q if is_even_solution else -q
    elif is_even_solution:
        beside[0] *= math.sqrt(2.0)
    index = (order - lowest) // 2
    chosen = {"select": "i", "select_range": (index, index)}
    guess = float(eigvalsh_tridiagonal(diagonal, beside, **chosen)[0])
    # The eigenvalue is good to 1e-16 of the largest diagonal element only: polish it.
    width = 1e-8 * max(1.0, abs(guess))

    def value(a: float) -> Number:
        return hill_determinant(a, q, is_odd, is_even_solution)

    return find_root(value, guess - width, guess + width)


def find_root(function: Callable[[float], Number], left: float, right: float) -> float:
    """Return the zero of a function of opposite signs at both ends (Brent)."""
    from scipy.optimize import brentq

    return float(brentq(function, left, right, xtol=1e-300, rtol=9e-16, maxiter=200))


def find_peak(function: Callable[[float], float], left: float, right: float) -> float:
    """Return the place of the maximum of a function with one hump in between."""
    from scipy.optimize import minimize_scalar

    if not left < right:  # a tongue narrower than a rounding
        return 0.5 * (left + right)
    result = minimize_scalar(
        lambda x: -function(x), bounds=(left, right), method="bounded", options={"xatol": 1e-14}
    )
    return float(result.x)


def first_rise(excess: Callable[[float], float], left: float, right: float) -> float:
    """Return the first point of an interval at which a function rises above zero, NaN without one.

    It is sampled at 33 points; a hump between samples is followed to its top.
    """
    samples = [float(x) for x in np.linspace(left, right, 33)]
    values = [excess(x) for x in samples]
    best = max(range(33), key=values.__getitem__)
    if values[best] <= 0.0:
        peak = find_peak(excess, samples[max(best - 1, 0)], samples[min(best + 1, 32)])
        samples, values = [left, peak], [values[0], excess(peak)]
    first = next((i for i in range(1, len(values)) if values[i] > 0.0), None)
    if first is None:
        return math.nan
    if values[first - 1] >= 0.0:  # a loss below rounding
        return left
    return find_root(excess, samples[first - 1], samples[first])
