"""The circle on which a ball is seen, by least squares: with beliefs, lenses, ovals and drives."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

# Least error of a place [pixels].
_LEAST = 0.45


@dataclass(frozen=True)
class Bow:
    """A circle by a point on it, its direction there, and its curvature: all finite if straight.

    Attributes
    ----------
    origin, outwards : numpy.ndarray, shape (2,)
        A place near the path [pixels], and a unit vector across it.
    unit : float
        Extent of the path [pixels].
    shape : numpy.ndarray, shape (3,)
        How far the path is outside the origin [unit], its turn from the direction of `outwards`
        [rad], and its curvature towards the other side [1/unit].
    """

    origin: np.ndarray
    outwards: np.ndarray
    unit: float
    shape: np.ndarray

    @classmethod
    def through(cls, points: np.ndarray) -> Bow:
        """Return roughly the circle of places."""
        middle = points.mean(axis=0)
        away = points - middle
        # x^2 + y^2 = 2 a x + 2 b y + c is linear.
        columns = np.column_stack([2.0 * away, np.ones(len(away))])
        a, b, c = np.linalg.lstsq(columns, (away**2).sum(axis=1), rcond=None)[0]
        distance = max(math.hypot(a, b), 1e-6)
        arm = math.sqrt(max(c + a * a + b * b, 1.0))
        unit = max(float(np.hypot(*np.ptp(away, axis=0))), 1.0)
        shape = np.array([(arm - distance) / unit, 0.0, unit / arm])
        return cls(middle, np.array([-a, -b]) / distance, unit, shape)

    def about(self, centre: np.ndarray) -> Bow:
        """Return the circle about a centre through the origin."""
        away = self.origin - centre
        across = _turned(self.outwards, 0.5 * math.pi)
        turn = math.atan2(float(away @ across), float(away @ self.outwards))
        bend = self.unit / max(float(np.hypot(*away)), 1e-9)
        return replace(self, shape=np.array([0.0, turn, bend]))

    @property
    def circle(self) -> np.ndarray:
        """Column, row and radius [pixels], shape (3,)."""
        height, turn, bend = self.shape
        bend = bend or 1e-12
        place = self.unit * (height * self.outwards - _turned(self.outwards, turn) / bend)
        return np.append(self.origin + place, self.unit / abs(bend))

    @property
    def slopes(self) -> np.ndarray:
        """Derivatives of column, row and radius by the shape, shape (3, 3)."""
        _, turn, bend = self.shape
        bend = bend or 1e-12
        outwards, across = _turned(self.outwards, turn), _turned(self.outwards, turn + math.pi / 2)
        place = np.column_stack([self.outwards, -across / bend, outwards / bend**2])
        return np.asarray(
            self.unit * np.vstack([place, [0.0, 0.0, -math.copysign(1.0, bend) / bend**2]])
        )

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Return how far places are outside the circle [pixels]."""
        height, turn, bend = self.shape
        outwards = _turned(self.outwards, turn)
        away = (points - self.origin) / self.unit - height * self.outwards
        inside = -(away @ outwards) - 0.5 * bend * np.sum(away**2, axis=1)
        root = np.sqrt(np.maximum(1.0 - 2.0 * bend * inside, 0.0))
        return np.asarray(-2.0 * self.unit * inside / (1.0 + root))


@dataclass(frozen=True)
class CircleFit:
    """A circle fitted to places in the picture.

    Attributes
    ----------
    bow : Bow
        The circle.
    extra : numpy.ndarray, shape (extra,)
        What else was fitted.
    spread : numpy.ndarray, shape (3 + extra, 3 + extra)
        Covariance of the bow's shape and the extra parameters.
    distances : numpy.ndarray, shape (place,)
        How far the places are outside the circle [pixels].
    slopes : numpy.ndarray, shape (place, 3 + extra)
        Derivatives of the distances by the parameters, less for places far off [pixels].
    """

    bow: Bow
    extra: np.ndarray
    spread: np.ndarray
    distances: np.ndarray
    slopes: np.ndarray

    @property
    def centre(self) -> np.ndarray:
        """Column and row [pixels]."""
        return self.bow.circle[:2]

    @property
    def arm(self) -> float:
        """Radius [pixels]."""
        return float(self.bow.circle[2])

    @property
    def covariance(self) -> np.ndarray:
        """Of column, row and radius [pixels^2], shape (3, 3)."""
        slopes = self.bow.slopes
        return np.asarray(slopes @ self.spread[:3, :3] @ slopes.T)

    @property
    def vague(self) -> float:
        """Error of the centre over the arm, of places with errors as large as the residual."""
        spread = math.sqrt(float(np.trace(self.covariance[:2, :2])))
        return spread * max(self.residual, _LEAST) / self.arm

    @property
    def residual(self) -> float:
        """Robust standard deviation of the distances [pixels]."""
        return 1.4826 * float(np.median(np.abs(self.distances)))


def fit_circle(
    places: Callable[..., np.ndarray],
    sigma: float,
    *,
    robust: float = math.inf,
    extra: Sequence[float] = (),
    limits: Sequence[float] = (),
    belief: tuple[np.ndarray, float] | None = None,
    bent: np.ndarray | None = None,
) -> CircleFit:
    """Return the circle nearest to places.

    Parameters
    ----------
    places : callable
        Places (place, 2) for extra parameters [pixels]: without a lens's distortion, from a pivot
        that moves, or stretched.
    sigma : float
        Error of one of them [pixels].
    robust : float
        Distance beyond which places count less [pixels].
    extra, limits : sequence of float
        Where extra parameters start, and their largest size.
    belief : tuple of numpy.ndarray, shape (2,), and float, optional
        Where the centre is beforehand, and the error of that [pixels].
    bent : numpy.ndarray, shape (place, 2), optional
        An error of all of them by one and the same number with a standard deviation of 1.
    """
    from scipy.optimize import least_squares

    start = Bow.through(places(*extra))
    if belief is not None:
        start = replace(start, shape=start.about(belief[0]).shape)

    def softened(off: np.ndarray) -> np.ndarray:
        return np.asarray(
            np.sign(off) * robust * np.sqrt(2.0 * (np.hypot(1.0, off / robust) - 1.0))
            if math.isfinite(robust)
            else off
        )

    def rest(p: np.ndarray) -> np.ndarray:
        bow = replace(start, shape=p[:3])
        off = softened(bow.distances(places(*p[3:]))) / sigma
        if belief is None:
            return off
        return np.append(off, (bow.circle[:2] - belief[0]) / belief[1])

    far = np.append(np.full(3, math.inf), limits or np.full(len(extra), math.inf))
    fit = least_squares(
        rest, [*start.shape, *extra], bounds=(-far, far), x_scale="jac", max_nfev=200
    )
    bow, points = replace(start, shape=fit.x[:3]), places(*fit.x[3:])
    spread = np.linalg.pinv(fit.jac.T @ fit.jac)
    off, slopes = bow.distances(points), sigma * fit.jac[: len(points)]
    if bent is not None:
        shift = spread @ (slopes.T @ (bow.distances(points + bent) - off)) / sigma**2
        spread = spread + np.outer(shift, shift)
    return CircleFit(bow, fit.x[3:], spread, off, slopes)


def _turned(vector: np.ndarray, angle: float) -> np.ndarray:
    """Return a vector turned by an angle [rad]."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])
