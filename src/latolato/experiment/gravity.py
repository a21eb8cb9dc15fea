"""The direction of gravity in a picture, and what all angles have in common of its error."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

# Arc above which the circle tells its centre [rad], and offset that a click may have [pixels, arm].
_WIDE_ARC = math.radians(60.0)
# Arc from which the hinge's place across it is looked for [rad]; errors of a click and of distances
# on the whole [pixels].
_NARROW_ARC, _CLICK, _UNROUND = math.radians(12.0), 1.0, 0.15
# Stroke of the pivot from which its axis is taken as vertical [pixels].
_STROKE = 6.0
# Lean from which a motion of the pivot is no drive [rad].
_LEAN = math.radians(40.0)
# Parts of the pivot's axis that are compared.
_PARTS = 8


def find_gravity(pivots: np.ndarray, angles: np.ndarray, is_clean: np.ndarray) -> tuple[float, str]:
    """Return gravity's direction from straight down in the image, and where it comes from."""
    ok = np.isfinite(pivots).all(axis=1)
    centred = pivots[ok] - pivots[ok].mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
    stroke = 2.0 * math.sqrt(2.0) * sizes[0] / math.sqrt(max(len(centred), 1))
    is_upright = abs(float(axes[0][1])) > math.cos(_LEAN)
    if stroke > _STROKE and sizes[1] < 0.2 * sizes[0] and is_upright:
        axis = axes[0] * np.sign(axes[0][1])
        return float(math.atan2(axis[0], axis[1])), "drive axis"
    if stroke < 0.25 * _STROKE or not is_upright:
        rest = _rest_position(angles, is_clean)
        if rest is not None:
            return rest, "rest position"
    return 0.0, "image"


def angle_offset_sigma(
    pivots: np.ndarray, source: str, arc: float, residual: float, arm: float
) -> float:
    """Return the standard deviation of what all angles have in common [rad].

    Where the pivot passes, the wall draws it aside by as much in every stroke: the means in parts
    of its axis scatter about a straight line, and neighbouring parts alike, which doubles the
    error of the line. About the rest position the hinge's place cancels.
    """
    if source == "rest position":
        return 0.5 * _UNROUND / arm
    if source == "image":
        return math.nan
    ok = np.isfinite(pivots).all(axis=1)
    _, _, axes = np.linalg.svd(pivots[ok] - pivots[ok].mean(axis=0), full_matrices=False)
    along, aside = (pivots[ok] @ axis for axis in axes)
    part = np.floor((along - along.min()) / (np.ptp(along) + 1e-9) * _PARTS).astype(int)
    count = np.bincount(part, minlength=_PARTS)
    seen = count > 0
    if seen.sum() < 4:
        return math.nan
    places = (np.bincount(part, along, _PARTS) / np.maximum(count, 1))[seen]
    means = (np.bincount(part, aside, _PARTS) / np.maximum(count, 1))[seen]
    line = np.polyfit(places, means, 1)
    rest = means - np.polyval(line, places)
    scatter = math.sqrt(float(np.sum(rest**2)) / (len(rest) - 2))
    axis = 2.0 * scatter / math.sqrt(float(np.sum((places - places.mean()) ** 2)))
    if arc >= _WIDE_ARC:
        hinge = 0.5 * residual
    elif arc >= _NARROW_ARC:
        hinge = 1.0 / math.hypot(1.0 / _CLICK, arc / (2.0 * math.sqrt(2.0) * _UNROUND))
    else:
        hinge = _CLICK
    return math.hypot(axis, hinge / arm)


def _rest_position(angles: np.ndarray, is_clean: np.ndarray) -> float | None:
    """Return the angle about which free swings decay, from three successive extremes each.

    ``(a1 + 2 a2 + a3)/4`` of successive extremes is the rest position up to second order of the
    decrement, whatever the amplitude. Two balls of equal frequency have it in the mean of their
    angles, which impacts between equal balls do not change.
    """
    swings = [angles[:, b] for b in range(angles.shape[1])]
    clean = [is_clean[:, b] for b in range(angles.shape[1])]
    moves = [np.nanstd(s) > 0.01 for s in swings]
    if len(swings) == 2 and all(moves):
        swing, ok = 0.5 * (swings[0] + swings[1]), np.isfinite(swings[0] + swings[1])
        if np.nanstd(swing) < 0.02:
            return float(np.nanmedian(swing))
    elif any(moves):
        b = moves.index(True)
        swing, ok = swings[b], clean[b] & np.isfinite(swings[b])
    else:
        return None
    extremes = find_extremes(swing[ok])
    if len(extremes) < 4:
        return None
    middles = 0.25 * (extremes[:-2] + 2.0 * extremes[1:-1] + extremes[2:])
    # Only swings below a right angle all the way have no other rest position beside.
    return float(np.median(middles)) if np.max(np.abs(extremes)) < 2.0 else None


def find_extremes(swing: np.ndarray) -> np.ndarray:
    """Return successive extremes of a swing, each from a parabola through its top."""
    middle = float(np.median(swing))
    side = np.sign(swing - middle)
    changes = np.flatnonzero(np.diff(side) != 0) + 1
    found = []
    for begin, end in pairwise(changes):
        part = swing[begin:end] - middle
        if len(part) < 5:
            continue
        k = int(np.argmax(np.abs(part)))
        a, b = max(0, k - max(2, len(part) // 6)), min(len(part), k + max(2, len(part) // 6) + 1)
        t = np.arange(a, b) - k
        c2, c1, c0 = np.polyfit(t, part[a:b], 2)
        found.append(middle + (c0 - c1 * c1 / (4.0 * c2) if c2 != 0.0 else part[k]))
    return np.array(found)
