"""Finds pivot and balls of a clip without clicks: round things that move on a circle."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.calibration.lens import Optics, distorted, undistorted
from latolato.experiment.sidecar import OUTSIDE, Place, Setup
from latolato.experiment.tracking.appearance import Colours
from latolato.experiment.tracking.blobs import Backdrop, Disc
from latolato.experiment.tracking.disc import disc_at
from latolato.experiment.tracking.orbit import Orbit, better, circle, driven_circle
from latolato.experiment.tracking.pivot import learn_pivot
from latolato.experiment.tracking.sample import Sample, median_planes
from latolato.experiment.video import Frame, Video

# Discs are of one ball if their changes point the same way, and their radii agree by this factor.
_ALIKE, _SIZE = 0.75, 1.7
# Share of frames that must show a ball, and show two for two to be proposed.
_SEEN, _TWICE = 0.3, 0.4
# Share of frames in which something stays in one column beside a ball: it is the pivot's.
_STAYS = 0.6
# Pixels, and share of the arm, that a ball may lie off the circle.
_OFF, _OFF_SHARE = 3.0, 0.02
# Residual from which a circle is good enough to look no further: pixels and share of the arm.
_ROUND, _ROUND_SHARE = 0.5, 0.002
# Uncertainty of the circle's centre, as a share of the arm, above which there is no pivot.
_VAGUE = 0.04
# Arm of the coarse pictures in which the pivot is followed [pixels].
_FINE = 160.0
# Where else the pivot may be in the first frame, above and below the centre, as shares of the arm.
_TRIALS = (0.0, -0.07, 0.07)
# Share of the radius by which edges must lie beside discs to be believed instead.
_ASIDE = 0.15
# A disc is a part of a ball if it is smaller than this share of the edge's radius.
_PART = 0.88
# Frames in which discs are measured again by their edge.
_EDGES = 9


def proposal_text(setup: Setup) -> str:
    """Return a proposal in words, with the equivalent options."""
    options = options_of(setup)
    if setup.pivot is None and not setup.has_own_pivots:
        return f"found in the video: {options}; no pivot was found in the picture"
    return f"found in the video: {options}"


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
) -> tuple[Setup, float]:
    """Positions of pivot and balls in the clicked frame, and a ball's radius [pixels].

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

    Raises
    ------
    InputError
        If no ball is found, with how to point at it.

    Notes
    -----
    Discs are what differs from the median over time. Their circle is fitted together with one
    harmonic of the pivot; if the residual is too large, the pivot is followed in the picture from
    the circle's centre, and both are repeated until they agree. It can miss: balls that
    rest in most of the clip, balls of the wall's colour, arcs of less than about 20 degrees.
    """
    frames = sample.from_click
    backdrop = Backdrop(frames, video.bounds)
    seen = [backdrop.discs(frame) for frame in frames]
    members = _one_class(seen, None if balls is None else np.array(balls, float))
    if members is None:
        raise InputError("no moving ball was found", way_out="point at pivot and ball")
    if count is None:
        counts = [len(group) for group in members if group]
        count = 2 if np.mean(np.array(counts) >= 2) > _TWICE else 1
    members = [group[:count] for group in members]
    known = None if pivot is None or isinstance(pivot, str) else np.array(pivot, float)
    colours = Colours.of(video)
    radius = float(np.median([disc.radius for group in members for disc in group]))
    shift, radius = _by_edge(frames, colours, members, radius, known)
    places = [np.array([d.centre + shift for d in group]).reshape(-1, 2) for group in members]
    lens, size = optics or Optics(), (video.width, video.height)
    places = [undistorted(group, size, lens) for group in places]
    orbit = _pivot(video, frames, places) if pivot is None else None
    hinge = known if known is not None else orbit.centre if orbit else None
    if orbit is not None:
        hinge = distorted(orbit.centre, size, lens)
    if balls is not None:
        starts = [np.array(ball, float) for ball in balls]
    else:
        number = video.first_frame + sample.click
        found = _starts(places, orbit, count, radius, number)
        starts = [distorted(ball, size, lens) for ball in found]
    starts.sort(key=lambda ball: -float(ball[0]))
    setup = Setup(
        pivot=None if hinge is None else _rounded(hinge),
        balls=tuple(_rounded(ball) for ball in starts),
        is_proposed=True,
    )
    return setup, radius


def _rounded(place: np.ndarray) -> Place:
    """Return a place to a tenth of a pixel, as it is shown."""
    return round(float(place[0]), 1), round(float(place[1]), 1)


def _one_class(seen: list[list[Disc]], balls: np.ndarray | None) -> list[list[Disc]] | None:
    """Return the discs of each frame that are balls: those alike that travel farthest."""
    best: tuple[float, list[list[Disc]]] | None = None
    left = [list(group) for group in seen]
    for _ in range(4):
        tops = [group[0] for group in left if group]
        if balls is not None and seen[0]:
            near = min(seen[0], key=lambda d: float(np.min(np.hypot(*(balls - d.centre).T))))
            if np.min(np.hypot(*(balls - near.centre).T)) < 1.5 * near.radius:
                tops = [near]
        if not tops:
            break
        typical = sorted(tops, key=lambda disc: disc.contrast * disc.radius)[len(tops) // 2]
        alike = [[disc for disc in group if _is_alike(disc, typical)] for group in left]
        alike = _without_column(alike)
        centres = np.array([disc.centre for group in alike for disc in group]).reshape(-1, 2)
        share = float(np.mean([bool(group) for group in alike]))
        if share > _SEEN:
            travel = float(np.hypot(*np.ptp(centres, axis=0)))
            width = float(np.ptp(centres[:, 0]))
            size = typical.radius * typical.contrast
            score = (travel + width) * share * size if travel > 2.0 * typical.radius else 0.0
            if score > 0.0 and (best is None or score > best[0]):
                best = (score, alike)
        if balls is not None:
            break
        left = [[disc for disc in group if not _is_alike(disc, typical)] for group in left]
    return best[1] if best else None


def _without_column(groups: list[list[Disc]]) -> list[list[Disc]]:
    """Return discs without those that stay in one column beside others: parts of the pivot."""
    discs = [disc for group in groups for disc in group]
    if not discs:
        return groups
    columns = np.array([disc.centre[0] for disc in discs])
    half = 0.6 * float(np.median([disc.radius for disc in discs]))
    crowd = [np.sum(np.abs(columns - column) < half) for column in columns]
    column = columns[int(np.argmax(crowd))]

    def is_in(disc: Disc) -> bool:
        return bool(abs(disc.centre[0] - column) < half)

    pairs = [group for group in groups if any(map(is_in, group)) and not all(map(is_in, group))]
    if len(pairs) < _STAYS * sum(bool(group) for group in groups):
        return groups
    return [
        [disc for disc in group if not is_in(disc)] if not all(map(is_in, group)) else []
        for group in groups
    ]


def _is_alike(disc: Disc, other: Disc) -> bool:
    """Return whether two discs may be the same ball, one of them perhaps smeared."""
    sizes = disc.radius / other.radius
    cosine = float(disc.change @ other.change) / max(
        float(np.linalg.norm(disc.change) * np.linalg.norm(other.change)), 1e-9
    )
    bright = disc.contrast / max(other.contrast, 1e-9)
    return 1.0 / _SIZE < sizes < _SIZE and cosine > _ALIKE and 0.25 < bright < 4.0


def _by_edge(
    frames: list[Frame],
    colours: Colours,
    members: list[list[Disc]],
    radius: float,
    pivot: np.ndarray | None,
) -> tuple[np.ndarray, float]:
    """Return how far the balls' edges lie off the discs, and their radius, in sharp frames."""
    discs = [(k, disc) for k, group in enumerate(members) for disc in group]
    sharp = sorted(discs, key=lambda one: -one[1].contrast)[: 4 * _EDGES : 4]
    shifts = []
    for k, disc in sharp:
        towards = disc.centre - [0.0, 10.0 * radius] if pivot is None else pivot
        centre, size, _ = disc_at(frames[k], colours, disc.centre, radius, towards, False)
        centre, size, _ = disc_at(frames[k], colours, centre, size, towards, True)
        shifts.append((*(centre - disc.centre), size))
    *shift, size = np.median(np.array(shifts), axis=0)
    # A disc's own centre is finer than its edge's, unless the wall hides a part of the ball.
    is_clear = math.hypot(*shift) > _ASIDE * size and radius < _PART * size
    return np.array(shift) if is_clear else np.zeros(2), float(size)


