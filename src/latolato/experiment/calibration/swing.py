"""Gravity by a swing: its direction, and its strength over the length.

The equation of motion about a moving pivot, averaged over windows of the clip, is a clock and a
plumb line. No drive needs to be known, and contacts of two equal balls cancel in their sum.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

# Half widths of windows, in the time in which the phase of the fastest swing grows by 1: the widest
# of which there are enough; windows begin a quarter of that apart.
_WIDTHS, _FEWEST, _APART = (3.0, 2.2, 1.5, 1.0), 6, 0.25
# Half width for one of two balls, which is free between contacts only.
_ALONE = 1.5
# Share of angles and speeds that are below those of the fastest swing.
_LARGEST = 0.98
# How much larger than the scatter from frame to frame a swing must be.
_CLEAR = 3.0
# Longest time between samples of a window, in typical ones.
_GAP = 4.5
# Share of the size of sines below which they cancel.
_CANCELS = 0.02
# Share of the response to a fast drive that even three frames in its period do not resolve.
_UNRESOLVED = 0.1
# What the equation may leave over, as a share of the accelerations.
_LEFT_OVER = 0.02


class Motion(NamedTuple):
    """What was seen of balls and pivot.

    `times` (frame,) [s], `angles` (frame, ball) from down [rad], NaN where unknown, `pivots`
    (frame, 2) to the right and up [arms], and which angles are those of a ball that `is_free`: only
    rod and air act on it, (frame, ball).
    """

    times: np.ndarray
    angles: np.ndarray
    pivots: np.ndarray
    is_free: np.ndarray


class Swing(NamedTuple):
    """What a swing tells, each with its standard deviation.

    `direction` of gravity from what angles are measured from [rad], `stiffness`, gravity over
    length in the clip's time [1/s^2], whose deviation is infinite where nothing tells it.
    """

    direction: float
    direction_sigma: float
    stiffness: float
    stiffness_sigma: float


def fit_swing(motion: Motion, axis: float | None = None) -> Swing | None:
    """Return what a swing shows of gravity, None if it is no swing of a pendulum.

    Parameters
    ----------
    motion : Motion
        What was seen.
    axis : float, optional
        Direction of a drive that is vertical, as it was seen [rad]. The pivot then moves along
        gravity, wherever that is found. What was seen of it across the axis is an error, for the
        wall draws a pivot aside; to the equation it would be a push.

    Notes
    -----
    ``a'' + y'' sin(a) + x'' cos(a) = -k sin(a - d) - c a'`` with the pivot's place (x, y) to the
    right and up, in arms, gravity's direction d, and drag c; each term is averaged with weights
    ``(1 - u^2)^2`` of the time u (the weak form of Messenger and Bortz, SIAM Multiscale Model.
    Simul. 19 (2021) 1474). Differences of slopes make the accelerations, so uneven time stamps do
    no harm. Windows are of one ball, or of the sum of two, in which contacts cancel, and of each of
    them where it is free. It can miss a swing of which no half is seen in one piece, and mistake a
    ball swung by hand for one that swings freely.
    """
    from scipy.optimize import least_squares

    if axis is not None:
        up = np.array([-math.sin(axis), math.cos(axis)])
        motion = motion._replace(pivots=np.outer(motion.pivots @ up, up))
    rows = next(
        (each for each in (windows(motion, width) for width in _WIDTHS) if len(each) >= _FEWEST),
        None,
    )
    if rows is None:
        return None
    _, bend, push, turned, sine, cosine, speed, pull, response = rows.T

    def rest(p: np.ndarray) -> np.ndarray:
        c, s = math.cos(p[0]), math.sin(p[0])
        lean = 0.0 if axis is None else p[0] - axis
        driven = math.cos(lean) * push + math.sin(lean) * turned
        return np.asarray(bend + driven + p[1] * (c * sine - s * cosine) + p[2] * speed)

    # A hand may hold the ball for a while: of all windows and each half, what explains most begins.
    half, starts = len(rows) // 2, []
    for part in (slice(None), slice(half), slice(half, None)):
        a, b, drag = np.linalg.lstsq(-rows[part, 4:7], (bend + push)[part], rcond=None)[0]
        turn = math.atan2(-b, max(a, 1e-3 * abs(b)))
        starts.append(np.array([turn, math.hypot(a, b), drag]))
    known = min(starts, key=lambda p: float(np.median(np.abs(rest(p)))))
    bounds = [-0.5 * math.pi, 0.0, -math.inf], [0.5 * math.pi, math.inf, math.inf]
    for _ in range(4):
        scale = 3.0 * float(np.median(np.abs(rest(known)))) + 1e-12
        fit = least_squares(rest, known, loss="cauchy", f_scale=scale, bounds=bounds)
        known = fit.x
    direction, stiffness, _ = known
    weights = 1.0 / (1.0 + (rest(known) / scale) ** 2)
    squares = float(np.sum(weights * rest(known) ** 2))
    # Windows overlap: of four, one counts.
    spread = np.linalg.pinv(fit.jac.T @ fit.jac) * squares / max(_APART * len(rows) - 3.0, 1.0)
    shift = np.linalg.pinv(fit.jac) @ (np.sqrt(weights) * response)
    sigmas = np.hypot(np.sqrt(np.diag(spread)), _UNRESOLVED * shift)
    is_explained = squares < float(np.sum(weights * (_LEFT_OVER * stiffness * pull) ** 2))
    if not (is_explained and stiffness > sigmas[1]):
        return None
    # Sines of two balls that mirror each other, or rest against each other, cancel: they show where
    # down is, but fit any gravity.
    tells = np.abs(sine) > _CANCELS * pull
    unsure = float(sigmas[1]) if tells.sum() >= _FEWEST else math.inf
    return Swing(float(direction), float(sigmas[0]), float(stiffness), unsure)


def windows(motion: Motion, width: float) -> np.ndarray:
    """Return the terms of the equation in windows in order of time, shape (window, 9).

    They are the time of its middle, the angular acceleration, what a moving pivot adds to it, and
    would add if it moved a quarter turn to the left of that, sine and cosine of the angle, the
    speed, the size of the sine, and which part of what the pivot adds is the ball's response to a
    fast drive. Half a window is as long as the phase of the fastest swing needs to grow by a
    `width`.
    """
    times, angles, unit = motion.times, motion.angles, _unit(motion)
    if unit == 0.0:
        return np.empty((0, 9))
    steps = np.diff(times)
    sine, cosine = np.sin(angles), np.cos(angles)
    # A difference of slopes is what a hat of two steps averages, and the terms are averaged alike.
    accelerations = _accelerations(times, motion.pivots)
    push, response = _pushes(steps, motion.pivots, accelerations, (cosine, sine))
    turned, _ = _pushes(steps, motion.pivots, accelerations, (sine, -cosine))
    speed = 0.5 * (angles[2:] - angles[:-2])
    sine, cosine, size = (_under_hats(steps, each) for each in (sine, cosine, np.abs(sine)))
    bend = _bends(steps, angles)
    terms = np.stack([bend, push, turned, sine, cosine, speed, size, response], axis=-1)
    is_even = np.maximum(steps[1:], steps[:-1]) < _GAP * float(np.median(steps))
    known = np.isfinite(terms).all(axis=-1) & is_even[:, None]
    free = known & motion.is_free[2:] & motion.is_free[1:-1] & motion.is_free[:-2]
    inner = times[1:-1]
    parts = [_averages(inner, terms.sum(axis=1), known.all(axis=1), width * unit)]
    if angles.shape[1] == 2:
        half = min(width, _ALONE) * unit
        parts += [_averages(inner, terms[:, b], free[:, b], half) for b in (0, 1)]
    rows = np.concatenate(parts)
    return rows[np.argsort(rows[:, 0], kind="stable")]


def _bends(steps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return by how much slopes differ before and after each inner frame, (frame - 2, column)."""
    return np.diff(np.diff(values, axis=0) / steps[:, None], axis=0)


