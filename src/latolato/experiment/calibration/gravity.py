"""The direction of gravity in a picture, and the error that all angles share because of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from latolato.experiment.calibration.hinge import UNROUND, Hinge
from latolato.experiment.calibration.swing import Motion, Swing, fit_swing

# Stroke of the pivot from which its axis is taken as vertical [pixels].
STROKE = 6.0
# By how many deviations axis and swing may differ for both to be right, and from which on the drive
# is oblique: a ball's pattern that turns over the top draws the swing aside by half a dozen.
_AGREE, _OBLIQUE = 3.0, 10.0
# Lean from which a motion of the pivot is no drive [rad].
_LEAN = math.radians(40.0)
# Parts of the pivot's axis that are compared.
_PARTS = 8
# Standard deviation of straight down in the picture of a camera that was levelled by eye [rad].
LEVELLED = math.radians(5.0)


@dataclass(frozen=True)
class Gravity:
    """Gravity's direction from straight down in the picture, and its standard deviation [rad].

    The source is ``"drive axis"``, which the swing confirms, ``"vertical drive"``, an axis that is
    taken as vertical because the swing does not tell, ``"swing"`` or ``"image"``; `swing` is what
    the swing told, if anything.
    """

    direction: float
    source: str
    sigma: float
    swing: Swing | None = None


def find_gravity(motion: Motion, hinge: Hinge) -> Gravity:
    """Return gravity's direction by the axis of a drive or by the swing, whichever is surer.

    Angles of the motion are those from straight down in the picture. A drive need not be vertical:
    where the swing clearly says otherwise, its axis does not count. Where it does not, the swing is
    read again as that about a pivot that moves along gravity.
    """
    axis, swing = _drive_axis(motion.pivots * hinge.arm), fit_swing(motion)
    if axis is not None and not _is_oblique(axis, swing):
        vertical = fit_swing(motion, axis.direction)
        swing = swing if vertical is None or _is_oblique(axis, vertical) else vertical
    if swing is None or swing.direction_sigma > LEVELLED:
        if axis is None:
            return Gravity(0.0, "image", LEVELLED, swing)
        # What leans more than a camera that was levelled by eye may be the drive.
        lean = max(axis.sigma, abs(axis.direction) - LEVELLED)
        return replace(axis, source="vertical drive", sigma=lean, swing=swing)
    down = Gravity(swing.direction, "swing", swing.direction_sigma, swing)
    if axis is None or _is_oblique(axis, swing):
        return down
    best = min(axis, down, key=lambda each: angle_offset_sigma(each, hinge))
    return replace(best, sigma=max(best.sigma, _apart(axis, swing) / _AGREE), swing=swing)


def _apart(axis: Gravity, swing: Swing) -> float:
    """Return the angle between a drive's axis and the direction of gravity by the swing [rad]."""
    return abs(math.remainder(axis.direction - swing.direction, math.tau))


def _is_oblique(axis: Gravity, swing: Swing | None) -> bool:
    """Return whether a swing clearly says that a drive is not vertical."""
    if swing is None or swing.direction_sigma > LEVELLED:
        return False
    return _apart(axis, swing) > _OBLIQUE * math.hypot(axis.sigma, swing.direction_sigma)


def is_upside_down(motion: Motion) -> bool:
    """Return whether balls swing as under gravity in the picture turned by half a turn."""
    turned = motion._replace(angles=motion.angles - math.pi, pivots=-motion.pivots)
    swing = fit_swing(turned)
    # Two balls that mirror each other fit any gravity, turned round too.
    return (
        swing is not None
        and swing.direction_sigma < LEVELLED
        and math.isfinite(swing.stiffness_sigma)
    )


def _drive_axis(pivots: np.ndarray) -> Gravity | None:
    """Return the direction of a drive's axis, None if the pivot is not driven up and down.

    `pivots` (frame, 2) are to the right and up [pixels].
    """
    known = pivots[np.isfinite(pivots).all(axis=1)]
    centred = known - known.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
    stroke = 2.0 * math.sqrt(2.0) * sizes[0] / math.sqrt(max(len(centred), 1))
    is_upright = abs(float(axes[0][1])) > math.cos(_LEAN)
    if not (stroke > STROKE and sizes[1] < 0.2 * sizes[0] and is_upright):
        return None
    down = -axes[0] * np.sign(axes[0][1])
    return Gravity(math.atan2(down[0], -down[1]), "drive axis", _axis_sigma(centred @ axes.T))


def angle_offset_sigma(down: Gravity, hinge: Hinge) -> float:
    """Return the standard deviation of what all angles have in common [rad].

    About the position of rest of a swing the hinge's place cancels.
    """
    if down.source == "swing":
        beside = 0.5 * UNROUND
    elif not hinge.is_seen:
        beside = hinge.aside
    else:
        beside = hinge.sigma_along(down.direction + 0.5 * math.pi)
    return math.hypot(down.sigma, beside / hinge.arm)


def _axis_sigma(path: np.ndarray) -> float:
    """Return the standard deviation of the direction of a path (along, aside) [rad].

    Where the pivot passes, the wall draws it aside by as much in every stroke: the means in parts
    of its axis scatter about a straight line, and neighbouring parts alike, which trebles the
    error of the line. A path of fewer than four parts says nothing.
    """
    along, aside = path.T
    part = np.floor((along - along.min()) / (np.ptp(along) + 1e-9) * _PARTS).astype(int)
    count = np.bincount(part, minlength=_PARTS)
    seen = count > 0
    if seen.sum() < 4:
        return LEVELLED
    places = (np.bincount(part, along, _PARTS) / np.maximum(count, 1))[seen]
    means = (np.bincount(part, aside, _PARTS) / np.maximum(count, 1))[seen]
    line = np.polyfit(places, means, 1)
    rest = means - np.polyval(line, places)
    scatter = math.sqrt(float(np.sum(rest**2)) / (len(rest) - 2))
    return 3.0 * scatter / math.sqrt(float(np.sum((places - places.mean()) ** 2)))
