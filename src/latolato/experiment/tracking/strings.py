"""Where the strings or rods of balls meet: most of the lines from there to a ball stand out.

A string moves with its ball, so it differs from the background all the way to the pivot. That needs
no circle: it holds for ovals, narrow arcs and several balls, wherever a string is seen.

Where a ball hardly leaves its place, its strings are near each other for a long way, and most of
such lines stand out from many places. There the string is looked for in each frame, at two heights
above the ball: at the height of the pivot, where it passes does not depend on how it leans.
"""

from __future__ import annotations

import numpy as np

from latolato.experiment.opencv import import_cv2
from latolato.experiment.tracking.background import clear_difference, difference
from latolato.experiment.tracking.detect import Copies

# Most frames that are looked at, and points on a line.
_FRAMES, _POINTS = 60, 32
# Step between places that are tried, and when refined [pixels of a small picture].
_STEP, _FINE = 3.0, 0.5
# By which factor distances of a ball from its pivot vary at most, as on ovals and about driven
# pivots, and the least of them [radii].
_VARIES, _NEAR = 1.5, 3.0
# Where the picture of the ball ends [radii], and how wide strings are at most: where those of all
# frames are nearer to each other, none of them stands out [pixels of a small picture].
_BALL, _WIDE = 1.5, 4.0
# Least share of the lines that stands out, and the part of the largest share at places that are as
# likely.
SHOWS, _LIKELY = 0.3, 0.9
# How far away others are as a share of the arm, and the largest part of the share there: anywhere,
# for where the swing is narrow strings are near each other for a long way, and to the side.
_ELSEWHERE, _LESS, _MUCH_LESS = 0.25, 0.9, 0.67
# How far about the best place others have a say, as a share of the arm.
_ABOUT = 0.05
# Scatter of a ball's places below which its strings are near each other [pixels of a small
# picture].
_NARROW = 16.0
# Heights above the ball at which a string is looked for: radii, and share of the arm. How far from
# where it is expected, at the least [pixels of a small picture], and as a share of the radius below
# and of the way that the ball goes above. Part of the clearest line's share from which others have
# a say, and how uncertain the pivot's height may be, as a share of it.
_LOW, _HIGH, _LEAST_REACH, _REACH_LOW, _REACH_HIGH = 1.5, 0.5, 4.0, 0.35, 0.25
_CLEAR, _SURE = 0.9, 0.1


