"""The edge of a ball: radius and softness, measured together with the colours on its two sides."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from latolato.experiment.rules import broken

# Luminance of linear light (BT.709), and the share of the largest contrast that must be in it.
_LUMA = np.array([0.2126, 0.7152, 0.0722])
_BRIGHT = 0.17
# Sectors around the ball that have colours of their own, and pixels that are enough.
_SECTORS, _MOST = 16, 7000
# Most places along the path of a smeared ball.
_PLACES = 6
# Half-width of the ring that is looked at: shares of the radius, nearby and far.
_RING, _FAR_RING = 0.16, 0.32
# Most steps towards the edge, when to stop [pixels], the steps of its slopes [pixels], and the
# residual that counts half, in standard deviations.
_ROUNDS, _CONVERGED, _STEP, _OUTLYING = 8, 0.02, 0.05, 3.0
# How firmly the wall about a ball is what was learned of it, and colours do not change outwards.
_FIRM, _FLAT = 0.03, 1e-3
# Error of the radius that no scatter shows, as a share of the softness.
_UNSEEN = 0.25
# Smallest softness, and largest as a share of the radius.
_SHARP, _SOFT = 0.35, 0.25
# Part of the ball's radius beyond which the rod is left out, and the half-width left out there.
_ROD_BEGINS, _ROD_HALF_WIDTH = 0.5, 0.3


@dataclass(frozen=True)
class Shot:
    """A ball in a frame, cut out.

    Attributes
    ----------
    image, wall : numpy.ndarray, shape (row, column, 3)
        Linear colours seen and those of the background.
    path : numpy.ndarray, shape (sample, 2)
        The ball's centres within the exposure, in the cut-out's pixels.
    pivot : numpy.ndarray, shape (2,)
        The pivot in the cut-out's pixels.
    turn : float
        By how much the ball's colours are turned [rad].
    others : numpy.ndarray, shape (ball, 2)
        Centres of other balls.
    look : int
        Which of several looks the ball has: balls that look different have colours of their own.
    """

    image: np.ndarray
    wall: np.ndarray
    path: np.ndarray
    pivot: np.ndarray
    turn: float
    others: np.ndarray
    look: int


@dataclass(frozen=True)
class Edge:
    """Radius and softness of an edge, and the radius's standard deviation [pixels]."""

    radius: float
    blur: float
    sigma: float


@dataclass
class _Ring:
    """Pixels about the edge: value, wall, distances from the path's places, sector, shot.

    Sectors of balls that look different have different numbers.
    """

    value: np.ndarray
    wall: np.ndarray
    away: np.ndarray
    middle: np.ndarray
    sector: np.ndarray
    shot: np.ndarray


def measured_edge(shots: list[Shot], radius: float, blur: float, is_far: bool) -> Edge:
    """Return the edge that explains the shots best.

    Across the edge a pixel is ``(1 - a) w B + a P`` with the share ``a`` that the ball covers, the
    learned background ``B`` and colours ``P`` and shadows ``w`` that may change linearly outwards
    and from sector to sector: what is learned of the paint beforehand cannot decide where it ends.

    Parameters
    ----------
    shots : list of Shot
        Slow balls.
    radius, blur : float
        Where to begin [pixels].
    is_far : bool
        Whether the radius may be far from where to begin.

    Raises
    ------
    InputError
        If no shot shows the ball's rim and the background there.
    """
    if is_far:
        trials = radius * np.linspace(0.8, 1.25, 19)
        ring = _ring(shots, radius, _FAR_RING * radius)
        one = np.ones(len(ring.value))
        costs = [_residual(ring, np.array([trial, blur]), one)[1] for trial in trials]
        radius = float(trials[int(np.argmin(costs))])
    low, high = np.array([0.85 * radius, _SHARP]), np.array([1.15 * radius, _SOFT * radius])
    at = np.clip([radius, blur], low, high)
    for _ in range(_ROUNDS):
        # The ring moves with the edge, or where it begins would decide where it ends.
        ring = _ring(shots, float(at[0]), max(_RING * float(at[0]), 3.0 * float(at[1]) + 1.5))
        new, gradient, bend = _stepped(ring, at)
        new = np.clip(new, low, high)
        moved, at = float(np.max(np.abs(new - at))), new
        if moved < _CONVERGED:
            break
    # What the colours do within the softness of the edge nobody sees.
    sigma = math.hypot(_spread(ring, gradient, bend), _UNSEEN * float(at[1]))
    return Edge(float(at[0]), float(at[1]), sigma)


