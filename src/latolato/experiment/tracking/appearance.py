"""What balls and background look like, learned from a sample of frames before tracking."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from latolato.experiment.tracking.kernels import fitting
from latolato.experiment.tracking.kernels import layers as kernels
from latolato.experiment.tracking.kernels.layers import Ball, Patch
from latolato.experiment.video import Video

# First steps take residuals this much larger for what they are, to be drawn from farther away.
_TOLERANT = 4.0
# Balls beyond these radii need every second pixel, and every fifth one only [pixels].
_LARGE, _LARGEST = 14.0, 28.0
# Distance of samples along the path of a smeared ball: its edge is as soft as that [pixels].
_SPACING = 2.0


_UNCHANGED = np.eye(3, dtype=np.float32)


class Colours(NamedTuple):
    """Turns coded planes into linear light."""

    table: np.ndarray
    mix: np.ndarray

    @classmethod
    def of(cls, video: Video) -> Colours:
        """Return the conversion that a video's tags ask for."""
        mix = kernels.colour_coefficients(video.matrix, video.is_full_range)
        return cls(kernels.linear_light(video.tone), mix)

    def window(
        self,
        planes: tuple[np.ndarray, ...],
        corner: Sequence[int] | np.ndarray,
        shape: tuple[int, int],
        whiten: np.ndarray = _UNCHANGED,
        every: int = 1,
    ) -> np.ndarray:
        """Return the colours of a window, shape (row, column, 3); NaN outside the frame.

        `whiten` is a matrix by which colours are multiplied.
        """
        out = np.empty((*shape, 3), np.float32)
        at = int(corner[0]), int(corner[1])
        kernels.window(planes, at, (self.table, self.mix), whiten, every, out)
        return out


