"""A camera that looks at a swing at an angle: it sees the ball's circle as an oval."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from latolato.experiment.calibration.circle_fit import CircleFit, fit_circle
from latolato.experiment.calibration.hinge import CLICK_SIGMA, UNROUND
from latolato.experiment.calibration.lens import UNKNOWN_LENS, undistorted

# Fewest places that make an oval, most of them that are fitted, and the narrowest arc [rad]: on a
# narrower one a pivot that is off makes the same path.
_FEWEST, _MOST, _NARROW = 30, 800, 0.5
# What may pass for a tilt: a lens of so many undeclared ones, about a pivot that is so many times
# better known than that of an oval.
_LENSES, _STIFF = 10.0, 10.0
# Pieces of the path whose errors count as independent.
_PIECES = 12
# Error of the pivot against the oval's middle, as a share of the arm: perspective moves it.
_ASIDE = 0.003
# How sure an oval must be [standard deviations], how much nearer than a circle it must be to the
# places, how near [pixels, arm], and the strongest one: an axis less than a fourth of the other.
_SURE, _BETTER, _NEAR, _NEAR_SHARE, _STRONGEST = 5.0, 0.5, 1.0, 3e-3, 0.6
# Step for derivatives.
_STEP = 1e-5


@dataclass(frozen=True)
class Tilt:
    """How obliquely a distant camera looks at the plane of the swing.

    Attributes
    ----------
    angle, sigma : float
        Between the line of sight and the normal of the plane, and its standard deviation [rad].
    axis : float
        Direction in the picture in which nothing is foreshortened, from straight down [rad].
    spread : numpy.ndarray, shape (2, 2)
        Covariance of the oval's two numbers, see `stretch`.
    """

    angle: float = 0.0
    sigma: float = 0.0
    axis: float = 0.0
    spread: np.ndarray | None = None

    @property
    def stretch(self) -> np.ndarray:
        """The symmetric matrix less one, with a trace of 0, that makes a circle of the oval."""
        ratio = math.cos(self.angle)
        e = (1.0 - ratio) / (1.0 + ratio)
        return e * np.array([math.cos(2.0 * self.axis), -math.sin(2.0 * self.axis)])

    @property
    def matrix(self) -> np.ndarray:
        """What turns places in the picture into those in the plane; straight down stays so."""
        return _matrix(self.stretch)

    def shares(self, angles: np.ndarray) -> np.ndarray:
        """Return the oval's distance from its middle at angles in the picture, over the arm."""
        if self.angle == 0.0:
            return np.ones_like(angles)
        return np.asarray(1.0 / np.hypot(*self.flat(_directions(angles)).T))

    def flat(self, away: np.ndarray) -> np.ndarray:
        """Positions in the plane of places (..., 2) in the picture, from the pivot [pixels]."""
        return away if self.angle == 0.0 else np.asarray(away @ self.matrix.T)

    def seen(self, flat: np.ndarray) -> np.ndarray:
        """Positions in the picture of places (..., 2) in the plane, from the pivot [pixels]."""
        return flat if self.angle == 0.0 else np.asarray(flat @ np.linalg.inv(self.matrix).T)

    def errors(self, away: np.ndarray) -> np.ndarray:
        """Return the standard deviation of angles at places (..., 2) that the tilt causes [rad]."""
        if self.spread is None:
            return np.zeros(away.shape[:-1])
        slopes = []
        for step in _STEP * np.eye(2):
            one, two = (away @ _matrix(self.stretch + sign * step).T for sign in (1.0, -1.0))
            turn = np.arctan2(one[..., 0], one[..., 1]) - np.arctan2(two[..., 0], two[..., 1])
            slopes.append(np.remainder(turn + math.pi, math.tau) - math.pi)
        slope = np.stack(slopes, axis=-1) / (2.0 * _STEP)
        return np.asarray(np.sqrt(np.einsum("...i,ij,...j->...", slope, self.spread, slope)))


def tilt_of(attributes: Mapping[str, Any], name: str = "") -> Tilt:
    """Return the tilt that a track table's attributes state, for one of its pivots or balls."""
    end = "_2" if name.endswith("_2") and "arm_pixels_2" in attributes else ""
    angle, axis = (float(attributes.get(f"{key}{end}", 0.0)) for key in ("tilt", "tilt_axis"))
    return Tilt(angle, axis=axis)


