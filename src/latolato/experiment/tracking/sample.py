"""A first reading of a video: all time stamps, and pairs of frames spread over it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from latolato.experiment.video import Frame, Video

# Pairs of consecutive frames that are kept to learn from, and at most twice as many on the way.
_PAIRS = 24
_GOLDEN = 0.6180339887498949


@dataclass(frozen=True)
class Sample:
    """What the first reading keeps.

    Attributes
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps of all frames [s].
    frames : list of Frame
        Copies of the first frame and of pairs of consecutive frames.
    """

    times: np.ndarray
    frames: list[Frame]

    @property
    def interval(self) -> float:
        """Median time between frames [s]."""
        return float(np.median(np.diff(self.times))) if self.times.size > 1 else 0.0


def read_sample(video: Video, progress: Callable[[float], None] | None = None) -> Sample:
    """Decode a whole video once; keep its time stamps and a sample of its frames."""
    expected = video.frame_count or 1
    step = max(1, expected // _PAIRS)
    times: list[float] = []
    kept: list[Frame] = []
    for frame in video.frames():
        times.append(frame.time)
        if _is_wanted(frame.number, step):
            kept.append(Frame(frame.number, frame.time, *(plane.copy() for plane in frame[2:])))
        if len(kept) > 4 * _PAIRS + 1:
            step *= 2
            kept = [one for one in kept if _is_wanted(one.number, step)]
        if progress and frame.number % 64 == 0:
            progress(min(1.0, frame.number / expected))
    return Sample(np.array(times), kept)


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
    return tuple(
        _median(np.stack([frame[2 + plane] for frame in frames])).astype(np.float32)
        for plane in range(3)
    )


def _median(stack: np.ndarray) -> np.ndarray:
    """Return the lower median along the first axis of whole numbers."""
    middle = (stack.shape[0] - 1) // 2
    median: np.ndarray = np.partition(stack, middle, axis=0)[middle]
    return median
