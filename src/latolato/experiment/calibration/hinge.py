"""The hinge of a pendulum in a picture: the centre of the circle on which its ball is seen."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

# Arc above which the circle tells its centre [rad].
WIDE_ARC = math.radians(60.0)
# Arc from which the hinge's place across it is looked for [rad]; errors of a click and of distances
# on the whole [pixels].
NARROW_ARC, CLICK, UNROUND = math.radians(12.0), 1.0, 0.15
# Error of the pivot against the ball that all frames share, from shading and edges, and the least
# one of the distances that changes along the arc [pixels].
_SHARED, _UNEVEN = 0.15, 0.01
# Side of the blocks that coders treat as one: errors are tied to places, and nearer ones agree
# [pixels].
_BLOCK = 16.0
# Residual of the circle above which lens, perspective or shutter are suspected [pixels, arm].
_ROUND, _ROUND_SHARE = 0.35, 1.2e-3
# Offset that a click may have [pixels, arm].
_NEAR, _NEAR_SHARE = 5.0, 0.01


@dataclass
class Hinge:
    """The centre of the circle on which a ball is seen.

    Attributes
    ----------
    offset, sigma : numpy.ndarray, shape (2,)
        From the clicked pivot to the hinge and its standard deviations [pixels].
    arm : float
        Distance from hinge to ball [pixels].
    arc : float
        Range of angles seen [rad].
    residual : float
        Root mean square distance from the circle [pixels].
    warnings : list of str
        What the user should know.
    source : str
        ``"picture"``, or where the picture does not show the pivot ``"declared"`` or ``"arc"``.
    scale_sigma : float
        Relative standard deviation of all angles, and of the scale, about a pivot that is not seen.
    aside : float
        Standard deviation of the place of such a pivot across the middle of the arc [pixels].
    """

    offset: np.ndarray
    sigma: np.ndarray
    arm: float
    arc: float
    residual: float
    warnings: list[str] = field(default_factory=list)
    source: str = "picture"
    scale_sigma: float = 0.0
    aside: float = 0.0

    @property
    def is_seen(self) -> bool:
        """Whether the picture shows the pivot."""
        return self.source == "picture"


def find_hinge(away: np.ndarray, angles: np.ndarray, noise: float) -> Hinge:
    """Return the hinge from positions about the click.

    `noise` is the scatter of the distances [pixels], which is no fault of the circle.
    """
    from scipy.optimize import least_squares

    distance = np.hypot(away[:, 0], away[:, 1])
    arm = float(np.median(distance)) if len(distance) else math.nan
    arc = range_of(angles)
    none, clicked = np.zeros(2), np.full(2, math.hypot(CLICK, _SHARED))
    if len(away) < 20:
        return Hinge(none, clicked, arm, arc, math.nan)

    def rest(p: np.ndarray) -> np.ndarray:
        return np.asarray(np.hypot(away[:, 0] - p[0], away[:, 1] - p[1]) - p[2])

    fit = least_squares(rest, [0.0, 0.0, arm], loss="soft_l1", f_scale=0.3)
    offset, fitted_arm = fit.x[:2], float(fit.x[2])
    residual = float(1.4826 * np.median(np.abs(rest(fit.x))))
    as_clicked = float(1.4826 * np.median(np.abs(distance - arm)))
    if arc < WIDE_ARC:
        return Hinge(*_across(away, angles, arc, arm), arm, arc, as_clicked)
    # Lenses and perspective make an oval: its second harmonic beside the circle.
    direction = np.arctan2(away[:, 0] - offset[0], away[:, 1] - offset[1])
    waves = np.stack([np.cos(2 * direction), np.sin(2 * direction)], axis=-1)
    oval = float(np.hypot(*np.linalg.lstsq(waves, rest(fit.x), rcond=None)[0]))
    limit = max(_ROUND, _ROUND_SHARE * fitted_arm, 2.0 * noise)
    too_far = float(np.hypot(*offset)) > max(_NEAR, _NEAR_SHARE * fitted_arm)
    bent = math.sqrt(max(residual**2 - noise**2, 0.0))
    if bent > limit or oval > 1.5 * limit or too_far:
        warning = (
            f"the ball does not move on a circle about the pivot (centre off by "
            f"{np.hypot(*offset):.1f} pixels, residual {max(bent, oval):.2f} pixels): lens, "
            "perspective or rolling shutter; the pivot is used as clicked"
        )
        sigma = np.maximum(clicked, np.abs(offset))
        return Hinge(none, sigma, arm, arc, as_clicked, [warning])
    # What distances get wrong along the arc moves the centre the more, the narrower it is.
    design = np.stack([np.sin(direction), np.cos(direction), np.ones_like(direction)], axis=-1)
    spread = np.diag(np.linalg.pinv(design.T @ design / len(design)))[:2]
    uneven = math.hypot(_UNEVEN, bent)
    count = max(min(len(design), arc * fitted_arm / _BLOCK), 1.0)
    sigma = np.sqrt(_SHARED**2 + (uneven**2 + noise**2 / count) * spread)
    return Hinge(offset, sigma, fitted_arm, arc, residual)


def range_of(angles: np.ndarray) -> float:
    """Return the range of angles without the outermost [rad]."""
    turned = np.mod(angles + math.pi, 2.0 * math.pi) - math.pi
    return float(np.ptp(np.quantile(turned, [0.005, 0.995]))) if len(turned) else 0.0


def _across(
    away: np.ndarray, angles: np.ndarray, arc: float, arm: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the hinge's offset across the middle of a narrow arc, and its standard deviations.

    Along the middle such an arc tells nothing.

    Distances grow along the arc when the hinge lies aside; the click is believed to `CLICK`, the
    distances on the whole to `UNROUND`.
    """
    clicked = math.hypot(CLICK, _SHARED)
    if arc < NARROW_ARC:
        return np.zeros(2), np.full(2, clicked)
    middle = 0.5 * float(np.sum(np.quantile(angles, [0.005, 0.995])))
    lean = np.sin(np.mod(angles - middle + math.pi, 2.0 * math.pi) - math.pi)
    distance = np.hypot(away[:, 0], away[:, 1])
    # distance = arm + offset * lean, with the offset drawn to zero.
    centred = lean - lean.mean()
    fitted = float(np.sum(centred * distance) / np.sum(centred**2))
    error = UNROUND / float(np.std(lean))
    offset = fitted / (1.0 + (error / CLICK) ** 2)
    across = np.array([math.cos(middle), -math.sin(middle)])
    along = np.array([math.sin(middle), math.cos(middle)])
    if abs(offset) > max(_NEAR, _NEAR_SHARE * arm):
        return np.zeros(2), np.maximum(clicked, np.abs(fitted * across))
    left = math.hypot(error / math.hypot(1.0, error / CLICK), _SHARED)
    return offset * across, np.hypot(left * across, clicked * along)
