"""The circle on which balls run about a pivot that moves: fitted to places in the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

# Frequencies of a drive that are tried [Hz], finely enough for half a radian over the clip.
_SLOWEST, _FASTEST, _FINENESS = 0.3, 12.0, 8
_MOST_TRIALS = 3000
# Fewest places that make a circle, and a circle about a driven pivot.
_FEWEST, _FEWEST_DRIVEN = 12, 24
# How much smaller residuals must be for a pivot to be driven.
_BETTER = 0.5


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
    middle = points.mean(axis=0)
    away = points - middle
    # x^2 + y^2 = 2 a x + 2 b y + c is linear.
    columns = np.column_stack([2.0 * away, np.ones(len(away))])
    a, b, c = np.linalg.lstsq(columns, (away**2).sum(axis=1), rcond=None)[0]
    start = np.array([a, b, math.sqrt(max(c + a * a + b * b, 1.0))])

    def rest(p: np.ndarray) -> np.ndarray:
        return np.asarray(np.hypot(away[:, 0] - p[0], away[:, 1] - p[1]) - p[2])

    p, residual, vague = _polished(rest, start)
    return Orbit(p[:2] + middle, abs(p[2]), residual, vague, shifts)


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
        cu, cv = 0.5 * solution[0], 0.5 * solution[1]
        a, b = 0.5 * solution[3], 0.5 * solution[4]
        arm = math.sqrt(max(float(np.median((u - cu) ** 2 + (v - cv) ** 2)), 0.01))
        start = np.array([cu, cv, arm, a, b, frequency * span, 0.0])

        def pivot(p: np.ndarray, at: np.ndarray) -> np.ndarray:
            phase = p[5] * at / span
            lift = p[3] * np.cos(phase) + p[4] * np.sin(phase)
            return np.stack([p[0] + lift * math.sin(p[6]), p[1] + lift * math.cos(p[6])], axis=-1)

        def rest(p: np.ndarray) -> np.ndarray:
            at = pivot(p, t)
            return np.asarray((np.hypot(u - at[:, 0], v - at[:, 1]) - p[2]) * scale)

        p, residual, vague = _polished(rest, start)
        if best is None or residual < best.residual:
            way = pivot(p, times - times[0])
            best = Orbit(
                way[0] * scale + middle,
                abs(p[2]) * scale,
                residual,
                vague,
                (way - way[0]) * scale,
            )
    return best


def better(still: Orbit | None, driven: Orbit | None) -> Orbit | None:
    """Return the circle about a pivot at rest, unless one about a driven pivot fits far better."""
    if still is None or driven is None:
        return still or driven
    return driven if driven.residual < _BETTER * still.residual else still


def _polished(rest: object, start: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Return parameters, median residual, and the relative error of the centre (the first two)."""
    from scipy.optimize import least_squares

    fit = least_squares(rest, start, loss="soft_l1", f_scale=1.0, x_scale="jac", max_nfev=60)
    residual = float(np.median(np.abs(rest(fit.x))))  # type: ignore[operator]
    normal = fit.jac.T @ fit.jac
    sizes = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    spread = np.linalg.pinv(normal / np.outer(sizes, sizes), rcond=1e-14) / np.outer(sizes, sizes)
    error = math.sqrt(float(spread[0, 0] + spread[1, 1])) * max(residual, 0.3)
    return fit.x, residual, error / abs(float(fit.x[2]))
