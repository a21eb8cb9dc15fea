"""Standard deviations of angles that are not below the scatter seen in the clip."""

from __future__ import annotations

import math

import numpy as np

# Error of positions that no scatter shows [pixels].
SYSTEMATIC = 0.05
# Samples from which on distances from the circle show errors, and the distance from which it is
# no chance [standard deviations].
_FEW, _FAR_OFF = 20, 4.0
# How many intervals seven samples may span to reveal errors of time stamps; how much more fast
# balls must scatter along their path than across, how much larger errors of time may be, since
# neighbouring ones go together, and how large they must be to count [intervals].
_SPAN, _SHOWN, _ROUGH_TIMES, _LEAST_OFF = 14.0, 3.0, 1.5, 0.02
# How much larger errors along the circle may be than across.
_ROUGH = 2.0


def honest_deviations(
    times: np.ndarray,
    angles: np.ndarray,
    *,
    sigmas: np.ndarray,
    off: np.ndarray,
    spreads: np.ndarray,
    is_clean: np.ndarray,
    arm: float,
) -> np.ndarray:
    """Return standard deviations that are not below the scatter seen in the clip [rad].

    The residuals of a fit do not show errors that neighbouring pixels share (compression, texture),
    nor those of the pivot. Two quantities do, and the larger one raises all deviations by one
    factor: the scatter about the quintic through the six neighbours, and the distances from the
    circle (`off`, `spreads` as the fits say [pixels]), which also see what lasts for many frames.
    The quintic counts up to twice the other, because fast swings between contacts are not quintics.
    A ball that is far off the circle is no better known along it.
    """
    raised: np.ndarray = np.hypot(sigmas, SYSTEMATIC / arm)
    stated = np.hypot(spreads, SYSTEMATIC)
    for b in range(angles.shape[1]):
        clean = is_clean[:, b] & np.isfinite(off[:, b] / stated[:, b])
        if not clean.any():
            continue
        factor = 1.0
        rest = off[:, b] - float(np.median(off[clean, b]))
        if clean.sum() >= _FEW:
            pulls = np.abs(rest[clean] / stated[clean, b])
            limit = _FAR_OFF * 1.4826 * float(np.median(pulls))
            factor = max(factor, float(np.sqrt(np.mean(np.minimum(pulls, limit) ** 2))))
        scatter = scatter_of(times, np.where(clean, angles[:, b], np.nan))
        if math.isfinite(scatter):
            along = scatter / float(np.median(raised[clean, b]))
            factor = max(factor, min(along, _ROUGH * factor))
        raised[:, b] *= factor
        far = clean & (np.abs(rest) > _FAR_OFF * factor * stated[:, b])
        raised[far, b] = np.maximum(raised[far, b], np.abs(rest[far]) / arm)
    return raised


def time_scatter(
    times: np.ndarray,
    angles: np.ndarray,
    *,
    is_clean: np.ndarray,
    is_broken: np.ndarray,
    noise: float,
) -> float:
    """Return how much time stamps are off [s], 0 if the angles do not show it.

    Fast balls then deviate from what their neighbours predict more along their path than across it,
    by their speed times that error, and slow balls less than fast ones: a pivot that is not seen
    right, or a motion that is too fast for the frames, moves both. An error below a fiftieth of the
    time between frames does not show, nor does any error in a motion without seven samples from
    contact to contact.

    Parameters
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    angles : numpy.ndarray, shape (frame, ball)
        Angles [rad].
    is_clean, is_broken : numpy.ndarray of bool, shape (frame, ball)
        Samples that are believed, and those about which the motion is not smooth.
    noise : float
        Scatter of the places across the path over the arm [rad].
    """
    rests, speeds = [], []
    if angles.shape[1] == 2:  # balls may meet between frames, where they turn from each other
        ways = np.sign(np.diff(angles[:, 0] - angles[:, 1]))
        is_broken = is_broken.copy()
        is_broken[1:-1] |= (ways[1:] * ways[:-1] <= 0.0)[:, None]
    for b in range(angles.shape[1]):
        seen = np.flatnonzero(is_clean[:, b] & np.isfinite(angles[:, b]))
        if len(seen) < _FEW:
            continue
        parts, late = np.cumsum(is_broken[:, b])[seen], times[seen]
        is_smooth = parts[6:] == parts[:-6] - is_broken[seen[:-6], b]
        is_smooth &= late[6:] - late[:-6] <= _SPAN * float(np.median(np.diff(times)))
        rests.append(np.abs(_left_over(late, angles[seen, b]))[is_smooth])
        speeds.append(np.abs(np.gradient(angles[seen, b], late)[3:-3])[is_smooth])
    rest, speed = (np.concatenate(each) if each else np.empty(0) for each in (rests, speeds))
    if len(rest) < _FEW:
        return 0.0
    is_fast, is_slow = speed >= np.median(speed), speed <= np.median(speed)
    slow, slower = (float(np.median(each[is_slow])) for each in (rest, speed))
    fast, faster = (float(np.median(each[is_fast])) for each in (rest, speed))
    off = _ROUGH_TIMES * 1.4826 * float(np.median(rest[is_fast] / speed[is_fast]))
    is_shown = 1.4826 * fast > _SHOWN * noise
    # Errors of time make deviations differ as speeds do, others do not: the middle decides.
    is_shown &= slow**2 * faster < fast**2 * slower
    return off if is_shown and off > _LEAST_OFF * float(np.median(np.diff(times))) else 0.0


def scatter_of(times: np.ndarray, values: np.ndarray) -> float:
    """Return the noise of a smooth series: what neighbours do not predict (robust)."""
    if len(values) < 20:
        return math.nan
    rest = _left_over(times, values)
    rest = rest[np.isfinite(rest)]
    return 1.4826 * float(np.median(np.abs(rest))) if len(rest) >= 10 else math.nan


def _left_over(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Residuals of values from the quintic through six neighbours, without the outer three.

    They are scaled to have the deviation of the values, shape (sample - 6,).
    """
    others = np.array([-3, -2, -1, 1, 2, 3])
    at = np.arange(3, len(values) - 3)
    apart = times[at[:, None] + others] - times[at][:, None]
    weights = np.ones_like(apart)
    for j in range(6):
        for k in range(6):
            if j != k:
                weights[:, j] *= apart[:, k] / (apart[:, k] - apart[:, j])
    rest = values[at] - np.sum(weights * values[at[:, None] + others], axis=1)
    return np.asarray(rest / np.sqrt(1.0 + np.sum(weights**2, axis=1)))
