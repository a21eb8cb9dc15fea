"""Learns a clip's scene from a sample of its frames: pivot, background, balls, exposure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from latolato.experiment.calibration.tilt import Tilt
from latolato.experiment.rules import broken, place_text
from latolato.experiment.tracking.appearance import (
    Appearance,
    Colours,
    arc,
    fit_balls,
)
from latolato.experiment.tracking.body import learn_body
from latolato.experiment.tracking.disc import disc_at
from latolato.experiment.tracking.geometry import Geometry
from latolato.experiment.tracking.paint import first_paint, learn_background
from latolato.experiment.tracking.pivot import (
    PivotTracker,
    learn_template,
    locate_all,
    velocities,
)
from latolato.experiment.tracking.route import Route
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.tracking.teach import (
    OUTLYING,
    SMALLEST_DISC,
    Sighting,
    learn_exposure,
    learn_look,
)
from latolato.experiment.video import Frame, Video

# First guesses, before anything was learned: standard deviation of linear light, edge softness.
_NOISE, _BLUR = 0.03, 0.8
# In poor light the noise to begin with is less: a share of the contrast of balls with the
# background, but no less than this.
_NOISE_SHARE, _LEAST_NOISE = 0.15, 0.003
# How far balls hide the background where they roughly are [radii].
_HIDES = 1.2
# How often balls are fitted and their look is learned again.
_ROUNDS = 3
# Typical share that colours that stay explain from which those that turn are not tried, and by how
# much these must explain more.
_PLAIN, _TURNS = 0.97, 1.05
# By how much turns between fitted places differ from what the route says, as a share, unless balls
# met between them.
_FASTER = 0.3
# Error of the radius of a ball whose pattern turns, as a share.
_PATTERN = 0.05
# By which factor radii of the same disc may differ, and those of two measurements of it.
_SIZE, _MEASURED = 1.5, 1.15
# Radius, in pixels of a small picture, below which a ball may be too small for an edge.
_SMALL = 2.0
# How many frames in which a ball is slow show what it looks like.
_SLOW = 7
# They are smeared by less than this share of the radius, or these are the slowest of them.
_SHARP, _FEW = 0.2, 3
# Radius of the smallest disc [pixels].
_SMALLEST = 1.0
# How clear a disc about a click must be, as a share of the clearest one.
_CLEAR = 0.85
# How often a disc is looked for again that lies this share of its radius aside.
_AGAIN, _ASIDE = 3, 0.15


@dataclass
class ImageModel:
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
    explained : float
        Share of a ball's pixels that typically look like one; a pattern lowers it.
    tilt : Tilt
        How obliquely the camera looks at the swing.
    lean : float
        By which angle what is followed is ahead of the middle of what moves [rad].
    unsure : float or numpy.ndarray
        By how much the pivot may be elsewhere, across the rods (frame, ball) or at all, as it moves
        unseen or balls are often off their circle [pixels].
    """

    pivot: PivotTracker
    look: Appearance
    arm: float
    balls: int
    explained: float = 1.0
    tilt: Tilt = field(default_factory=Tilt)
    lean: float = 0.0
    unsure: float | np.ndarray = 0.0

    def reach(self, angles: np.ndarray) -> np.ndarray:
        """Return the distance from pivot to ball at angles in the picture [pixels]."""
        return self.arm * self.tilt.shares(angles)

    def off(self, away: np.ndarray) -> np.ndarray:
        """Return how far places (..., 2) from the pivot are off the circle or oval [pixels]."""
        return np.asarray(np.abs(np.linalg.norm(self.tilt.flat(away), axis=-1) - self.arm))


