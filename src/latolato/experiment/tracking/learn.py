"""Learns a clip's scene from a sample of its frames: pivot, background, balls, exposure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from latolato.experiment.tracking import kernels
from latolato.experiment.tracking.appearance import (
    Appearance,
    Colours,
    arc,
    best_angles,
    fit_balls,
    median_background,
    samples_for,
)
from latolato.experiment.tracking.pivot import (
    PivotTracker,
    learn_pivot,
    learn_template,
    locate_all,
    velocities,
)
from latolato.experiment.tracking.sample import Sample, median_planes
from latolato.experiment.video import Frame, Video

# First guesses, before anything was learned: standard deviation of linear light, edge softness.
_NOISE, _BLUR = 0.03, 0.8
# Share of the contrast between ball and wall from which a residual is something else.
_OUTLYING = 0.3
# Share of a ball's pixels that must look like one for a frame to teach.
_TEACHES = 0.8
# Gain at which a place on the circle is taken for a ball.
_LIKELY = 0.2
# Frames whose ball moved less than this share of its radius in an interval teach its colours.
_SLOW = 0.4


@dataclass
class Scene:
    """What was learned of a clip.

    Attributes
    ----------
    pivot : PivotTracker
        Follows the pivot.
    look : Appearance
        Layers of the image.
    arm : float
        Distance from pivot to ball centre [pixels].
    balls : int
        How many balls are followed.
    starts, speeds : numpy.ndarray, shape (ball,)
        Angles in the first frame from straight down in the image [rad], right ball first, and how
        much they grow per frame interval; NaN if the second frame does not tell.
    radius : float
        Radius of the balls by their area [pixels], which neither blur nor smear changes.
    """

    pivot: PivotTracker
    look: Appearance
    arm: float
    balls: int
    starts: np.ndarray
    speeds: np.ndarray
    radius: float = math.nan


@dataclass
class _Found:
    """A ball found in a frame of the sample."""

    frame: int
    centre: np.ndarray
    pivot: np.ndarray
    angle: float
    speed: float
    explained: float
    drift: np.ndarray

    def path(self, arm: float, exposure: float) -> np.ndarray:
        """Return the ball's centres within the exposure, shape (sample, 2)."""
        smear = 0.0 if math.isnan(self.speed) else self.speed * exposure
        count = samples_for(abs(smear) * arm + exposure * float(np.hypot(*self.drift)))
        angles = self.angle + smear * ((np.arange(count) + 0.5) / count - 0.5)
        steps = exposure * ((np.arange(count) + 0.5) / count - 0.5)
        path = arc(self.pivot + steps[:, None] * self.drift, angles, arm)
        return path + (self.centre - path.mean(axis=0))