def _directions(angles: np.ndarray) -> np.ndarray:
    """Return unit vectors at angles from straight down in the picture."""
    return np.stack([np.sin(angles), np.cos(angles)], axis=-1)


def _matrix(stretch: np.ndarray) -> np.ndarray:
    """Return the matrix of an oval's two numbers: not foreshortened one way, and turned down."""
    e1, e2 = stretch
    plain = np.array([[1.0 + e1, e2], [e2, 1.0 - e1]]) / (1.0 - math.hypot(e1, e2))
    turn = math.atan2(plain[0, 1], plain[1, 1])
    cosine, sine = math.cos(turn), math.sin(turn)
    return np.array([[cosine, -sine], [sine, cosine]]) @ plain


def fit_tilt(
    places: np.ndarray,
    pivots: np.ndarray,
    *,
    size: tuple[int, int],
    pivot_sigma: float = CLICK_SIGMA,
) -> Tilt | None:
    """Return the tilt at which a circle about the pivot is seen in places, None if none is sure.

    Parameters
    ----------
    places, pivots : numpy.ndarray, shape (place, 2)
        Where a ball is in the picture, and the pivot at the same time [pixels].
    size : tuple of int
        Width and height of the picture [pixels].
    pivot_sigma : float
        Standard deviation of the pivot's place, which all frames share [pixels].

    Notes
    -----
    A circle of radius ``R`` whose plane is tilted by ``t`` is seen as an oval with the semi-axes
    ``R`` and ``R cos t`` about the pivot. To decide whether there is one, the pivot is believed to
    1 pixel and 0.3 % of the arm even where it was found: about the centre of a circle there is no
    oval, and where strings meet it is known that well. The oval is then fitted with the deviation
    of the pivot. The covariance includes a lens of ``k1 = 0.01``, which makes ovals, too; where one
    of up to 0.1 may make this oval, there is none, and none on an arc of less than 0.5 rad. It can
    miss a perspective that makes one side larger than the other, and a tilt about a pivot that was
    found as the centre of a circle.
    """
    turns = np.unwrap(np.arctan2(*(places - pivots).T))
    if len(places) < _FEWEST or np.ptp(np.quantile(turns, [0.02, 0.98])) < _NARROW:
        return None
    thin = slice(None, None, math.ceil(len(places) / _MOST))
    places, pivots = places[thin], pivots[thin]
    away = places - pivots
    bend = undistorted(places, size, UNKNOWN_LENS) - undistorted(pivots, size, UNKNOWN_LENS) - away
    arm = float(np.median(np.hypot(*away.T)))
    none, near = np.zeros(2), math.hypot(CLICK_SIGMA, _ASIDE * arm)

    def oval(e1: float, e2: float) -> np.ndarray:
        return np.asarray(away @ np.array([[1.0 + e1, e2], [e2, 1.0 - e1]]))

    def of_one(sigma: float) -> float:
        return sigma * math.sqrt(len(away) / _PIECES)

    circle = fit_circle(
        lambda lens: away + lens * bend, of_one(UNROUND), extra=[0.0], limits=[_LENSES],
        belief=(none, near / _STIFF),
    )  # fmt: skip
    rough = fit_circle(oval, of_one(UNROUND), belief=(none, near), extra=[0.0, 0.0])

    def fitted(sigma: float) -> tuple[CircleFit, float, float]:
        fit = fit_circle(
            oval, of_one(max(rough.residual, UNROUND)), belief=(none, sigma),
            extra=rough.extra.tolist(), bent=bend,
        )  # fmt: skip
        strength = float(np.hypot(*fit.extra))
        along = fit.extra / max(strength, _STEP)
        return fit, strength, math.sqrt(float(along @ fit.spread[3:, 3:] @ along))

    fit, e, sigma = fitted(near)
    is_near = fit.residual < min(max(_NEAR, _NEAR_SHARE * arm), _BETTER * circle.residual)
    if not _SURE * sigma < e < _STRONGEST or not is_near:
        return None
    fit, e, sigma = fitted(math.hypot(pivot_sigma, _ASIDE * arm))
    e1, e2 = fit.extra
    angle = math.acos((1.0 - e) / (1.0 + e))
    # cos t = (1 - e)/(1 + e), so that sin t dt = 2 de/(1 + e)^2.
    tilt_sigma = 2.0 * sigma / ((1.0 + e) ** 2 * math.sin(angle))
    return Tilt(angle, tilt_sigma, 0.5 * math.atan2(-e2, e1), fit.spread[3:, 3:])
