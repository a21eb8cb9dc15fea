"""Numbers read off a motion: its peaks, its beats, its growth from period to period."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# A beat whose largest peak exceeds the settled peaks by less is not seen.
VISIBLE_BEAT = 1.005


def peaks(time: Floats, angle: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
    """Return times [s] and sizes [rad] of the turning points, where |angle| is largest.

    Parameters
    ----------
    time, angle, angular_velocity : ndarray, shape (time,)
        A smooth motion, with several samples per swing.

    Notes
    -----
    Between samples the angle is the cubic that has both samples' angles and velocities; the error
    is of fourth order in their spacing (1e-6 of the angle for 50 samples per swing).
    """
    outward = np.where(angle >= 0.0, angular_velocity, -angular_velocity)
    index = np.flatnonzero((outward[:-1] > 0.0) & (outward[1:] <= 0.0))
    h = time[index + 1] - time[index]
    x0, x1 = angle[index], angle[index + 1]
    v0, v1 = angular_velocity[index] * h, angular_velocity[index + 1] * h
    # x = x0 + v0 s + b s^2 + a s^3 with s in [0, 1]; its slope is zero at the turning point.
    a, b = 2.0 * (x0 - x1) + v0 + v1, 3.0 * (x1 - x0) - 2.0 * v0 - v1
    root = np.sqrt(np.maximum(b * b - 3.0 * a * v0, 0.0))
    # The root within the interval, written so that nothing cancels.
    s = np.clip(v0 / -(b - np.sign(v0) * root), 0.0, 1.0)
    return time[index] + s * h, np.abs(x0 + s * (v0 + s * (b + s * a)))


def beats(times: Floats, sizes: Floats) -> tuple[Floats, Floats]:
    """Return times [s] and sizes [rad] of the peaks that are larger than both neighbours."""
    inner = np.flatnonzero((sizes[1:-1] > sizes[:-2]) & (sizes[1:-1] >= sizes[2:])) + 1
    return times[inner], sizes[inner]


def first_above(x: Floats, values: Floats, level: float) -> float:
    """Return the x at which `values` first exceed `level`, interpolated linearly, or NaN."""
    above = np.flatnonzero(values > level)
    if above.size == 0:
        return float("nan")
    i = int(above[0])
    if i == 0:
        return float(x[0])
    part = (level - values[i - 1]) / (values[i] - values[i - 1])
    return float(x[i - 1] + part * (x[i] - x[i - 1]))


def growth_per_period(
    time: Floats, angle: Floats, *, samples_per_period: int, first: float, last: float
) -> tuple[float, float]:
    """Return growth rate [1/s] and sign of the factor by which an angle grows per drive period.

    Parameters
    ----------
    time, angle : ndarray, shape (time,)
        Samples at fixed parts of the drive period.
    samples_per_period : int
        Samples per drive period.
    first, last : float
        Stretch of time that is used [s]; the fastest growing part must prevail in it.
    """
    strobe = np.arange(0, len(time), samples_per_period)
    strobe = strobe[(time[strobe] >= first) & (time[strobe] <= last)]
    t, x = time[strobe], angle[strobe]
    slope = np.polyfit(t - t[0], np.log(np.abs(x)), 1)[0]
    return float(slope), float(np.sign(np.median(x[1:] / x[:-1])))
