"""Balls that are too small for an edge: bright or dark dots, by the middle of what they change."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from latolato.experiment.tracking.appearance import BallFit
from latolato.experiment.tracking.route import Route
from latolato.experiment.tracking.sample import Sample, median_planes

# Radius below which a ball is a dot [pixels]; only what is as small as this many pixels of a small
# picture may be one. How many of the slowest frames are looked at.
_SMALLEST_DISC, _SMALL, _SLOWEST = 3.0, 2.0, 7
# How far about the path of a dot is looked: radii and pixels.
_ABOUT, _LOOSE = 3.0, 3.0
# Part of the largest difference from the wall from which a pixel belongs to the dot.
_OWN = 0.25
# Error of a dot's middle that noise does not show [pixels]: its pixels are few and coded.
_COARSE = 0.15


@dataclass
class Dot:
    """How a dot is found in frames.

    Attributes
    ----------
    behind : numpy.ndarray, shape (row, column)
        Luma of the background.
    limit : float
        Least difference from it that is no noise [steps of 255].
    radius, radius_sigma : float
        Of the dot, and its standard deviation [pixels].
    exposure : float
        Share of the frame interval in which light is collected.
    change : float
        Sum of the differences that a dot typically makes [steps of 255].
    is_spinning : bool
        Whether its colours turn: no dot shows that.
    body : None
        It is as good as round.
    """

    behind: np.ndarray
    limit: float
    radius: float
    radius_sigma: float
    exposure: float
    change: float = 0.0
    is_spinning: bool = False
    body: None = None

    def fit(
        self,
        planes: tuple[np.ndarray, ...],
        paths: list[np.ndarray],
        pivot: np.ndarray,
        rounds: int = 6,
        tolerant: int = 1,
    ) -> BallFit:
        """Move dots to the middles of what differs from the wall about their paths.

        Parameters and result are those of `latolato.experiment.tracking.appearance.fit_balls`.
        `tolerant` widens where is looked; a pixel belongs to the path that is nearest. That a dot
        looks like the wall shows in how little of it is explained.
        """
        balls = len(paths)
        shift, covariance = np.zeros((balls, 2)), np.zeros((2 * balls, 2 * balls))
        totals = np.zeros(balls)
        for b, (total, centre) in enumerate(self.middles(planes, paths, 1.0 + tolerant)):
            totals[b] = total
            shift[b] = centre - paths[b].mean(axis=0)
            error = _COARSE**2 + (self.limit / max(total, 1.0)) ** 2 * self.radius**2
            covariance[2 * b : 2 * b + 2, 2 * b : 2 * b + 2] = np.eye(2) * error
        explained = np.minimum(totals / max(self.change, 1e-9), 1.0)
        return BallFit(shift, covariance, explained, np.zeros(balls), 0.0)

    def middles(
        self, planes: tuple[np.ndarray, ...], paths: list[np.ndarray], wide: float
    ) -> list[tuple[float, np.ndarray]]:
        """Return the sum of the differences about each path, and their middle [pixels]."""
        reach = (_ABOUT * self.radius + _LOOSE) * wide
        everything = np.concatenate(paths)
        low = np.maximum(np.floor(everything.min(axis=0) - reach).astype(int), 0)
        high = np.ceil(everything.max(axis=0) + reach).astype(int) + 1
        part = np.s_[low[1] : high[1], low[0] : high[0]]
        apart = np.abs(planes[0][part].astype(float) - self.behind[part])
        rows, columns = np.indices(apart.shape)
        places = np.stack([columns, rows], axis=-1) + low
        away = np.stack([_distances(places, path) for path in paths])
        nearest = np.argmin(away, axis=0)
        found = []
        for b, path in enumerate(paths):
            own = (nearest == b) & (away[b] < reach)
            floor = max(self.limit, _OWN * float(apart[own].max(initial=0.0)))
            weight = np.where(own & (apart > floor), apart, 0.0)
            total = float(weight.sum())
            middle = np.tensordot(weight, places, 2) / total if total else path.mean(axis=0)
            found.append((total, middle))
        return found


def dot_radius(sample: Sample, route: Route) -> float:
    """Return the radius of dots [pixels], NaN for balls that are large enough for an edge.

    It is that of a disc of as many pixels as differ by half of what the clearest one does, in
    frames in which they are slow.
    """
    if not route.radius < _SMALL * max(sample.copies.shrink, 2.0):
        return math.nan
    behind = median_planes(sample.frames[::3])[0]
    speeds = np.linalg.norm(route.velocities[0], axis=-1)
    seen = [
        (float(speeds[frame.number, b]), frame, route.places[frame.number, b])
        for frame in sample.frames
        for b in np.flatnonzero(route.is_seen[frame.number] & np.isfinite(speeds[frame.number]))
    ]
    reach, radii = math.ceil(2.0 * route.radius) + 3, []
    for _, frame, place in sorted(seen, key=lambda one: one[0])[:_SLOWEST]:
        left, top = np.maximum(np.rint(place).astype(int) - reach, 0)
        part = np.s_[top : top + 2 * reach + 1, left : left + 2 * reach + 1]
        apart = np.abs(frame.luma[part].astype(float) - behind[part])
        radii.append(math.sqrt(np.count_nonzero(apart > 0.5 * apart.max()) / math.pi))
    radius = float(np.median(radii)) if radii else math.nan
    return radius if radius < _SMALLEST_DISC else math.nan


def _distances(places: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Return how far places (row, column, 2) are from the nearest of some centres."""
    away = places[..., None, :] - path
    return np.asarray(np.min(np.hypot(away[..., 0], away[..., 1]), axis=-1))
