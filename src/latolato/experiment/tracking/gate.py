"""Checks that what was followed is the ball, before a track is written."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from latolato.core.errors import InputError, joined
from latolato.experiment.opencv import import_cv2
from latolato.experiment.rules import broken, place_text, said
from latolato.experiment.tracking.link import extent_of
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.tracking.steady import (
    TOO_FAR,
    Bar,
    camera_motions,
    farthest,
    reduced,
)
from latolato.experiment.video import Frame

# Largest ratio between the measured and the declared radius, either way.
_RADIUS_RATIO = 1.5
# Radius from which not all pixels about a ball are looked at [pixels].
_ENOUGH = 16.0
# How far outside the ball a click may lie [pixels], and how many frames off a ball must be seen.
_BESIDE, _SOON = 3.0, 3
# Extent of a ball's path below which the ball rests [pixels], and the same in radii: the place of a
# large disc on a wall is measured badly.
_RESTING, _RESTING_RADII = 2.0, 0.1
# Share of the speeds below a fast one, and how many steps at that no ball leaps between frames.
_FAST, _LEAPS = 0.98, 2.0
# Over a fast one, speeds of a picture that stands still and of a ball on its way; by which share
# speeds before and after a pause may differ, and its fewest frames.
_STILL, _ON_ITS_WAY, _AS_FAST, _PAUSE = 0.05, 0.2, 0.5, 4
# Motion of the camera that is reported [pixels], and the share of it by which a ball must move.
_MENTIONED, _CARRIED = 1.0, 0.3
# Share of frames that need not show a small motion of the camera for it to be believed.
_UNSHOWN = 0.5
# Width to which pictures are reduced to see what changes far from the ball [pixels].
_COARSE = 160
# A pixel has changed if it differs by this many times the typical difference, and by this many
# steps of 255. Colour counts more than light, which shadows change too.
_CLEAR, _LEAST, _CHROMA = 3.0, 4.0, 2.0
# With how many other frames a frame is compared, and how far the ball must be away there: in radii,
# and as a share of the farthest.
_PARTNERS, _APART, _HALFWAY = 3, 2.3, 0.5
# Least share of the pixels under the ball that must have changed (of a disc whose radius is as much
# too large as a declared one may be), and by how much it must exceed the share beside the ball.
_CHANGED, _MORE = _RADIUS_RATIO**-2, 0.2
# Share under the ball from which it moves as a whole, and share of the rest of the picture that may
# change meanwhile, for a disc about a part of the ball to be believed.
_WHOLE, _ELSEWHERE = 0.9, 0.3
# Shares of frames in which a ball must pass for the track to be believed at all, as a ball and as a
# part of something larger, and how many neighbours have a say in whether a stretch is believed.
_PASSING, _ALWAYS, _NEIGHBOURS = 0.75, 0.9, 5
# Fewest pixels that tell, and the least share of the frames in which a ball was measured that must.
_FEWEST, _TELLING = 4, 0.25
# By how much a disc may be too small or too large for the pixels under it to be its own: as a share
# of its radius, and where discs nearly cover each other, in pixels.
_UNSURE_EDGE, _EDGE = 0.15, 1.0


@dataclass(frozen=True)
class Finding:
    """A fault that a check found in a track.

    Attributes
    ----------
    fault : InputError
        Why the track cannot be believed, and what to do instead.
    is_refusal : bool
        Whether the whole track is refused. Otherwise the user is warned.
    doubtful : numpy.ndarray of bool, shape (frame, ball), or None
        Samples that must not count as measured; None if all may.
    """

    fault: InputError
    is_refusal: bool = True
    doubtful: np.ndarray | None = None


def examine(
    sample: Sample,
    track: Positions,
    clicks: Sequence[np.ndarray],
    expected_radius: float | None = None,
) -> list[Finding]:
    """Return the faults that checks find in a track; an empty list for a good one.

    The first refusal ends the examination.

    Parameters
    ----------
    sample : Sample
        Frames spread over the clip.
    track : Positions
        What was followed in all frames.
    clicks : sequence of numpy.ndarray, shape (2,)
        Where the balls are in the clicked frame according to the user [pixels].
    expected_radius : float, optional
        Radius of a ball according to the user, by the scale [pixels].
    """
    checks: tuple[Callable[[], Finding | None], ...] = (
        lambda: clicked_ball(track, clicks, sample.click),
        lambda: declared_radius(track, expected_radius),
        lambda: moving_ball(track),
        lambda: uncut_clip(track),
        lambda: resting_camera(sample, track),
        lambda: changing_pixels(sample, track),
    )
    findings: list[Finding] = []
    for check in checks:
        finding = check()
        if finding is not None:
            findings.append(finding)
            if finding.is_refusal:
                break
    return findings


def clicked_ball(track: Positions, clicks: Sequence[np.ndarray], number: int = 0) -> Finding | None:
    """Check that the balls are where they were clicked, in the frame of a number.

    A ball that was not measured then must be a few frames later or before, as far away as it may
    have moved, or rest there when it is seen. It can miss a frame before start or after end.
    """
    if not 0 <= number < len(track.times):
        return None
    for ball in range(track.centres.shape[1]):
        seen = np.flatnonzero(track.is_measured[:, ball])
        if not len(seen):
            continue
        near = int(seen[np.argmin(np.abs(seen - number))])
        late, place = abs(near - number), track.centres[near, ball]
        steps = np.hypot(*np.diff(track.centres[:, ball], axis=0).T)
        reach = track.radius + _BESIDE
        if late and np.isfinite(steps).any():
            reach += min(late, _SOON) * float(np.nanquantile(steps, 0.98))
        away = min(float(np.hypot(*(place - click))) for click in clicks)
        step = float(np.nanmean(steps[max(near - 1, 0) : near + 2])) if len(steps) else math.nan
        if late > _SOON and (away > reach or step > _RESTING):  # it may have rested there
            times = {"time": track.times[number], "near": track.times[near]}
            return Finding(broken("not_where_pointed", {**times, "count": late}))
        if away > reach:
            sizes = {"radius": f"{track.radius:.0f}", "pixels": f"{away:.0f}"}
            return Finding(broken("other_ball", {"place": place_text(place), **sizes}))
    return None


def declared_radius(track: Positions, expected: float | None) -> Finding | None:
    """Check that the measured radius is the declared one within a factor of 1.5.

    It can miss whatever has the size of the ball, and everything if no radius is declared.
    """
    if expected is None:
        return None
    ratio = track.radius / expected
    if 1.0 / _RADIUS_RATIO <= ratio <= _RADIUS_RATIO:
        return None
    sizes = {"radius": f"{track.radius:.1f}", "declared": f"{expected:.1f}"}
    return Finding(broken("other_radius", sizes))


def moving_ball(track: Positions) -> Finding | None:
    """Check that each ball moves by more than two pixels, and a tenth of its radius.

    It can miss a thing at rest whose place is measured badly; `changing_pixels` sees that.
    """
    for ball in range(track.centres.shape[1]):
        places = track.centres[track.is_measured[:, ball], ball]
        if len(places) < _FEWEST:
            continue
        extent = extent_of(places)
        if extent < max(_RESTING, _RESTING_RADII * track.radius):
            values = {"place": place_text(places[0]), "extent": f"{extent:.1f}"}
            return Finding(broken("resting_ball", values))
    return None


def uncut_clip(track: Positions) -> Finding | None:
    """Check that no ball leaps, and that none stops at once and goes on as fast: a cut, a pause.

    A ball leaps where the ways before and after a step lead to places that are two steps of a fast
    ball apart. Where two touch they are one step apart at most. What a pause repeats and the frame
    after a cut are doubtful. It can miss what is cut where a ball is nearly the same on both sides,
    and pauses of fewer than four frames or near a turning point.
    """
    known = np.flatnonzero(track.is_measured.all(axis=1))
    if len(known) < _FEWEST:
        return None
    times, places = track.times[known], track.centres[known]
    cuts, pauses = _cuts(times, places, track.radius), _pauses(times, places)
    if not cuts and not pauses:
        return None
    doubtful = np.zeros(track.flags.shape, bool)
    doubtful[known[[k + 1 for k in cuts]]] = True
    for i, j in pauses:
        doubtful[known[i] + 1 : known[j] + 1] = True
    told = [said("cut_at", time=times[k + 1]) for k in cuts]
    told += [said("still_picture", begin=times[i], end=times[j]) for i, j in pauses]
    shown = told if len(told) < 4 else [*told[:3], said("more_places", count=len(told) - 3)]
    fault = broken("cut_clip", {"places": joined(shown, ", ")})
    return Finding(fault, is_refusal=False, doubtful=doubtful)


def _cuts(times: np.ndarray, places: np.ndarray, radius: float) -> list[int]:
    """Return the last samples before cuts, of balls at places (sample, ball, 2) [pixels]."""
    steps = np.diff(times)
    rates = np.diff(places, axis=0) / steps[:, None, None]
    fastest = np.quantile(np.linalg.norm(rates, axis=-1), _FAST, axis=0)
    leaps = np.zeros(len(steps))
    for k in range(2, len(steps) - 2):
        middle = 0.5 * (times[k] + times[k + 1])
        # One sample further away as well: a single wrong place is no cut.
        ways = [
            places[k + 1 + j]
            - rates[k + 1 + j] * (times[k + 1 + j] - middle)
            - places[k - j]
            - rates[k - 1 - j] * (middle - times[k - j])
            for j in (0, 1)
        ]
        reach = _LEAPS * fastest * steps[k] + radius
        leaps[k] = float(np.min(np.linalg.norm(ways, axis=-1) / reach))
    # The steps beside a cut seem to leap as well.
    far = np.flatnonzero(leaps > 1.0)
    return [int(k) for k in far if leaps[k] == leaps[k - 1 : k + 2].max()]


def _pauses(times: np.ndarray, places: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last samples of pauses, of balls at places (sample, ball, 2)."""
    rates = np.diff(places, axis=0) / np.diff(times)[:, None, None]
    speeds = np.linalg.norm(rates, axis=-1)
    fastest = np.quantile(speeds, _FAST, axis=0)
    is_still = (speeds < _STILL * fastest).all(axis=1)
    edges = np.flatnonzero(np.diff(np.r_[False, is_still, False])).tolist()
    found = []
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin < _PAUSE or begin < 1 or end + 1 >= len(rates):
            continue
        before = rates[begin - 1]
        for after in rates[end : end + 2]:  # of the first one, a part may be the pause's
            fast = np.fmax(*(np.linalg.norm(one, axis=-1) for one in (before, after)))
            goes_on = np.linalg.norm(after - before, axis=-1) < _AS_FAST * fast
            if (goes_on & (fast > _ON_ITS_WAY * fastest)).all():
                found.append((begin, end))
                break
    return found