def learn_scene(
    video: Video,
    sample: Sample,
    pivot: np.ndarray,
    balls: list[np.ndarray],
    radius: float | None,
    progress: Callable[[float], None] | None = None,
) -> Scene:
    """Return what a clip looks like.

    Parameters
    ----------
    video, sample : Video, Sample
        The clip and the frames to learn from.
    pivot : numpy.ndarray, shape (2,)
        Pivot in the first frame (column, row) [pixels].
    balls : list of numpy.ndarray, shape (2,)
        Centre of each ball in the first frame [pixels].
    radius : float or None
        Expected radius of the balls [pixels]; None measures it.

    Raises
    ------
    ValueError
        If no ball is found in most of the sample.
    """
    frames = sample.frames
    colours = Colours.of(video)
    arm = float(np.mean([np.hypot(*(ball - pivot)) for ball in balls]))
    centres = [np.array(ball, float) for ball in balls]
    guess = radius or 0.08 * arm
    centres[0], size = disc_at(frames[0], colours, centres[0], guess, pivot, radius is not None)
    for k in range(1, len(centres)):
        centres[k], _ = disc_at(frames[0], colours, centres[k], size, pivot, True)
    arm = float(np.mean([np.hypot(*(centre - pivot)) for centre in centres]))
    medians = median_planes(frames[::2])
    tracker, shifts = learn_pivot(frames, medians[0], np.asarray(pivot, float), arm)
    pivots = tracker.place(shifts)
    margin = arm + 2.5 * size + 6.0
    low = np.floor(pivots.min(axis=0) - margin).astype(int)
    high = np.ceil(pivots.max(axis=0) + margin).astype(int)
    low, high = np.maximum(low, 0), np.minimum(high, [video.width, video.height])
    behind = median_background(medians, colours, low, high)
    for centre in centres:
        _uncover(behind, low, frames[0], colours, centre, size)
    behind = _filled(behind)
    paint = _first_paint(frames[0], colours, centres, size)
    weight = np.eye(3) / _NOISE**2
    look = Appearance(colours, size, _BLUR, paint, behind, low, weight, scale=4.0)
    starts = np.sort([math.atan2(*(centre - pivot)) for centre in centres])[::-1]
    scene = Scene(tracker, look, arm, len(balls), starts, np.full(len(balls), np.nan))
    found: list[_Found] = []
    for round_ in range(3):
        if round_ == 0:
            found = _find(scene, frames, pivots)
        found = _fit(scene, frames, found, pivots)
        if not found:
            raise ValueError(
                f"{video.path}: no ball like the one at ({balls[0][0]:g}, {balls[0][1]:g}) was "
                "found in other frames; point at the ball's centre in the first frame"
            )
        _relearn(scene, frames, found)
        if round_ == 0:
            covered = [(one.frame, one.centre) for one in found]
            _learn_background(scene, frames, covered)
        if round_ > 0:
            _learn_exposure(scene, frames, found)
            if not tracker.is_still and tracker.exposure > 0.0:
                shifts = locate_all(tracker, frames, shifts)
                learn_template(tracker, frames, medians[0], shifts)
                shifts = locate_all(tracker, frames, shifts)
                tracker.anchor = shifts[0].copy()
                pivots = tracker.place(shifts)
        if progress:
            progress((round_ + 1) / 3)
    scene.radius = look.radius
    for b, start in enumerate(starts):
        own = [one for one in found if one.frame == 0 and abs(one.angle - start) < size / arm]
        if own:
            scene.speeds[b] = own[0].speed
    return scene


def disc_at(
    frame: Frame,
    colours: Colours,
    click: np.ndarray,
    radius: float,
    pivot: np.ndarray,
    is_known: bool,
) -> tuple[np.ndarray, float]:
    """Return centre and radius of the disc near a click: where the colour steps most outwards.

    Daugman, IEEE Trans. Pattern Anal. Mach. Intell. 15 (1993) 1148: the mean difference across a
    circle, here as the mean over directions of a difference that is bounded, so that rods, shadows
    and another ball do not decide.
    """
    reach = int(3.2 * radius) + 8
    corner = np.rint(click).astype(int) - reach
    side = 2 * reach + 1
    image = colours.window(frame[2:], (int(corner[0]), int(corner[1])), (side, side))
    image = np.nan_to_num(np.sqrt(image), nan=0.0)
    turns = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    away = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    towards = (pivot - click) / max(float(np.hypot(*(pivot - click))), 1e-9)
    away = away[away @ towards < 0.85]

    def score(centre: np.ndarray, size: float) -> float:
        gap = max(1.2, 0.07 * size)
        inner = _looked_up(image, centre + away * (size - gap) - corner)
        outer = _looked_up(image, centre + away * (size + gap) - corner)
        step = inner - outer
        typical = np.median(step, axis=0)
        along = step @ typical / max(float(np.linalg.norm(typical)), 1e-6)
        return float(np.mean(np.clip(along, -0.1, 0.25)))

    sizes = radius * (np.linspace(0.9, 1.1, 9) if is_known else np.geomspace(0.4, 2.5, 24))
    centre, size = np.array(click, float), radius
    for reach_, count in ((0.3 * radius, 7), (0.06 * radius, 7), (0.015 * radius, 5)):
        offsets = np.linspace(-reach_, reach_, count)
        trials = [
            (score(centre + np.array([dx, dy]), one), dx, dy, one)
            for one in sizes
            for dx in offsets
            for dy in offsets
        ]
        _, dx, dy, size = max(trials)
        centre = centre + np.array([dx, dy])
        sizes = size * np.linspace(0.94, 1.06, 7)
    return centre, float(size)


