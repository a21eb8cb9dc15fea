"""The circle on which balls run about a pivot that moves: fitted to places in the picture."""

from __future__ import annotations

import math

import numpy as np

from latolato.experiment.calibration.circle_fit import CircleFit, fit_circle

# Frequencies of a drive that are tried [Hz], finely enough for half a radian over the clip.
_SLOWEST, _FASTEST, _FINENESS = 0.3, 12.0, 8
_MOST_TRIALS = 3000
# Fewest places that make a circle, and a circle about a driven pivot.
_FEWEST, _FEWEST_DRIVEN = 12, 24
# How much smaller residuals must be for a pivot to be driven.
_BETTER = 0.5
# Distance beyond which places are mistakes [pixels].
_MISTAKEN = 1.0


def circle(places: list[np.ndarray], shifts: np.ndarray) -> CircleFit | None:
    """Return the circle of places about a pivot whose shifts are known, None for too few.

    Parameters
    ----------
    places : list of numpy.ndarray, shape (ball, 2)
        Centres of the balls at each time [pixels].
    shifts : numpy.ndarray, shape (time, 2)
        Of the pivot from where it is first [pixels].
    """
    points = np.concatenate([group - shifts[k] for k, group in enumerate(places)])
    if len(points) < _FEWEST:
        return None
    return fit_circle(lambda: points, 1.0, robust=_MISTAKEN)


def driven_circle(places: list[np.ndarray], times: np.ndarray) -> CircleFit | None:
    """Return the circle of places about a pivot that moves as one harmonic, None for too few.

    Its centre is the pivot at the first time.

    With the pivot at ``v0 + p(t)`` the equation of the circle is linear in the pivot's place, its
    amplitudes and their products, for each trial frequency; the best is polished.
    """
    count = [len(group) for group in places]
    points = np.concatenate(places)
    if len(points) < _FEWEST_DRIVEN:
        return None
    t = np.repeat(times - times[0], count)
    middle = points.mean(axis=0)
    scale = max(float(np.std(points)), 1.0)
    u, v = ((points - middle) / scale).T
    squares = u * u + v * v
    span = max(float(t.max()), 1e-9)
    number = int(min(_FINENESS * span * (_FASTEST - _SLOWEST), _MOST_TRIALS))
    candidates = []
    for frequency in 2.0 * math.pi * np.linspace(_SLOWEST, _FASTEST, max(number, 50)):
        cos, sin = np.cos(frequency * t), np.sin(frequency * t)
        columns = np.column_stack(
            [u, v, np.ones_like(u), v * cos, v * sin, cos, sin, cos * cos - sin * sin, cos * sin]
        )
        solution = np.linalg.lstsq(columns, squares, rcond=None)[0]
        left = float(np.median(np.abs(columns @ solution - squares)))
        candidates.append((left, float(frequency), solution))
    candidates.sort(key=lambda one: one[0])
    best: CircleFit | None = None
    for _, frequency, solution in candidates[:4]:
        a, b = 0.5 * solution[3], 0.5 * solution[4]

        def about(a: float, b: float, turns: float, lean: float) -> np.ndarray:
            phase = turns * t / span
            lift = a * (np.cos(phase) - 1.0) + b * np.sin(phase)
            return points - np.stack([lift * math.sin(lean), lift * math.cos(lean)], axis=-1)

        fit = fit_circle(
            about, 1.0, robust=_MISTAKEN, extra=[scale * a, scale * b, frequency * span, 0.0]
        )
        if best is None or fit.residual < best.residual:
            best = fit
    return best


def better(still: CircleFit | None, driven: CircleFit | None) -> CircleFit | None:
    """Return the circle about a pivot at rest, unless one about a driven pivot fits far better."""
    if still is None or driven is None:
        return still or driven
    return driven if driven.residual < _BETTER * still.residual else still