def resting_camera(sample: Sample, track: Positions) -> Finding | None:
    """Check that the camera moves by no more than 2 % of the diagonal, and balls do not with it.

    Where it moves by less, frames were corrected before, if the background shows that in all of
    them. It can miss what `latolato.experiment.tracking.steady.camera_motions` can miss.
    """
    number = sample.click if sample.click < len(track.times) else 0
    hidden = []
    for place in track.centres[number][np.isfinite(track.centres[number]).all(axis=-1)]:
        pivot = track.pivots[number]
        end = pivot if np.isfinite(pivot).all() else place
        hidden.append(Bar(place, end, 1.5 * track.reach))
    _, motions, unknown = camera_motions(sample, hidden)
    far = farthest(motions)
    if far is None or far.moved < _MENTIONED:
        return None
    if far.moved > TOO_FAR * math.hypot(*sample.frames[0].luma.shape):
        return Finding(broken("moved_camera", far.values))
    if unknown > _UNSHOWN:  # a small motion would be seen in the other frames, too
        return None
    for ball in range(track.centres.shape[1]):
        own = np.array(
            [
                motion.matrix @ [*track.centres[number, ball], 1.0]
                for number, motion in motions.items()
                if number < len(track.times) and track.is_measured[number, ball]
            ]
        )
        extent = extent_of(own) if len(own) >= _FEWEST else math.inf
        if extent < max(_RESTING, _CARRIED * far.moved):
            return Finding(broken("carried_ball", {**far.values, "extent": f"{extent:.1f}"}))
    return Finding(broken("moving_camera", far.values), is_refusal=False)


