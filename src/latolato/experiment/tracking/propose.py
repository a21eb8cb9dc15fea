"""Finds pivot and balls of a clip without clicks: round things that move on a circle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from latolato.core.errors import InputError, Sentence
from latolato.experiment.calibration.circle_fit import CircleFit
from latolato.experiment.calibration.lens import Optics, distorted, undistorted
from latolato.experiment.calibration.orbit import DrivenCircle, better, circle, driven_circle
from latolato.experiment.rules import broken, said
from latolato.experiment.sidecar import OUTSIDE, Place, Setup
from latolato.experiment.tracking.detect import Blobs, detect, shrunk
from latolato.experiment.tracking.link import (
    Trajectory,
    are_alike,
    length_of_clear,
    link_alike,
    link_clicked,
    link_movers,
    may_be_pair,
)
from latolato.experiment.tracking.pivot import Strings, learn_pivot
from latolato.experiment.tracking.route import radius_of_parts
from latolato.experiment.tracking.sample import Sample, median_planes
from latolato.experiment.tracking.strings import SHOWS, Lines
from latolato.experiment.video import Frame, Video

# How many things that move are looked at for each price of leaps, and how many places of each are
# enough for a circle.
_MOVERS, _ENOUGH = 4, 120
# Fewest frames, share of the frames and way in radii that show a ball. The other one of a pair may
# be seen more seldom, for they may rest in one blob.
_FEWEST, _SEEN, _TRAVELS = 12, 0.2, 1.0
# By which factors leaps cost more than usual: balls move on steadily, but at few frames a second.
_DEAR = 6.0, 1.0
# How much better a ball two parts must be together, if they are one with a stripe: synthetic ones
# are 2.3 to 4 times as good, balls without one 1.0 to 1.2. In which share of the frames there are
# two parts: 0.26 and more of those with a stripe, 0.05 and less of two balls side by side.
_WHOLE, _PARTS = 1.5, 0.15
# Share of its whole way that a ball goes without a leap; what goes less consists of several things.
_ALL_WAY = 0.35
# How roughly things move that are half as likely a ball, and that are none: fewer than 8 frames
# show a swing, or what flickers in several places was linked.
_ROUGH, _ROUGHEST = 0.5, 0.75
# How far off a circle something is half as likely a ball: pixels and share of its way.
_LOOSE, _LOOSE_SHARE = 0.75, 0.015
# By how much distances from a pivot that is known, and may be driven, vary at most, as a share.
_ABOUT = 0.5
# How much the distance of two balls varies at least, as a share of the first one's way: that of
# synthetic pairs by 0.78 and more, that of shadows and of weights above the pivot by 0.17 at most.
_DISTANCES = 0.4
# By which factor the other ball of a pair may be farther off a circle than the first one.
_OFF_TOO = 1.5
# How near centres of circles are that are one pivot, as a share of the larger arm.
_ONE_PIVOT = 0.05
# How far a circle's centre may be off, in its deviations.
_UNSURE = 2.0
# Pixels, and share of the arm, that a ball may lie off the circle.
_OFF, _OFF_SHARE = 4.5, 0.03
# Residual from which a circle is good enough to look no further: pixels and share of the arm.
_ROUND, _ROUND_SHARE = 0.75, 0.003
# Uncertainty of the circle's centre, as a share of the arm, above which there is no pivot.
_VAGUE = 0.04
# Arm of the coarse pictures in which the pivot is followed, and how far it is from their edges
# [pixels of them].
_FINE, _MARGIN = 160.0, 12.0
# Where else the pivot may be in the first frame, above and below the centre, and how far it may
# move to the side, as shares of the arm.
_TRIALS, _ASIDE = (0.0, -0.07, 0.07), 0.1


def proposal_text(setup: Setup) -> Sentence:
    """Return a proposal in words, with the equivalent options."""
    options = options_of(setup)
    if setup.pivot is None and not setup.has_own_pivots:
        return said("proposed_without_pivot", options=options)
    return said("proposed", options=options)


def options_of(setup: Setup) -> str:
    """Return the options of `latolato track` that point at pivots and balls."""
    pivots = [setup.pivot, setup.pivot_2] if setup.has_own_pivots else [setup.pivot]
    named = [("pivot", place) for place in pivots] + [("ball", place) for place in setup.balls]
    return " ".join(
        f"--{name} {OUTSIDE if place is None else f'{place[0]:g},{place[1]:g}'}"
        for name, place in named
    )


def propose(
    video: Video,
    sample: Sample,
    *,
    pivot: Sequence[float] | str | None = None,
    balls: Sequence[Sequence[float]] | None = None,
    count: int | None = None,
    optics: Optics | None = None,
    click_frame: int | None = None,
) -> tuple[Setup, float, Sample]:
    """Positions of pivot and balls in a frame, a ball's radius [pixels], and the sample from there.

    The right-hand ball comes first; no pivot is in the picture if none is found.

    Parameters
    ----------
    video, sample : Video, Sample
        The clip and its first reading.
    pivot, balls : sequence, optional
        What is already known [pixels]; a pivot ``"outside"`` is not searched for.
    count : int, optional
        How many balls swing; None to find out.
    optics : Optics, optional
        The lens: circles are ovals in what it shows.
    click_frame : int, optional
        The frame in which they are to be found; by default the first one that shows all balls.

    Raises
    ------
    InputError
        If no ball is found, with how to point at it.

    Notes
    -----
    What differs from the background is linked through all frames, in parts and with parts joined;
    balls are what goes far and smoothly on a circle. That is fitted together with one harmonic of
    the pivot; if the residual is too large, the pivot is followed in the picture, from where
    strings meet or from the circle's centre, and both are repeated until they agree. If that is no
    better, the first circle stays. Where no circle shows the pivot, or strings meet elsewhere, it
    is where these meet. It can miss: balls of the wall's colour or that swing by less than their
    radius, and, without strings, arcs of less than about 20 degrees.
    """
    known = None if pivot is None or isinstance(pivot, str) else np.array(pivot, float)
    lens = optics or Optics()
    if balls is None:
        tracks, shown = _swinging(sample, count, known)
        sample = _begun(video, sample, shown, len(tracks), is_free=click_frame is None)
        starts = [track.places[sample.click] for track in tracks]
    else:
        tracks, blobs = [], sample.copies.blobs
        starts = [np.array(ball, float) for ball in balls]
        for start in starts:
            track, blobs = link_clicked(blobs, sample.copies, start, sample.click, None)
            tracks.append(track)
    hinges = [known]
    if pivot is None:
        # Where only one of two balls is seen, it may be both of them in one blob.
        both = np.all([track.is_seen for track in tracks], axis=0)
        clear = both if both.sum() >= _FEWEST else np.ones(len(both), bool)
        places = [np.where(clear[:, None], track.places, np.nan) for track in tracks]
        hinges = _pivots(video, sample, places, tracks[0].radius, lens)
    order = sorted(range(len(starts)), key=lambda b: -float(starts[b][0]))
    if len(hinges) > 1:
        hinges = [hinges[b] for b in order]
    pivots = [None if hinge is None else _rounded(hinge) for hinge in hinges]
    setup = Setup(
        pivot=pivots[0],
        pivot_2=pivots[-1] if len(pivots) > 1 else None,
        has_own_pivots=len(pivots) > 1,
        balls=tuple(_rounded(starts[b]) for b in order),
        is_proposed=True,
        is_pivot_found=pivot is None,
        click_frame=video.first_frame + sample.click,
    )
    return setup, float(np.median([track.radius for track in tracks])), sample


class _Mover(NamedTuple):
    """Something that moves, how likely it is a ball, and how far off a circle it is."""

    track: Trajectory
    likely: float
    off: float


def _swinging(
    sample: Sample, count: int | None, pivot: np.ndarray | None
) -> tuple[list[Trajectory], np.ndarray]:
    """Return the one or two of the things that move that swing, and which frames show them.

    A ball with a stripe like the wall is two parts. They are one if that is a far better ball, for
    one without a stripe is the same; frames show it where they show both parts.
    """
    blobs = sample.copies.blobs
    parts = _movers(blobs, sample, pivot)
    # A stripe is no wider than its ball, which is as wide as a part of it is long.
    wholes = detect(sample.copies, stripe=length_of_clear(blobs))
    joined = _movers(wholes, sample, pivot)
    first, other = _best(joined), _best(parts)
    least = 0.0 if other is None else _WHOLE * other.likely
    if first is not None and first.likely > least and not first.track.is_rod:
        tracks = _chosen(wholes, joined, sample, 1 if count == 1 else None, pivot)
        seen = np.all([track.is_seen for track in tracks], axis=0)
        shown = seen.copy()
        for frame in np.flatnonzero(seen).tolist():
            places = [track.places[frame] for track in tracks]
            shown[frame] = math.isfinite(radius_of_parts(blobs[frame], places))
        # Two balls that are one for being side by side show parts in few frames.
        if len(tracks) >= (count or 1) and shown.sum() > _PARTS * seen.sum():
            return tracks, shown
    tracks = _chosen(blobs, parts, sample, count, pivot)
    return tracks, np.all([track.is_seen for track in tracks], axis=0)


def _movers(blobs: list[Blobs], sample: Sample, pivot: np.ndarray | None) -> list[_Mover]:
    """Return what moves in a clip."""
    tracks = [
        track.without_rests()
        for dear in _DEAR
        for track in link_movers(blobs, sample.copies, _MOVERS, dear)
    ]
    return [_scored(track, sample.times, pivot) for track in tracks]


def _best(movers: list[_Mover]) -> _Mover | None:
    """Return the likeliest ball of what is seen often, None if there is none."""
    often = [one for one in movers if one.likely > 0.0 and one.track.is_seen.mean() > _SEEN]
    return max(often, key=lambda one: one.likely, default=None)


def _chosen(
    blobs: list[Blobs],
    movers: list[_Mover],
    sample: Sample,
    count: int | None,
    pivot: np.ndarray | None,
) -> list[Trajectory]:
    """Return the one or two balls among what moves, which consists of blobs.

    Raises
    ------
    InputError
        If there are fewer than asked for.
    """
    best = _best(movers)
    if best is None:
        leaps = any(_leaps(one.track) for one in movers)
        reason = ": what moves leaps from one frame to the next" if leaps else ""
        raise InputError(f"no moving ball was found{reason}", way_out="point at pivot and ball")
    first = best.track
    if first.is_rod:
        raise broken("long_and_thin")
    # Its look is known now: it and another ball like it are linked again by that, apart.
    again, left = link_alike(blobs, first, _DEAR[0])
    other, _ = link_alike(left, first, _DEAR[0])
    again, other = again.without_rests(), other.without_rests()
    pair = [_scored(track, sample.times, pivot) for track in (again, other)]
    if count != 1 and all(_may_swing(one, best.off) for one in pair) and are_alike(again, other):
        return [again, other]
    others = [
        one
        for one in movers
        if _may_swing(one, best.off)
        and (are_alike(first, one.track) or _share_circle(first, one.track, sample))
    ]
    second = max(others, key=lambda one: one.likely, default=None)
    if count == 2 and second is None:
        raise InputError(
            "only one moving ball was found, not two", way_out="point at pivot and both balls"
        )
    return [first] if second is None or count == 1 else [first, second.track]


def _share_circle(first: Trajectory, other: Trajectory, sample: Sample) -> bool:
    """Return whether two things swing about one pivot, not always as far from each other.

    They are balls of any colour then: a shadow goes along with its ball, and parts of one thing, as
    a weight above the pivot, keep their distance. Where the first one alone shows a pivot at rest,
    both must: a pivot that may move makes one circle of many paths.
    """
    if not may_be_pair(first, other):
        return False
    apart = np.linalg.norm(other.places - first.places, axis=1)
    if np.ptp(np.nanquantile(apart, [0.02, 0.98])) < _DISTANCES * first.travel:
        return False
    some = _some(first.places, other.places)
    places = [track.places[some] for track in (first, other)]
    if _at_rest([first.places]) is not None:
        return _at_rest(places) is not None
    return _is_round(better(*_circles(places, sample.times[some], sample.interval)))


def _leaps(track: Trajectory) -> bool:
    """Return whether something is seen often and goes on by more than its radius, but roughly."""
    if track.is_seen.mean() < _SEEN or track.roughness < _ROUGHEST:
        return False
    ways = np.linalg.norm(np.diff(track.places, axis=0), axis=1)
    return bool(np.nanmedian(ways) > track.radius)


def _may_swing(one: _Mover, first: float) -> bool:
    """Return whether something may be a ball by how likely it is and how far off a circle.

    It may be about as far off as the `first` ball, for their pivot may move in any way.
    """
    return one.likely > 0.0 and one.off < max(1.0, _OFF_TOO * first)


def _scored(track: Trajectory, times: np.ndarray, pivot: np.ndarray | None) -> _Mover:
    """Return something that moves with how likely it is the ball, 0 for surely not.

    The ball is seen often, goes far without leaps, moves on smoothly, is large, and runs on a
    circle about a pivot that rests or is driven, about the one that is known if any is. It is less
    likely if it is off that by 1 or more.
    """
    share, travel = float(track.is_seen.mean()), track.travel
    rough = track.roughness
    if track.is_seen.sum() < _FEWEST or rough > _ROUGHEST:
        return _Mover(track, 0.0, math.inf)
    if travel < max(_TRAVELS * track.radius, _ALL_WAY * track.extent):
        return _Mover(track, 0.0, math.inf)
    some = _some(track.places)
    if pivot is None:
        interval = float(np.median(np.diff(times)))
        orbit = better(*_circles([track.places[some]], times[some], interval))
        off = math.inf if orbit is None else orbit.residual / (_LOOSE + _LOOSE_SHARE * travel)
    else:
        away = np.hypot(*(track.places[some] - pivot).T)
        off = float(np.ptp(np.quantile(away, [0.1, 0.9])) / (_ABOUT * np.median(away)))
    smooth = 1.0 / (1.0 + off**2) / (1.0 + (rough / _ROUGH) ** 4)
    return _Mover(track, math.sqrt(share) * travel * track.radius * smooth, off)


def _begun(video: Video, sample: Sample, shown: np.ndarray, count: int, *, is_free: bool) -> Sample:
    """Return a sample that begins with a frame that shows all balls, of which there are `count`.

    Raises
    ------
    InputError
        If the frame that was asked for does not show them, and it is not free to choose.
    """
    if sample.click < len(shown) and shown[sample.click]:
        return sample
    frames = {frame.number: frame for frame in sample.frames}
    pairs = [n for n in sorted(frames) if shown[n] and n + 1 in frames and shown[n + 1]]
    if not is_free or not pairs:
        frame = video.first_frame + sample.click
        rule = "balls_not_in_frame" if count == 2 else "ball_not_in_frame"
        raise broken(rule, {"seen": int(shown.sum()), "count": len(shown), "frame": frame})
    return replace(sample, clicked=[frames[pairs[0]], frames[pairs[0] + 1]])


def _some(*tracks: np.ndarray) -> np.ndarray:
    """Return the numbers of frames in which things are seen that are enough for a circle."""
    known = np.flatnonzero(np.any([np.isfinite(track[:, 0]) for track in tracks], axis=0))
    return known[:: max(1, len(known) // _ENOUGH)]


def _circles(
    tracks: list[np.ndarray], times: np.ndarray, interval: float
) -> tuple[CircleFit | None, CircleFit | None]:
    """Return the circle of tracks about one pivot at rest, and if it is not round a driven one."""
    groups = _groups(tracks)
    still = circle(groups, np.zeros((len(groups), 2)))
    if _is_round(still):
        return still, None
    return still, driven_circle(groups, times, interval)


def _at_rest(tracks: list[np.ndarray]) -> CircleFit | None:
    """Return the round circle of tracks about one pivot at rest, None if there is none."""
    groups = _groups([track[_some(*tracks)] for track in tracks])
    still = circle(groups, np.zeros((len(groups), 2)))
    return still if _is_round(still) else None


def _groups(tracks: list[np.ndarray]) -> list[np.ndarray]:
    """Return the places of tracks that are known, (ball, 2) for each frame."""
    return [
        np.array([place for place in places if np.isfinite(place[0])]).reshape(-1, 2)
        for places in zip(*tracks, strict=True)
    ]


def _rounded(place: np.ndarray) -> Place:
    """Return a place to a tenth of a pixel, as it is shown."""
    return round(float(place[0]), 1), round(float(place[1]), 1)


def _pivots(
    video: Video, sample: Sample, tracks: list[np.ndarray], radius: float, lens: Optics
) -> list[np.ndarray | None]:
    """Return the pivot of all balls, or that of each, by their strings and their circles.

    `tracks` are places (frame, 2) in the picture. None is a pivot that it does not show.
    """
    size = video.width, video.height
    lines = [Lines(sample.copies, track, radius) for track in tracks]
    meetings = [each.meeting() for each in lines]
    flat = [undistorted(each, size, lens) for each in tracks]
    own = [_at_rest([track]) for track in flat]
    centres = [None if one is None else distorted(one.centre, size, lens) for one in own]

    def share(place: np.ndarray) -> float:
        return min(one.share_at(place) for one in lines)

    shared = max((place for place in meetings if place is not None), key=share, default=None)
    meeting = None if shared is None or share(shared) <= SHOWS else _seen(video, shared)
    # Both balls together show a pivot at rest best, unless their arms differ.
    round_ = [one for one in own if one is not None]
    still = _at_rest(flat) or (round_[0] if len(round_) == len(own) else None)
    rests = still is not None
    orbit = still or _common_circle(video, sample, flat, radius, meeting)
    # Strings from a pivot that is driven meet in no one place.
    is_driven = (
        not rests
        and orbit is not None
        and _is_round(orbit)
        and _seen(video, distorted(orbit.centre, size, lens)) is not None
    )
    if len(tracks) == 2 and not is_driven:
        both = zip(meetings, centres, strict=True)
        each = [centre if meeting is None else meeting for meeting, centre in both]
        if _are_apart(each, tracks):
            return [_seen(video, place) for place in each]
    if orbit is None or orbit.residual > max(_OFF, _OFF_SHARE * orbit.arm):
        return [meeting]
    centre = _seen(video, distorted(orbit.centre, size, lens))
    if centre is None or orbit.vague > _VAGUE:
        return [meeting]
    moves = 0.0 if rests else math.inf
    if isinstance(orbit, DrivenCircle):
        moves = orbit.amplitude
    # Strings know a pivot at rest better: a lens or an oblique view bends circles, and a narrow arc
    # hardly shows its centre. They are as far off a driven one as it moves.
    by_strings = meeting is not None and moves < _UNSURE * orbit.vague * orbit.arm
    return [meeting if by_strings else centre]


def _are_apart(pivots: Sequence[np.ndarray | None], tracks: list[np.ndarray]) -> bool:
    """Return whether places of pivots, None for unknown, are those of two pivots."""
    if pivots[0] is None or pivots[1] is None:
        return False
    arms = [
        np.nanmedian(np.linalg.norm(track - pivot, axis=1))
        for track, pivot in zip(tracks, pivots, strict=True)
    ]
    return bool(np.linalg.norm(pivots[0] - pivots[1]) > _ONE_PIVOT * max(arms))


def _seen(video: Video, place: np.ndarray | None) -> np.ndarray | None:
    """Return a place that the pictures show, None for others."""
    return place if place is not None and video.shows(place) else None


def _common_circle(
    video: Video,
    sample: Sample,
    tracks: list[np.ndarray],
    radius: float,
    meeting: np.ndarray | None,
) -> CircleFit | None:
    """Return the circle about the pivot whose motion makes the balls' paths most nearly one.

    Strings that are seen meet about where it is.
    """
    times = sample.times
    # A driven pivot is where it is in the first of the frames.
    some = np.append(min(sample.click, len(times) - 1), _some(*tracks))
    own = [track[some] for track in tracks]
    first = better(*_circles(own, times[some], sample.interval))
    if first is None or _is_round(first):
        return first
    frames = sample.from_click
    places = [
        np.array(
            [t[f.number] for t in tracks if 0 <= f.number < len(t) and np.isfinite(t[f.number, 0])]
        ).reshape(-1, 2)
        for f in frames
    ]
    return _followed(video, frames, places, radius, first, meeting)


def _is_round(orbit: CircleFit | None) -> bool:
    """Return whether there is a circle that is good enough to look no further."""
    if orbit is None:
        return False
    return orbit.residual < _ROUND + _ROUND_SHARE * orbit.arm and orbit.vague < _VAGUE


def _followed(
    video: Video,
    frames: list[Frame],
    places: list[np.ndarray],
    radius: float,
    first: CircleFit,
    meeting: np.ndarray | None,
) -> CircleFit:
    """Return the circle about a pivot that is followed in the picture from where it may be.

    It may be where strings meet, and about the centre of the `first` circle, which is returned if
    no other is good or better: it has more freedom.
    """
    size = np.array([video.width, video.height])
    # A third of the pairs of frames is enough, and so are coarse pictures.
    kept = [k for k in range(len(frames)) if (k // 2) % max(1, len(frames) // 32) == 0]
    fold = int(np.clip(first.arm / _FINE, 1.0, size.min() / (2.0 * _MARGIN)))
    # Chroma is not needed.
    coarse = [frames[k]._replace(luma=shrunk(frames[k].luma, fold)) for k in kept]
    median = median_planes(coarse)[0]
    shown = np.concatenate(places)
    best: CircleFit | None = None
    starts = [(first.centre + np.array([0.0, share * first.arm]), first.arm) for share in _TRIALS]
    if meeting is not None:
        arm = float(np.median(np.linalg.norm(shown - meeting, axis=1)))
        starts.insert(0, (meeting, arm))
    for centre, arm in starts:
        for _ in range(3):
            if (np.minimum(centre, size - 1.0 - centre) < _MARGIN * fold).any():
                break
            strings = Strings.between(centre / fold, shown / fold, radius / fold)
            place, length = (centre + 0.5) / fold - 0.5, arm / fold
            tracker, shifts = learn_pivot(coarse, median, place, length, _ASIDE * length, strings)
            if tracker.is_still:
                break
            orbit = circle([places[k] for k in kept], fold * (shifts - shifts[0]))
            if orbit is None:
                break
            change = float(np.hypot(*(orbit.centre - centre)))
            centre, arm = orbit.centre, orbit.arm
            if best is None or orbit.residual < best.residual:
                best = orbit
            if change < 1.0:
                break
        if best is not None and _is_round(best):
            return best
    return first if best is None or first.residual < best.residual else best