def _pushes(
    steps: np.ndarray, pivots: np.ndarray, bends: np.ndarray, cosines: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return what the pivot's acceleration adds under each hat, and the ball's response in it.

    `bends` (frame, 2) are the accelerations to the right and up, `cosines` (frame, ball) how much
    of them counts. The difference of the pivot's slopes times the middle's cosine is right for slow
    drives, and errors of both places cancel in it. It leaves out that within a hat the cosine
    varies with the acceleration: that is the response.
    """
    pushes = responses = np.zeros((len(steps) - 1, cosines[0].shape[1]))
    for axis, cosine in enumerate(cosines):
        place, bend, middle = pivots[:, axis, None], bends[:, axis, None], cosine[1:-1]
        pushes = pushes + _bends(steps, place) * middle
        responses = responses + _under_hats(steps, bend * cosine)
        responses = responses - _under_hats(steps, bend) * middle
    return pushes + responses, responses


def _under_hats(steps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return integrals of values (frame, column) times a hat about each inner frame.

    The hat falls from 1 to 0 at both neighbours, `steps` (frame - 1,) away. Values are taken as a
    parabola through the three frames: Numerov's weights 1, 10 and 1 where steps are even.
    """
    before, after = steps[:-1, None], steps[1:, None]
    first = (before**2 + before * after - after**2) / (12.0 * before)
    last = (after**2 + before * after - before**2) / (12.0 * after)
    middle = 0.5 * (before + after) - first - last
    return np.asarray(first * values[:-2] + middle * values[1:-1] + last * values[2:])


def _accelerations(times: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return second derivatives of places (frame, 2) by splines through each piece without gaps."""
    from scipy.interpolate import CubicSpline

    out = np.full_like(places, np.nan)
    known = np.flatnonzero(np.isfinite(places).all(axis=1))
    gap = _GAP * float(np.median(np.diff(times)))
    for piece in np.split(known, np.flatnonzero(np.diff(times[known]) >= gap) + 1):
        if len(piece) > 1:
            out[piece] = CubicSpline(times[piece], places[piece])(times[piece], 2)
    return out


def _averages(times: np.ndarray, terms: np.ndarray, ok: np.ndarray, half: float) -> np.ndarray:
    """Return times and weighted sums of terms (frame, term) in windows of frames that are ok."""
    rows = []
    for middle in np.arange(times[0] + half, times[-1] - half, _APART * half):
        near = slice(*np.searchsorted(times, [middle - half, middle + half]))
        if near.stop - near.start >= 3 and ok[near].all():
            weight = (1.0 - ((times[near] - middle) / half) ** 2) ** 2
            rows.append([middle, *(weight @ terms[near])])
    return np.array(rows).reshape(-1, 1 + terms.shape[1])


def _unit(motion: Motion) -> float:
    """Return the time in which the phase of the fastest swing grows by 1 [s], 0 for no swing."""
    times, angles = motion.times, motion.angles
    if len(times) < 3 or np.isfinite(angles).sum() < _FEWEST:
        return 0.0
    size = min(float(np.nanquantile(np.abs(angles - np.nanmedian(angles)), _LARGEST)), 1.0)
    bends = np.abs(np.diff(angles, 2, axis=0))
    if not (np.isfinite(bends).any() and size > _CLEAR * float(np.nanmedian(bends))):
        return 0.0
    step = float(np.median(np.diff(times)))
    unit, lag = 0.0, 1
    for _ in range(4):  # noise makes speeds over short times large
        speeds = np.abs(angles[lag:] - angles[:-lag]) / (times[lag:] - times[:-lag])[:, None]
        if not np.nansum(speeds) > 0.0:
            return 0.0
        unit = max(size / float(np.nanquantile(speeds, _LARGEST)), 2.01 * step)
        lag = max(min(int(0.5 * unit / step), len(times) // 4), 1)
    return unit