def learn_image_model(
    video: Video,
    sample: Sample,
    geometry: Geometry,
    balls: list[np.ndarray],
    radius: float | None,
    route: Route,
    progress: Callable[[float], None] | None = None,
    *,
    rough_radius: float | None = None,
    half: float | None = None,
) -> ImageModel:
    """The image model of a clip: background, balls and pivot.

    Parameters
    ----------
    video, sample : Video, Sample
        The clip and the frames to learn from.
    geometry : Geometry
        What the balls turn about.
    balls : list of numpy.ndarray, shape (2,)
        Centre of each ball in the clicked frame [pixels].
    radius : float or None
        Expected radius of the balls [pixels]; None measures it.
    route : Route
        Where the balls roughly are in all frames.
    rough_radius : float, optional
        Of the balls, from which their radius is looked for [pixels]; by default a share of the arm.
    half : float, optional
        Half the side of the patch about a click that shows a bob, if that is no disc [pixels].

    Raises
    ------
    InputError
        If no ball is found in most of the sample.
    """
    frames = sample.from_click
    colours, medians = Colours.of(video), sample.medians
    tracker, shifts, tilt = replace(geometry.tracker), geometry.shifts, geometry.tilt
    pivots = tracker.place(shifts)
    centres = [np.array(ball, float) for ball in balls]
    size = radius or rough_radius or 0.08 * geometry.arm(balls)
    shots = [[(0, ball)] for ball in balls]
    dot = _dot_radius(sample, route)
    if half is not None:
        size = half
    for b, click in enumerate(balls if half is None else []):
        shots[b], size = _discs(frames, colours, route, b, click, size, pivots[0], radius, dot)
        first_frame, first_place = shots[b][0]
        centres[b] = first_place if first_frame == 0 else centres[b]
    if size < _SMALLEST:
        raise broken("small_disc", {"place": place_text(balls[0])})
    arm = geometry.arm(centres)
    margin = arm + 2.5 * size + 6.0
    low = np.floor(pivots.min(axis=0) - margin).astype(int)
    high = np.ceil(pivots.max(axis=0) + margin).astype(int)
    # No ball is found where the background is unknown.
    first, beyond = video.bounds
    low, high = np.maximum(low, first), np.minimum(high, beyond)
    covered = _covered(frames, route, balls)
    behind = learn_background(medians, frames, colours, covered, (low, high), _HIDES * size + 2.0)
    paint = _first_paints(frames, shots, colours, size)
    contrast = min(
        _contrast(one, behind, np.array([at for _, at in own]) - low, size)
        for one, own in zip(paint, shots, strict=True)
    )
    if half is not None or _look_alike(paint, size, contrast):
        shots = [[shot for own in shots for shot in own]]
        paint = _first_paints(frames, shots, colours, size)
    noise = float(np.clip(_NOISE_SHARE * contrast, _LEAST_NOISE, _NOISE))
    weight = np.eye(3) / noise**2
    look = Appearance(colours, size, _BLUR, paint, behind, low, weight, scale=4.0)
    if route.is_smeared:
        look.exposure = route.exposure
    scene = ImageModel(tracker, look, arm, len(balls), tilt=tilt)
    if half is None:
        turning = _first_paints(frames, shots, colours, size, pivots)
        sightings = _first_fit(scene, frames, pivots, route, turning)
    else:
        sightings = _first_bobs(scene, frames, pivots, route, balls, medians)
    for round_ in range(_ROUNDS):
        if round_ > 0:
            sightings = fit_sample(scene, frames, sightings, pivots, tolerant=1)
        if not sightings:
            raise broken("found_once", {"place": place_text(balls[0])})
        scene.arm = learn_look(look, frames, sightings, medians, is_first=round_ == 0, tilt=tilt)
        if not look.scale > 0.0:
            raise broken("like_surroundings")
        if round_ > 0:
            learn_exposure(look, frames, sightings, scene.arm, scene.balls)
            tracker.exposure = look.exposure
            if not tracker.is_still and tracker.exposure > 0.0:
                shifts = locate_all(tracker, frames, shifts)
                learn_template(tracker, frames, medians[0], shifts)
                shifts = locate_all(tracker, frames, shifts)
                tracker.anchor = shifts[0].copy()
                pivots = tracker.place(shifts)
        if progress:
            progress((round_ + 1) / _ROUNDS)
    scene.explained = float(np.median([one.explained for one in sightings]))
    if look.is_spinning and look.body is None:  # a pattern may look like the wall at the edge
        look.radius_sigma = math.hypot(look.radius_sigma, _PATTERN * look.radius)
    return scene


def _covered(
    frames: list[Frame], route: Route, balls: list[np.ndarray]
) -> list[tuple[int, np.ndarray]]:
    """Return numbers of frames of the sample, each with a place of a ball, clicked or rough."""
    covered = [(0, ball) for ball in balls]
    for k, frame in enumerate(frames):
        if 0 <= frame.number < len(route.times):
            places = route.places[frame.number]
            covered += [(k, place) for place in places if np.isfinite(place).all()]
    return covered


