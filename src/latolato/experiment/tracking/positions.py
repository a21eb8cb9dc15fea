"""Where pivot and balls are in every frame of a clip: what the tracker's steps pass on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import binary_erosion

from latolato.core.errors import Sentence, joined
from latolato.experiment.rules import said
from latolato.experiment.track_table import CLEAN, MEASURED
from latolato.experiment.tracking.appearance import reach_of

# How far a point is blurred by a lens and by the halved resolution of colour [pixels].
_BLUR = 2.5
# Time between frames in which balls that come to touch have met, as a share.
_NEAR = 0.25
# Diameters between frames from which a ball leaps, and the share of the samples that are not clean
# which lie in one stretch, or are partly hidden, for that to be the reason.
_LEAPS, _MOST = 1.0, 0.6


@dataclass
class Positions:
    """Raw positions in the image; NaN is unknown.

    Attributes
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    pivots : numpy.ndarray, shape (frame, 2)
        Pivot (column, row) [pixels]; unknown if it is out of the picture.
    centres : numpy.ndarray, shape (frame, ball, 2)
        Centres of the balls [pixels].
    angles : numpy.ndarray, shape (frame, ball)
        Unwrapped angles from straight down in the image [rad].
    sigmas : numpy.ndarray, shape (frame, ball)
        Standard deviations of the angles [rad].
    spreads : numpy.ndarray, shape (frame, ball)
        Standard deviations of the distances from the pivot [pixels].
    flags : numpy.ndarray of str, shape (frame, ball)
        ok, collision, occluded, manual, predicted or lost.
    radius : float
        Radius of a ball [pixels].
    body : numpy.ndarray of bool, shape (row, column), or None
        What a bob covers that is no disc, about its centre as it hangs straight down.
    """

    times: np.ndarray
    pivots: np.ndarray
    centres: np.ndarray
    angles: np.ndarray
    sigmas: np.ndarray
    spreads: np.ndarray
    flags: np.ndarray
    radius: float
    body: np.ndarray | None = None

    @classmethod
    def unknown(cls, times: np.ndarray, balls: int, radius: float = math.nan) -> Positions:
        """Return the positions in frames before anything is followed: all are lost."""
        count = len(times)
        angles, sigmas, spreads = np.full((3, count, balls), np.nan)
        return cls(
            times.copy(),
            np.full((count, 2), np.nan),
            np.full((count, balls, 2), np.nan),
            angles,
            sigmas,
            spreads,
            np.full((count, balls), "lost", "U9"),
            radius,
        )

    @property
    def is_measured(self) -> np.ndarray:
        """Whether the picture shows a ball, as far as the tracker knows, shape (frame, ball)."""
        return np.isin(self.flags, MEASURED)

    @property
    def reach(self) -> float:
        """How far from its centre a ball reaches [pixels]."""
        return self.radius if self.body is None else reach_of(self.body)

    def covers(self, away: np.ndarray, angle: float, unsure: float) -> np.ndarray:
        """Return whether places (..., 2) from a ball's centre are under it.

        A disc's edge is known to `unsure` [pixels], that of a body to a pixel; the smallest is as
        large as its blur.
        """
        if self.body is None:
            disc: np.ndarray = np.hypot(away[..., 0], away[..., 1]) < max(
                self.radius - unsure, _BLUR
            )
            return disc
        cosine, sine = math.cos(angle), math.sin(angle)
        rows = away[..., 0] * sine + away[..., 1] * cosine
        columns = away[..., 0] * cosine - away[..., 1] * sine
        inner = np.pad(binary_erosion(self.body), 1)
        at = np.stack([rows, columns], axis=-1) + (np.array(inner.shape) - 1) / 2
        row, column = np.clip(np.rint(at).astype(int), 0, np.array(inner.shape) - 1).T
        return np.asarray(inner[row.T, column.T])

    def clean_share(self, fresh: np.ndarray) -> float:
        """Return the share of clean samples and contacts in `fresh` frames, shape (frame,)."""
        return float(np.isin(self.flags[fresh], (*CLEAN, "collision")).mean())

    def gaps_text(self, fresh: np.ndarray) -> Sentence:
        """Return in words how few samples of `fresh` frames (frame,) are clean, and why."""
        flags = self.flags[fresh]
        unclean = ~np.isin(flags, (*CLEAN, "collision"))
        parts = ((flag, np.mean(flags == flag)) for flag in ("occluded", "predicted", "lost"))
        flags_text = joined(
            [
                said(f"share_{flag}", percent=f"{100.0 * share:.0f}")
                for flag, share in parts
                if share > 0.005
            ],
            ", ",
        )
        percent = f"{100.0 * self.clean_share(fresh):.0f}"

        def text(rule: str, **values: Any) -> Sentence:
            reason = said(rule, **values)
            return said("few_seen", percent=percent, flags=flags_text, reason=reason)

        places = np.where(self.is_measured[..., None], self.centres, np.nan)
        steps = np.linalg.norm(np.diff(places, axis=0), axis=-1)
        leap = float(np.nanmedian(steps)) / (2.0 * self.reach) if np.isfinite(steps).any() else 0.0
        # The stretch in which all balls are unclean, of the most frames.
        edges = np.flatnonzero(np.diff(np.r_[False, unclean.all(axis=1), False]))
        begins, ends = edges[::2], edges[1::2]
        longest = int(np.argmax(ends - begins)) if len(begins) else 0
        if len(begins) and ends[longest] - begins[longest] > _MOST * unclean.any(axis=1).sum():
            times = self.times[fresh][[begins[longest], ends[longest] - 1]]
            return text("unseen_stretch", begin=times[0], end=times[1])
        if leap > _LEAPS:
            return text("leaping", leap=f"{leap:.1f}")
        if np.mean(flags == "occluded") > _MOST * unclean.mean():
            return text("hidden_ball")
        if not np.isfinite(self.angles).any():
            return text("nothing_near")
        return text("nothing_on_circle")

    def give_up(self, doubtful: np.ndarray) -> None:
        """Mark samples, shape (frame, ball), as lost, but for those that were set by hand."""
        doubtful = doubtful & (self.flags != "manual")
        self.flags[doubtful] = "lost"
        for numbers in (self.centres, self.angles, self.sigmas, self.spreads):
            numbers[doubtful] = np.nan


def meetings(one: Positions, other: Positions) -> np.ndarray:
    """Return in which frames the balls of two tracks met, shape (frame,).

    They touch, or would within a quarter of the time between frames.
    """
    away = np.linalg.norm(one.centres[:, 0] - other.centres[:, 0], axis=-1)
    steps = np.abs(np.diff(away))
    fastest = np.fmax(np.append(steps, 0.0), np.append(0.0, steps))
    return np.asarray(away <= one.radius + other.radius + _NEAR * fastest)
