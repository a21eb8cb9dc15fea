"""The hinge of a pendulum in a picture: the centre of the circle on which its ball is seen."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from latolato.core.errors import Sentence
from latolato.experiment.calibration.circle_fit import fit_circle
from latolato.experiment.rules import said

# Arc above which a path that is no circle shows [rad].
WIDE_ARC = math.radians(60.0)
# Standard deviations of a click and of distances on the whole [pixels].
CLICK_SIGMA, UNROUND = 1.0, 0.15
# Standard deviation of the place of a pivot that nobody clicked on, as a share of the arm.
_UNCLICKED = 0.02
# Error of the pivot against the ball that all frames share, from shading and edges, the least one
# of the distances that changes along the arc, and the distance beyond which one is a mistake of the
# tracker [pixels].
_SHARED, _UNEVEN, _MISTAKEN = 0.15, 0.02, 0.3
# Side of the blocks that coders treat as one: errors are tied to places, and nearer ones agree
# [pixels].
_BLOCK = 16.0
# Residual of the circle above which lens, perspective or shutter are suspected [pixels, arm].
_ROUND, _ROUND_SHARE = 0.35, 1.2e-3
# Pieces of an arc that may be bent each for itself.
_PIECES = 25
# Distance of another centre from the pivot that is no accident [standard deviations], and from the
# hinge that matters [pixels]; what its circle may leave over, in noise.
_ELSEWHERE, _APART, _AS_ROUND = 4.0, 2.0, 1.0
# Offset that the place of a pivot may have [standard deviations, arm].
_NEAR, _NEAR_SHARE = 5.0, 0.01


@dataclass
class Hinge:
    """The centre of the circle on which a ball is seen.

    Attributes
    ----------
    offset, sigma : numpy.ndarray, shape (2,)
        From where the pivot was taken to be to the hinge, and its standard deviations [pixels].
    arm : float
        Distance from hinge to ball [pixels].
    arc : float
        Range of angles seen [rad].
    residual : float
        Root mean square distance from the circle [pixels].
    warnings : list of Sentence
        What the user should know.
    source : str
        ``"picture"``, or where the picture does not show the pivot ``"declared"`` or ``"arc"``.
    scale_sigma : float
        Relative standard deviation of all angles, and of the scale, about a pivot that is not seen.
    aside : float
        Standard deviation of the place of such a pivot across the middle of the arc [pixels].
    sway : float
        Amplitude of a motion of the pivot to the side that makes what the circle misses [pixels].
    """

    offset: np.ndarray
    sigma: np.ndarray
    arm: float
    arc: float
    residual: float
    warnings: list[Sentence] = field(default_factory=list)
    source: str = "picture"
    scale_sigma: float = 0.0
    aside: float = 0.0
    sway: float = 0.0

    @property
    def is_seen(self) -> bool:
        """Whether the picture shows the pivot."""
        return self.source == "picture"

    def sigma_along(self, direction: float) -> float:
        """Standard deviation of its place along a direction from straight down [pixels]."""
        return math.hypot(math.sin(direction) * self.sigma[0], math.cos(direction) * self.sigma[1])


def sigma_of_pivot(arm: float, *, is_clicked: bool) -> float:
    """Standard deviation of where a pivot is taken to be at the end of an arm [pixels].

    It was clicked in the picture, or else found there, declared outside of it, or moves unseen.
    """
    return CLICK_SIGMA if is_clicked else math.hypot(CLICK_SIGMA, _UNCLICKED * arm)


def find_hinge(
    away: np.ndarray, angles: np.ndarray, *, noise: float, pivot_sigma: float = CLICK_SIGMA
) -> Hinge:
    """Return the hinge from positions (place, 2) about a pivot that is known to `pivot_sigma`.

    `noise` is the scatter of the distances, which is no fault of the circle; both are in pixels.
    What distances get wrong along the arc moves the centre the more, the narrower it is; along the
    middle of a narrow arc the pivot's place tells more.
    """
    distance = np.hypot(away[:, 0], away[:, 1])
    arm = float(np.median(distance)) if len(distance) else math.nan
    arc = range_of(angles)
    none, unsure = np.zeros(2), np.full(2, math.hypot(pivot_sigma, _SHARED))
    if len(away) < 20:
        return Hinge(none, unsure, arm, arc, math.nan)
    count = max(min(len(away), arc * arm / _BLOCK), 1.0)
    uneven, bent = math.hypot(_UNEVEN, noise / math.sqrt(count)), 0.0
    for _ in range(2):  # what the circle leaves beyond noise bends some pieces of the arc
        shared = math.hypot(uneven, bent / math.sqrt(_PIECES))
        fit = fit_circle(
            lambda: away, shared * math.sqrt(len(away)), robust=_MISTAKEN,
            belief=(none, pivot_sigma),
        )  # fmt: skip
        bent = math.sqrt(max(fit.residual**2 - noise**2, 0.0))
    offset, residual = fit.centre, fit.residual
    # Lenses and perspective make an oval: its second harmonic beside the circle.
    direction = np.arctan2(away[:, 0] - offset[0], away[:, 1] - offset[1])
    waves = np.stack([np.cos(2 * direction), np.sin(2 * direction)], axis=-1)
    oval = float(np.hypot(*np.linalg.lstsq(waves, fit.distances, rcond=None)[0]))
    limit = max(_ROUND, _ROUND_SHARE * fit.arm, 2.0 * noise)
    is_wide = arc >= WIDE_ARC
    is_oval = is_wide and (bent > limit or oval > 1.5 * limit)
    if is_oval or float(np.hypot(*offset)) > max(_NEAR * pivot_sigma, _NEAR_SHARE * fit.arm):
        sizes = {"offset": f"{np.hypot(*offset):.1f}", "residual": f"{max(bent, oval):.2f}"}
        warning = said("off_centre", **sizes)
        sigma = np.maximum(unsure, np.abs(offset))
        scatter = float(1.4826 * np.median(np.abs(distance - arm)))
        return Hinge(none, sigma, arm, arc, scatter, [warning] if is_wide else [])
    spread = np.diag(fit.covariance)[:2] * (1.0 + (bent / shared) ** 2)
    sigma = np.sqrt(_SHARED**2 + np.minimum(spread, pivot_sigma**2))
    if bent <= limit:
        return Hinge(offset, sigma, fit.arm, arc, residual)
    # A pivot that moves to the side changes distances by the sine of the angle only. It may have
    # been pointed at where it turns.
    sway = bent * math.sqrt(2.0 / float(np.mean(np.sin(direction) ** 2)))
    warning = said("swaying_pivot", varies=f"{bent:.2f}", sway=sway)
    return Hinge(offset, sigma, fit.arm, arc, residual, [warning], sway=sway)


def other_centre(
    away: np.ndarray, angles: np.ndarray, hinge: Hinge, *, noise: float, pivot_sigma: float
) -> np.ndarray | None:
    """Return the centre (2,) of a circle that places show as well, far from the hinge [pixels].

    None if there is none. A pivot that is in a wrong place makes the same path as a camera that
    looks at an angle, and a belief in the place draws the hinge to it.

    Parameters
    ----------
    away : numpy.ndarray, shape (place, 2)
        Places in the picture from where the pivot was taken to be [pixels].
    angles : numpy.ndarray, shape (place,)
        Their angles [rad].
    hinge : Hinge
        What is believed.
    noise : float
        Scatter of the distances [pixels].
    pivot_sigma : float
        Standard deviation of the pivot's place [pixels].
    """
    if len(away) < 20 or not hinge.is_seen:
        return None
    count = max(min(len(away), range_of(angles) * hinge.arm / _BLOCK), 1.0)
    sigma = math.hypot(_UNEVEN, noise / math.sqrt(count)) * math.sqrt(len(away))
    fit = fit_circle(lambda: away, sigma, robust=_MISTAKEN)
    # What it leaves beyond noise bends some pieces of the arc.
    bent = math.sqrt(max(fit.residual**2 - noise**2, 0.0))
    if bent > _AS_ROUND * max(noise, _SHARED):
        return None
    spread = fit.covariance[:2, :2] * (1.0 + len(away) * (bent / sigma) ** 2 / _PIECES)
    # How sure it is that it is not where the pivot was taken to be, which is at the origin.
    sure = np.linalg.inv(spread + pivot_sigma**2 * np.eye(2))
    is_elsewhere = fit.centre @ sure @ fit.centre > _ELSEWHERE**2
    is_far = float(np.hypot(*(fit.centre - hinge.offset))) > _APART
    return fit.centre if is_elsewhere and is_far else None


def range_of(angles: np.ndarray) -> float:
    """Return the range of angles without the outermost [rad]."""
    turned = np.mod(angles + math.pi, 2.0 * math.pi) - math.pi
    return float(np.ptp(np.quantile(turned, [0.005, 0.995]))) if len(turned) else 0.0