def _first_paints(
    frames: list[Frame],
    shots: list[list[tuple[int, np.ndarray]]],
    colours: Colours,
    radius: float,
    pivots: np.ndarray | None = None,
) -> np.ndarray:
    """Return the typical colours in each group of shots, shape (group, row, column, 3).

    Shots are numbers of frames with a ball's centre. With `pivots` (frame, 2) they are turned back
    to what they are where the rod hangs down.
    """
    turns = [
        [0.0 if pivots is None else math.atan2(*(at - pivots[k])) for k, at in own] for own in shots
    ]
    return np.stack([
        first_paint(
            [(frames[k], at, turn) for (k, at), turn in zip(own, each, strict=True)],
            colours, radius,
        )
        for own, each in zip(shots, turns, strict=True)
    ])  # fmt: skip


def _first_fit(
    scene: ImageModel, frames: list[Frame], pivots: np.ndarray, route: Route, turning: np.ndarray
) -> list[Sighting]:
    """Return the balls of the sample fitted with colours that stay or that turn: as explains more.

    `turning` are the colours that turn with the rod.
    """
    look = scene.look

    def fitted() -> list[Sighting]:
        first = first_sightings(scene, frames, pivots, route)
        return fit_sample(scene, frames, first, pivots, tolerant=3)

    def explained(sightings: list[Sighting]) -> float:
        return float(np.sum([one.explained for one in sightings]))

    staying, paint = fitted(), look.paint
    if not staying or explained(staying) > _PLAIN * len(staying):
        return staying
    look.is_spinning, look.paint = True, turning
    look.whitened()
    turned = fitted()
    if explained(turned) > _TURNS * explained(staying):
        return turned
    look.is_spinning, look.paint = False, paint
    look.whitened()
    return staying


def _first_bobs(
    scene: ImageModel,
    frames: list[Frame],
    pivots: np.ndarray,
    route: Route,
    balls: list[np.ndarray],
    medians: tuple[np.ndarray, ...],
) -> list[Sighting]:
    """Return the bobs of the sample, fitted with what is different about the clicks (2,)."""
    clicked = [
        Sighting(0, ball, pivots[0], math.atan2(*(ball - pivots[0])), 0.0, 1.0, np.zeros(2), b)
        for b, ball in enumerate(balls)
    ]
    scene.look.is_spinning = True
    learn_body(scene.look, frames, clicked, medians)
    scene.lean = _lean(route, frames[0].number, balls, pivots[0])
    first = first_sightings(scene, frames, pivots, route)
    found = fit_sample(scene, frames, first, pivots, tolerant=3)
    if not any(one.frame > 1 for one in found):
        raise broken("patch_found_once", {"place": place_text(balls[0])})
    return found


def _lean(route: Route, number: int, balls: list[np.ndarray], pivot: np.ndarray) -> float:
    """Return by which angle what is pointed at is ahead of the middle of what moves [rad]."""
    if not (0 <= number < len(route.times) and route.is_seen[number].all()):
        return 0.0
    own, seen = (
        np.arctan2(*(np.array(places) - pivot).T) for places in (balls, route.places[number])
    )
    return float(np.mean(np.remainder(own - seen + math.pi, math.tau) - math.pi))


def _dot_radius(sample: Sample, route: Route) -> float:
    """Return the radius of balls that are too small for an edge [pixels], NaN for larger ones.

    It is that of a disc of as many pixels as differ by half of what the clearest one does, in
    frames in which they are slow.
    """
    if not route.radius < _SMALL * max(sample.copies.shrink, 2.0):
        return math.nan
    behind = sample.medians[0]
    speeds = np.linalg.norm(route.velocities[0], axis=-1)
    seen = [
        (float(speeds[frame.number, b]), frame, route.places[frame.number, b])
        for frame in sample.frames
        for b in np.flatnonzero(route.is_seen[frame.number] & np.isfinite(speeds[frame.number]))
    ]
    reach, radii = math.ceil(2.0 * route.radius) + 3, []
    for _, frame, place in sorted(seen, key=lambda one: one[0])[:_SLOW]:
        left, top = np.maximum(np.rint(place).astype(int) - reach, 0)
        part = np.s_[top : top + 2 * reach + 1, left : left + 2 * reach + 1]
        apart = np.abs(frame.luma[part].astype(float) - behind[part])
        radii.append(math.sqrt(np.count_nonzero(apart > 0.5 * apart.max()) / math.pi))
    radius = float(np.median(radii)) if radii else math.nan
    return radius if radius < SMALLEST_DISC else math.nan