def _pivot(video: Video, frames: list[Frame], places: list[np.ndarray]) -> Orbit | None:
    """Return the circle about the pivot whose motion makes the balls' paths most nearly one."""
    times = np.array([frame.time for frame in frames])
    first = better(circle(places, np.zeros((len(places), 2))), driven_circle(places, times))
    if first is None:
        return None
    best = first if _is_round(first) else _followed(video, frames, places, first)
    if best is None or best.residual > max(_OFF, _OFF_SHARE * best.arm):
        return None
    size = np.array([video.width, video.height])
    inside = (best.centre >= 0.0).all() and (best.centre <= size - 1.0).all()
    return best if inside and best.vague < _VAGUE else None


def _is_round(orbit: Orbit) -> bool:
    """Return whether a circle is good enough to look no further."""
    return orbit.residual < _ROUND + _ROUND_SHARE * orbit.arm and orbit.vague < _VAGUE


def _followed(
    video: Video, frames: list[Frame], places: list[np.ndarray], first: Orbit
) -> Orbit | None:
    """Return the circle about a pivot that is followed in the picture from where it may be."""
    size = np.array([video.width, video.height])
    # A third of the pairs of frames is enough, and so are coarse pictures.
    kept = [k for k in range(len(frames)) if (k // 2) % max(1, len(frames) // 32) == 0]
    fold = max(1, int(first.arm / _FINE))
    coarse = [_coarse(frames[k], fold) for k in kept]
    median = median_planes(coarse)[0]
    best: Orbit | None = None
    for trial in _TRIALS:
        centre, arm = first.centre + np.array([0.0, trial * first.arm]), first.arm
        for _ in range(3):
            if (np.minimum(centre, size - 1.0 - centre) < 12.0 * fold).any():
                break
            tracker, shifts = learn_pivot(coarse, median, (centre + 0.5) / fold - 0.5, arm / fold)
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
            break
    return best


def _coarse(frame: Frame, fold: int) -> Frame:
    """Return a frame with its luma averaged over squares; its chroma is not needed."""
    rows, columns = (side // fold * fold for side in frame.luma.shape)
    parts = frame.luma[:rows, :columns].reshape(rows // fold, fold, columns // fold, fold)
    luma = np.rint(parts.mean(axis=(1, 3))).astype(np.uint8)
    return Frame(frame.number, frame.time, luma, luma[:2, :2], luma[:2, :2])


def _starts(
    places: list[np.ndarray], orbit: Orbit | None, count: int, radius: float, number: int
) -> list[np.ndarray]:
    """Return the balls in the clicked frame, from there or from where they are a frame later."""
    for k in (0, 1):  # a pair of frames: where balls are in the second is near enough
        group = places[k]
        shift = orbit.shifts[min(k, len(orbit.shifts) - 1)] if orbit else np.zeros(2)
        on_circle = [
            place
            for place in group
            if orbit is None
            or abs(np.hypot(*(place - shift - orbit.centre)) - orbit.arm)
            < max(2.0 * radius, 0.05 * orbit.arm)
        ]
        if len(on_circle) >= count:
            return list(on_circle[:count])
    shown = sum(len(group) >= count for group in places)
    if not shown:
        raise InputError(
            "only one moving ball was found, not two", way_out="point at pivot and both balls"
        )
    raise InputError(
        f"{count} {'balls were' if count == 2 else 'ball was'} found in {shown} of {len(places)} "
        f"frames, but not in frame {number}",
        way_out="point at pivot and ball, or look in another frame (--click-frame)",
    )
