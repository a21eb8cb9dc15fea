"""Follows balls about an unseen pivot: along their path in the picture, without any geometry."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.tracking.blobs import Backdrop, Disc
from latolato.experiment.tracking.follow import Corrections
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.video import Frame, Video

if TYPE_CHECKING:
    import xarray as xr

# How far from where it is expected a ball may be, in radii, and by how much its radius may differ.
_NEAR, _SIZE = 2.5, 1.8
# Standard deviations by which periods of halves of a clip differ.
_APART = 3.0
# Steps of 255 by which a place from which a ball has gone looks otherwise.
_CHANGED = 9.0
# Fewest passages through the middle that make a period, the longest one in frames, and the least
# share of known places.
_FEWEST, _PAUSE, _KNOWN = 4, 2.5, 0.5


def follow_path(
    video: Video,
    sample: Sample,
    starts: list[np.ndarray],
    progress: Callable[[float], None] | None = None,
    corrections: Corrections | None = None,
) -> Positions:
    """Positions of balls in every frame, from those in one of them, without angles.

    Parameters
    ----------
    video, sample : Video, Sample
        The clip and its first reading.
    starts : list of numpy.ndarray, shape (2,)
        Centres in the clicked frame, the right-hand ball first [pixels].
    progress : callable, optional
        Called with the fraction done.
    corrections : callable, optional
        Returns the places of balls that are set by hand in a frame, which was read already.

    Raises
    ------
    InputError
        If a ball is found in less than a tenth of the frames.

    Notes
    -----
    A ball is the disc that differs from the background nearest to where the last two frames lead.
    """
    backdrop = Backdrop(sample.frames, video.bounds)
    count, balls = len(sample.times), len(starts)
    out = Positions.unknown(sample.times, balls)
    radii: list[float] = []
    seen: list[list[Disc]] = []
    for frame in video.frames():
        seen.append(backdrop.discs(frame))
        if progress and frame.number % 16 == 0:
            progress(frame.number / count)
    click = min(max(sample.click, 0), count)
    # What a frame shows that repeats the one before is older than the frame.
    repeats = sample.repeats
    for numbers in (range(click, count), range(click - 1, -1, -1)):
        tracks = [_Track(start) for start in starts]
        for number in numbers:
            discs, fixed = seen[number], corrections(number) if corrections else {}
            for b, track in enumerate(tracks):
                if b in fixed:
                    track.places, track.missed = [fixed[b]], 0
                    out.centres[number, b], out.flags[number, b] = fixed[b], "manual"
                    continue
                if repeats[number]:
                    continue
                disc = track.next(discs)
                if disc is not None:
                    out.centres[number, b] = disc.centre
                    out.flags[number, b] = "ok"
                    radii.append(disc.radius)
                    discs = [one for one in discs if one is not disc]
    share = float(out.is_measured.mean(axis=0).min())
    if share < 0.1:
        raise InputError(
            f"the ball was found in {100 * share:.0f} % of the frames",
            way_out="point at its centre",
        )
    out.radius = float(np.median(radii))
    return out


def swinging(sample: Sample, path: Positions) -> tuple[Sample, list[np.ndarray]] | None:
    """Return a sample as if balls were pointed at where they swing slowly, and their places there.

    None if its pairs of frames show all of them only near where they were pointed at, or if what
    was there is there still: another ball then passed it.
    """
    frames = {frame.number: frame for frame in sample.frames}
    at = path.centres[min(max(sample.click, 0), len(path.times) - 1)]
    far = np.linalg.norm(path.centres - at, axis=-1).min(axis=1) > _NEAR * path.radius
    steps = np.linalg.norm(np.diff(path.centres, axis=0), axis=-1).max(axis=1)
    pairs = [n for n in frames if n + 1 in frames and far[n] and np.isfinite(steps[n])]
    if not pairs:
        return None
    n = min(pairs, key=lambda number: float(steps[number]))
    if not all(_has_left(sample.from_click[0], frames[n], one, path.radius) for one in at):
        return None
    return replace(sample, clicked=[frames[n], frames[n + 1]]), list(path.centres[n])


def _has_left(first: Frame, later: Frame, place: np.ndarray, radius: float) -> bool:
    """Return whether the inner part of a ball at a place looks different in a later frame."""
    reach = max(1, int(0.25 * radius))
    u, v = np.rint(0.5 * place).astype(int)
    part = np.s_[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]
    planes = ((frame.luma[::2, ::2], frame.blue, frame.red) for frame in (first, later))
    changes = (
        float(np.median(np.abs(one[part].astype(float) - other[part])))
        for one, other in zip(*planes, strict=True)
    )
    return max(changes) > _CHANGED


class _Track:
    """One ball's state from frame to frame."""

    def __init__(self, start: np.ndarray) -> None:
        self.places = [start]
        self.typical: Disc | None = None
        self.missed = 0

    def next(self, discs: list[Disc]) -> Disc | None:
        """Return the disc that is this ball, if there is one."""
        last = self.places[-1]
        step = last - self.places[-2] if len(self.places) > 1 else np.zeros(2)
        expected = last + step if self.missed == 0 else last
        best, least = None, math.inf
        for disc in discs:
            away = float(np.hypot(*(disc.centre - expected)))
            reach = _NEAR * disc.radius * (1.0 + self.missed) + float(np.hypot(*step))
            if self.typical is not None:
                ratio = disc.radius / self.typical.radius
                if not 1.0 / _SIZE < ratio < _SIZE:
                    continue
                away += 2.0 * disc.radius * abs(math.log(ratio))
            if away < reach and away < least:
                best, least = disc, away
        if best is None:
            self.missed += 1
            self.places = [last]
            return None
        was_missed, self.missed = self.missed > 0, 0
        self.typical = best if self.typical is None else _blended(self.typical, best)
        self.places = [best.centre] if was_missed else [last, best.centre]
        return best


