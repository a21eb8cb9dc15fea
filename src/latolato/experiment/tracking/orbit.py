"""The circle on which balls run about a pivot that moves: fitted to places in the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from latolato.experiment.calibration.circle_fit import CircleFit, fit_circle

# Frequencies of a drive that are tried [Hz], finely enough for half a radian over the clip.
_SLOWEST, _FASTEST, _FINENESS = 0.3, 12.0, 8
_MOST_TRIALS = 3000
# Fewest places that make a circle, and a circle about a driven pivot.
_FEWEST, _FEWEST_DRIVEN = 12, 24
# How much smaller residuals must be for a pivot to be driven.
_BETTER = 0.5
# Distance beyond which places are mistakes, and the least error of one [pixels].
_MISTAKEN, _LEAST = 1.0, 0.3


@dataclass(frozen=True)
class Orbit:
    """A circle about a moving pivot.

    Attributes
    ----------
    centre : numpy.ndarray, shape (2,)
        The pivot at the first time, column and row [pixels].
    arm : float
        Radius of the circle [pixels].
    residual : float
        Median distance of the places from it [pixels].
    vague : float
        Standard deviation of the centre, as a share of the arm.
    shifts : numpy.ndarray, shape (time, 2)
        How far the pivot is from `centre` [pixels].
    """

    centre: np.ndarray
    arm: float
    residual: float
    vague: float
    shifts: np.ndarray


def circle(places: list[np.ndarray], shifts: np.ndarray) -> Orbit | None:
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
    return _orbit(fit_circle(lambda: points, 1.0, robust=_MISTAKEN), shifts)


def driven_circle(places: list[np.ndarray], times: np.ndarray) -> Orbit | None:
    """Return the circle of places about a pivot that moves as one harmonic, None for too few.

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
    best: Orbit | None = None
    for _, frequency, solution in candidates[:4]:
        a, b = 0.5 * solution[3], 0.5 * solution[4]

        def pivot(
            at: np.ndarray, a: float, b: float, turns: float, lean: float, span: float = span
        ) -> np.ndarray:
            lift = a * np.cos(turns * at / span) + b * np.sin(turns * at / span)
            return np.stack([lift * math.sin(lean), lift * math.cos(lean)], axis=-1)

        fit = fit_circle(
            lambda *p: points - pivot(t, *p), 1.0, robust=_MISTAKEN,
            extra=[scale * a, scale * b, frequency * span, 0.0],
        )  # fmt: skip
        way = pivot(times - times[0], *fit.extra)
        orbit = _orbit(fit, way - way[0], way[0])
        if best is None or orbit.residual < best.residual:
            best = orbit
    return best


def better(still: Orbit | None, driven: Orbit | None) -> Orbit | None:
    """Return the circle about a pivot at rest, unless one about a driven pivot fits far better."""
    if still is None or driven is None:
        return still or driven
    return driven if driven.residual < _BETTER * still.residual else still


def _orbit(fit: CircleFit, shifts: np.ndarray, first: np.ndarray | float = 0.0) -> Orbit:
    """Return a circle about a pivot that is off its middle by `first` in the beginning."""
    residual = float(np.median(np.abs(fit.distances)))
    error = math.sqrt(float(np.trace(fit.covariance[:2, :2]))) * max(residual, _LEAST)
    return Orbit(fit.centre + first, fit.arm, residual, error / fit.arm, shifts)
