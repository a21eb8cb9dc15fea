"""Learns a clip's scene from a sample of its frames: pivot, background, balls, exposure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.calibration.tilt import Tilt
from latolato.experiment.tracking.appearance import (
    Appearance,
    Colours,
    Look,
    arc,
    best_angles,
)
from latolato.experiment.tracking.blobs import Backdrop, Disc
from latolato.experiment.tracking.disc import disc_at
from latolato.experiment.tracking.paint import filled, first_paint, learn_background, uncover
from latolato.experiment.tracking.pivot import (
    PivotTracker,
    learn_pivot,
    learn_template,
    locate_all,
    velocities,
)
from latolato.experiment.tracking.sample import Sample, median_planes
from latolato.experiment.tracking.teach import Sighting, learn_exposure, learn_look
from latolato.experiment.video import Frame, Video

# First guesses, before anything was learned: standard deviation of linear light, edge softness.
_NOISE, _BLUR = 0.03, 0.8
# In poor light the noise is less: a share of the contrast, but no less than this.
_NOISE_SHARE, _LEAST_NOISE = 0.15, 0.003
# How often balls are fitted and their look is learned again.
_ROUNDS = 3
# How much more a paint that turns must explain than one that stays.
_TURNS = 1.05
# Gain at which a place on the circle is taken for a ball.
_LIKELY = 0.2
# How far about a click something that moves is looked for, as a share of the arm, and by which
# factor radii of the same disc may differ.
_ABOUT, _SIZE = 0.4, 1.5
# How clear a disc about a click must be, as a share of the clearest one.
_CLEAR = 0.85
# How often a disc is looked for again that lies this share of its radius aside.
_AGAIN, _ASIDE = 3, 0.15
# Fewest turns between two frames that tell how fast balls are.
_FEWEST_TURNS = 4


@dataclass
class ImageModel:
    """What was learned of a clip.

    Attributes
    ----------
    pivot : PivotTracker
        Follows the pivot.
    look : Look
        Layers of the image, or a template of bobs that are no discs.
    arm : float
        Distance from pivot to ball centre [pixels].
    balls : int
        How many balls are followed.
    starts, speeds : numpy.ndarray, shape (ball,)
        Angles in the clicked frame from straight down in the image [rad], right ball first, and
        how much they grow per frame interval; NaN if the next frame does not tell.
    explained : float
        Share of a ball's pixels that typically look like one; a pattern lowers it.
    stiffness : float
        Gravity over length, estimated from the swing seen [1/s^2]; 0 if it is unknown.
    tilt : Tilt
        How obliquely the camera looks at the swing.
    """

    pivot: PivotTracker
    look: Look
    arm: float
    balls: int
    starts: np.ndarray
    speeds: np.ndarray
    explained: float = 1.0
    stiffness: float = 0.0
    tilt: Tilt = field(default_factory=Tilt)

    def reach(self, angles: np.ndarray) -> np.ndarray:
        """Return the distance from pivot to ball at angles in the picture [pixels]."""
        return self.arm * self.tilt.shares(angles)

    def off(self, away: np.ndarray) -> np.ndarray:
        """Return how far places (..., 2) from the pivot are off the circle or oval [pixels]."""
        return np.asarray(np.abs(np.linalg.norm(self.tilt.flat(away), axis=-1) - self.arm))


def learn_image_model(
    video: Video,
    sample: Sample,
    pivot: np.ndarray,
    balls: list[np.ndarray],
    radius: float | None,
    progress: Callable[[float], None] | None = None,
    *,
    unseen_radius: float | None = None,
    tilt: Tilt | None = None,
) -> ImageModel:
    """The image model of a clip: background, balls and pivot.

    Parameters
    ----------
    video, sample : Video, Sample
        The clip and the frames to learn from.
    pivot : numpy.ndarray, shape (2,)
        Pivot in the clicked frame (column, row) [pixels], in the picture or out of it.
    balls : list of numpy.ndarray, shape (2,)
        Centre of each ball in the clicked frame [pixels].
    radius : float or None
        Expected radius of the balls [pixels]; None measures it.
    unseen_radius : float, optional
        Of balls about a pivot that the picture does not show, which is assumed at rest: their rough
        radius [pixels].
    tilt : Tilt, optional
        How obliquely the camera looks, if the path is an oval about a pivot at rest.

    Raises
    ------
    InputError
        If no ball is found in most of the sample.
    """
    frames = sample.from_click
    colours, tilt = Colours.of(video), tilt or Tilt()
    arm = float(np.mean([np.hypot(*tilt.flat(ball - pivot)) for ball in balls]))
    centres = [np.array(ball, float) for ball in balls]
    # The disc about each click: of the size that is declared or guessed, or of what moves there.
    size = radius or unseen_radius or 0.08 * arm
    for k, click in enumerate(centres):
        trials = [(click, size, k > 0 or radius is not None)]
        trials += [
            (d.centre, d.radius, True) for d in _moving_about(video, frames, click, arm, radius)
        ]
        found = [_settled(frames[0], colours, trial, pivot) for trial in trials]
        # The rim of what moves is known: another circle nearby is that of a pattern.
        found[1:] = [
            one
            for one, trial in zip(found[1:], trials[1:], strict=True)
            if _is_alike(one[1], trial[1])
        ]
        # Across a highlight colours step as across the ball: the largest of the clear ones.
        clear = _CLEAR * max(step for _, _, step in found)
        centres[k], each, _ = max((one for one in found if one[2] >= clear), key=lambda one: one[1])
        size = each if k == 0 else size
    arm = float(np.mean([np.hypot(*tilt.flat(centre - pivot)) for centre in centres]))
    medians = median_planes(frames[::3])
    pivot = np.asarray(pivot, float)
    if unseen_radius is None and tilt.angle == 0.0:
        tracker, shifts = learn_pivot(frames, medians[0], pivot, arm)
    else:
        tracker, shifts = PivotTracker.unseen(pivot), np.zeros((len(frames), 2))
    pivots = tracker.place(shifts)
    margin = arm + 2.5 * size + 6.0
    low = np.floor(pivots.min(axis=0) - margin).astype(int)
    high = np.ceil(pivots.max(axis=0) + margin).astype(int)
    # No ball is found where the background is unknown.
    first, beyond = video.bounds
    low, high = np.maximum(low, first), np.minimum(high, beyond)
    width, height = high - low
    behind = colours.window(medians, low, (int(height), int(width)))
    for centre in centres:
        uncover(behind, low, frames[0], colours, centre, size)
    behind = filled(behind)
    paint = first_paint(frames[0], centres, np.zeros(len(centres)), colours, size)
    weight = np.eye(3) / _first_noise(paint, behind, np.array(centres) - low, size) ** 2
    look = Appearance(colours, size, _BLUR, paint, behind, low, weight, scale=4.0)
    starts = np.sort([math.atan2(*(centre - pivot)) for centre in centres])[::-1]
    unknown = np.full(len(balls), np.nan)
    scene = ImageModel(tracker, look, arm, len(balls), starts, unknown, tilt=tilt)
    sightings: list[Sighting] = []
    for round_ in range(_ROUNDS):
        if round_ == 0:
            sightings = find_balls(scene, frames, pivots, centres)
        sightings = fit_sample(scene, frames, sightings, pivots, tolerant=3 if round_ == 0 else 1)
        if not sightings:
            raise InputError(
                f"no ball like the one at ({balls[0][0]:g}, {balls[0][1]:g}) was found in other "
                "frames",
                way_out="point at the middle of the ball",
            )
        scene.arm = learn_look(look, frames, sightings, is_first=round_ == 0, tilt=tilt)
        if not look.scale > 0.0:
            raise InputError(
                f"the disc at ({balls[0][0]:g}, {balls[0][1]:g}) looks like its surroundings",
                way_out="point at the middle of the ball",
            )
        if round_ == 0:
            covered = [(one.frame, one.centre) for one in sightings]
            learn_background(look, frames, covered)
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
    learn_swing(scene, sightings, sample.interval)
    return scene


def learn_swing(scene: ImageModel, sightings: list[Sighting], interval: float) -> None:
    """Learn how much of balls is explained, how fast they are, and what that says about their fall.

    As if they fell freely: from rest at the angle ``a``, ``w^2 = 2 g/l (1 - cos a)`` at the bottom.
    """
    scene.explained = float(np.median([one.explained for one in sightings]))
    near = scene.look.radius / scene.arm
    for b, start in enumerate(scene.starts):
        own = [one for one in sightings if one.frame == 0 and abs(one.angle - start) < near]
        if own:
            scene.speeds[b] = own[0].speed
    turns = np.array([abs(one.speed) for one in sightings])
    if np.isfinite(turns).sum() < _FEWEST_TURNS or interval == 0.0:
        return
    fastest = float(np.nanquantile(turns, 0.95)) / interval
    widest = min(0.5 * float(np.ptp([one.angle for one in sightings])), math.pi)
    scene.stiffness = fastest**2 / max(2.0 * (1.0 - math.cos(widest)), 1e-6)


def _moving_about(
    video: Video, frames: list[Frame], click: np.ndarray, arm: float, radius: float | None
) -> list[Disc]:
    """Return the discs that move about a click in the first frame, of about a declared radius."""
    first, beyond = video.bounds
    low = np.maximum(np.floor(click - _ABOUT * arm).astype(int), first)
    high = np.minimum(np.ceil(click + _ABOUT * arm).astype(int) + 1, beyond)
    discs = Backdrop(frames[::3], (low, high)).discs(frames[0])
    return [
        disc
        for disc in discs
        if np.hypot(*(disc.centre - click)) < disc.radius
        and (radius is None or _is_alike(disc.radius, radius))
    ]


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


def _first_noise(
    paint: np.ndarray, behind: np.ndarray, centres: np.ndarray, radius: float
) -> float:
    """Return the noise to begin with, by which balls on this background can be told from it.

    Centres (ball, 2) are those of the balls in the background's pixels.
    """
    m = (paint.shape[0] - 1) // 2
    j, i = np.nonzero(np.hypot(*(np.indices(paint.shape[:2]) - m)) < 0.8 * radius)
    contrasts = []
    for centre in np.rint(centres).astype(int):
        rows = np.clip(centre[1] + j - m, 0, behind.shape[0] - 1)
        columns = np.clip(centre[0] + i - m, 0, behind.shape[1] - 1)
        away = np.linalg.norm(paint[j, i] - behind[rows, columns], axis=-1)
        contrasts.append(float(np.nanmedian(away)))
    return float(np.clip(_NOISE_SHARE * min(contrasts), _LEAST_NOISE, _NOISE))


def find_balls(
    scene: ImageModel, frames: list[Frame], pivots: np.ndarray, centres: list[np.ndarray]
) -> list[Sighting]:
    """Find the balls in the sample with colours that stay or that turn: as explains more."""
    look = scene.look
    assert isinstance(look, Appearance)
    paint, some = look.paint, range(0, len(frames), 2)

    def explained() -> float:
        gains = [
            best_angles(look, frames[k][2:], pivots[k], scene.arm, scene.balls, scene.tilt)[1]
            for k in some
        ]
        return float(np.maximum(gains, 0.0).sum())

    staying = explained()
    angles = np.array([math.atan2(*(centre - pivots[0])) for centre in centres])
    look.is_spinning = True
    look.paint = first_paint(frames[0], centres, angles, look.colours, look.radius)
    look.whitened()
    if explained() < _TURNS * staying:
        look.is_spinning, look.paint = False, paint
        look.whitened()
    return find_all(scene, frames, pivots)


def find_all(scene: ImageModel, frames: list[Frame], pivots: np.ndarray) -> list[Sighting]:
    """Find the balls in every frame of the sample, on the whole circle."""
    look, sightings = scene.look, []
    for k, frame in enumerate(frames):
        angles, gain = best_angles(look, frame[2:], pivots[k], scene.arm, scene.balls, scene.tilt)
        for angle, share in zip(angles, gain, strict=True):
            if share > _LIKELY:
                at = np.array([angle])
                centre = arc(pivots[[k]], at, scene.reach(at))[0]
                sightings.append(
                    Sighting(
                        k, centre, pivots[k], float(angle), math.nan, float(share), np.zeros(2)
                    )
                )
    return sightings


def _set_speeds(sightings: list[Sighting], frames: list[Frame], balls: int) -> None:
    """Tell balls how far they turn to the next frame, or from the last one; NaN if unknown.

    Only pairs of frames in which all balls were found tell: another ball would be taken for the
    one that is missing.
    """
    seen: dict[int, list[Sighting]] = {}
    for one in sightings:
        one.speed = math.nan
        seen.setdefault(frames[one.frame].number, []).append(one)
    for number, own in seen.items():
        others = seen.get(number + 1, [])
        if len(own) != balls or len(others) != balls:
            continue
        turn = np.array([[other.angle - one.angle for other in others] for one in own])
        turn = np.mod(turn + np.pi, 2.0 * np.pi) - np.pi
        partner = np.argmin(np.abs(turn), axis=1)
        if len(set(partner.tolist())) < balls:
            continue
        for k, one in enumerate(own):
            one.speed = float(turn[k, partner[k]])
            if math.isnan(others[partner[k]].speed):
                others[partner[k]].speed = one.speed


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
            paths = [one.path(scene.arm, look.exposure) for one in group]
            fit = look.fit(frame[2:], paths, pivots[k], rounds=8, tolerant=tolerant)
            for one, shift, share in zip(group, fit.shift, fit.explained, strict=True):
                one.centre, one.pivot, one.drift = one.centre + shift, pivots[k], drift[k]
                away = one.centre - one.pivot
                one.angle, one.explained = float(np.arctan2(away[0], away[1])), float(share)
                if scene.off(away) < 0.6 * look.radius:
                    kept.append(one)
    _set_speeds(kept, frames, scene.balls)
    return kept
