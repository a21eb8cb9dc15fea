"""What moves in each frame of a clip: small pictures of all frames, and blobs that differ in them.

A blob is a connected set of pixels that differ from the clip's background. Rods and
shadows are cut off: a rod is thinner than half the ball at its end, and a shadow differs by less
than the ball that casts it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from latolato.experiment.opencv import import_cv2
from latolato.experiment.tracking.background import (
    background_of,
    clear_difference,
    difference,
)
from latolato.experiment.video import Frame

# Pixels of a small picture, and of those of a whole clip together.
_PIXELS, _ALL_PIXELS = 100_000, 90_000_000
# Part of a thing's own difference from which a pixel belongs to it, and not to its shadow.
_OWN = 0.45
# How far colours may be from one that is looked for [steps of 255]; light may be twice as far.
_SAME_COLOUR, _WEIGHTS = 20.0, np.array([2.0, 1.0, 1.0])
# Half widths of rods of which parts of a pixel count [pixels of a small picture].
_SMALL = 1.0, 2.0
# Fewest pixels of a small picture that make a blob.
_FEWEST = 3
# Blobs of a frame that are kept, the clearest first.
_MOST = 40


class Blobs(NamedTuple):
    """What moves in one frame.

    Attributes
    ----------
    places : numpy.ndarray, shape (blob, 2)
        Centres, column and row [pixels of the video].
    radii, lengths : numpy.ndarray, shape (blob,)
        Half the width of an ellipse of the same second moments, and half its length [pixels].
    contrasts : numpy.ndarray, shape (blob,)
        How much a blob differs from the background [steps of 255].
    colours, walls : numpy.ndarray, shape (blob, 3)
        Median luma, blue and red chroma, and those of the background there.
    """

    places: np.ndarray
    radii: np.ndarray
    lengths: np.ndarray
    contrasts: np.ndarray
    colours: np.ndarray
    walls: np.ndarray

    @classmethod
    def of(cls, rows: list[tuple[float, ...]], shrink: int) -> Blobs:
        """Return blobs of rows of numbers in pixels of a small picture, the clearest first."""
        table = np.array(rows, float).reshape(-1, 11)
        table = table[np.argsort(-table[:, 4] * table[:, 2], kind="stable")[:_MOST]]
        places = (table[:, :2] + 0.5) * shrink - 0.5
        radii, lengths = shrink * table[:, 2:4].T
        return cls(places, radii, lengths, table[:, 4], table[:, 5:8], table[:, 8:])

    def without(self, number: int) -> Blobs:
        """Return the other blobs."""
        return Blobs(*(np.delete(values, number, axis=0) for values in self))


@dataclass(frozen=True)
class Copies:
    """Small pictures of all frames of a clip.

    Attributes
    ----------
    pictures : numpy.ndarray, shape (frame, row, column, 3)
        Luma, blue and red chroma, in steps of 255.
    shrink : int
        Columns and rows of the video in a pixel of a small picture.
    bounds : tuple of numpy.ndarray, shape (2,)
        First column and row in which balls are looked for, and the first ones beyond [pixels].
    """

    pictures: np.ndarray
    shrink: int
    bounds: tuple[np.ndarray, np.ndarray]

    @classmethod
    def none(cls) -> Copies:
        """Return no pictures."""
        return cls(np.zeros((0, 1, 1, 3), np.uint8), 1, (np.zeros(2, int), np.zeros(2, int)))

    @cached_property
    def blobs(self) -> list[Blobs]:
        """What moves in each frame: see `detect`."""
        return detect(self)

    @cached_property
    def background(self) -> np.ndarray:
        """Picture of the clip without what moves, shape (row, column, 3)."""
        return background_of(self.pictures)

    def small(self, places: np.ndarray) -> np.ndarray:
        """Places (..., 2) of the video in pixels of small pictures."""
        return np.asarray((places + 0.5) / self.shrink - 0.5)

    def colour(self, number: int, place: np.ndarray, radius: float) -> np.ndarray:
        """Return the median colour within a radius of a place in a frame, shape (3,) [255]."""
        reach = max(0.7 * radius / self.shrink, 0.5)
        (left, top), (right, bottom) = (
            np.maximum(np.rint(self.small(place) + side).astype(int), 0) for side in (-reach, reach)
        )
        part = self.pictures[number, top : bottom + 1, left : right + 1]
        return np.asarray(np.median(part, axis=(0, 1))) if part.size else np.full(3, math.nan)


class Copier:
    """Makes small pictures of frames as they are decoded; of long clips smaller ones.

    They lie in one array from the start: many small ones between whole frames would leave gaps in
    memory as large as they are.

    Parameters
    ----------
    bounds : tuple of numpy.ndarray, shape (2,)
        See `Copies`.
    expected : int
        About how many frames there will be.
    """

    def __init__(self, bounds: tuple[np.ndarray, np.ndarray], expected: int) -> None:
        self.shrink, self.bounds, self.expected = 1, bounds, expected
        self.count, self.pictures = 0, np.empty((0, 1, 1, 3), np.uint8)

    def add(self, frame: Frame) -> None:
        """Keep a small picture of a frame."""
        if self.count == 0:
            self.shrink = max(1, round(math.sqrt(frame.luma.size / _PIXELS)))
        picture = small_picture(frame, self.shrink)
        if self.count == len(self.pictures):
            self._move(max(self.expected, 2 * self.count), list(self.pictures), picture.shape)
        self.pictures[self.count] = picture
        self.count += 1
        if self.count * picture[..., 0].size > _ALL_PIXELS:
            self.shrink *= 2
            halves = [shrunk(each, 2) for each in self.pictures[: self.count]]
            self._move(len(self.pictures), halves, halves[0].shape)

    def _move(self, size: int, pictures: list[np.ndarray], shape: tuple[int, ...]) -> None:
        """Make room for `size` pictures of a shape, and put those so far into it."""
        most = _ALL_PIXELS // (shape[0] * shape[1]) + 2
        self.pictures = np.empty((min(size, most), *shape), np.uint8)
        for own, picture in zip(self.pictures, pictures, strict=False):
            own[...] = picture

    def taken(self) -> Copies:
        """The small pictures of the frames so far."""
        return Copies(self.pictures[: self.count], self.shrink, self.bounds)


def small_picture(frame: Frame, shrink: int) -> np.ndarray:
    """Return a frame in a picture that is smaller by a factor, shape (row, column, 3).

    The remainder at the right and lower edge is cut off: whole pixels are many times faster.
    """
    cv2 = import_cv2()
    # The mean of squares of four is faster still.
    luma = shrunk(shrunk(frame.luma, 2), shrink // 2) if shrink % 2 == 0 else frame.luma
    luma = shrunk(luma, shrink) if shrink % 2 else luma
    rows, columns = luma.shape
    chroma = (
        np.ascontiguousarray(plane[: rows * shrink // 2, : columns * shrink // 2])
        for plane in frame[3:]
    )
    return np.asarray(cv2.merge([luma, *(cv2.resize(one, (columns, rows)) for one in chroma)]))


def shrunk(picture: np.ndarray, factor: int) -> np.ndarray:
    """Return the means of squares of pixels."""
    rows, columns = (side // factor for side in picture.shape[:2])
    part = np.ascontiguousarray(picture[: rows * factor, : columns * factor])
    if factor == 1:
        return part
    cv2 = import_cv2()
    return np.asarray(cv2.resize(part, (columns, rows), interpolation=cv2.INTER_AREA))


def detect(copies: Copies, colour: np.ndarray | None = None, stripe: float = 0.0) -> list[Blobs]:
    """Return what moves in each frame.

    Parameters
    ----------
    copies : Copies
        Small pictures of all frames.
    colour : numpy.ndarray, shape (3,), optional
        Luma and chroma of what is looked for [steps of 255]; by default anything.
    stripe : float
        Parts of a ball that are nearer to each other than this are one [pixels].

    Notes
    -----
    It can miss: what moves by less than about half its width, what has the colour of the
    background, and what is smaller than about three pixels of a small picture, which has 100,000 of
    them or fewer.
    """
    cv2 = import_cv2()
    wall = copies.background
    limit = clear_difference(copies.pictures, wall)
    (left, top), (right, bottom) = (
        np.rint(copies.small(edge)).astype(int) for edge in copies.bounds
    )
    part = np.s_[max(top, 0) : bottom + 1, max(left, 0) : right + 1]
    corner = np.array([max(left, 0), max(top, 0)])
    half = math.ceil(0.5 * stripe / copies.shrink)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * half + 1,) * 2) if half else None
    return [
        _blobs(cv2, picture[part], wall[part], corner, limit, copies.shrink, colour, disc)
        for picture in copies.pictures
    ]


def _blobs(
    cv2: Any,
    picture: np.ndarray,
    wall: np.ndarray,
    corner: np.ndarray,
    limit: float,
    shrink: int,
    colour: np.ndarray | None,
    disc: np.ndarray | None,
) -> Blobs:
    """Return the blobs of one picture, which begins at a corner of the whole one.

    Parts between which a `disc` (row, column) of ones does not fit are one.
    """
    apart = cv2.GaussianBlur(difference(picture, wall), (3, 3), 0)
    _, mask = cv2.threshold(apart, limit, 1, cv2.THRESH_BINARY)
    if colour is not None:
        low, high = colour - _SAME_COLOUR * _WEIGHTS, colour + _SAME_COLOUR * _WEIGHTS
        mask = cv2.bitwise_and(mask, cv2.inRange(picture, low, high))
    if disc is not None:
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, disc)
    # Where anything differs: labels of a whole picture take nine times longer.
    left, top, width, height = cv2.boundingRect(mask)
    if width == 0:
        return Blobs.of([], shrink)
    mask = mask[top : top + height, left : left + width]
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    rows: list[tuple[float, ...]] = []
    for number in range(1, count):
        x, y, width, height, area = stats[number].tolist()
        if area < _FEWEST:
            continue
        own = labels[y : y + height, x : x + width] == number
        x, y = x + left, y + top
        part = np.s_[y : y + height, x : x + width]
        for u, v, *rest in _split(cv2, own, apart[part], picture[part], wall[part], disc):
            rows.append((u + x + corner[0], v + y + corner[1], *rest))
    return Blobs.of(rows, shrink)


def _split(
    cv2: Any,
    own: np.ndarray,
    apart: np.ndarray,
    picture: np.ndarray,
    wall: np.ndarray,
    disc: np.ndarray | None,
) -> list[tuple[float, ...]]:
    """Return the blobs in one connected thing, without rods and shadows.

    Parts between which a `disc` (row, column) of ones does not fit are one. Each is its column,
    row, half width, half length, contrast, three colours, and the wall's.
    """
    limit = _OWN * _ranked(apart[own], 0.9)
    clear = (own & (apart > limit)).astype(np.uint8)
    if disc is not None:
        clear = cv2.morphologyEx(clear, cv2.MORPH_CLOSE, disc) & own.astype(np.uint8)
    clear = cv2.copyMakeBorder(clear, 2, 2, 2, 2, cv2.BORDER_CONSTANT)
    depth = cv2.distanceTransform(clear, cv2.DIST_L2, 5)
    reach = float(0.5 * depth.max())
    # Of a ball of few pixels, half a pixel more cuts a rod off.
    reach = round(reach) if _SMALL[0] <= reach < _SMALL[1] else int(reach)
    if reach >= 1:
        wide = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
        clear = cv2.morphologyEx(
            cv2.morphologyEx(clear, cv2.MORPH_CLOSE, wide), cv2.MORPH_OPEN, wide
        )
    count, labels = cv2.connectedComponents(clear[2:-2, 2:-2])
    both = np.concatenate([picture, wall], axis=-1)
    rows = []
    for number in range(1, count):
        own = labels == number
        weight = cv2.moments(apart * own)
        total = weight["m00"]
        # Moments of pixels as squares; those of a disc are a quarter of its squared radius.
        across, down, skew = (weight[name] / total for name in ("mu20", "mu02", "mu11"))
        mean, half = 0.5 * (across + down) + 1.0 / 12.0, math.hypot(0.5 * (across - down), skew)
        typical = _ranked(apart[own], 0.5)
        # A colour after the other: numpy is slow along an axis of six.
        colours = _ranked(both[own & (apart >= typical)].T.copy(), 0.5)
        rows.append((
            weight["m10"] / total, weight["m01"] / total,
            2.0 * math.sqrt(mean - half), 2.0 * math.sqrt(mean + half), typical, *colours,
        ))  # fmt: skip
    return rows


def _ranked(values: np.ndarray, share: float) -> Any:
    """Return a quantile of numbers of 8 bits along the last axis; they are sorted in place."""
    at = share * (values.shape[-1] - 1)
    values.sort(axis=-1, kind="stable")  # by their digits: many times faster than numpy's quantile
    low, high = values[..., math.floor(at)], values[..., math.ceil(at)]
    return low + (at % 1.0) * (high.astype(float) - low)