def _looked_up(image: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the colours nearest to places (place, 2) of column and row."""
    at = np.rint(places).astype(int)
    i = np.clip(at[:, 0], 0, image.shape[1] - 1)
    j = np.clip(at[:, 1], 0, image.shape[0] - 1)
    colours: np.ndarray = image[j, i]
    return colours


def _uncover(
    behind: np.ndarray,
    low: np.ndarray,
    frame: Frame,
    colours: Colours,
    centre: np.ndarray,
    radius: float,
) -> None:
    """Mark the background as unseen where it shows the ball itself, which rested there mostly."""
    j, i = np.indices(behind.shape[:2])
    away = np.hypot(i + low[0] - centre[0], j + low[1] - centre[1])
    shown = colours.window(frame[2:], (int(low[0]), int(low[1])), behind.shape[:2])
    inside = away < 0.8 * radius
    outside = (away > 1.3 * radius) & (away < 1.7 * radius)
    if not inside.any() or not outside.any():
        return
    own = np.nanmedian(np.abs(behind - shown)[inside].sum(axis=-1))
    wall = np.nanmedian(behind[outside], axis=0)
    contrast = np.nanmedian(np.abs(behind - wall)[inside].sum(axis=-1))
    if own < 0.5 * contrast:
        behind[away < 1.25 * radius] = np.nan


def _filled(behind: np.ndarray) -> np.ndarray:
    """Return the background with unseen places filled from their nearest neighbours."""
    from scipy.ndimage import distance_transform_edt

    unseen = ~np.isfinite(behind).all(axis=-1)
    if not unseen.any() or unseen.all():
        return behind
    at = distance_transform_edt(unseen, return_distances=False, return_indices=True)
    filled: np.ndarray = behind[tuple(at)]
    return filled


def _first_paint(
    frame: Frame, colours: Colours, centres: list[np.ndarray], radius: float
) -> np.ndarray:
    """Return the mean colours of the balls in the first frame about their centres."""
    look = [_splatted([(frame, centre)], colours, radius, 0.88 * radius) for centre in centres]
    return np.asarray(np.mean(look, axis=0))


def _splatted(
    seen: list[tuple[Frame, np.ndarray]], colours: Colours, radius: float, inner: float
) -> np.ndarray:
    """Return the mean colour about given centres, extended beyond `inner` by the nearest."""
    half = int(np.ceil(1.3 * radius)) + 2
    side = 2 * half + 1
    total, weights = np.zeros((side, side, 3)), np.zeros((side, side))
    for frame, centre in seen:
        corner = np.floor(centre).astype(int) - half
        image = colours.window(frame[2:], (int(corner[0]), int(corner[1])), (side + 1, side + 1))
        rest = centre - np.floor(centre)
        ok = np.isfinite(image[..., 0])
        image = np.nan_to_num(image)
        for dj, b in ((0, 1.0 - rest[1]), (1, rest[1])):
            for di, a in ((0, 1.0 - rest[0]), (1, rest[0])):
                part = slice(dj, dj + side), slice(di, di + side)
                total += (a * b) * image[part]
                weights += (a * b) * ok[part]
    paint = total / np.maximum(weights, 1e-9)[..., None]
    j, i = np.indices((side, side)) - half
    paint[(np.hypot(i, j) > inner) | (weights < 1e-6)] = np.nan
    return np.asarray(_filled(paint), float)


def _find(scene: Scene, frames: list[Frame], pivots: np.ndarray) -> list[_Found]:
    """Find the balls in every frame of the sample, on the whole circle."""
    look, found = scene.look, []
    for k, frame in enumerate(frames):
        angles, gain = best_angles(look, frame[2:], pivots[k], scene.arm, scene.balls)
        for angle, share in zip(angles, gain, strict=True):
            if share > _LIKELY:
                centre = arc(pivots[[k]], np.array([angle]), scene.arm)[0]
                found.append(_Found(k, centre, pivots[k], float(angle), math.nan, 0.0, np.zeros(2)))
    return found


def _fit(
    scene: Scene, frames: list[Frame], found: list[_Found], pivots: np.ndarray
) -> list[_Found]:
    """Fit the balls found in each frame together; keep those on the circle, with their speeds."""
    look, kept = scene.look, []
    drift = np.nan_to_num(velocities(frames, pivots))
    for k, frame in enumerate(frames):
        own = [one for one in found if one.frame == k]
        far = len(own) < 2 or np.hypot(*(own[0].centre - own[1].centre)) > 3.5 * look.radius
        for group in [[one] for one in own] if far else [own]:
            paths = [one.path(scene.arm, look.exposure) for one in group]
            fit = fit_balls(look, frame[2:], paths, pivots[k], rounds=8, tolerant=3)
            for one, shift, share in zip(group, fit.shift, fit.explained, strict=True):
                one.centre, one.pivot, one.drift = one.centre + shift, pivots[k], drift[k]
                away = one.centre - one.pivot
                one.angle, one.explained = float(np.arctan2(away[0], away[1])), float(share)
                if abs(np.hypot(*away) - scene.arm) < 0.6 * look.radius:
                    kept.append(one)
    for one in kept:
        one.speed = math.nan
        for step in (-1, 1):
            near = [
                step * ((other.angle - one.angle + np.pi) % (2.0 * np.pi) - np.pi)
                for other in kept
                if frames[other.frame].number == frames[one.frame].number + step
            ]
            if near:
                one.speed = float(min(near, key=abs))
    return kept


def _relearn(scene: Scene, frames: list[Frame], found: list[_Found]) -> None:
    """Learn arm, colours, radius, softness and noise anew from the balls found."""
    look = scene.look
    good = [one for one in found if one.explained > _TEACHES] or found
    arms = [float(np.hypot(*(one.centre - one.pivot))) for one in good]
    scene.arm = float(np.median(arms))
    known = [one for one in good if not math.isnan(one.speed)] or good
    teachers = sorted(known, key=lambda one: abs(one.speed))[:16]
    seen = [(frames[one.frame], one.centre) for one in teachers]
    look.paint = _splatted(seen, look.colours, look.radius, look.radius - 1.6 * look.blur - 0.3)
    _learn_edge(scene, frames, teachers[:8])
    _learn_noise(look, frames, good)


def _learn_edge(scene: Scene, frames: list[Frame], teachers: list[_Found]) -> None:
    """Learn radius and softness of the edge: those that explain the frames best."""
    look = scene.look
    paths = [one.path(scene.arm, look.exposure) for one in teachers]

    def cost() -> float:
        return sum(
            fit_balls(look, frames[one.frame][2:], [path], one.pivot, rounds=1, tolerant=0).cost
            for one, path in zip(teachers, paths)
        )

    for width in (0.08, 0.03, 0.01):
        for name, low, high in (("radius", 0.0, 1e9), ("blur", 0.35, 0.25 * look.radius)):
            middle = getattr(look, name)
            spread = 3.0 * width if name == "blur" else width
            trials = middle * (1.0 + spread * np.linspace(-1.5, 1.5, 7))
            trials = np.unique(np.clip(trials, low, high))
            costs = []
            for trial in trials:
                setattr(look, name, float(trial))
                costs.append(cost())
            setattr(look, name, float(trials[int(np.argmin(costs))]))


def _radius_by_area(look: Appearance, frames: list[Frame], found: list[_Found]) -> float:
    """Return the radius of a disc as large as the balls [pixels]; rods' side is left out."""
    areas = []
    half = int(1.5 * look.radius) + 3
    middle = (look.paint.shape[0] - 1) // 2
    slow = sorted(
        (one for one in found if one.explained > _TEACHES), key=lambda one: abs(one.speed)
    )
    for one in slow[:12]:
        corner = np.rint(one.centre).astype(int) - half
        shape = (2 * half + 1, 2 * half + 1)
        wall = look.background(corner, shape)
        seen = look.seen(frames[one.frame][2:], corner, shape)
        j, i = np.indices(shape)
        dx, dy = i + corner[0] - one.centre[0], j + corner[1] - one.centre[1]
        p = np.clip(np.rint(dx).astype(int) + middle, 0, 2 * middle)
        q = np.clip(np.rint(dy).astype(int) + middle, 0, 2 * middle)
        gap = look.white_paint[q, p] - wall
        share = np.sum(gap * (seen - wall), axis=-1) / np.sum(gap * gap, axis=-1)
        towards = (one.pivot - one.centre) / np.hypot(*(one.pivot - one.centre))
        away = np.hypot(dx, dy)
        # Half the disc away from the rod.
        use = (dx * towards[0] + dy * towards[1] < 0.0) & (away < 1.4 * look.radius)
        if np.isfinite(share[use]).all():
            areas.append(2.0 * share[use].sum())
    return math.sqrt(float(np.median(areas)) / math.pi) if areas else look.radius


def _learn_noise(look: Appearance, frames: list[Frame], found: list[_Found]) -> None:
    """Learn the covariance of what the background does not explain around the balls."""
    outer, inner, rest_walls = [], [], []
    exposure = look.exposure or 0.5
    for one in found[:: max(1, len(found) // 30)]:
        arm = float(np.hypot(*(one.pivot - one.centre)))
        smear = 0.0 if math.isnan(one.speed) else abs(one.speed) * exposure * arm
        half = int(1.7 * look.radius + 0.5 * smear) + 2
        side = 2 * half + 1
        corner = np.rint(one.centre).astype(int) - half
        image = look.colours.window(
            frames[one.frame][2:], (int(corner[0]), int(corner[1])), (side, side)
        )
        wall = look.wall(corner, (side, side))
        j, i = np.indices((side, side))
        dx, dy = i + corner[0] - one.centre[0], j + corner[1] - one.centre[1]
        away = np.hypot(dx, dy)
        along = (one.pivot - one.centre) / np.hypot(*(one.pivot - one.centre))
        is_rod = (dx * along[0] + dy * along[1] > 0.0) & (
            np.abs(dx * along[1] - dy * along[0]) < 0.5 * look.radius
        )
        beyond = away - 0.5 * smear
        ring = (beyond > 1.15 * look.radius) & (beyond < 1.7 * look.radius) & ~is_rod
        if not np.isfinite(wall[ring]).any():
            continue
        outer.append((image - wall)[ring])
        rest_walls.append(np.nanmedian(wall[ring], axis=0))
        if one.explained > _TEACHES and smear < _SLOW * look.radius:
            m = (look.paint.shape[0] - 1) // 2
            core = away < 0.8 * look.radius
            p = np.clip(np.rint(dx[core]).astype(int) + m, 0, 2 * m)
            q = np.clip(np.rint(dy[core]).astype(int) + m, 0, 2 * m)
            inner.append(image[core] - look.paint[q, p])
    rest = np.concatenate(outer)
    rest = rest[np.isfinite(rest).all(axis=1)]
    if len(rest) < 200:
        return
    size = np.linalg.norm(rest, axis=1)
    rest = rest[size <= np.quantile(size, 0.97)]
    covariance = rest.T @ rest / len(rest) + np.eye(3) * 2e-6
    look.weight = np.linalg.inv(covariance)
    if inner:
        own = np.concatenate(inner)
        own = own[np.isfinite(own).all(axis=1)]
        squares = np.einsum("ni,ij,nj->n", own, look.weight, own)
        look.scale = float(np.sqrt(max(12.0, 3.0 * np.quantile(squares, 0.8))))
    m = (look.paint.shape[0] - 1) // 2
    j, i = np.indices(look.paint.shape[:2]) - m
    gap = look.paint[np.hypot(i, j) < 0.8 * look.radius] - np.median(rest_walls, axis=0)
    contrast = float(np.median(np.einsum("ni,ij,nj->n", gap, look.weight, gap)))
    look.scale = max(look.scale, _OUTLYING * contrast**0.5)


def _learn_background(
    scene: Scene, frames: list[Frame], covered: list[tuple[int, np.ndarray]]
) -> None:
    """Learn the background anew where balls hid it in much of the sample, from other frames."""
    look = scene.look
    height, width = look.behind.shape[:2]
    hidden = np.zeros((len(frames), height, width), bool)
    reach = 1.3 * look.radius + 2.0
    for k, centre in covered:
        x, y = centre - look.corner
        i0, i1 = max(0, int(x - reach)), min(width, int(x + reach) + 2)
        j0, j1 = max(0, int(y - reach)), min(height, int(y + reach) + 2)
        if i0 >= i1 or j0 >= j1:
            continue
        j, i = np.mgrid[j0:j1, i0:i1]
        hidden[k, j0:j1, i0:i1] |= np.hypot(i - x, j - y) < reach
    often = hidden.mean(axis=0) > 0.2
    if not often.any():
        return
    rows, columns = np.nonzero(often)
    colours = np.full((len(frames), len(rows), 3), np.nan, np.float32)
    low, shape = (
        (int(rows.min()), int(columns.min())),
        (int(np.ptp(rows)) + 1, int(np.ptp(columns)) + 1),
    )
    for k, frame in enumerate(frames):
        corner = (int(look.corner[0]) + low[1], int(look.corner[1]) + low[0])
        image = look.colours.window(frame[2:], corner, shape)
        colours[k] = image[rows - low[0], columns - low[1]]
        colours[k][hidden[k, rows, columns]] = np.nan
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # pixels that no frame shows
        seen = np.nanmedian(colours, axis=0)
    behind = look.behind.copy()
    behind[rows, columns] = seen
    look.behind = _filled(behind)


def _learn_exposure(scene: Scene, frames: list[Frame], found: list[_Found]) -> None:
    """Learn which share of the frame interval is exposed, from the fastest balls found."""
    look = scene.look
    moving = [one for one in found if abs(one.speed) * scene.arm > 3.0 and one.explained > 0.3]
    if scene.balls == 2:  # away from contacts, where the speed is not that of the pair of frames
        alone = []
        for one in moving:
            others = [o for o in found if o.frame == one.frame and o is not one]
            if all(np.hypot(*(o.centre - one.centre)) > 4.0 * look.radius for o in others):
                alone.append(one)
        moving = alone
    fastest = sorted(moving, key=lambda one: -abs(one.speed))[:8]
    if len(fastest) < 3:
        return

    def cost(share: float) -> float:
        # The window is that of the longest smear, so that costs compare.
        return sum(
            _cost_in_window(look, frames[one.frame], one.path(scene.arm, share), one, scene.arm)
            for one in fastest
        )

    middle, step = (look.exposure, 0.1) if look.exposure > 0.0 else (0.5, 0.25)
    while step > 0.04:
        trials = np.unique(np.clip(middle + step * np.arange(-2, 3), 0.0, 1.0))
        costs = [cost(float(share)) for share in trials]
        middle, step = float(trials[int(np.argmin(costs))]), 0.5 * step
    look.exposure = scene.pivot.exposure = middle


def _cost_in_window(
    look: Appearance, frame: Frame, path: np.ndarray, one: _Found, arm: float
) -> float:
    """Return the cost of a smeared ball after its shift was fitted, summed over pixels."""
    fit = fit_balls(look, frame[2:], [path], one.pivot)
    reach = abs(one.speed) * arm
    margin = look.radius * 1.35 + 2.0 * look.blur + 3.0
    ends = path + fit.shift[0]
    low = np.floor(one.centre - reach / 2.0 - margin).astype(int)
    high = np.ceil(one.centre + reach / 2.0 + margin).astype(int)
    shape = (int(high[1] - low[1] + 1), int(high[0] - low[0] + 1))
    matrix, vector, tally = np.empty((2, 2)), np.empty(2), np.empty((1, 4))
    cost: float = kernels.normal_equations(
        look.seen(frame[2:], low, shape), look.background(low, shape),
        look.ball(ends, low, shape)[None], ends.mean(axis=0)[None], one.pivot, look.radius,
        low.astype(float), look.scale, False, matrix, vector, tally,
    )  # fmt: skip
    return cost
