"""Where balls roughly are in every frame: linked from both sides before anything is learned."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from latolato.experiment.calibration.parabola import parabola_top
from latolato.experiment.opencv import import_cv2
from latolato.experiment.tracking.detect import Blobs, Copies, detect
from latolato.experiment.tracking.link import (
    ALIKE,
    WEIGHTS,
    Trajectory,
    are_alike,
    extent_of,
    link_alike,
    link_clicked,
)
from latolato.experiment.video import Frame

# Frames without a detection that are bridged, and how far apart the ends of a longer gap may be
# for a ball to have rested there [radii].
_BRIDGED, _RESTED = 12, 1.5
# A blob is a part of a ball if it is smaller than this share of the typical one.
_PARTLY = 0.8
# How wide a stripe of the wall's colour across a ball may be [radii]; how near to the middle of two
# parts a click is, which is nearer to no part, as a share of how far these are apart, and how far
# that is at most [their half lengths].
_STRIPE, _AMID, _PARTED = 0.9, 0.25, 2.5
# By how much steps of time that count as even differ from the typical one, as a share.
_EVEN = 0.05
# Fewest fast blobs that show the exposure.
_FEWEST = 6
# What is this many times longer than wide may be more than a ball.
_LONG = 1.5
# Two balls are one blob where they are nearer than this and only one is detected [radii].
_MERGED = 3.5
# Balls may touch where they are nearer than this [radii]: their blobs are one a little before.
_TOUCH = 2.5
# A ball that goes no farther than this never leaves its place [radii]; how alike it looks all the
# time then, though what is detected may leap.
_STAYS, _SAME = 3.0, 0.9
# Half the side of the patch that is compared then, and how far it may move between frames [radii].
_PATCH, _STEP = 1.3, 1.5


@dataclass
class Route:
    """Where balls are in every frame.

    Attributes
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    places : numpy.ndarray, shape (frame, ball, 2)
        Column and row [pixels], between detections interpolated; NaN where unknown.
    is_seen : numpy.ndarray, shape (frame, ball)
        Where a ball was detected as a whole.
    radius : float
        Of a ball, roughly [pixels]: the declared one, or else the detected one.
    detected_radius : float
        Typical half width of what was detected [pixels]; NaN if nothing was.
    exposure : float
        Share of the time between frames that the length of smears shows, roughly.
    is_traced : bool
        Whether balls hardly leave their places: then only their rims are detected.
    is_rod : bool
        Whether what moves there is long and thin, and no ball.
    meets : float
        When a ball that nobody pointed at, and that looks the same, comes near the only one [s];
        NaN if none does.
    """

    times: np.ndarray
    places: np.ndarray
    is_seen: np.ndarray
    radius: float
    detected_radius: float
    exposure: float = 0.0
    is_traced: bool = False
    is_rod: bool = False
    meets: float = math.nan

    @property
    def is_smeared(self) -> bool:
        """Whether smears are typically longer than balls are wide, as of small bright dots."""
        speeds = np.linalg.norm(self.velocities[0], axis=-1)[self.is_seen]
        if not np.isfinite(speeds).any():
            return False
        smear = float(np.nanmedian(speeds) * np.median(np.diff(self.times))) * self.exposure
        return smear > 2.0 * self.radius

    @cached_property
    def velocities(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocities and accelerations, each (frame, ball, 2) [pixels/s, pixels/s^2].

        Where a ball turns at once, as at a contact, the velocity is that of the smoother side; NaN
        where unknown.
        """
        return velocities(self.times, self.places, self.radius)

    def ball(self, number: int) -> Route:
        """Return the route of one ball."""
        one = slice(number, number + 1)
        return replace(self, places=self.places[:, one], is_seen=self.is_seen[:, one])

    def seen_in(self, frames: list[Frame]) -> tuple[np.ndarray, np.ndarray]:
        """Places (place, 2) at which balls were detected in some frames, and which of them each."""
        in_clip = [k for k, frame in enumerate(frames) if 0 <= frame.number < len(self.times)]
        numbers = [frames[k].number for k in in_clip]
        is_seen = self.is_seen[numbers]
        return self.places[numbers][is_seen], np.repeat(in_clip, is_seen.sum(axis=1))

    def ordered(self, pivot: np.ndarray) -> Route:
        """Return the route of two balls in their order about a pivot: they cannot pass each other.

        Equal balls that meet exchange their speeds, which looks like passing through each other.
        The right-hand ball comes first; beyond the top, what follows from the way there does.
        """
        if self.places.shape[1] == 1:
            return self
        raw = np.arctan2(*np.moveaxis(self.places - pivot, -1, 0))
        both = np.isfinite(raw).all(axis=1)
        swap = np.zeros(len(raw), bool)
        edges = np.flatnonzero(np.diff(np.r_[False, both, False]))
        for begin, end in zip(edges[::2], edges[1::2], strict=True):
            turns = np.unwrap(raw[begin:end], axis=0)
            between = turns[:, 0] - turns[:, 1]
            # Where both are nearest to the bottom, their angles are what they seem.
            lowest = int(np.argmin(np.abs(raw[begin:end]).max(axis=1)))
            now = raw[begin + lowest, 0] - raw[begin + lowest, 1]
            between += math.tau * np.rint((now - between[lowest]) / math.tau)
            swap[begin:end] = np.remainder(between + math.tau, 2.0 * math.tau) < math.tau
        # A ball that is seen alone is the one that it was, or else the one that it will be.
        known = np.flatnonzero(both)
        if len(known):
            before = np.searchsorted(known, np.arange(len(raw)), side="right") - 1
            swap = swap[known[np.maximum(before, 0)]]
        order = np.where(swap[:, None], [1, 0], [0, 1])
        return replace(
            self,
            places=np.take_along_axis(self.places, order[..., None], axis=1),
            is_seen=np.take_along_axis(self.is_seen, order, axis=1),
        )

    def angles(self, pivot: np.ndarray) -> np.ndarray:
        """Angles about a place from straight down, without leaps by whole turns (frame, ball)."""
        raw = np.arctan2(*np.moveaxis(self.places - pivot, -1, 0))
        for b in range(raw.shape[1]):
            known = np.isfinite(raw[:, b])
            raw[known, b] = np.unwrap(raw[known, b])
        return np.asarray(raw)