def changing_pixels(sample: Sample, track: Positions) -> Finding | None:
    """Check that the pixels under the ball change when it comes, and that those beside it do not.

    Those beside it may change too if nearly all under it do and the rest of the picture rests: the
    disc is then about a part of the ball: the user is warned of one, and two are refused. It can
    miss any part of a larger thing that moves, a place beside the ball's centre by less than half a
    radius, and what happens between the frames of the sample.
    """
    numbers, shares = change_shares(sample, track)
    doubtful = np.zeros(track.is_measured.shape, bool)
    radius = {"radius": f"{track.radius:.0f}"}
    is_part = False
    for ball in range(track.centres.shape[1]):
        known = np.isfinite(shares[:, ball, 0])
        seen = track.is_measured[numbers, ball]
        if seen.sum() < _FEWEST:
            continue
        if known.sum() < max(_FEWEST, _TELLING * seen.sum()):
            extent = extent_of(track.centres[numbers[seen], ball])
            return Finding(broken("small_motion", {"extent": f"{extent:.1f}", **radius}))
        under, beside, elsewhere, plain = shares[known, ball].T
        is_ball = (under >= _CHANGED) & (under - beside >= _MORE)
        moves = (plain >= _WHOLE) & (elsewhere <= _ELSEWHERE)
        # Beside a ball the shadow of another one may come and go.
        passes = is_ball | moves
        is_alone = is_ball.mean() >= _PASSING
        if not is_alone and passes.mean() < _ALWAYS:
            is_busy = np.median(under) >= _WHOLE and np.median(elsewhere) > _ELSEWHERE
            parts = {"under": under, "beside": beside, "elsewhere": elsewhere}
            values = {name: _percent(each) for name, each in parts.items()} | radius
            return Finding(broken("busy_background" if is_busy else "no_ball", values))
        is_part |= not is_alone
        doubtful[:, ball] = _stretches(numbers[known], passes, len(doubtful))
    doubtful &= track.is_measured
    if doubtful.any():
        percent = _percent(doubtful[track.is_measured], np.mean)
        return Finding(broken("unlike_pixels", {"percent": percent}), False, doubtful)
    if is_part:  # two discs may be parts of one ball, and of one after the other
        return Finding(broken("part_of_larger", radius), is_refusal=track.centres.shape[1] == 2)
    return None


