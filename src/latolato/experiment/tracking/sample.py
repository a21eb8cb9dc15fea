"""A first reading of a video: all time stamps, and pairs of frames spread over it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from heapq import heappop, heappush

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.tracking.detect import Copier, Copies
from latolato.experiment.video import Frame, Video

# Pairs of consecutive frames that are kept to learn from, and at most twice as many on the way;
# the fewest, and the memory from which there are fewer than usual [bytes].
_PAIRS, _FEWEST_PAIRS, _MEMORY = 24, 10, 200e6
_GOLDEN = 0.6180339887498949
# A frame repeats the one before if it changes by less than this share of what is usual among the
# frames about it: how many of them on each side, and the share of them that may repeat as well.
_SAME, _NEAR, _USUAL = 0.1, 4, 0.75
# Fewest repeats that make a pattern, and the least change beside them, as a share of the usual one:
# at turning points it is less.
_FEWEST_REPEATS, _SUDDEN = 8, 0.7
# Time between frames from which one is missing, and how far it typically is from the median where
# frames have no rate [intervals].
_APART, _UNEVEN = 1.75, 0.3
# How many frames that changed most are kept, how many pixels are compared, and the side of squares
# of these over which a change is averaged.
_CHANGED, _COMPARED, _SQUARE = 4, 100_000, 8
# Pixels of which a median is taken at the same time: those of all frames stay in the cache.
_PART = 16384


@dataclass(frozen=True)
class Sample:
    """What the first reading keeps.

    Attributes
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps of all frames [s].
    frames : list of Frame
        Copies of the first frame and of pairs of consecutive frames.
    clicked : list of Frame
        Copies of the frame in which pivot and balls are pointed at and of the next one, which need
        not lie between start and end; empty for the first frame.
    changes : numpy.ndarray, shape (frame,)
        Difference of each frame from the one before where that is largest [steps of 255]; none of
        the first one.
    changed : list of Frame
        Copies of the frames that changed most.
    is_converted : bool
        Whether pictures are repeated again and again, and the times are therefore even ones.
    copies : Copies
        Small pictures of all frames.
    """

    times: np.ndarray
    frames: list[Frame]
    clicked: list[Frame] = field(default_factory=list)
    changes: np.ndarray = field(default_factory=lambda: np.full(1, math.nan))
    changed: list[Frame] = field(default_factory=list)
    is_converted: bool = False
    copies: Copies = field(default_factory=Copies.none)

    @property
    def click(self) -> int:
        """Number of the frame in which pivot and balls are pointed at."""
        return self.clicked[0].number if self.clicked else 0

    @property
    def from_click(self) -> list[Frame]:
        """The frames with that one and its successor first."""
        own = {frame.number for frame in self.clicked}
        return [*self.clicked, *(frame for frame in self.frames if frame.number not in own)]

    @cached_property
    def medians(self) -> tuple[np.ndarray, ...]:
        """Median of each plane over a third of the frames: what rests."""
        return median_planes(self.from_click[::3])

    @cached_property
    def repeats(self) -> np.ndarray:
        """Whether a frame shows the picture of the one before, shape (frame,).

        It changes by much less than most frames about it. Where next to nothing moves, as in a
        drawn pendulum's turning points, a frame may seem to. Of a picture that stays for more than
        half a dozen frames, only the first and last ones are found.
        """
        if len(self.changes) < 2:  # the first frame, which repeats none
            return np.zeros(len(self.changes), bool)
        about = np.lib.stride_tricks.sliding_window_view(
            np.pad(self.changes, _NEAR, constant_values=math.nan), 2 * _NEAR + 1
        )
        ranked = np.sort(about, axis=-1)  # unknown ones last
        rank = np.rint(_USUAL * (np.isfinite(ranked).sum(axis=-1) - 1.0)).astype(int)
        return np.asarray(self.changes < _SAME * ranked[np.arange(len(ranked)), rank])

    @property
    def gaps(self) -> np.ndarray:
        """How many frames are missing before each one by the time stamps, shape (frame,).

        None are where frames come when something changes, as in some recordings of a screen.
        """
        apart = np.diff(self.times, prepend=self.times[:1]) / (self.interval or 1.0)
        if np.median(np.abs(apart - 1.0)) > _UNEVEN:
            return np.zeros(len(apart), int)
        return np.where(apart > _APART, np.rint(apart) - 1.0, 0.0).astype(int)

    @property
    def interval(self) -> float:
        """Median time between frames [s]."""
        return float(np.median(np.diff(self.times))) if self.times.size > 1 else 0.0


def read_sample(
    video: Video, progress: Callable[[float], None] | None = None, click: int = 0
) -> Sample:
    """Decode a video once; keep its time stamps and a sample of its frames.

    Parameters
    ----------
    video : Video
        The clip.
    progress : callable, optional
        Called with the fraction done.
    click : int
        Number of the frame in which pivot and balls are pointed at.

    Raises
    ------
    InputError
        If the file has no such frame.
    """
    expected = video.expected_count or 1
    # 4:2:0 of 8 bits.
    fitting = int(_MEMORY / (3.0 * video.width * video.height))
    pairs = min(_PAIRS, max(_FEWEST_PAIRS, fitting))
    step = max(1, expected // pairs)
    times: list[float] = []
    kept: list[Frame] = []
    clicked: list[Frame] = []
    changes = [math.nan]
    changed: list[tuple[float, int, Frame]] = []
    before = None
    copier = Copier(video.bounds, expected)
    for frame in video.frames():
        times.append(frame.time)
        copier.add(frame)
        thin = max(1, math.isqrt(frame.luma.size // _COMPARED))
        luma = frame.luma[::thin, ::thin].astype(np.int16)
        if before is not None:
            change = np.abs(luma - before)
            changes.append(_largest(change))
            mean = float(np.mean(change))
            if len(changed) < _CHANGED or mean > changed[0][0]:
                heappush(changed, (mean, frame.number, _copied(frame)))
            if len(changed) > _CHANGED:
                heappop(changed)
        before = luma
        if 0 < click <= frame.number <= click + 1:
            clicked.append(_copied(frame))
        if _is_wanted(frame.number, step):
            kept.append(_copied(frame))
        if len(kept) > 4 * pairs + 1:
            step *= 2
            kept = [one for one in kept if _is_wanted(one.number, step)]
        if progress and frame.number % 64 == 0:
            progress(min(1.0, frame.number / expected))
    if click != 0 and not clicked:
        for frame in replace(video, start=-math.inf, end=math.inf).frames():
            if click <= frame.number <= click + 1:
                clicked.append(_copied(frame))
            elif frame.number > click:
                break
    if click != 0 and not clicked:
        raise InputError(f"the video has no frame {click + video.first_frame}")
    most = [frame for _, _, frame in changed]
    sample = Sample(
        np.array(times), kept, clicked, np.array(changes[: len(times)]), most,
        copies=copier.taken(),
    )  # fmt: skip
    repeats = sample.repeats
    even = even_times(sample.times, repeats, sample.changes)
    # A repeated picture teaches no speed.
    fresh = [
        frame._replace(time=float(even[frame.number]))
        for frame in kept
        if not repeats[frame.number]
    ]
    is_converted = even is not sample.times
    return replace(sample, times=even, frames=fresh, is_converted=is_converted)


def _largest(change: np.ndarray) -> float:
    """Return the largest mean of a change over a small square."""
    rows, columns = (size // _SQUARE for size in change.shape)
    # Rows first, in the small numbers that they are: numpy is slow along a short axis.
    strips = change[: rows * _SQUARE, : columns * _SQUARE].reshape(rows, _SQUARE, -1)
    squares = strips.sum(axis=1, dtype=np.int16).reshape(rows, columns, _SQUARE)
    return float(squares.sum(axis=2).max()) / _SQUARE**2


def even_times(times: np.ndarray, repeats: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """Return even times of frames if pictures are repeated regularly.

    As after a conversion from 24 to 30 frames a second: every fifth picture is a repeat, and the
    others are shown up to an interval late. Repeats lie evenly between pictures. Times of clips
    whose repeats are no such pattern, as where a camera was late, are left as they are.
    """
    fresh = np.flatnonzero(~repeats)
    apart = np.diff(np.flatnonzero(repeats))
    if len(apart) < _FEWEST_REPEATS or np.ptp(apart) > 1 or len(fresh) < 2:
        return times
    beside = np.append(changes[1:], math.nan)[repeats]
    if np.nanmedian(beside) < _SUDDEN * np.nanmedian(changes[fresh]):
        return times
    number = np.arange(len(fresh))
    after = np.append(False, repeats[:-1])[fresh]  # all of these are as late
    rate, _ = np.polyfit(number[after], times[fresh[after]], 1)
    line = rate, float(np.mean(times[fresh] - rate * number))
    even = np.polyval(line, number)
    if np.abs(times[fresh] - even).max() > float(np.median(np.diff(times))):
        return times
    late = np.maximum(np.arange(len(times)) - fresh[-1], 0)
    between = np.interp(np.arange(len(times)), fresh, number) + late / (late.max() + 1.0)
    return np.asarray(np.polyval(line, between))


def _copied(frame: Frame) -> Frame:
    """Return a frame that does not hold on to the decoder's memory."""
    return Frame(frame.number, frame.time, *(plane.copy() for plane in frame[2:]))


