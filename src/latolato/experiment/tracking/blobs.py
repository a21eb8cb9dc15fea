"""Round things that move: what differs from the picture's median over time, as discs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from latolato.core.errors import import_extra
from latolato.experiment.tracking.sample import median_planes
from latolato.experiment.video import Frame

# Differences of colour count more than those of light, which shadows have too.
_CHROMA = 2.0
# A difference is one above this many standard deviations of the noise, and above some steps of 255.
_CLEAR, _LEAST = 6.0, 9.0
# Part of a thing's own difference from which a pixel belongs to it, and not to its shadow.
_OWN = 0.45
# Radii of the smallest and the largest ball, as shares of the picture's smaller side.
_SMALLEST, _LARGEST = 0.006, 0.2
# Elongation, by smear, above which something is no ball.
_LONGEST = 3.5


@dataclass(frozen=True)
class Disc:
    """Something round that differs from the background of a frame.

    Attributes
    ----------
    centre : numpy.ndarray, shape (2,)
        Column and row [pixels].
    radius : float
        Half its smaller width [pixels].
    contrast : float
        How much it differs [steps of 255].
    change : numpy.ndarray, shape (3,)
        Median difference from the background in luma and, weighted, in chroma.
    """

    centre: np.ndarray
    radius: float
    contrast: float
    change: np.ndarray


class Backdrop:
    """What does not move, at half the resolution: colour is stored no finer.

    Parameters
    ----------
    frames : list of Frame
        The sample.
    bounds : tuple of numpy.ndarray, shape (2,)
        First column and row that are looked at, and the first ones beyond [pixels].
    """

    def __init__(self, frames: list[Frame], bounds: tuple[np.ndarray, np.ndarray]) -> None:
        self.side = min(frames[0].blue.shape)
        self.low, self.high = bounds[0] // 2, (bounds[1] + 1) // 2
        luma, blue, red = median_planes([self._part(frame) for frame in frames])
        cv2 = import_cv2()
        self.shape = blue.shape
        self.mean = np.dstack([_halved(cv2, luma.astype(np.float32), blue.shape), blue, red])
        spread = [np.abs(self._picture(f) - self.mean) for f in frames[:: max(1, len(frames) // 9)]]
        self.noise = 1.4826 * float(np.median(np.median(spread, axis=0)[..., 0])) + 0.3

    def _part(self, frame: Frame) -> Frame:
        """Return the part of a frame that is looked at."""
        (left, top), (right, bottom) = self.low, self.high
        luma = frame.luma[2 * top : 2 * bottom, 2 * left : 2 * right]
        blue, red = (plane[top:bottom, left:right] for plane in frame[3:])
        return Frame(frame.number, frame.time, luma, blue, red)

    def _picture(self, frame: Frame) -> np.ndarray:
        """Return a frame at half the resolution, slightly blurred, shape (row, column, 3)."""
        cv2, frame = import_cv2(), self._part(frame)
        luma = _halved(cv2, frame.luma, self.shape)
        picture = np.dstack([luma, frame.blue, frame.red]).astype(np.float32)
        blurred: np.ndarray = cv2.GaussianBlur(picture, (0, 0), 0.8)
        return blurred

    def difference(self, frame: Frame) -> tuple[np.ndarray, np.ndarray]:
        """Return how much each pixel differs [steps of 255], and its change in each plane."""
        change = (self._picture(frame) - self.mean) * np.array([1.0, _CHROMA, _CHROMA], np.float32)
        # Plane by plane: numpy is slow along an axis of three.
        luma, blue, red = np.abs(np.moveaxis(change, -1, 0))
        return np.maximum(np.maximum(luma, blue), red), change

    def discs(self, frame: Frame) -> list[Disc]:
        """Return the round things in a frame, the clearest first."""
        cv2 = import_cv2()
        apart, change = self.difference(frame)
        mask = (apart > max(_LEAST, _CLEAR * self.noise)).astype(np.uint8)
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, _round(cv2, 1))
        count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
        side = self.side
        discs: list[Disc] = []
        for i in range(1, count):
            x, y, width, height, area = (int(n) for n in stats[i])
            if area < 3.0 * (_SMALLEST * side) ** 2:
                continue
            part, corner = np.s_[y : y + height, x : x + width], self.low + np.array([x, y])
            own = labels[part] == i
            discs += self._split(cv2, own, apart[part], change[part], corner)
        discs = [disc for disc in discs if _SMALLEST * side < disc.radius / 2.0 < _LARGEST * side]
        return sorted(discs, key=lambda disc: -disc.contrast * disc.radius)

    def _split(
        self, cv2: Any, own: np.ndarray, apart: np.ndarray, change: np.ndarray, corner: np.ndarray
    ) -> list[Disc]:
        """Return the discs in one connected thing, without rods and shadows."""
        limit = _OWN * float(np.quantile(apart[own], 0.9))
        clear = np.pad((own & (apart > limit)).astype(np.uint8), 2)
        clear = cv2.morphologyEx(clear, cv2.MORPH_CLOSE, _round(cv2, 2))
        depth = cv2.distanceTransform(clear, cv2.DIST_L2, 5)
        # A rod is thinner than half the ball at its end.
        size = max(1, int(0.5 * float(depth.max())))
        opened = cv2.morphologyEx(clear, cv2.MORPH_OPEN, _round(cv2, size))
        outlines, _ = cv2.findContours(opened, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        discs = []
        for outline in outlines:
            (u, v), around = cv2.minEnclosingCircle(outline)
            inside = np.zeros_like(opened)
            cv2.drawContours(inside, [outline], -1, 1, -1)
            inner = float(depth[inside > 0].max())
            if around > _LONGEST * max(inner, 1.0):
                continue
            core = inside[2:-2, 2:-2] > 0
            if not core.any():
                continue
            # A half that hides before a wall of its colour leaves half a disc: its circle is whole.
            area = float(core.sum())
            radius = max(inner, min(around, area / max(2.0 * around, 1.0)))
            centre = 2.0 * (np.array([u, v]) - 2.0 + corner) + 0.5
            discs.append(
                Disc(
                    centre,
                    2.0 * radius,
                    float(np.median(apart[core])),
                    np.median(change[core], axis=0),
                )
            )
        return discs


def import_cv2() -> Any:
    """Return OpenCV."""
    return import_extra("cv2", "video", "finding balls and drawing on videos")


def _round(cv2: Any, radius: int) -> Any:
    """Return a round structuring element."""
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))


def _halved(cv2: Any, luma: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return luma at the resolution of the chroma."""
    halved: np.ndarray = cv2.resize(
        np.ascontiguousarray(luma), (shape[1], shape[0]), interpolation=cv2.INTER_AREA
    )
    return halved