def _percent(shares: np.ndarray, typical: Callable[[np.ndarray], Any] = np.median) -> str:
    """Return a typical share in per cent as a text."""
    return f"{100.0 * float(typical(shares)):.0f}"


def change_shares(sample: Sample, track: Positions) -> tuple[np.ndarray, np.ndarray]:
    """Return numbers of the sample's frames, and shares of pixels that changed.

    A frame is compared with others in which the ball is elsewhere, the nearest in time: the wall
    shows there what the ball hides here. The shares under the ball, beside it and in the rest of
    the picture, and under the ball if the light is taken as steady, of shape (sample frame, ball,
    4), are medians over these; NaN where a ball was not measured or never is elsewhere.
    """
    frames = sample.frames
    numbers = np.array([frame.number for frame in frames])
    centres, is_measured = track.centres[numbers], track.is_measured[numbers]
    limit = max(_LEAST, _CLEAR * _typical_difference(frames))
    shares = np.full((*centres.shape[:2], 4), np.nan)
    coarse = _Coarse(frames, centres, track.reach, limit)
    for k, ball in np.argwhere(is_measured):
        away = np.hypot(*(centres[:, ball] - centres[k, ball]).T)
        away[~is_measured[:, ball]] = np.nan
        farthest = float(np.nanmax(away))
        enough = min(max(_APART * track.reach, _HALFWAY * farthest), farthest)
        if enough < _RESTING:
            continue
        partners = np.flatnonzero(away >= 0.98 * enough)
        partners = partners[np.argsort(np.abs(partners - k), kind="stable")][:_PARTNERS]
        window = _Window.about(frames[k], centres[k, ball], track.reach)
        if window is None:
            continue
        here = window.picture(frames[k])
        changes = []
        for j in partners:
            at = int(k), int(j), int(ball)
            under, beside = _regions(window, track, numbers, *at, _UNSURE_EDGE * track.radius)
            if under.sum() < _FEWEST:
                under, _ = _regions(window, track, numbers, *at, _EDGE)
            if under.sum() < _FEWEST or beside.sum() < _FEWEST:
                continue
            change = here - window.picture(frames[j])
            # The light may change for all.
            local = np.median(change[beside], axis=0)
            changed, plainly = (_largest(change - light) > limit for light in (local, 0.0))
            elsewhere = coarse.changed(int(k), int(j))
            changes.append(
                (changed[under].mean(), changed[beside].mean(), elsewhere, plainly[under].mean())
            )
        if changes:
            shares[k, ball] = np.median(changes, axis=0)
    return numbers, shares