@dataclass
class Appearance:
    """The layers of the image: balls that move in front of a background that does not.

    Attributes
    ----------
    radius, blur : float
        Radius of the balls, or half the width of other bobs, and softness of the edge [pixels].
    paint : numpy.ndarray, shape (ball, row, column, 3)
        Linear colour of each ball about its centre; one for all that look alike.
    behind : numpy.ndarray, shape (row, column, 3)
        Whitened colour of the background from `corner` on, NaN where it was never seen; it is
        made of the linear one that is given.
    weight : numpy.ndarray, shape (3, 3)
        Inverse covariance of the background's residuals (noise, shadows, compression).
    scale : float
        Whitened residual beyond which a pixel belongs to something else.
    exposure : float
        Share of the frame interval in which light is collected.
    radius_sigma : float
        Standard deviation of the radius [pixels].
    is_spinning : bool
        Whether the paint turns with the rod, as a pattern does, or stays, as shading does.
    shading : numpy.ndarray, shape (ball, row, column, 3), or None
        Linear colour that is added to a paint that turns, and stays.
    variance : numpy.ndarray, shape (ball, row, column)
        By how much more than the background's the whitened colours vary about the paint, each.
    body : numpy.ndarray of bool, shape (row, column), or None
        Which part of the paint is the bob, if it is no disc.
    whiten : numpy.ndarray, shape (3, 3)
        The matrix that makes residuals white.
    white_paint, white_shading : numpy.ndarray, shape (ball, row, column, 4)
        The colours of paint and shading times it, and the share that a ball covers.
    """

    colours: Colours
    radius: float
    blur: float
    paint: np.ndarray
    behind: np.ndarray
    corner: np.ndarray
    weight: np.ndarray
    scale: float
    exposure: float = 0.0
    radius_sigma: float = 0.0
    is_spinning: bool = False
    shading: np.ndarray | None = None
    variance: np.ndarray = field(default_factory=lambda: np.zeros((1, 1, 1), np.float32))
    body: np.ndarray | None = None
    whiten: np.ndarray = field(init=False)
    white_paint: np.ndarray = field(init=False)
    white_shading: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.whiten = _UNCHANGED
        self.whitened()

    def whitened(self) -> None:
        """Bring the whitened colours into step with what they are made of."""
        whiten = np.linalg.cholesky(self.weight).T.astype(np.float32)
        if (whiten != self.whiten).any():
            change = np.linalg.inv(self.whiten).T @ whiten.T
            for row in self.behind:  # in place: the picture may be large
                row[:] = row @ change
            self.whiten = whiten
        share = np.ones(self.paint.shape[1:3]) if self.body is None else self.body
        white = (self.paint @ self.whiten.T) * share[..., None]
        shares = np.broadcast_to(share[..., None], (*self.paint.shape[:3], 1))
        self.white_paint = np.concatenate([white, shares], axis=-1).astype(np.float32)
        shading = np.zeros((1, 1, 1, 3)) if self.shading is None else self.shading @ self.whiten.T
        self.white_shading = np.pad(shading, ((0, 0),) * 3 + ((0, 1),)).astype(np.float32)

    @property
    def reach(self) -> float:
        """How far from its centre a ball reaches [pixels]."""
        return self.radius if self.body is None else reach_of(self.body) + 2.0 * self.blur

    @property
    def core(self) -> np.ndarray:
        """Which part of the paint is surely the ball's, shape (row, column)."""
        if self.body is not None:
            return self.body
        m = (self.paint.shape[1] - 1) // 2
        return np.asarray(np.hypot(*(np.indices(self.paint.shape[1:3]) - m)) < 0.8 * self.radius)

    def number(self, ball: int) -> int:
        """Return which of the paints is that of a ball."""
        return min(ball, len(self.paint) - 1)

    def drawn(self, *balls: int) -> Ball:
        """How the kernels draw some balls, one or neighbours in ascending order, whitened."""
        looks = self.white_paint, self.white_shading, self.variance
        if len(self.paint) == 1:
            return Ball(self.reach, self.blur, *looks, self.is_spinning)
        own = slice(balls[0], balls[-1] + 1)
        paint, shading, variance = (each[own] if len(each) > 1 else each for each in looks)
        return Ball(self.reach, self.blur, paint, shading, variance, self.is_spinning)

    def ball(
        self,
        ball: int,
        path: np.ndarray,
        pivot: np.ndarray,
        corner: np.ndarray,
        shape: tuple[int, int],
    ) -> np.ndarray:
        """Return one ball's whitened layer in a window, averaged over the centres in `path`."""
        layer = np.zeros((*shape, 4), np.float32)
        fitting.draw(path, np.zeros(2), pivot, self.drawn(ball), 0, corner.astype(float), layer)
        return layer

    def patch(
        self,
        planes: tuple[np.ndarray, ...],
        corner: np.ndarray,
        shape: tuple[int, int],
        every: int = 1,
    ) -> Patch:
        """Return a window of a frame and its background in whitened colours."""
        seen = self.colours.window(planes, corner, shape, self.whiten, every)
        behind = self.background(corner, shape)
        return Patch(seen, behind, corner.astype(float), every)

    def wall(self, corner: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
        """Return the background of a window in linear light."""
        return self.background(corner, shape) @ np.linalg.inv(self.whiten).T

    def background(self, corner: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
        """Return the whitened background of a window; NaN beyond the part that was learned."""
        x, y = np.asarray(corner) - self.corner
        height, width = self.behind.shape[:2]
        rows, columns = shape
        if x >= 0 and y >= 0 and x + columns <= width and y + rows <= height:
            return self.behind[y : y + rows, x : x + columns]
        out = np.full((rows, columns, 3), np.nan, np.float32)
        left, top = max(x, 0), max(y, 0)
        known = self.behind[top : max(y + rows, 0), left : max(x + columns, 0)]
        out[top - y :, left - x :][: known.shape[0], : known.shape[1]] = known
        return out


@dataclass(frozen=True)
class BallFit:
    """Balls fitted to one frame.

    Attributes
    ----------
    shift : numpy.ndarray, shape (ball, 2)
        What is to be added to the expected centres [pixels].
    covariance : numpy.ndarray, shape (2 ball, 2 ball)
        Of the shifts, from the residuals.
    explained, hidden : numpy.ndarray, shape (ball,)
        Shares of a ball's pixels that look like a ball, and like the background instead.
    cost : float
        Mean bounded squared residual per pixel.
    """

    shift: np.ndarray
    covariance: np.ndarray
    explained: np.ndarray
    hidden: np.ndarray
    cost: float


def fit_balls(
    look: Appearance,
    planes: tuple[np.ndarray, ...],
    paths: Mapping[int, np.ndarray],
    pivot: np.ndarray,
    rounds: int = 6,
    tolerant: int = 1,
) -> BallFit:
    """Move balls from where they are expected until they explain a frame (Gauss-Newton).

    Parameters
    ----------
    look : Appearance
        What to expect.
    planes : tuple of numpy.ndarray
        The frame.
    paths : mapping of int to numpy.ndarray, shape (sample, 2)
        Centres of each ball, by its number, within the exposure; the fit shifts them as a whole.
    pivot : numpy.ndarray
        Pivot (column, row), from which rods run.
    rounds, tolerant : int
        Most steps, and how many of them overlook large residuals to be drawn from farther away.
    """
    margin = 1.35 * look.reach + 2.0 * look.blur + 3.0
    everything = np.concatenate(list(paths.values()))
    low = np.floor(everything.min(axis=0) - margin).astype(int)
    high = np.ceil(everything.max(axis=0) + margin).astype(int)
    shape = (int(high[1] - low[1] + 1), int(high[0] - low[0] + 1))
    every = 5 if look.radius > _LARGEST else 2 if look.radius > _LARGE else 1
    patch = look.patch(planes, low, shape, every=every)
    scales = np.full(rounds, look.scale)
    scales[:tolerant] *= _TOLERANT
    ends, drawn = np.cumsum([len(path) for path in paths.values()]), look.drawn(*paths)
    cost, shift, matrix, tally = fitting.settle(patch, everything, ends, pivot, drawn, scales)
    pixels = np.maximum(tally[:, 0], 1.0)
    covariance = np.linalg.inv(matrix)
    cost *= every / (shape[0] * shape[1])
    return BallFit(shift, covariance, tally[:, 1] / pixels, tally[:, 2] / pixels, cost)


def reach_of(body: np.ndarray) -> float:
    """Return how far from its middle a body (row, column) reaches [pixels]."""
    middle = (np.array(body.shape) - 1) / 2
    return float(np.linalg.norm(np.argwhere(body) - middle, axis=1).max())


def arc(pivots: np.ndarray, angles: np.ndarray, arm: float | np.ndarray) -> np.ndarray:
    """Return centres of a ball for pivots (sample, 2) and angles from straight down (sample,).

    The arm may be another one at each angle, as on an oval.
    """
    away = np.stack([np.sin(angles), np.cos(angles)], axis=-1)
    return np.asarray(pivots + np.expand_dims(arm, -1) * away)


def samples_for(length: float) -> int:
    """Return how many samples make a smear of some pixels smooth."""
    return max(1, math.ceil(length / _SPACING))