def velocities(
    times: np.ndarray, places: np.ndarray, radius: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities and accelerations of places (frame, ball, 2) by their neighbours.

    Where no velocity is known it is NaN, and where no acceleration is it is 0.
    """
    steps = np.full((len(places) + 1, *places.shape[1:]), np.nan)
    steps[1:-1] = np.diff(places, axis=0) / np.diff(times)[:, None, None]
    before, after = steps[:-1], steps[1:]
    interval = float(np.median(np.diff(times)))
    bends = (after - before) / interval
    rough = np.linalg.norm(bends, axis=-1)
    known = np.isfinite(rough)
    typical = float(np.median(rough[known])) if known.any() else 0.0
    is_smooth = known & (rough <= max(4.0 * typical, 0.5 * radius / interval**2))
    # One side only: the one whose step is more like the step before it, or after it.
    beside = np.full((len(places) + 2, places.shape[1]), np.inf)
    beside[1:-1][known] = rough[known]
    takes_before = beside[:-2] <= beside[2:]
    takes_before = np.where(np.isfinite(before).all(axis=-1), takes_before, False)
    takes_before |= ~np.isfinite(after).all(axis=-1)
    one_sided = np.where(takes_before[..., None], before, after)
    velocity = np.where(is_smooth[..., None], 0.5 * (before + after), one_sided)
    # At few frames a second a swing is no parabola: where five places in even steps are smooth, the
    # slope of the quartic through them.
    if len(places) >= 5:
        wide = np.full(places.shape, np.nan)
        near, far = places[3:-1] - places[1:-3], places[4:] - places[:-4]
        wide[2:-2] = (8.0 * near - far) / (12.0 * interval)
        gaps = np.diff(times)
        is_even = np.zeros(len(times), bool)
        uneven = np.abs(np.stack([gaps[k : len(gaps) - 3 + k] for k in range(4)]) / interval - 1.0)
        is_even[2:-2] = (uneven < _EVEN).all(axis=0)
        around = np.zeros_like(is_smooth)
        around[1:-1] = is_smooth[2:] & is_smooth[1:-1] & is_smooth[:-2]
        use = around & is_even[:, None] & np.isfinite(wide).all(axis=-1)
        velocity = np.where(use[..., None], wide, velocity)
    return velocity, np.where(is_smooth[..., None], bends, 0.0)


def find_route(
    copies: Copies,
    times: np.ndarray,
    clicks: list[np.ndarray],
    number: int,
    radius: float | None,
    is_stale: np.ndarray,
    pivots: list[np.ndarray | None],
) -> Route:
    """Return where balls are that are pointed at in a frame.

    Parameters
    ----------
    copies : Copies
        Small pictures of all frames.
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    clicks : list of numpy.ndarray, shape (2,)
        Column and row of each ball [pixels].
    number : int
        The frame that they belong to.
    radius : float or None
        Of a ball [pixels], None if it is not known.
    is_stale : numpy.ndarray of bool, shape (frame,)
        Which frames show an older picture.
    pivots : list of numpy.ndarray, shape (2,), or None
        About which each ball swings, None where that is not known [pixels].
    """
    left, bounds = list(copies.blobs), copies.bounds
    parted = radius_of_parts(left[number], clicks) if 0 <= number < len(left) else math.nan
    if math.isfinite(parted):
        left = detect(copies, stripe=_STRIPE * (radius or parted))
    empty = Blobs.of([], copies.shrink)
    for frame in np.flatnonzero(is_stale).tolist():
        if frame != number:
            left[frame] = empty
    tracks: list[Trajectory] = []
    # Where balls are parted, the click shows the colour of the stripe.
    is_known = not 0 <= number < len(left) or math.isfinite(parted)
    for click, pivot in zip(clicks, pivots, strict=True):
        track, others = link_clicked(left, copies, click, number, radius, pivot)
        if is_known or _is_by_itself(left[number], click, copies, number, radius):
            left = others
        else:
            # It is a part of something larger that moves with it: its colour tells it.
            colour = copies.colour(number, click, radius or 2.0 * copies.shrink)
            own = detect(copies, colour)
            track, others = link_clicked(own, copies, click, number, radius, pivot)
            left = others if len(clicks) == 1 else left
        tracks.append(track)
    is_rod = any(track.is_rod for track in tracks)
    detected_radius = float(np.median([track.radius for track in tracks]))
    size = radius or detected_radius
    places = np.stack([track.places for track in tracks], axis=1)
    is_traced = []
    for b, track in enumerate(tracks):
        stays = not track.is_seen.any() or track.extent < _STAYS * size
        traced, likeness = _traced(copies, clicks[b], number, size, 0.0 if stays else _SAME)
        known = traced[np.isfinite(traced[:, 0])]
        stays |= likeness > _SAME and extent_of(known) < _STAYS * size
        is_traced.append(stays)
        if stays:
            places[:, b] = traced
    detected = places.copy()
    touching = np.full_like(places, np.nan)
    if len(tracks) == 2:
        is_one = _are_one(times, places, size)
        is_one &= ~_told_apart(left, places, np.flatnonzero(is_one), size)
        known = [pivot for pivot in pivots if pivot is not None]
        if known:
            pivot = np.mean(known, axis=0)
            # Of a ball that is traced no blob was linked.
            one, other = (track.lengths[is_one] for track in tracks)
            lengths = np.nan_to_num(np.where(np.isfinite(one), one, other), nan=size)
            middles = np.nanmean(places[is_one], axis=1)
            touching[is_one] = _touching(middles, lengths, pivot, size)
        places[is_one] = detected[is_one] = np.nan
    sizes = np.stack([track.radii for track in tracks], axis=1)
    with np.errstate(invalid="ignore"):
        places[sizes < _PARTLY * np.nanmedian(sizes, axis=0)] = np.nan
    # At the edge of what is looked at a ball is cut.
    with np.errstate(invalid="ignore"):
        is_whole = (places > bounds[0] + size).all(axis=-1) & (places < bounds[1] - size).all(
            axis=-1
        )
    is_seen = np.isfinite(places[..., 0]) & is_whole
    places = _bridged(times, places, size)
    # Where nothing better is known, a part of a ball tells where it is, or a blob of both.
    for rough in (detected, touching):
        places = np.where(np.isfinite(places), places, rough)
    route = Route(times, places, is_seen, size, detected_radius, is_traced=any(is_traced))
    if len(tracks) == 1:
        route.meets = _meeting(times, tracks[0], left)
    return replace(route, is_rod=is_rod, exposure=_exposure(route, tracks))


def _are_one(times: np.ndarray, places: np.ndarray, radius: float) -> np.ndarray:
    """Return in which frames two balls (frame, ball, 2) may be one blob, as where they touch.

    Only one is seen there, and the other is near it by its neighbours in time: on a smooth curve,
    or where it was last seen before or is first seen after.
    """
    filled, frames = _bridged(times, places, radius), np.arange(len(times))
    result = np.zeros(len(times), bool)
    for b in range(2):
        known = np.flatnonzero(np.isfinite(places[:, b, 0]))
        if not len(known):
            continue
        later = np.searchsorted(known, frames)
        around = [known[np.clip(k, 0, len(known) - 1)] for k in (later - 1, later)]
        for other in (filled[:, b], *(places[k, b] for k in around)):
            apart = np.linalg.norm(filled[:, 1 - b] - other, axis=-1)
            result |= np.isnan(places[:, b, 0]) & (apart < _MERGED * radius)
    return np.asarray(result & (np.isfinite(places[..., 0]).sum(axis=1) == 1))


def _told_apart(
    left: list[Blobs], places: np.ndarray, frames: np.ndarray, radius: float
) -> np.ndarray:
    """Put the ball that is missing in some frames where a blob like it lies beside the other one.

    Balls that are one blob for a while may be two in a frame between: too few to be linked.
    Returns in which frames there is such a blob, and writes its place into `places`.
    """
    result = np.zeros(len(places), bool)
    for frame in frames.tolist():
        own, seen = left[frame], int(np.isfinite(places[frame, 1, 0]))
        away = np.linalg.norm(own.places - places[frame, seen], axis=1)
        is_ball = (own.lengths < _LONG * own.radii) & (own.radii > _PARTLY * radius)
        is_ball &= (own.radii < radius / _PARTLY) & (away > radius) & (away < _MERGED * radius)
        if is_ball.any():
            result[frame] = True
            places[frame, 1 - seen] = own.places[np.argmin(np.where(is_ball, away, np.inf))]
    return result


def _touching(
    middles: np.ndarray, lengths: np.ndarray, pivot: np.ndarray, radius: float
) -> np.ndarray:
    """Return the places (frame, ball, 2) of balls that are one blob, on both sides of its middle.

    The second moment along two discs at distances ``d`` from their middle is ``r^2/4 + d^2``, and
    that of an ellipse of half `lengths` ``L`` is ``L^2/4``.
    """
    down = middles - pivot
    down = down / np.linalg.norm(down, axis=1, keepdims=True)
    apart = np.sqrt(np.maximum(0.25 * (lengths**2 - radius**2), 0.0))
    apart = np.clip(apart, radius, 0.5 * _MERGED * radius)
    across = apart[:, None] * np.column_stack([down[:, 1], -down[:, 0]])
    return np.stack([middles + across, middles - across], axis=1)


def _meeting(times: np.ndarray, first: Trajectory, left: list[Blobs]) -> float:
    """Return when a ball first comes near one like it [s], NaN if it never does."""
    if not first.is_seen.any():
        return math.nan
    other, _ = link_alike(left, first)
    if not are_alike(first, other):
        return math.nan
    apart = np.linalg.norm(first.places - other.places, axis=1)
    # How near they may be between frames. A NaN is not near: where they touch, they are one blob.
    steps = np.abs(np.diff(apart, prepend=apart[0], append=apart[-1]))
    nearest = apart - np.fmax(steps[:-1], steps[1:])
    is_near = (apart < _MERGED * first.radius) & (nearest < _TOUCH * first.radius)
    near = np.flatnonzero(is_near)
    return float(times[near[0]]) if len(near) else math.nan


def _is_by_itself(
    blobs: Blobs, click: np.ndarray, copies: Copies, number: int, radius: float | None
) -> bool:
    """Return whether what is clicked moves by itself, or nothing moves there.

    A ball in a hand is a part of something long that mostly has another colour.
    """
    away = np.linalg.norm(blobs.places - click, axis=1)
    if not (away < blobs.lengths + copies.shrink).any():
        return True
    at = int(np.argmin(away))
    if blobs.lengths[at] > _LONG * blobs.radii[at]:
        own = copies.colour(number, click, radius or blobs.radii[at])
        if np.linalg.norm((own - blobs.colours[at]) * WEIGHTS) > ALIKE:
            return False
    return bool(away[at] < blobs.radii[at] + copies.shrink)


def radius_of_parts(blobs: Blobs, clicks: list[np.ndarray]) -> float:
    """Return the radius of balls that are seen as two parts, as with a stripe like the wall.

    Of all that are clicked, at places (2,), one part lies on each side of the click; else it is
    NaN.
    """
    sizes = []
    for click in clicks:
        near = np.argsort(np.linalg.norm(blobs.places - click, axis=1))[:2]
        if len(near) < 2:
            return math.nan
        places, radii = blobs.places[near], blobs.radii[near]
        apart = math.dist(*places)
        nearest = float(np.linalg.norm(places - click, axis=1).min())
        is_between = math.dist(places.mean(axis=0), click) < _AMID * apart < nearest
        are_parts = (
            radii.max() < _LONG * radii.min() and apart < _PARTED * blobs.lengths[near].max()
        )
        if not (is_between and are_parts):
            return math.nan
        sizes.append(0.5 * apart + float(radii.mean()))
    return float(np.mean(sizes)) if max(sizes) < _LONG * min(sizes) else math.nan


def _exposure(route: Route, tracks: list[Trajectory]) -> float:
    """Return which share of the time between frames is exposed, by the length of smears.

    A line of length ``l`` has the same second moments as an ellipse of half length ``l/sqrt(3)``.
    """
    speeds = np.linalg.norm(route.velocities[0], axis=-1) * np.median(np.diff(route.times))
    radii, lengths = (
        np.stack([getattr(track, name) for track in tracks], axis=1)
        for name in ("radii", "lengths")
    )
    smears = np.sqrt(3.0 * np.maximum(lengths**2 - radii**2, 0.0))
    with np.errstate(invalid="ignore"):
        fast = route.is_seen & (speeds > max(np.nanquantile(speeds, 0.7), route.radius))
    shares = smears[fast] / speeds[fast]
    if np.isfinite(shares).sum() < _FEWEST:
        return 0.0
    return float(np.clip(np.nanmedian(shares), 0.0, 1.0))


def _bridged(times: np.ndarray, places: np.ndarray, radius: float) -> np.ndarray:
    """Return places (frame, ball, 2) with short gaps filled by smooth curves."""
    from scipy.interpolate import Akima1DInterpolator

    out = places.copy()
    for b in range(places.shape[1]):
        known = np.flatnonzero(np.isfinite(places[:, b, 0]))
        if len(known) < 3:
            continue
        at = places[known, b]
        curve = Akima1DInterpolator(times[known], at, axis=0)
        gaps, apart = np.diff(known), np.linalg.norm(np.diff(at, axis=0), axis=1)
        for k in np.flatnonzero(gaps > 1).tolist():
            inside = np.arange(known[k] + 1, known[k + 1])
            if gaps[k] <= _BRIDGED:
                out[inside, b] = curve(times[inside])
            elif apart[k] < _RESTED * radius:
                share = (times[inside] - times[known[k]]) / (times[known[k + 1]] - times[known[k]])
                out[inside, b] = at[k] + share[:, None] * (at[k + 1] - at[k])
    return out


def _traced(
    copies: Copies, click: np.ndarray, number: int, radius: float, least: float
) -> tuple[np.ndarray, float]:
    """Return places (frame, 2) of a ball that never leaves its place, by its picture at the click.

    Such a ball is in the median picture, so what differs from that is only its rim. How much it
    typically looks like that picture comes second, 1 at most. One that is less alike than `least`
    in half of the frames is not traced any further.
    """
    cv2 = import_cv2()
    shrink, (count, rows, columns, _) = copies.shrink, copies.pictures.shape
    number = min(max(number, 0), count - 1)
    half = max(2, round(_PATCH * radius / shrink))
    reach = max(2, round(_STEP * radius / shrink))
    start = at = copies.small(click)
    # Beyond the picture its rim goes on.
    patch = cv2.getRectSubPix(copies.pictures[number], (2 * half + 1,) * 2, start.tolist())
    out, scores = np.full((count, 2), np.nan), np.zeros(count)
    unlike = 0
    for frame in (*range(number, count), *range(number - 1, -1, -1)):
        at = start if frame in (number, number - 1) else at
        u, v = np.rint(at).tolist()
        if not (0 <= u < columns and 0 <= v < rows):
            continue
        part = cv2.getRectSubPix(copies.pictures[frame], (2 * (half + reach) + 1,) * 2, (u, v))
        match = cv2.matchTemplate(part, patch, cv2.TM_CCOEFF_NORMED)
        _, scores[frame], _, (x, y) = cv2.minMaxLoc(match)
        at = np.array([u - reach + _top(match[y], x), v - reach + _top(match[:, x], y)])
        out[frame] = (at + 0.5) * shrink - 0.5
        unlike += scores[frame] < least
        if unlike > count / 2:
            break
    return out, float(np.median(scores))


def _top(values: np.ndarray, at: int) -> float:
    """Return where values are largest, between the places of their largest and its neighbours."""
    near = np.arange(at - 1, at + 2)
    return parabola_top(near, values[near])[0] if 0 < at < len(values) - 1 else float(at)