def _discs(
    frames: list[Frame],
    colours: Colours,
    route: Route,
    ball: int,
    click: np.ndarray,
    size: float,
    pivot: np.ndarray,
    radius: float | None,
    dot: float,
) -> tuple[list[tuple[int, np.ndarray]], float]:
    """Return frames of the sample with a ball's centre in each, and its radius [pixels].

    They are the clicked frame, the first, unless the ball is smeared there by a quarter of its
    width, and some in which it is slow: a hand may hold it in the first. Each shows the disc of
    the size that is declared or guessed, or of what moves there. A `dot` is a radius too small for
    a disc to be looked for, NaN for larger ones.
    """
    speeds = np.linalg.norm(route.velocities[0][:, ball], axis=-1)
    smears = speeds * float(np.median(np.diff(route.times))) * route.exposure
    numbers = [frame.number for frame in frames]
    in_clip = [k for k, n in enumerate(numbers) if 0 <= n < len(smears)]
    known = route.is_seen[:, ball] & np.isfinite(smears)
    seen = [k for k in in_clip if known[numbers[k]]]
    # One of each part of the clip, for it may rest in a hand for a while.
    later = [k for k in seen if k > 0]
    parts = [part.tolist() for part in np.array_split(np.array(later, int), _SLOW)]
    slow = [min(part, key=lambda k: float(smears[numbers[k]])) for part in parts if part]
    slow.sort(key=lambda k: float(smears[numbers[k]]))
    sharp = [k for k in slow if smears[numbers[k]] < _SHARP * route.radius]
    slow = sharp if len(sharp) > _FEW else slow[:_FEW]
    if math.isfinite(dot):  # it has no rim
        return [(k, route.places[numbers[k], ball]) for k in slow], dot
    is_moving = not route.is_traced and (radius is None or _is_alike(route.radius, radius))
    found: list[tuple[int, np.ndarray, float, float]] = []
    if 0 not in seen or smears[numbers[0]] < 0.5 * route.radius or not slow:
        trials = [(np.array(click, float), size, ball > 0 or radius is not None)]
        if 0 in seen and is_moving:
            trials.append((route.places[numbers[0], ball], route.radius, True))
        discs = [_settled(frames[0], colours, trial, pivot) for trial in trials]
        # The rim of what moves is known: another circle nearby is that of a pattern.
        if len(discs) > 1 and not _is_alike(discs[1][1], trials[1][1]):
            del discs[1]
        # Across a highlight colours step as across the ball: the largest of the clear ones.
        clear = _CLEAR * max(step for _, _, step in discs)
        found.append((0, *max((d for d in discs if d[2] >= clear), key=lambda d: d[1])))
    if is_moving:
        is_whole = bool(found) and _is_alike(found[0][2], route.radius)
        near = found[0][2] if is_whole else route.radius
        others = [
            (k, *_settled(frames[k], colours, (route.places[numbers[k], ball], near, True), pivot))
            for k in slow
        ]
        others = [one for one in others if radius is None or _is_alike(one[2], radius)]
        # What moves is as large as the ball: a circle of another size is that of a highlight.
        alike = [one for one in others if _is_alike(one[2], route.detected_radius)]
        if not alike and radius is None:  # no rim is clear: the ball is what moves
            whole = route.detected_radius, 0.0
            alike = [(k, route.places[numbers[k], ball], *whole) for k in slow]
        others = alike or others
        typical = float(np.median([one[2] for one in others])) if others else near
        # What most frames show is the ball; in a hand it may look larger.
        if others and found and not _is_same(found[0][2], typical):
            found.clear()
        found += [one for one in others if _is_same(one[2], typical)]
        if not found and others:
            found = [min(others, key=lambda one: abs(one[2] - typical))]
    if not found:
        found = [(slow[0], route.places[numbers[slow[0]], ball], size, 0.0)]
    return [one[:2] for one in found], float(np.median([one[2] for one in found]))


def _is_same(one: float, other: float) -> bool:
    """Return whether two measurements may be of one radius."""
    return 1.0 / _MEASURED < one / other < _MEASURED


def _is_alike(one: float, other: float) -> bool:
    """Return whether two radii may be the same."""
    return 1.0 / _SIZE < one / other < _SIZE


def _settled(
    frame: Frame, colours: Colours, trial: tuple[np.ndarray, float, bool], pivot: np.ndarray
) -> tuple[np.ndarray, float, float]:
    """Return the disc near a place: near what was found again as long as that lies far aside."""
    near, size, is_known = trial
    disc = disc_at(frame, colours, near, size, pivot, is_known)
    for _ in range(_AGAIN):
        if np.hypot(*(disc[0] - near)) < _ASIDE * disc[1]:
            break
        near = disc[0]
        again = disc_at(frame, colours, near, disc[1], pivot, is_known)
        if again[2] < disc[2] or not _is_alike(again[1], disc[1]):
            break
        disc = again
    return disc


