"""Follows the balls of a task through its video, step by step, and refuses what is no pendulum."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from latolato.core.errors import InputError, Sentence, joined
from latolato.experiment.calibration.calibrate import Calibration, calibrate, unsmeared
from latolato.experiment.calibration.circle import Circle, doubt_about, unseen_circle
from latolato.experiment.calibration.hinge import CLICK_SIGMA, sigma_of_pivot
from latolato.experiment.calibration.lens import distorted, undistorted
from latolato.experiment.calibration.orbit import DrivenCircle, drive_of, rate_values
from latolato.experiment.calibration.pace import pace_warnings
from latolato.experiment.calibration.scale import TOLERANCE, scale_of
from latolato.experiment.rules import broken, place_text, said
from latolato.experiment.sidecar import Setup
from latolato.experiment.task import READ, Progress, Task, part_of
from latolato.experiment.tracking.body import ROUND, SHARE
from latolato.experiment.tracking.gate import examine, moving_ball
from latolato.experiment.tracking.geometry import Geometry, fit_geometry
from latolato.experiment.tracking.learn import ImageModel, learn_image_model
from latolato.experiment.tracking.positions import Positions, meetings
from latolato.experiment.tracking.refine import OFF_CIRCLE, OFF_SHARE, Corrections, refine
from latolato.experiment.tracking.route import Route, find_route
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.tracking.steady import Steadier
from latolato.experiment.video import Video

# By which factor what moves may be larger or smaller than the declared ball.
_OTHER_SIZE = 5.0
# Shares of samples that are measured, and that are clean, below which no ball was followed; below
# which too few are clean; below which one in slow motion is measured too seldom.
_NEVER, _HARDLY, _SELDOM, _OFTEN = 0.25, 0.1, 0.7, 0.95
# Share of frames from which a ball that is off its circle does not swing about the pivot, and the
# share of the arm by which it is off at least.
_ASTRAY, _OFF = 0.4, 0.03
# How far off the circle balls are in half of the sample, as a share of how far off samples may be,
# from which many samples are left out. Those left look better than they are, for a pivot is as far
# from where it is taken to be sideways as along the rod. It is up to 0.15 in clips without fault.
_OFTEN_OFF = 0.4
# Share of the frames in which something is seen from which its rough path tells what it is.
_PLAINLY = 0.5
# Error of a ball's place where its pattern resembles the background, as a share of its radius:
# where the colours learned explain all of the ball, and how much more where they explain nothing.
# Synthetic clips: 0.04 to 0.06 where they explain nine tenths, 0.12 where they explain a quarter.
_PATTERN, _UNEXPLAINED = 0.05, 0.1
# Share of learning the scene in the work that follows the first reading.
_LEARNED = 0.2
# Doubt about a pivot's height by the distances of balls: of rods at 72 degrees half is believed.
_TILTED = 0.1
# Distance from where a pivot was taken to be that is no accident [standard deviations of a click]:
# 95 % of clicks are nearer.
_ELSEWHERE = 2.5
# Share of the arm by which a pivot that nothing shows may be elsewhere by the measured paths of
# balls than by their rough ones: two about pivots of their own may move as if about a driven one.
_UNCLEAR = 0.1
# By which factor the distances of two balls from one pivot differ whose arms are different.
_OTHER_ARM = 1.15


@dataclass(frozen=True)
class Track:
    """Balls that were followed about one pivot."""

    scene: ImageModel
    seen: Positions
    measured: Calibration


@dataclass(frozen=True)
class PathOnly:
    """Balls whose pivot is not known, and why."""

    seen: Positions
    doubt: Sentence


def follow(task: Task, sample: Sample, progress: Progress | None) -> list[Track] | PathOnly:
    """Follow the balls of a task: both about one pivot, or each about its own.

    Raises
    ------
    InputError
        If what was followed is no ball, does not swing about the pivot, or may be another ball.
    """
    setup, route = task.setup, _route(task, sample)
    at_rest = moving_ball(_positions(task, sample, route))
    if at_rest is not None:
        raise at_rest.fault
    found: list[Track] | Track | PathOnly
    if setup.has_own_pivots or _has_own_arms(setup, task.video):
        found = _each_alone(task, sample, route, progress)
    else:
        if setup.pivot is not None:
            route = route.ordered(np.array(setup.pivot))
            task = replace(task, setup=_as_ordered(setup, route, sample.click))
        found = _found(task, sample, route, part_of(progress, READ, 1.0))
        if math.isfinite(route.meets):  # a ball that looks the same, and nobody pointed at
            raise broken("second_ball", {"time": route.meets})
    if isinstance(found, PathOnly):
        return replace(found, seen=_believed(task, sample, route, found.seen))
    return found if isinstance(found, list) else [found]


def _as_ordered(setup: Setup, route: Route, clicked: int) -> Setup:
    """Return a set-up whose balls are in the order of a route, by their places when clicked.

    If the route does not tell, as where that frame is not used, the right-hand ball comes first.
    """
    if len(setup.balls) < 2:
        return setup
    first, last = setup.balls
    is_turned = first[0] < last[0]
    if 0 <= clicked < len(route.times) and np.isfinite(route.places[clicked]).all():
        one, other = route.places[clicked]
        apart = math.dist(one, first) + math.dist(other, last)
        is_turned = math.dist(one, last) + math.dist(other, first) < apart
    return replace(setup, balls=(last, first)) if is_turned else setup


def _has_own_arms(setup: Setup, video: Video) -> bool:
    """Return whether two balls swing about one pivot in the picture at different distances."""
    if len(setup.balls) < 2 or setup.pivot is None or not video.shows(setup.pivot):
        return False
    short, long = sorted(math.dist(ball, setup.pivot) for ball in setup.balls)
    return long > _OTHER_ARM * short


def _each_alone(
    task: Task, sample: Sample, route: Route, progress: Progress | None
) -> list[Track] | PathOnly:
    """Return two balls, each of which was followed about a pivot of its own."""
    tracks: list[Track] = []
    setup = task.setup
    for b, pivot in enumerate(setup.pivots):
        corrections = ((n, 1, u, v) for n, ball, u, v in setup.corrections if ball == b + 1)
        alone = replace(
            setup,
            pivot=pivot,
            balls=setup.balls[b : b + 1],
            has_own_pivots=False,
            corrections=tuple(corrections),
        )
        low = READ + 0.5 * b * (1.0 - READ)
        tell = part_of(progress, low, low + 0.5 * (1.0 - READ))
        found = _found(replace(task, setup=alone), sample, route.ball(b), tell)
        if isinstance(found, PathOnly):
            return PathOnly(_positions(task, sample, route), found.doubt)
        tracks.append(found)
    right, left = (track.seen for track in tracks)
    is_meeting = meetings(right, left)
    for seen in (right, left):
        seen.flags[(is_meeting & (seen.flags[:, 0] == "ok"))[:, None]] = "collision"
    return tracks


def _found(task: Task, sample: Sample, route: Route, progress: Progress | None) -> Track | PathOnly:
    """Return balls about one pivot: in the picture, or where the arc shows it."""
    pivot = task.setup.pivot
    if pivot is not None and task.video.shows(pivot):
        scene, seen = _followed(task, sample, np.array(pivot), route, progress)
        return Track(scene, seen, _calibrated(task, sample, scene, seen))
    if task.setup.shape == "template":
        raise broken("bob_without_pivot")
    path = _positions(task, sample, route)
    circle = _circle_of(task, path)
    if isinstance(circle, Sentence):
        return PathOnly(path, circle)
    attempt = replace(task, warnings=[])  # a track that is given up leaves no warnings
    scene, seen = _followed(attempt, sample, circle.centre, route, progress, is_unseen=True)
    circle = _circle_of(task, seen)
    if isinstance(circle, Sentence):
        return PathOnly(path, circle)
    task.warnings += attempt.warnings
    return Track(scene, seen, _calibrated(task, sample, scene, seen, circle))


def _followed(
    task: Task,
    sample: Sample,
    pivot: np.ndarray,
    route: Route,
    progress: Progress | None,
    *,
    is_unseen: bool = False,
) -> tuple[ImageModel, Positions]:
    """The image model learned from a clip, and the positions of its balls about the pivot.

    The picture does not show the pivot if it `is_unseen`.
    """
    video, setup = task.video, task.setup
    size, radius = (video.width, video.height), setup.radius
    balls = [np.array(ball) for ball in setup.balls]
    corrections = _corrections(task, sample)
    tell = part_of(progress, 0.0, _LEARNED)
    is_disc = setup.shape != "template"
    if is_unseen:
        geometry = Geometry.at_rest(pivot, len(sample.from_click))
    else:
        geometry = fit_geometry(sample, pivot, balls, route, size, setup.optics)
        if route.is_seen.mean() > _PLAINLY:  # it is no wall where something else is seen at times
            _check_distances(sample, geometry, route)

    def learned(radius: float | None) -> ImageModel:
        rough = route.radius if is_unseen else None
        half: float | None = None
        if not is_disc:
            half = 0.5 * setup.patch if setup.patch else ROUND * radius if radius else None
            half = math.ceil(half or SHARE * geometry.arm(balls))
        return learn_image_model(
            video, sample, geometry, balls, radius, route, tell, rough_radius=rough, half=half
        )

    if is_unseen:
        scene = learned(None)
        seen = refine(video, sample, scene, route, part_of(progress, _LEARNED, 1.0), corrections)
        return scene, _believed(task, sample, route, seen)
    scale = scale_of(setup, size, (geometry.arm(balls), 0.0))
    expected = radius / scale.metres if radius and scale else None
    seen_radius = math.nan if route.is_traced else route.detected_radius
    if is_disc and expected and abs(math.log(expected / seen_radius)) > math.log(_OTHER_SIZE):
        sizes = {"radius": f"{seen_radius:.0f}", "declared": f"{expected:.1f}"}
        raise broken("other_radius", sizes)
    scene = learned(expected)
    doubt = TOLERANCE + scene.look.radius_sigma / scene.look.radius
    if is_disc and expected and abs(scene.look.radius / expected - 1.0) > doubt:
        # A declared radius that is wrong may lead astray: without it more may be explained.
        try:
            free = learned(None)
        except InputError:
            free = scene
        if free.explained > scene.explained:
            scene = free
    distances = _check_distances(sample, geometry, route, scene.arm)
    left_out = max(OFF_CIRCLE * scene.look.radius, OFF_SHARE * scene.arm)
    # What always hides a part of the ball makes all distances wrong alike, and no pivot move.
    varies = np.abs(distances - np.median(distances)) if len(distances) else np.zeros(1)
    if is_disc and float(np.median(varies)) > _OFTEN_OFF * left_out:
        scene.unsure = float(np.sqrt(np.mean((distances - scene.arm) ** 2)))
    scale = scale_of(setup, size, (scene.arm, 0.0), (scene.look.radius, 0.0))
    seen = refine(video, sample, scene, route, part_of(progress, _LEARNED, 1.0), corrections)
    if geometry.driven is not None:
        _settle_drive(task, scene, seen, geometry.driven, geometry.shifts[0])
    if route.is_traced:
        _check_motion(seen, seen.clean_share(~sample.repeats))
    declared = radius / scale.metres if radius and scale else None
    return scene, _believed(task, sample, route, seen, declared)


def _settle_drive(
    task: Task, scene: ImageModel, seen: Positions, rough: DrivenCircle, apart: np.ndarray
) -> None:
    """Fit the motion of a pivot that the picture does not show again, now that balls are measured.

    What its one harmonic leaves of the distances is taken as the pivot's height in that frame,
    where rods are steep enough to tell. What is not known of both joins the deviations, and so does
    how far it is `apart` (2,) from where it was taken to be [pixels], if that is no accident:
    lenses and oblique views move the centre of the circle, and bend the path less than noise does.

    Raises
    ------
    InputError
        If the measured paths put the pivot elsewhere than the rough ones.
    """
    size, optics = (task.video.width, task.video.height), task.setup.optics
    is_clean = seen.flags == "ok"
    clean = undistorted(np.where(is_clean[..., None], seen.centres, np.nan), size, optics)
    driven = drive_of(seen.times, clean, rough.pivots(seen.times).mean(axis=0)) or rough
    if float(np.hypot(*(driven.centre - rough.centre))) > _UNCLEAR * rough.arm:
        centres = {"one": place_text(rough.centre), "other": place_text(driven.centre)}
        raise broken("unclear_drive", centres)
    pivots = driven.pivots(seen.times)
    away = clean - pivots[:, None]
    off = np.linalg.norm(away, axis=-1) - driven.arm
    share = np.cos(np.arctan2(away[..., 0], away[..., 1]))
    weight = np.nansum(share**2, axis=1) + _TILTED
    pivots[:, 1] += np.nansum(off * share, axis=1) / weight
    seen.pivots[:] = distorted(pivots, size, optics)
    aside, along = driven.unsure(seen.times).T[..., None]
    along = np.hypot(along, driven.residual * np.sqrt(_TILTED / weight)[:, None])
    # Angles feel what is across the rod.
    across = np.where(np.isnan(share), 1.0, np.sqrt(1.0 - share**2))
    scene.unsure = np.hypot(aside, along * across)
    place, pixels = place_text(pivots.mean(axis=0)), f"{driven.amplitude:.1f}"
    values = {"place": place, "pixels": pixels, **rate_values(driven.frequency, seen.times)}
    task.warnings.append(said("unseen_drive", **values))
    distance = float(np.hypot(*apart))
    if distance > _ELSEWHERE * CLICK_SIGMA:
        turned = (away[..., 1] * apart[0] - away[..., 0] * apart[1]) / np.linalg.norm(away, axis=-1)
        scene.unsure = np.hypot(scene.unsure, np.where(np.isnan(turned), distance, turned))
        where = place_text(np.asarray(task.setup.pivot) + apart)
        task.warnings.append(said("other_centre", place=where, pixels=f"{distance:.0f}"))


def _route(task: Task, sample: Sample) -> Route:
    """Return where the balls of a set-up roughly are in all frames."""
    setup, radius = task.setup, None
    if setup.radius and setup.length and setup.pivot:
        radius = setup.radius / setup.length * math.dist(setup.balls[0], setup.pivot)
    return find_route(
        sample.copies, sample.times,
        [np.array(ball) for ball in setup.balls], sample.click, radius, sample.repeats,
        [None if pivot is None else np.array(pivot) for pivot in setup.pivots],
    )  # fmt: skip


def _positions(task: Task, sample: Sample, route: Route) -> Positions:
    """Return positions of balls about an unseen pivot: those of their route."""
    out = Positions.unknown(sample.times, route.places.shape[1], route.radius)
    corrections = _corrections(task, sample)
    out.flags[route.is_seen] = "ok"
    out.centres[route.is_seen] = route.places[route.is_seen]
    for number, _, _, _ in task.setup.corrections:
        frame = number - task.video.first_frame
        for ball, place in corrections(frame).items():
            out.centres[frame, ball], out.flags[frame, ball] = place, "manual"
    return out


def _corrections(task: Task, sample: Sample) -> Corrections:
    """Return the function that tells where balls of a frame are set by hand, once it is read.

    Frames count from the first one used on. Places are those of a camera at rest.

    Raises
    ------
    InputError
        If no such frame is used, or there is no such ball.
    """
    places: dict[int, dict[int, np.ndarray]] = {}
    first, count = task.video.first_frame, len(task.setup.balls)
    for number, ball, *place in task.setup.corrections:
        if not 0 <= number - first < len(sample.times):
            last = first + len(sample.times) - 1
            raise broken("unused_correction", {"frame": number, "first": first, "last": last})
        if ball > count:
            raise broken("correction_of_none", {"ball": ball, "frame": number})
        places.setdefault(number - first, {})[ball - 1] = np.array(place)
    steadier = task.video.steadier

    def placed(number: int) -> dict[int, np.ndarray]:
        fixed = places.get(number, {})
        if isinstance(steadier, Steadier):
            return {ball: steadier.place(number, place) for ball, place in fixed.items()}
        return fixed

    return placed


def _circle_of(task: Task, seen: Positions) -> Circle | Sentence:
    """Return the circle about a pivot that is not seen, or why it cannot be believed."""
    video, setup, optics = task.video, task.setup, task.setup.optics
    size = video.width, video.height
    clean = np.where((seen.flags == "ok")[..., None], seen.centres, np.nan)
    places = undistorted(clean, size, optics)
    declared = None if setup.pivot is None else np.array(setup.pivot)
    has_lens = bool(optics.lens_k1 or optics.lens_k2)
    circle = unseen_circle(places, size, declared=declared, has_lens=has_lens)
    doubt = doubt_about(seen.times, places, circle)
    if doubt is not None:
        return doubt
    assert circle is not None  # which is a doubt
    return circle


def _check_motion(seen: Positions, clean: float) -> None:
    """Refuse what hardly leaves its place and is often lost if it leaps about instead of swinging.

    From frame to frame a swing goes less far than it goes in all; noise goes farther.
    """
    follows = seen.is_measured[1:] & seen.is_measured[:-1]
    if clean > _SELDOM or not follows.any():
        return
    steps, places = np.diff(seen.centres, axis=0)[follows], seen.centres[seen.is_measured]
    middle = places.mean(axis=0)
    step, scatter = (
        float(np.sqrt(np.mean(np.sum(away**2, axis=-1)))) for away in (steps, places - middle)
    )
    if step > scatter:
        values = {"place": place_text(middle), "scatter": f"{scatter:.1f}"}
        raise broken("jumping_ball", values)


def _believed(
    task: Task, sample: Sample, route: Route, seen: Positions, radius: float | None = None
) -> Positions:
    """Return a track without the samples that are not to be believed, or refuse it as a whole."""
    if isinstance(task.video.steadier, Steadier):
        unknown = np.isnan(task.video.steadier.deviations(len(seen.times)))
        seen.give_up(np.broadcast_to(unknown[:, None], seen.flags.shape))
    # A repeated picture need not be measured, so it does not count.
    share = float(seen.is_measured[~sample.repeats].mean())
    factor = task.setup.slow_motion
    pace = said("wrong_pace", factor=factor)
    clean = seen.clean_share(~sample.repeats)
    if share < _NEVER or clean < _HARDLY:
        shares = {"percent": f"{100.0 * share:.0f}", "clean": f"{100.0 * clean:.0f}"}
        place = {"place": place_text(*task.setup.balls), "frame": task.setup.click_frame}
        error = _fault(route, "rarely_found", {**place, **shares})
        if factor != 1.0:
            error.add_way_out(pace)
        raise error
    balls = [np.array(ball) for ball in task.setup.balls]
    for finding in examine(sample, seen, balls, radius):
        if finding.is_refusal:
            raise finding.fault
        task.warnings.append(joined([finding.fault.rule, finding.fault.way_out or ""], "; "))
        if finding.doubtful is not None:
            seen.give_up(finding.doubtful)
    share = float(seen.is_measured[~sample.repeats].mean())
    if factor != 1.0 and share < _OFTEN:
        percent = f"{100.0 * share:.0f}"
        task.warnings.append(said("hard_to_follow", percent=percent, advice=pace))
    elif seen.clean_share(~sample.repeats) < _SELDOM:
        task.warnings.append(seen.gaps_text(~sample.repeats))
    return seen


def _calibrated(
    task: Task, sample: Sample, scene: ImageModel, seen: Positions, circle: Circle | None = None
) -> Calibration:
    """Return angles about the hinge, or about the centre of a circle where no pivot is seen."""
    video, setup = task.video, task.setup
    if not scene.pivot.is_still:
        seen.pivots = unsmeared(seen.times, seen.pivots, scene.look.exposure * sample.interval)
    size = video.width, video.height
    sigma = sigma_of_pivot(scene.arm, is_clicked=not setup.is_pivot_found)
    measured = calibrate(
        seen, size, rotation=video.rotation, optics=setup.optics, circle=circle, pivot_sigma=sigma
    )
    if isinstance(video.steadier, Steadier):
        places = video.steadier.deviations(len(seen.times))
        measured.sigmas = np.hypot(measured.sigmas, places[:, None] / measured.hinge.arm)
    stiffness = setup.gravity / setup.length if setup.length else None
    swing = measured.gravity.swing
    task.warnings += pace_warnings(measured.motion, swing, stiffness, setup.slow_motion)
    measured.sigmas = np.hypot(measured.sigmas, scene.unsure / measured.hinge.arm)
    if scene.look.is_spinning and scene.look.body is None:
        share = _PATTERN + _UNEXPLAINED * (1.0 - scene.explained)
        unsure = share * scene.look.radius / measured.hinge.arm
        measured.sigmas = np.hypot(measured.sigmas, unsure)
        task.warnings.append(said("turning_pattern", off=1e3 * unsure))
    return measured


def _check_distances(
    sample: Sample, geometry: Geometry, route: Route, arm: float | None = None
) -> np.ndarray:
    """Refuse balls that are often off the circle, or oval, about the pivot, by their rough path.

    Its radius is the `arm` [pixels], or before that is learned their typical distance. Returns
    their distances in the sample, shape (place,) [pixels].
    """
    places, shown_in = route.seen_in(sample.from_click)
    if not len(places):
        return np.empty(0)
    pivots = geometry.pivots[shown_in]
    distances = np.linalg.norm(geometry.tilt.flat(places - pivots), axis=-1)
    arm = arm or float(np.median(distances))
    if np.mean(np.abs(distances - arm) > max(route.radius, _OFF * arm)) < _ASTRAY:
        return np.asarray(distances)
    low, high = (f"{end:.0f}" for end in np.quantile(np.hypot(*(places - pivots).T), [0.05, 0.95]))
    place = place_text(np.median(pivots, axis=0))
    raise _fault(route, "other_pivot", {"low": low, "high": high, "place": place})


def _fault(route: Route, rule: str, values: dict[str, Any]) -> InputError:
    """Return why what was followed is no ball that swings: a rod is none for a simpler reason."""
    return broken("long_and_thin") if route.is_rod else broken(rule, values)
