"""The lens: places with and without its distortion, and what an undeclared one does to angles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from latolato.experiment.calibration.circle_fit import fit_circle
from latolato.experiment.parameters import VIDEO_PARAMETERS

# Places from which a lens can be told, and most of them that are fitted.
_FEWEST, _MOST = 40, 600
# Strongest distortion that is tried.
_STRONGEST = 0.3
# How sure a distortion must be [standard deviations]: in synthetic clips those of true lenses were
# 3.0 to 4.1 and those without a lens 2.2 at most.
_SURE = 2.5
# Least error of the distances that changes along the path [pixels]: no place is known better.
_UNEVEN = 0.01
# How far beside the middle of a pivot a click may be, as a share of the arm, before a lens is the
# better reason for it.
_BESIDE = 0.005
# Noise above which a distance is a mistake of the tracker [pixels].
_ROBUST = 0.3


@dataclass(frozen=True, kw_only=True)
class Optics:
    """What the user declares about the camera.

    Parameters
    ----------
    row_time : float
        Time between the exposures of two rows of a rolling shutter [s]; a frame's time stamp is
        that of its first row.
    lens_k1, lens_k2 : float
        Radial distortion: an undistorted distance ``s`` from the middle of the picture, in units of
        half its diagonal, is seen at ``s (1 + k1 s^2 + k2 s^4)``.

    Raises
    ------
    InputError
        If one is out of its range.
    """

    row_time: float = 0.0
    lens_k1: float = 0.0
    lens_k2: float = 0.0

    def __post_init__(self) -> None:
        for name in ("row_time", "lens_k1", "lens_k2"):
            VIDEO_PARAMETERS[name].checked(getattr(self, name))


# Distortion that a lens may have that nobody declared.
UNKNOWN_LENS = Optics(lens_k1=0.01)


def lens_errors(
    balls: np.ndarray,
    pivots: np.ndarray,
    *,
    use: np.ndarray,
    angles: np.ndarray,
    size: tuple[int, int],
    noise: float,
    pivot_sigma: float,
) -> np.ndarray | None:
    """Return by how much a lens that the path shows would change angles [rad], None if none shows.

    Parameters
    ----------
    balls, pivots : numpy.ndarray, shape (frame, ball, 2)
        Where each ball is, and the pivot at the same time [pixels].
    use : numpy.ndarray of bool, shape (frame, ball)
        Which of them are fitted.
    angles : numpy.ndarray, shape (frame, ball)
        As they are without the lens [rad].
    size : tuple of int
        Width and height of the picture [pixels].
    noise : float
        Scatter of the distances from the pivot [pixels].
    pivot_sigma : float
        Standard deviation of the place where the pivot was taken to be [pixels].

    Notes
    -----
    It is the lens with which places lie best on a circle about the pivot. A lens stretches the
    circle more where it is far from the middle of the picture, and moves its centre. A narrow arc,
    or one all at the same distance from the middle, tells little. What the lens leaves of the
    distances beyond their noise may change slowly along the path, as errors of a fast pivot do, and
    does not average out.
    """
    count = int(use.sum())
    if count < _FEWEST:
        return None
    # One place for each pixel of the path: a ball that is held tells no more by resting longer.
    arm = float(np.median(np.linalg.norm(balls[use] - pivots[use], axis=1)))
    _, thin = np.unique(np.rint(arm * angles[use]), return_index=True)
    thin = thin[:: math.ceil(len(thin) / _MOST)]
    some, about = balls[use][thin], pivots[use][thin]

    def away(k1: float, balls: np.ndarray, pivots: np.ndarray) -> np.ndarray:
        lens = Optics(lens_k1=k1)
        return np.asarray(undistorted(balls, size, lens) - undistorted(pivots, size, lens))

    belief = np.zeros(2), math.hypot(pivot_sigma, _BESIDE * arm)
    left = _UNEVEN
    for _ in range(2):  # what it leaves is known once it is fitted
        sigma = math.sqrt(len(some) * (left**2 + noise**2 / count))
        fit = fit_circle(
            lambda k1: away(k1, some, about), sigma,
            robust=_ROBUST, belief=belief, extra=[0.0], limits=[_STRONGEST],
        )  # fmt: skip
        left = math.sqrt(max(fit.residual**2 - noise**2, _UNEVEN**2))
    k1 = float(fit.extra[0])
    if abs(k1) < _SURE * math.sqrt(fit.spread[3, 3]):
        return None
    true = away(k1, balls, pivots) - fit.centre
    turned = np.arctan2(true[..., 0], true[..., 1]) - angles
    return np.asarray(np.remainder(turned + math.pi, 2.0 * math.pi) - math.pi)


def undistorted(places: np.ndarray, size: tuple[int, int], optics: Optics) -> np.ndarray:
    """Return positions as a lens without distortion would show them [pixels]."""
    k1, k2 = optics.lens_k1, optics.lens_k2
    if not (k1 or k2):
        return places
    middle = (np.array(size) - 1.0) / 2.0
    unit = 0.5 * math.hypot(*size)
    seen = (places - middle) / unit
    distance = np.linalg.norm(seen, axis=-1, keepdims=True)
    true = distance.copy()
    for _ in range(30):  # a contraction for the distortions of usable lenses
        true = distance / (1.0 + k1 * true**2 + k2 * true**4)
    straight: np.ndarray = middle + seen * (true / np.maximum(distance, 1e-12)) * unit
    return straight


def distorted(places: np.ndarray, size: tuple[int, int], optics: Optics) -> np.ndarray:
    """Positions at which a lens shows undistorted places (..., 2) [pixels]."""
    middle = (np.array(size) - 1.0) / 2.0
    unit = 0.5 * math.hypot(*size)
    away = (places - middle) / unit
    squares = np.sum(away**2, axis=-1, keepdims=True)
    moved: np.ndarray = middle + away * unit * (
        1.0 + optics.lens_k1 * squares + optics.lens_k2 * squares**2
    )
    return moved