def _blended(typical: Disc, disc: Disc) -> Disc:
    """Return a disc whose radius follows slowly."""
    radius = 0.95 * typical.radius + 0.05 * disc.radius
    return Disc(disc.centre, radius, disc.contrast, disc.change)


def period_of(times: np.ndarray, places: np.ndarray) -> tuple[float, float]:
    """Return the period of a swing in the picture and its standard deviation [s], NaN for none.

    Parameters
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    places : numpy.ndarray, shape (frame, 2) or (frame, 1)
        Column and row [pixels], or angle [rad]; NaN where unknown.

    Notes
    -----
    The slope of a straight line through the instants at which the ball passes the middle of its
    path in one direction, along the path's longest extent. None where fewer than half of the places
    are known: whole swings may be missing. If the halves of the clip differ by more than 3 standard
    deviations, half their difference joins the deviation: periods change with the amplitude.
    """
    period, sigma = _period(times, places)
    apart = halves_apart(times, places)
    if apart is not None:
        sigma = math.hypot(sigma, 0.5 * abs(apart[1] - apart[0]))
    return period, sigma


def period_of_ball(table: xr.Dataset, ball: int) -> tuple[float, float]:
    """Return the period of a ball's swing and its standard deviation [s], NaN for none.

    By its angle, or by its place in the picture in a table without angles.
    """
    names = [f"angle_{ball}"]
    if names[0] not in table.variables or not np.isfinite(table[names[0]].values).any():
        names = [f"ball_{ball}_u", f"ball_{ball}_v"]
    if not all(name in table.variables for name in names):
        return math.nan, math.nan
    places = np.column_stack([table[name].values for name in names])
    return period_of(table["time"].values, places)


def halves_apart(times: np.ndarray, places: np.ndarray) -> tuple[float, float] | None:
    """Return the periods of the halves of a clip [s], None if they agree or are unknown.

    Arguments are those of `period_of`.
    """
    middle = len(times) // 2
    halves = [_period(times[part], places[part]) for part in (np.s_[:middle], np.s_[middle:])]
    (early, one), (late, other) = halves
    return (early, late) if abs(late - early) > _APART * math.hypot(one, other) else None


def _period(times: np.ndarray, places: np.ndarray) -> tuple[float, float]:
    """Return the period of passages through the middle and the deviation of their line [s]."""
    ok = np.isfinite(places).all(axis=1)
    if ok.sum() < max(8, _KNOWN * len(ok)):
        return math.nan, math.nan
    centred = places[ok] - np.median(places[ok], axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    swing, instants = centred @ axis, times[ok]
    low, high = np.quantile(swing, [0.02, 0.98])
    swing = swing - 0.5 * (low + high)
    pause = _PAUSE * float(np.median(np.diff(times)))
    slack = 0.15 * (high - low)
    periods = [_slope(_passages(instants, sign * swing, slack, pause)) for sign in (1, -1)]
    known = [pair for pair in periods if math.isfinite(pair[0])]
    if not known:
        return math.nan, math.nan
    period = float(np.mean([pair[0] for pair in known]))
    return period, float(max(pair[1] for pair in known))


def _passages(times: np.ndarray, swing: np.ndarray, slack: float, pause: float) -> np.ndarray:
    """Return when a swing passes zero upwards, having been well below; NaN amid a pause."""
    passages, is_armed = [], False
    for k in range(1, len(swing)):
        is_armed = is_armed or swing[k - 1] < -slack
        if is_armed and swing[k - 1] <= 0.0 < swing[k]:
            is_armed = False
            share = -swing[k - 1] / (swing[k] - swing[k - 1])
            passed = times[k] - times[k - 1]
            passages.append(times[k - 1] + share * passed if passed <= pause else math.nan)
    return np.array(passages)


def _slope(passages: np.ndarray) -> tuple[float, float]:
    """Return the period of passages, some of which may be missing, and its error."""
    counted = np.flatnonzero(np.isfinite(passages))
    if len(counted) < _FEWEST:
        return math.nan, math.nan
    passages, apart = passages[counted], np.diff(counted)
    typical = float(np.median(np.diff(passages) / apart))
    steps = np.maximum(np.rint(np.diff(passages) / typical), apart)
    number = np.concatenate([[0.0], np.cumsum(steps)])
    fit, covariance = np.polyfit(number, passages, 1, cov="unscaled")
    rest = passages - np.polyval(fit, number)
    freedom = max(len(passages) - 2, 1)
    return float(fit[0]), float(math.sqrt(covariance[0, 0] * (rest @ rest) / freedom))
