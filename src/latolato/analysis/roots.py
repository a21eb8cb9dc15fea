"""Zeros and maxima of functions of one variable."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np


def find_root(function: Callable[[float], float], left: float, right: float) -> float:
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