def _stepped(ring: _Ring, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a better radius and softness (Gauss-Newton), each pixel's slope, and the curvature."""
    rest, _ = _residual(ring, at, np.ones(len(ring.value)))
    for _ in range(2):
        scale = _OUTLYING * 1.4826 * float(np.median(np.abs(rest))) + 1e-6
        weight = 1.0 / (1.0 + (rest / scale) ** 2) ** 2
        rest, _ = _residual(ring, at, weight)
    slopes = np.stack(
        [
            (_residual(ring, at + one, weight)[0] - _residual(ring, at - one, weight)[0])
            / (2.0 * _STEP)
            for one in _STEP * np.eye(2)
        ],
        axis=-1,
    )
    gradient = weight[:, None] * slopes * rest[:, None]
    bend = slopes.T @ (weight[:, None] * slopes) + 1e-12 * np.eye(2)
    step = -np.linalg.solve(bend, gradient.sum(axis=0))
    step[0] = np.clip(step[0], -0.06 * at[0], 0.06 * at[0])
    step[1] = np.clip(step[1], -0.4 * at[1], 0.6 * at[1])
    return at + step, gradient, bend


def _spread(ring: _Ring, gradient: np.ndarray, bend: np.ndarray) -> float:
    """Return the radius's standard deviation from how shots, and sectors, disagree about it."""
    inverse = np.linalg.inv(bend)
    variances = []
    for labels in (ring.shot, ring.sector):
        parts = np.stack(
            [np.bincount(labels, gradient[:, k], minlength=labels.max() + 1) for k in range(2)],
            axis=-1,
        )
        parts = parts[np.bincount(labels) > 0]
        parts = parts - parts.mean(axis=0)
        variances.append(float((inverse @ (parts.T @ parts) @ inverse)[0, 0]))
    return math.sqrt(max(variances))


def _ring(shots: list[Shot], radius: float, half: float) -> _Ring:
    """Return the pixels of all shots near the edge."""
    lists: list[list[np.ndarray]] = [[] for _ in range(6)]
    direction = _direction(shots, radius)
    places_each = min(max(len(shot.path) for shot in shots), _PLACES)
    every = max(1, int(4.0 * math.pi * radius * half * len(shots) / _MOST))
    for k, shot in enumerate(shots):
        centre = shot.path.mean(axis=0)
        smear = 0.5 * float(np.hypot(*(shot.path[-1] - shot.path[0])))
        j, i = np.ogrid[: shot.image.shape[0], : shot.image.shape[1]]
        middle = np.hypot(i - centre[0], j - centre[1])
        # The ring first: what follows takes a multiple of this.
        near = np.flatnonzero(np.abs(middle - radius) < half + smear)[::every]
        rows, columns = np.unravel_index(near, middle.shape)
        middle, places = middle[rows, columns], np.stack([columns, rows], axis=-1)
        out = places - centre
        rod = (shot.pivot - centre) / max(float(np.hypot(*(shot.pivot - centre))), 1e-9)
        use = ~(
            (out @ rod > _ROD_BEGINS * radius)
            & (np.abs(out @ np.array([rod[1], -rod[0]])) < _ROD_HALF_WIDTH * radius)
        )
        for other in shot.others:
            use &= np.hypot(*(places - other).T) > 1.35 * radius + smear
        value = shot.image[rows, columns] @ direction
        wall = shot.wall[rows, columns] @ direction
        use &= np.isfinite(value) & np.isfinite(wall)
        angle = np.arctan2(out[use, 0], out[use, 1]) - shot.turn
        sector = np.floor((angle / (2.0 * np.pi) % 1.0) * _SECTORS).astype(int) % _SECTORS
        sector += _SECTORS * shot.look
        # All shots have as many places: those between samples of the path's are interpolated.
        at = (np.arange(places_each) + 0.5) / places_each * len(shot.path) - 0.5
        path = np.stack([np.interp(at, range(len(shot.path)), one) for one in shot.path.T], axis=1)
        away = np.hypot(*(places[use][:, None] - path[None]).transpose(2, 0, 1))
        for parts, part in zip(
            lists,
            (value[use], wall[use], away, middle[use], sector, np.full(int(use.sum()), k)),
            strict=True,
        ):
            parts.append(part)
    ring = _Ring(*(np.concatenate(parts) for parts in lists))
    if not len(ring.value):
        raise broken("hidden_rim")
    return ring


def _direction(shots: list[Shot], radius: float) -> np.ndarray:
    """Return the colour by which the ball differs: brightness, if it differs enough in that.

    Colour is stored at half the resolution and suffers first from compression.
    """
    gaps = []
    for shot in shots:
        j, i = np.indices(shot.image.shape[:2])
        away = np.hypot(i - shot.path[:, 0].mean(), j - shot.path[:, 1].mean())
        rim = (away < 0.9 * radius) & (away > 0.6 * radius)
        gaps.append((shot.image - shot.wall)[rim])
    gap = np.concatenate(gaps)
    gap = gap[np.isfinite(gap).all(axis=1)]
    if not len(gap):
        raise broken("hidden_rim")
    size = np.sqrt(np.mean(gap**2, axis=0))
    if math.sqrt(float(np.mean((gap @ _LUMA) ** 2))) > _BRIGHT * float(size.max()):
        return _LUMA
    _, _, axes = np.linalg.svd(gap, full_matrices=False)
    return np.asarray(axes[0])


def _residual(ring: _Ring, at: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, float]:
    """The edge's residual, shape (pixel,), and cost with the best colours on both sides."""
    radius, blur = float(at[0]), float(at[1])
    depth = np.clip((radius - ring.away) / blur, -2.0, 2.0)
    share = np.mean(0.5 + depth * (0.375 - depth * depth * 0.03125), axis=1)
    outwards = ring.middle / radius - 1.0
    behind = (1.0 - share) * ring.wall
    columns = [share, share * outwards, behind, behind * outwards]
    target = ring.value - behind
    count = int(ring.sector.max()) + 1
    matrix, vector = np.empty((count, 4, 4)), np.empty((count, 4))
    for m in range(4):
        own = weight * columns[m]
        vector[:, m] = np.bincount(ring.sector, own * target)
        for n in range(m + 1):
            matrix[:, m, n] = matrix[:, n, m] = np.bincount(ring.sector, own * columns[n])
    for m, firm in ((1, _FLAT), (2, _FIRM), (3, _FIRM)):
        matrix[:, m, m] *= 1.0 + firm
    matrix += 1e-9 * np.eye(4)
    colours = np.linalg.solve(matrix, vector[..., None])[..., 0]
    rest = target - sum(columns[m] * colours[ring.sector, m] for m in range(4))
    return rest, float(np.sum(weight * rest**2))