class _Coarse:
    """Small pictures of the sample: what changes away from the balls."""

    def __init__(
        self, frames: list[Frame], centres: np.ndarray, radius: float, limit: float
    ) -> None:
        self.pictures = [reduced(frame, _COARSE) for frame in frames]
        scale = frames[0].luma.shape[1] / self.pictures[0].shape[1]
        self.centres, self.reach, self.limit = centres / scale, 1.5 * radius / scale + 1.0, limit

    def changed(self, k: int, j: int) -> float:
        """Return which share of the picture away from the balls differs in two frames."""
        change = self.pictures[k].astype(np.float32) - self.pictures[j]
        v, u = np.ogrid[: change.shape[0], : change.shape[1]]
        free = np.ones(change.shape, bool)
        for place in self.centres[[k, j]].reshape(-1, 2):
            if np.isfinite(place).all():
                free &= _squared_distance(u, v, place) > self.reach**2
        if not free.any():
            return 1.0
        return float(np.mean(np.abs(change[free] - np.median(change[free])) > self.limit))


def _typical_difference(frames: list[Frame]) -> float:
    """Return the median difference of a pixel between frames of the sample [steps of 255].

    The middle half of the picture is enough.
    """
    whole = _Window.whole(frames[0])
    window = replace(whole, top=whole.bottom // 4, bottom=3 * whole.bottom // 4)
    pictures = [window.picture(frame) for frame in frames[:: max(1, len(frames) // 6)]]
    return float(np.median([_largest(b - a) for a, b in pairwise(pictures)]))


def _largest(change: np.ndarray) -> np.ndarray:
    """Return the largest size of a pixel's changes, shape (row, column)."""
    # Plane by plane: numpy is slow along an axis of three.
    luma, blue, red = np.abs(np.moveaxis(change, -1, 0))
    return np.asarray(np.maximum(np.maximum(luma, blue), red))


def _squared_distance(u: np.ndarray, v: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the squared distance of columns (1, column) and rows (row, 1) from a place."""
    return np.asarray((u - place[0]) ** 2 + (v - place[1]) ** 2)


@dataclass(frozen=True)
class _Window:
    """Columns and rows of a part of the picture at half the resolution: colour is no finer."""

    left: int
    top: int
    right: int
    bottom: int
    # Of so many pixels along a line one is looked at.
    step: int

    @classmethod
    def whole(cls, frame: Frame) -> _Window:
        """Return the whole picture."""
        rows, columns = (side // 2 for side in frame.luma.shape)
        return cls(0, 0, columns, rows, 2)

    @classmethod
    def about(cls, frame: Frame, centre: np.ndarray, radius: float) -> _Window | None:
        """Return the part about a ball and its surroundings; None if it is out of the picture."""
        all_ = cls.whole(frame)
        reach = 1.2 * radius + 4.0
        u, v = (centre - 0.5) / 2.0
        left, top = max(0, math.floor(u - reach)), max(0, math.floor(v - reach))
        right = min(all_.right, math.ceil(u + reach) + 1)
        bottom = min(all_.bottom, math.ceil(v + reach) + 1)
        step = max(1, int(radius / _ENOUGH))
        return cls(left, top, right, bottom, step) if min(right - left, bottom - top) > 2 else None

    def picture(self, frame: Frame) -> np.ndarray:
        """Return luma and weighted chroma, slightly blurred, shape (row, column, 3)."""
        part = slice(self.top, self.bottom), slice(self.left, self.right)
        fine = frame.luma[2 * self.top : 2 * self.bottom, 2 * self.left : 2 * self.right]
        quarters = (fine[row::2, column::2] for row in (0, 1) for column in (0, 1))
        luma = 0.25 * np.add.reduce([*quarters], dtype=np.float32)
        chroma = [np.float32(_CHROMA) * plane[part] for plane in (frame.blue, frame.red)]
        planes = np.dstack([luma, *chroma])
        import_cv2().GaussianBlur(planes, (0, 0), 0.8, dst=planes)
        return planes[:: self.step, :: self.step].copy()

    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Return columns (1, column) and rows (row, 1) of its pixels in the full picture."""
        step = self.step
        rows, columns = np.ogrid[self.top : self.bottom : step, self.left : self.right : step]
        return 2.0 * columns + 0.5, 2.0 * rows + 0.5


def _regions(
    window: _Window,
    track: Positions,
    numbers: np.ndarray,
    k: int,
    j: int,
    ball: int,
    unsure: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return which pixels are under a ball of frame `k`, and which beside it.

    Both are free of other balls and of the balls of frame `j`, and what is beside is free of rods.
    The disc's edge is where it is said to be give or take `unsure` [pixels].
    """
    u, v = window.places()
    radius = track.reach
    own = track.centres[numbers[k], ball]
    distance = np.sqrt(_squared_distance(u, v, own))
    is_free, is_clear = np.ones(distance.shape, bool), np.ones(distance.shape, bool)
    for q in (k, j):
        for other in range(track.centres.shape[1]):
            place = track.centres[numbers[q], other]
            if not np.isfinite(place).all():
                continue
            if (q, other) != (k, ball):
                is_free &= _squared_distance(u, v, place) > (radius + unsure + 1.0) ** 2
            # Without a pivot in the picture no rod is left out.
            rod = track.pivots[numbers[q]] - place
            x, y = rod / max(float(np.hypot(*rod)), 1e-9)
            along = (u - place[0]) * x + (v - place[1]) * y
            across = np.abs((u - place[0]) * y - (v - place[1]) * x)
            is_clear &= ~((along > 0.0) & (across < 0.35 * radius + 2.0))
    away, angle = (
        np.stack(np.broadcast_arrays(u, v), axis=-1) - own,
        float(track.angles[numbers[k], ball]),
    )
    under = is_free & track.covers(away, angle, unsure)
    beside = is_free & is_clear & (distance > 1.35 * radius + 2.0) & (distance < 2.2 * radius + 4.0)
    return under, beside


def _stretches(numbers: np.ndarray, passes: np.ndarray, count: int) -> np.ndarray:
    """Return which frames are nearest to a stretch of the sample that does not pass."""
    half = _NEIGHBOURS // 2
    padded = np.pad(passes.astype(float), half, mode="edge")
    voted = np.convolve(padded, np.ones(_NEIGHBOURS) / _NEIGHBOURS, mode="valid") < 0.5
    middles = 0.5 * (numbers[1:] + numbers[:-1])
    return np.asarray(voted[np.searchsorted(middles, np.arange(count))])