def _is_wanted(number: int, step: int) -> bool:
    """Return whether a frame is one of the pair in its stretch of `step` frames.

    Pairs at even distances could always meet the drive at the same phase and take a moving pivot
    for one at rest; the golden ratio spreads them within their stretches.
    """
    stretch = number // step
    offset = int(0.8 * step * (stretch * _GOLDEN % 1.0))
    return 0 <= number - stretch * step - offset < 2


def median_planes(frames: list[Frame]) -> tuple[np.ndarray, ...]:
    """Return the median of each plane over frames."""
    _, _, *planes = zip(*frames, strict=True)
    return tuple(_median(list(same)) for same in planes)


def _median(planes: list[np.ndarray]) -> np.ndarray:
    """Return the lower median of at most 255 planes of 8-bit numbers.

    Bit by bit: the largest number than which no more than half of them are smaller. That is many
    times faster than sorting, and by parts of the picture it needs little memory.
    """
    middle = (len(planes) - 1) // 2
    median = np.empty(planes[0].size, np.uint8)
    flat = [plane.ravel() for plane in planes]
    for first in range(0, len(median), _PART):
        part = np.stack([plane[first : first + _PART] for plane in flat])
        levels = np.zeros(part.shape[1], np.uint8)
        for bit in np.uint8(1) << np.arange(8, dtype=np.uint8)[::-1]:
            smaller = (part < (levels | bit)).view(np.uint8).sum(axis=0, dtype=np.uint8)
            levels[smaller <= middle] |= bit
        median[first : first + _PART] = levels
    return median.reshape(planes[0].shape)
