"""How the camera moves, and frames as a camera at rest would have taken them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from latolato.experiment.opencv import import_cv2
from latolato.experiment.rules import broken
from latolato.experiment.tracking.detect import Copies, small_picture
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.video import Frame, Video

# Width to which pictures are reduced to find the camera's motion [pixels].
_WIDTH = 480
# Most features, how far apart they are as a share of the picture's width, and half the size of a
# feature's neighbourhood [pixels].
_MOST, _SPREAD, _HALF = 96, 0.05, 10
# How many times stronger than the typical place a feature must be, and how strong at least.
_STRONG, _WEAKEST = 3.0, 1e-5
# Fewest features that show a motion of the camera, the share of the picture that they must enclose,
# which no ball and no pair of rods does, and the share of all that must agree.
_FEATURES, _ENCLOSED, _AGREEING = 8, 0.15, 0.5
# How far features that agree may be apart in the reduced picture [pixels]; how far in the picture
# those that are kept may be, as a multiple of the typical one, and how far in any case [pixels].
_AGREE, _OUTLYING, _FINE = 1.0, 3.0, 0.1
# Motion of the camera from which frames are corrected [pixels], the largest one that is, as a share
# of the picture's diagonal, and the share of frames that need not show it.
_MOVES, TOO_FAR, _UNKNOWN = 0.3, 0.02, 0.1
# By how many of its standard deviations it must exceed none.
_CLEAR = 3.0
# How many frames are compared with the first one.
_COMPARED = 24
# Error of places that features do not show [pixels].
_FLOOR = 0.01


class Bar(NamedTuple):
    """What lies no farther from a straight line than a reach [pixels], in one frame."""

    start: np.ndarray
    end: np.ndarray
    reach: float


@dataclass(frozen=True)
class CameraMotion:
    """How the camera moved since another frame.

    Attributes
    ----------
    matrix : numpy.ndarray, shape (2, 3)
        Takes places (column, row, 1) to those in the other frame [pixels].
    moved : float
        How far places move, the middles of the picture's quarters at most [pixels].
    sigma : float
        Standard deviation of places that are corrected [pixels].
    time : float
        When [s].
    """

    matrix: np.ndarray
    moved: float
    sigma: float
    time: float

    @property
    def values(self) -> dict[str, Any]:
        """What sentences state about it."""
        return {"pixels": f"{self.moved:.1f}", "time": self.time}


class Surroundings:
    """Features of the background of a frame, which show how the camera moves.

    Shi and Tomasi, CVPR (1994) 593, for features; Lucas and Kanade's flow takes them to other
    frames, where most of them must agree on a shift, a turn and a zoom. Things that move are
    outvoted. They must enclose a part of the picture: a pendulum before a plain wall is none.

    Parameters
    ----------
    frame : Frame
        The frame.
    hidden : sequence of Bar
        Balls and rods, which are not the background.
    """

    def __init__(self, frame: Frame, hidden: Sequence[Bar] = ()) -> None:
        cv2 = import_cv2()
        self.frame, self.small = frame, reduced(frame, _WIDTH)
        self.scale = frame.luma.shape[1] / self.small.shape[1]
        bars = [
            Bar(bar.start / self.scale, bar.end / self.scale, bar.reach / self.scale + 3.0)
            for bar in hidden
        ]
        self.points = _features(cv2, self.small, bars)

    def motion(self, frame: Frame) -> CameraMotion | None:
        """Return how the camera moved up to a frame; None if the features do not agree."""
        if len(self.points) < _FEATURES:
            return None
        cv2 = import_cv2()
        later = reduced(frame, _WIDTH)
        options = {"winSize": (2 * _HALF + 1, 2 * _HALF + 1)}
        start = self.points[:, None]
        there, seen, _ = cv2.calcOpticalFlowPyrLK(
            self.small, later, start, None, maxLevel=4, **options
        )
        back, is_back, _ = cv2.calcOpticalFlowPyrLK(
            later, self.small, there, None, maxLevel=4, **options
        )
        kept = (seen[:, 0] > 0) & (is_back[:, 0] > 0)
        kept &= np.hypot(*(back - start)[:, 0].T) < 0.5 * _AGREE
        before = (self.points + 0.5) * self.scale - 0.5
        after = (there[:, 0] + 0.5) * self.scale - 0.5
        if self.scale > 1.0 and kept.any():
            fine, seen, _ = cv2.calcOpticalFlowPyrLK(
                np.ascontiguousarray(self.frame.luma), np.ascontiguousarray(frame.luma),
                before[:, None], after[:, None].copy(), maxLevel=0,
                flags=cv2.OPTFLOW_USE_INITIAL_FLOW, **options,
            )  # fmt: skip
            kept &= (seen[:, 0] > 0) & (np.hypot(*(fine[:, 0] - after).T) < _AGREE * self.scale)
            after = fine[:, 0]
        return self._agreed(cv2, before[kept], after[kept], frame.time)

    def _agreed(
        self, cv2: Any, before: np.ndarray, after: np.ndarray, time: float
    ) -> CameraMotion | None:
        """Return the motion on which features agree."""
        if len(before) < _FEATURES:
            return None
        matrix, agreeing = cv2.estimateAffinePartial2D(
            after, before, ransacReprojThreshold=_AGREE * self.scale
        )
        if matrix is None:
            return None
        agrees = agreeing[:, 0] > 0
        if agrees.sum() < max(_FEATURES, _AGREEING * len(before)):
            return None
        before, after = before[agrees], after[agrees]
        size = np.array(self.frame.luma.shape)
        hull = cv2.convexHull(before.astype(np.float32))
        if cv2.contourArea(hull) < _ENCLOSED * size.prod():
            return None
        typical = float(np.median(np.hypot(*_left_over(matrix, after, before).T)))
        finer, agreeing = cv2.estimateAffinePartial2D(
            after, before, ransacReprojThreshold=max(_OUTLYING * typical, _FINE)
        )
        if finer is None:
            return None
        matrix, near = finer, agreeing[:, 0] > 0
        left = _left_over(matrix, after, before)[near]
        quarters = np.array([[x, y] for x in (0.25, 0.75) for y in (0.25, 0.75)]) * size[::-1]
        moves = _left_over(matrix, quarters, quarters)
        # Compression lets parts of the picture lag, which features share: no mean over them helps.
        sigma = math.hypot(math.sqrt(float(np.mean(left**2))), _FLOOR)
        return CameraMotion(matrix, float(np.hypot(*moves.T).max()), sigma, time)


def _left_over(matrix: np.ndarray, places: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return how far places (place, 2) that a matrix moves are from others [pixels]."""
    return np.asarray(places @ matrix[:, :2].T + matrix[:, 2] - others)


