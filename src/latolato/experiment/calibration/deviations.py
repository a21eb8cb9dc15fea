"""Standard deviations of angles that are not below the scatter seen in the clip."""

from __future__ import annotations

import math

import numpy as np

# Error of positions that no scatter shows [pixels].
SYSTEMATIC = 0.05
# Samples from which on distances from the circle show errors, and the distance from which it is
# no chance [standard deviations].
_FEW, _FAR_OFF = 20, 4.0
# How much larger errors along the circle may be than across.
_ROUGH = 2.0


def honest_deviations(
    times: np.ndarray,
    angles: np.ndarray,
    sigmas: np.ndarray,
    off: np.ndarray,
    spreads: np.ndarray,
    is_clean: np.ndarray,
    arm: float,
) -> np.ndarray:
    """Return standard deviations that are not below the scatter seen in the clip [rad].

    A fit's residuals know nothing of errors that neighbouring pixels share (compression, texture)
    nor of the pivot's. Two things do, and the larger raises all deviations by one factor: the
    scatter about the quintic through the six neighbours, and the distances from the circle (`off`,
    `spreads` as the fits say [pixels]), which also see what lasts for many frames. The quintic is
    believed up to twice the other: fast swings between contacts are none. A ball that is far off
    the circle is no better known along it.
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


def scatter_of(times: np.ndarray, values: np.ndarray) -> float:
    """Return the noise of a smooth series: what its neighbours do not predict (robust)."""
    if len(values) < 20:
        return math.nan
    others = np.array([-3, -2, -1, 1, 2, 3])
    at = np.arange(3, len(values) - 3)
    apart = times[at[:, None] + others] - times[at][:, None]
    weights = np.ones_like(apart)
    for j in range(6):
        for k in range(6):
            if j != k:
                weights[:, j] *= apart[:, k] / (apart[:, k] - apart[:, j])
    rest = values[at] - np.sum(weights * values[at[:, None] + others], axis=1)
    rest = rest / np.sqrt(1.0 + np.sum(weights**2, axis=1))
    rest = rest[np.isfinite(rest)]
    return 1.4826 * float(np.median(np.abs(rest))) if len(rest) >= 10 else math.nan