def _look_alike(paints: np.ndarray, radius: float, contrast: float) -> bool:
    """Return whether paints (ball, row, column, 3) differ less than something else from a ball."""
    m = (paints.shape[1] - 1) // 2
    core = np.hypot(*(np.indices(paints.shape[1:3]) - m)) < 0.8 * radius
    typical = paints[:, core].mean(axis=1)  # also of a pattern, which may be turned
    return bool(np.linalg.norm(typical[0] - typical[-1]) < OUTLYING * contrast)


def _contrast(paint: np.ndarray, behind: np.ndarray, centres: np.ndarray, radius: float) -> float:
    """Return the least difference of a ball from the background.

    Centres (place, 2) are those of the ball in the background's pixels.
    """
    m = (paint.shape[0] - 1) // 2
    j, i = np.nonzero(np.hypot(*(np.indices(paint.shape[:2]) - m)) < 0.8 * radius)
    contrasts = []
    for centre in np.rint(centres).astype(int):
        rows = np.clip(centre[1] + j - m, 0, behind.shape[0] - 1)
        columns = np.clip(centre[0] + i - m, 0, behind.shape[1] - 1)
        away = np.linalg.norm(paint[j, i] - behind[rows, columns], axis=-1)
        contrasts.append(float(np.nanmedian(away)))
    return min(contrasts)


def first_sightings(
    scene: ImageModel, frames: list[Frame], pivots: np.ndarray, route: Route
) -> list[Sighting]:
    """Return the balls in the frames of the sample, where the route says that they are."""
    sightings, drift = [], np.nan_to_num(velocities(frames, pivots))
    speeds = route.velocities[0] * float(np.median(np.diff(route.times)))
    for k, frame in enumerate(frames):
        if not 0 <= frame.number < len(route.times):
            continue
        for b in np.flatnonzero(route.is_seen[frame.number]):
            away = route.places[frame.number, b] - pivots[k]
            angle = math.atan2(*away) + scene.lean
            centre = arc(pivots[k], np.array(angle), scene.reach(np.array(angle)))
            u, v = speeds[frame.number, b] - drift[k]
            turn = (u * away[1] - v * away[0]) / float(away @ away)
            sightings.append(Sighting(k, centre, pivots[k], angle, turn, 1.0, drift[k], int(b)))
    return sightings


def fit_sample(
    scene: ImageModel,
    frames: list[Frame],
    sightings: list[Sighting],
    pivots: np.ndarray,
    tolerant: int,
) -> list[Sighting]:
    """Fit the balls found in each frame together; keep those on the circle, with their speeds."""
    look, kept = scene.look, []
    drift = np.nan_to_num(velocities(frames, pivots))
    for k, frame in enumerate(frames):
        own = [one for one in sightings if one.frame == k]
        far = len(own) < 2 or np.hypot(*(own[0].centre - own[1].centre)) > 3.5 * look.radius
        for group in [[one] for one in own] if far else [own]:
            paths = {one.ball: one.path(scene.arm, look.exposure) for one in group}
            fit = fit_balls(look, frame[2:], paths, pivots[k], rounds=8, tolerant=tolerant)
            for one, shift, share in zip(group, fit.shift, fit.explained, strict=True):
                one.centre, one.pivot, one.drift = one.centre + shift, pivots[k], drift[k]
                away = one.centre - one.pivot
                one.angle, one.explained = float(np.arctan2(away[0], away[1])), float(share)
                if scene.off(away) < 0.6 * look.radius:
                    kept.append(one)
    _update_speeds(kept, frames)
    return kept


def _update_speeds(sightings: list[Sighting], frames: list[Frame]) -> None:
    """Tell balls how far they turn to the next frame of a pair, where their fits say it better."""
    at = {(frames[one.frame].number, one.ball): one for one in sightings}
    for (number, ball), one in at.items():
        other = at.get((number + 1, ball))
        if other is not None and not math.isnan(one.speed):
            turn = one.speed + math.remainder(other.angle - one.angle - one.speed, math.tau)
            if abs(turn - one.speed) < _FASTER * abs(one.speed):
                one.speed = other.speed = turn