class Lines:
    """What stands out in small pictures on lines from a ball.

    Parameters
    ----------
    copies : Copies
        Small pictures of all frames.
    places : numpy.ndarray, shape (frame, 2)
        Of the ball [pixels], NaN where unknown.
    radius : float
        Of the ball [pixels].
    """

    def __init__(self, copies: Copies, places: np.ndarray, radius: float) -> None:
        cv2 = import_cv2()
        frames = _spread(places)
        self.copies, self.balls = copies, copies.small(places[frames])
        self.radius = radius / copies.shrink
        size = 2 * max(1, int(np.ceil(self.radius))) + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
        wall = copies.background
        self.thin = thin = np.stack([
            cv2.morphologyEx(difference(copies.pictures[k], wall), cv2.MORPH_TOPHAT, disc)
            for k in frames
        ])  # fmt: skip
        # What always differs does not move, as an edge before a camera that shakes.
        thin = thin.astype(np.float32) - 2.0 * np.median(thin, axis=0)
        thin = np.clip(thin / clear_difference(copies.pictures, wall), 0.0, 1.0)
        self.shows = np.stack([cv2.GaussianBlur(each, (3, 3), 0) for each in thin])

    def shares(self, pivots: np.ndarray) -> np.ndarray:
        """Return which share of the lines to places (place, 2) in small pictures stands out."""
        rows, columns = self.shows.shape[1:]
        turns = np.exp(1j * np.arctan2(*np.moveaxis(self.balls - pivots[:, None], -1, 0)))
        turns = np.angle(turns / turns.mean(axis=1, keepdims=True))
        hidden = _WIDE / np.maximum(turns.std(axis=1), 1e-6)
        along = (np.arange(_POINTS) + 0.5) / _POINTS
        total = np.zeros(len(pivots))
        for shows, ball in zip(self.shows, self.balls, strict=True):
            arm = np.maximum(np.hypot(*(pivots - ball).T), 1e-6)
            start = np.minimum(_BALL * self.radius / arm, 1.0)
            end = np.maximum(1.0 - hidden / arm, 0.7 * start + 0.3)
            share = start[:, None] + (end - start)[:, None] * along
            u, v = (
                np.rint(ball[k] + share * (pivots[:, k, None] - ball[k])).astype(np.intp)
                for k in (0, 1)
            )
            inside = (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
            seen = shows[np.clip(v, 0, rows - 1), np.clip(u, 0, columns - 1)] * inside
            total += seen.sum(axis=1) / np.maximum(inside.sum(axis=1), 1)
        return total / len(self.balls)

    def share_at(self, pivot: np.ndarray) -> float:
        """Return which share of the lines to a place in the video stands out."""
        return float(self.shares(self.copies.small(pivot)[None])[0])

    def meeting(self) -> np.ndarray | None:
        """Return the place to which most of the lines stand out [pixels], None for none.

        It may lie out of the picture, by half of it. It can miss pivots of strings that are not
        seen, and of a ball that swings by less than the width of its string.
        """
        rows, columns = self.shows.shape[1:]
        size = np.array([columns, rows])
        tried = _grid(-0.5 * size, 1.5 * size, _STEP)
        away = np.linalg.norm(self.balls[:, None] - tried, axis=-1)
        near, far = np.quantile(away, [0.1, 0.9], axis=0)
        tried = tried[(far < _VARIES * near) & (near > _NEAR * self.radius)]
        if not len(tried):
            return None
        shares = self.shares(tried)
        best = tried[np.argmax(shares)]
        arm = float(np.median(np.hypot(*(self.balls - best).T)))
        down = self.balls.mean(axis=0) - best
        aside = np.abs((tried - best) @ [down[1], -down[0]]) / np.hypot(*down)
        away = np.hypot(*(tried - best).T)
        least = max(SHOWS, shares[aside > _ELSEWHERE * arm].max(initial=0.0) / _MUCH_LESS)
        if shares.max() < least:
            return None
        if np.hypot(*self.balls.std(axis=0)) < _NARROW:
            return self._crossing(best)
        if shares.max() < shares[away > _ELSEWHERE * arm].max(initial=0.0) / _LESS:
            return None
        reach = np.full(2, max(2.0 * _STEP, _ABOUT * arm))
        fine = best + _grid(-reach, reach, _FINE)
        shares = self.shares(fine)
        weights = np.maximum(shares - _LIKELY * shares.max(), 0.0)
        middle = weights @ fine / weights.sum()
        return np.asarray((middle + 0.5) * self.copies.shrink - 0.5)

    def _crossing(self, pivot: np.ndarray) -> np.ndarray | None:
        """Return where the strings of all frames cross [pixels], None where that is not sure.

        `pivot` is roughly that place [pixels of a small picture].
        """
        from scipy.stats import theilslopes

        cv2 = import_cv2()
        middle = self.balls.mean(axis=0)
        arm = float(np.hypot(*(pivot - middle)))
        up = (pivot - middle) / arm
        across = np.array([-up[1], up[0]])
        low, high = _LOW * self.radius, _HIGH * arm
        if high < 2.0 * low:
            return None
        balls = (self.balls - middle) @ across
        below, above = (
            np.arange(-reach, reach + 0.5 * _FINE, _FINE)
            for reach in np.maximum(
                [_REACH_LOW * self.radius, _REACH_HIGH * np.ptp(balls)], _LEAST_REACH
            )
        )
        along = np.linspace(0.0, 1.0, _POINTS)
        ends = []
        for thin, ball in zip(self.thin, balls, strict=True):
            # Where the string may pass at both heights, and how clear it is between them.
            pairs = np.stack(np.meshgrid(below, above), axis=-1).reshape(-1, 2)
            pairs += ball * (1.0 - np.array([low, high]) / arm)
            sides = pairs @ [1.0 - along, along]
            at = middle + (low + (high - low) * along)[:, None] * up + sides[..., None] * across
            u, v = np.moveaxis(at.astype(np.float32), -1, 0)
            share = np.sqrt(cv2.remap(thin, u, v, cv2.INTER_LINEAR)).mean(axis=1)
            weights = np.maximum(share - _CLEAR * share.max(), 0.0)
            ends.append(weights @ pairs / max(float(weights.sum()), 1e-6))
        # Only the lean is known from the string alone: a camera that shakes moves both ends.
        lows, highs = np.transpose(ends)
        lean = lows - highs
        if not np.ptp(lean) > 0.0:
            return None
        slope, side, least, most = theilslopes(lows, lean)
        heights = low + (high - low) * np.array([slope, least, most])
        if not heights[2] - heights[1] < _SURE * heights[0]:
            return None
        crossing = middle + heights[0] * up + side * across
        return np.asarray((crossing + 0.5) * self.copies.shrink - 0.5)


def _spread(places: np.ndarray) -> np.ndarray:
    """Return the numbers of frames that spread over a path (frame, 2), the slowest at each part."""
    known = np.flatnonzero(np.isfinite(places[:, 0]))
    away = places[known] - places[known].mean(axis=0)
    along = away @ np.linalg.svd(away, full_matrices=False)[2][0]
    low, high = np.quantile(along, [0.02, 0.98])
    part = np.floor(_FRAMES * (along - low) / max(high - low, 1e-6))
    speeds = np.nan_to_num(np.linalg.norm(np.gradient(places, axis=0), axis=1)[known], nan=np.inf)
    order = np.lexsort((speeds, part))
    return known[order[np.unique(part[order], return_index=True)[1]]]


def _grid(low: np.ndarray, high: np.ndarray, step: float) -> np.ndarray:
    """Return places (place, 2) between two, by a step."""
    across, down = (np.arange(*each, step) for each in zip(low, high + 0.5 * step, strict=True))
    return np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)