def reduced(frame: Frame, widest: int) -> np.ndarray:
    """Return a frame's luma in a picture of at most some width."""
    rows, columns = frame.luma.shape
    width = min(widest, columns)
    size = (width, max(1, round(rows * width / columns)))
    small: np.ndarray = import_cv2().resize(
        np.ascontiguousarray(frame.luma), size, interpolation=import_cv2().INTER_AREA
    )
    return small


def _features(cv2: Any, picture: np.ndarray, hidden: Sequence[Bar]) -> np.ndarray:
    """Return the clearest features away from each other, shape (feature, 2)."""
    smooth = cv2.GaussianBlur(picture, (0, 0), 1.0)
    strength = cv2.cornerMinEigenVal(smooth, 7)
    mask = np.zeros_like(picture)
    inner = np.s_[_HALF:-_HALF, _HALF:-_HALF]
    mask[inner] = strength[inner] > max(_STRONG * float(np.median(strength)), _WEAKEST)
    for bar in hidden:
        start, end = (tuple(np.rint(place).astype(int).tolist()) for place in bar[:2])
        cv2.line(mask, start, end, 0, 2 * math.ceil(bar.reach))
    points = cv2.goodFeaturesToTrack(
        smooth, _MOST, 1e-6, _SPREAD * picture.shape[1], mask=mask, blockSize=7
    )
    return np.zeros((0, 2), np.float32) if points is None else np.asarray(points[:, 0])


class Steadier:
    """Shows frames as a camera at rest would have taken them.

    Attributes
    ----------
    moved : float
        How far the camera moved in the frames shown [pixels].
    """

    def __init__(self, surroundings: Surroundings) -> None:
        self.surroundings = surroundings
        self.moved = 0.0
        self._sigmas: dict[int, float] = {}
        self._matrices: dict[int, np.ndarray] = {}
        self._matrix = np.eye(2, 3)

    def __call__(self, frame: Frame) -> Frame:
        """Return a frame moved to where its background was in the other frame.

        Where the background does not show the motion, it is that of the frame before.
        """
        motion = self.surroundings.motion(frame)
        if motion is not None:
            self._matrix = motion.matrix
            self.moved = max(self.moved, motion.moved)
            self._sigmas[frame.number] = motion.sigma
        self._matrices[frame.number] = self._matrix
        # A place of the halved planes is half the place less a quarter.
        halved = self._matrix.copy()
        halved[:, 2] = 0.5 * (self._matrix @ [0.5, 0.5, 1.0] - 0.5)
        planes = (_moved(frame.luma, self._matrix), *(_moved(p, halved) for p in frame[3:]))
        return Frame(frame.number, frame.time, *planes)

    def place(self, number: int, place: np.ndarray) -> np.ndarray:
        """Position in the steady picture of a place in a frame already read [pixels]."""
        return np.asarray(self._matrices[number] @ [*place, 1.0])

    def motions(self, count: int) -> np.ndarray:
        """Transforms from the steady picture to each of the first frames.

        They are matrices by which ``(column, row, 1)`` is multiplied, shape (frame, 2, 3).
        """
        still = np.eye(2, 3)
        matrices = (self._matrices.get(number, still) for number in range(count))
        return np.array([np.linalg.inv(np.vstack([m, [0.0, 0.0, 1.0]]))[:2] for m in matrices])

    def deviations(self, count: int) -> np.ndarray:
        """Return standard deviations of places in the first frames [pixels], NaN where unknown."""
        return np.array([self._sigmas.get(number, math.nan) for number in range(count)])


def _moved(plane: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Return a plane whose places are moved by a matrix."""
    cv2 = import_cv2()
    moved: np.ndarray = cv2.warpAffine(
        np.ascontiguousarray(plane), matrix, plane.shape[1::-1],
        flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    return moved


def camera_motions(
    sample: Sample, hidden: Sequence[Bar] = ()
) -> tuple[Surroundings, dict[int, CameraMotion], float]:
    """Return the background of the clicked frame, and how the camera moved up to some others.

    Frames whose background does not show it are left out; their share comes last. It can miss a
    camera that moves in front of a wall without any features, or for a few frames between those of
    the sample only, unless it then changes more than anything else.
    """
    first, *others = sample.from_click
    some = {f.number: f for f in others[:: max(1, len(others) // _COMPARED)] + sample.changed}
    surroundings = Surroundings(first, hidden)
    motions = {number: surroundings.motion(frame) for number, frame in some.items()}
    known = {number: motion for number, motion in motions.items() if motion is not None}
    return surroundings, known, 1.0 - len(known) / max(len(some), 1)


def farthest(motions: dict[int, CameraMotion]) -> CameraMotion | None:
    """Return the largest motion of a camera but one, which may be a mistake; None if unknown."""
    ordered = sorted(motions.values(), key=lambda motion: motion.moved)
    return ordered[-2] if len(ordered) > 1 else None


def steadied(video: Video, sample: Sample, hidden: Sequence[Bar] = ()) -> tuple[Video, Sample]:
    """Return a video and its sample as a camera at rest would have taken them.

    They are the same if the camera rests or is not shown to move.

    Parameters
    ----------
    video, sample : Video, Sample
        The clip and its first reading.
    hidden : sequence of Bar
        Balls and rods, which are not the background.

    Raises
    ------
    InputError
        If the camera moves too far for that.
    """
    surroundings, motions, unknown = camera_motions(sample, hidden)
    motion = farthest(motions)
    if motion is None or motion.moved < _MOVES:
        return video, sample
    if motion.moved > TOO_FAR * math.hypot(video.width, video.height):
        raise broken("moved_camera", motion.values)
    if unknown > _UNKNOWN or motion.moved < _CLEAR * float(
        np.median([motion.sigma for motion in motions.values()])
    ):
        return video, sample
    steadier = Steadier(surroundings)
    frames, clicked, changed = (
        [steadier(frame) for frame in some]
        for some in (sample.frames, sample.clicked, sample.changed)
    )
    copies = _steady_copies(sample.copies, sample.from_click[0], hidden)
    return replace(video, steadier=steadier), replace(
        sample, frames=frames, clicked=clicked, changed=changed, copies=copies
    )


def _steady_copies(copies: Copies, first: Frame, hidden: Sequence[Bar]) -> Copies:
    """Return small pictures as a camera at rest would have taken them, where it was in `first`."""

    def as_frame(picture: np.ndarray) -> Frame:
        return Frame(0, 0.0, *np.moveaxis(picture, -1, 0))

    share = 1.0 / copies.shrink
    bars = [Bar(copies.small(b.start), copies.small(b.end), b.reach * share) for b in hidden]
    surroundings = Surroundings(as_frame(small_picture(first, copies.shrink)), bars)
    matrix, pictures = np.eye(2, 3), np.empty_like(copies.pictures)
    for k, picture in enumerate(copies.pictures):
        motion = surroundings.motion(as_frame(picture))
        matrix = matrix if motion is None else motion.matrix
        pictures[k] = _moved(picture, matrix)
    return replace(copies, pictures=pictures)
