"""A video becomes a table of angles about the moving pivot."""

from __future__ import annotations

import math
import warnings as alarms
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.atomic import checked_path
from latolato.core.errors import InputError, reading
from latolato.experiment.calibration.calibrate import Calibration, calibrate, unsmeared
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.calibration.scale import Scale, scale_of, stick_pixels
from latolato.experiment.parameters import VIDEO_PARAMETERS
from latolato.experiment.sidecar import (
    Setup,
    checked_place,
    checked_region,
    checked_stick,
    read_sidecar,
    with_changes,
    write_sidecar,
)
from latolato.experiment.track_table import track_table
from latolato.experiment.tracking.appearance import Look
from latolato.experiment.tracking.follow import follow
from latolato.experiment.tracking.gate import examine
from latolato.experiment.tracking.learn import ImageModel, learn_image_model
from latolato.experiment.tracking.learn_template import learn_template_model
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.propose import proposal_text, propose
from latolato.experiment.tracking.sample import Sample, read_sample
from latolato.experiment.tracking.wander import follow_path, period_of
from latolato.experiment.video import Limits, Video, digest_of, open_video

if TYPE_CHECKING:
    import xarray as xr

Place = Sequence[float]
Progress = Callable[[float], None]
# Share by which a declared size must differ from the measured one to be worth a warning.
_TOLERANCE = 0.03
# Frames that a whole file may declare and not show.
_FEW_MISSING = 3
# Shares of samples below which no ball was followed, and hardly one.
_NEVER, _SELDOM = 0.25, 0.4
# Fewest frames that show a motion.
_FEWEST = 8
# Error of a ball's place where its pattern resembles the background, as a share of its radius:
# where the colours learned explain all of the ball, and how much more where they explain nothing.
# Synthetic clips: 0.04 to 0.06 where they explain nine tenths, 0.12 where they explain a quarter.
_PATTERN, _UNEXPLAINED = 0.05, 0.1
# Half the side of a template over the radius of the bob.
_PATCH = 1.4
# Shares of the work: the first reading, learning the scene.
_READ, _LEARNED = 0.25, 0.35


@dataclass
class Task:
    """A video that is ready to be tracked."""

    video: Video
    setup: Setup
    sample: Sample | None = None
    warnings: list[str] = field(default_factory=list)
    radius: float | None = None
    # Where the set-up was read from, None if it was given or found.
    setup_file: Path | None = None


def track(
    path: str | Path,
    *,
    pivot: Place | None = None,
    balls: int | Sequence[Place] | None = None,
    start: float | None = None,
    end: float | None = None,
    click_frame: int | None = None,
    region: Sequence[float] | None = None,
    length: float | None = None,
    radius: float | None = None,
    stick: Sequence[Place] | None = None,
    stick_length: float | None = None,
    shape: str | None = None,
    patch: float | None = None,
    gravity: float | None = None,
    optics: Optics | None = None,
    slow_motion: float | None = None,
    limits: Limits | None = None,
    sidecar: str | Path | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return where pivot and balls are in every frame of a video, with angles and their errors.

    Parameters
    ----------
    path : str or Path
        The video.
    pivot : sequence of float, optional
        Column and row of the pivot in the clicked frame as displayed [pixels].
    balls : int or sequence of sequence of float, optional
        How many balls swing, 1 or 2; or column and row of each ball's centre in the clicked frame.
        What is not pointed at is found in the video, and a warning names it.
    start, end : float, optional
        First and last instant used, as in the column ``time`` [s].
    click_frame : int, optional
        Number of the clicked frame: that in which pivot and balls are pointed at, or found. The
        first one of the file is 0; by default it is the first one used.
    region : sequence of float, optional
        Left, top, right and bottom of the part of the picture in which balls are looked for
        [pixels]; the pivot may lie outside.
    length : float, optional
        From pivot to ball centre [m]: the scale of the picture. Without it the scale is that of
        the stick, without that one of the radius; the others are checked against it. Without any,
        angles are known, and positions in pixels only (columns ``pivot_u``, ``ball_1_u`` and so
        on).
    radius : float, optional
        Radius of a ball [m].
    stick : sequence of sequence of float, optional
        Column and row of both ends of a stick of known length, in the plane of the swing
        [pixels].
    stick_length : float, optional
        Its length [m].
    shape : str, optional
        How balls are recognised: as a ``"disc"``, the default, or by a ``"template"`` of what was
        pointed at, which turns with the pendulum: rings, blocks, bottles.
    patch : float, optional
        Side of the square about the click that the template is made of [pixels]. By default 2.8
        radii, where radius and scale are known, else 0.3 of the distance from pivot to click.
    gravity : float, optional
        Gravitational acceleration [m/s^2], by default 9.8.
    optics : Optics, optional
        Row time of a rolling shutter and radial distortion of the lens.
    slow_motion : float, optional
        How many times slower than life the video plays: 8 for 240 Hz played at 30 Hz.
    limits : Limits, optional
        Largest duration, size and memory that a video may ask for.
    sidecar : str or Path, optional
        Keeps the set-up. It is read if it exists and neither pivot nor balls are pointed at; it is
        always written. What is given here as well replaces what a sidecar says. Without it the
        set-up of no earlier table is used.
    progress : callable, optional
        Called with the fraction done, from 0 to 1.

    Returns
    -------
    xarray.Dataset
        One row per frame used on the dimension ``frame``: ``time``, positions of pivot and balls
        [m] with the origin at the mean pivot and y up, ``angle_1`` from the direction of gravity
        about the moving pivot [rad], its ``angle_sigma_1`` and ``flag_1``, and the same of a second
        ball; ball 1 is the right-hand one. Flags are ok, collision (balls touch), occluded (partly
        hidden), predicted (carried on by the equation of motion) and lost. The attribute
        ``geometry`` is ``metric``; ``angles`` without a scale; ``unknown`` without a pivot in the
        picture, where angles are NaN, flags are about the ball's image alone, and ``period`` and
        ``period_sigma`` [s] come from its path. ``warnings`` repeats what was warned of.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    InputError
        If it is no video, cannot be decoded, exceeds a limit, has time stamps that do not increase,
        a place lies outside the frame, no ball is found, what was followed is not the ball, the
        camera moves, or the sidecar is another video's.
        Without the extra `video`.

    Warns
    -----
    RuntimeWarning
        For a set-up that was read, what was found instead of pointed at, a radius or a stick that
        does not fit the scale, a path that is no circle, an unknown direction of gravity, an
        unknown geometry.

    Notes
    -----
    Pivot and balls are layers fitted to each frame in linear light, with the equation of motion as
    the prediction; balls cannot pass each other. The track must pass the checks of
    `latolato.experiment.tracking.gate`. It can miss: balls of other sizes or colours than each
    other, a perspective that is not seen in the circle, and what each of the checks can miss.

    See Also
    --------
    latolato.experiment.track_table.write_table : Writes the table.
    """
    path = checked_path("path", path)
    settings = {
        "start": start,
        "end": end,
        "click_frame": click_frame,
        "region": None if region is None else checked_region(region),
        "length": length,
        "radius": radius,
        "stick": None if stick is None else checked_stick(stick),
        "stick_length": stick_length,
        "shape": shape,
        "patch": patch,
        "gravity": gravity,
        "optics": optics,
        "slow_motion": slow_motion,
        "limits": limits,
    }
    task = prepare(path, pivot, balls, settings, sidecar, progress)
    table = run(task, progress)
    if sidecar is not None:
        write_sidecar(task.setup, path, sidecar)
    if task.setup_file is not None:
        alarms.warn(f"set-up read from {task.setup_file}", RuntimeWarning, stacklevel=2)
    for text in task.warnings:
        alarms.warn(text, RuntimeWarning, stacklevel=2)
    return table


def prepare(
    path: Path,
    pivot: Place | None,
    balls: int | Sequence[Place] | None,
    settings: dict[str, Any],
    sidecar: str | Path | None = None,
    progress: Progress | None = None,
) -> Task:
    """Return what is to be tracked: as pointed at, as a sidecar says, or as found in the video."""
    for name, value in settings.items():
        if value is not None and name in VIDEO_PARAMETERS:
            VIDEO_PARAMETERS[name].checked(value)
    clicks = None if isinstance(balls, int) or balls is None else list(balls)
    count = balls if isinstance(balls, int) else len(clicks) if clicks else None
    if count is not None and count not in (1, 2):
        raise InputError("must be 1 or 2", parameter="balls", value=count)
    with reading(path):
        if pivot is None and clicks is None and sidecar is not None and Path(sidecar).is_file():
            stored = read_sidecar(sidecar, path)
            if settings.get("click_frame") not in (None, stored.click_frame):
                raise InputError(
                    f"is {stored.click_frame} in '{sidecar}', which has the places of that frame",
                    parameter="click_frame",
                    way_out="remove the file, or point at pivot and balls",
                )
            setup = with_changes(stored, settings)
            if count is not None and count != len(setup.balls):
                raise InputError(
                    f"'{sidecar}' is made for {len(setup.balls)} balls, not {count}",
                    way_out="remove it, or point at pivot and balls",
                )
            video = _video_of(path, setup)
            messages = [proposal_text(setup)] if setup.is_proposed else []
            return Task(video, _checked(setup, video), warnings=messages, setup_file=Path(sidecar))
        setup = Setup(
            pivot=None if pivot is None else checked_place("pivot", pivot),
            balls=tuple(checked_place("ball", ball) for ball in clicks or ()),
        )
        setup = with_changes(setup, settings)
        video = _video_of(path, setup)
        if settings.get("click_frame") is None:
            setup = replace(setup, click_frame=video.first_frame)
        setup = _checked(setup, video)
        if pivot is not None and clicks is not None:
            return Task(video, setup)
        sample = _sample_of(video, setup, progress)
        proposal, size = propose(
            video, sample, pivot=pivot, balls=clicks, count=count, optics=setup.optics
        )
        setup = replace(setup, pivot=proposal.pivot, balls=proposal.balls, is_proposed=True)
        return Task(video, setup, sample, [proposal_text(setup)], size)


def run(task: Task, progress: Progress | None = None) -> xr.Dataset:
    """Return the track table of a prepared video; what is to be warned of joins the task's list."""
    video, pivot = task.video, task.setup.pivot
    with reading(video.path):
        sample = task.sample or _sample_of(video, task.setup, progress)
        balls = [np.array(ball) for ball in task.setup.balls]
        if pivot is None:
            table = _wandered(task, sample, balls, progress)
        else:
            table = _tracked(task, sample, np.array(pivot), balls, progress)
    if progress:
        progress(1.0)
    missing = video.expected_count - table.sizes["frame"]
    if missing > _FEW_MISSING and video.end == math.inf:
        task.warnings.append(
            f"{missing} of the {video.expected_count} frames that the file declares could not be "
            "decoded: is it whole?"
        )
    if task.warnings:
        # One text, whose parts a semicolon tells apart.
        task.warnings[:] = [text.replace("; ", ", ") for text in task.warnings]
        table.attrs["warnings"] = "; ".join(task.warnings)
    return table


def _video_of(path: Path, setup: Setup) -> Video:
    """Return the part of a video that a set-up names."""
    start = -math.inf if setup.start is None else setup.start
    end = math.inf if setup.end is None else setup.end
    if not start < end:
        raise InputError(f"must lie after start ({start:g} s)", parameter="end", value=end)
    video = open_video(
        path, slow_motion=setup.slow_motion, limits=setup.limits, start=start, end=end
    )
    return replace(video, region=setup.region)


def _sample_of(video: Video, setup: Setup, progress: Progress | None) -> Sample:
    """Return the first reading of a video that shows a motion."""
    tell = progress and (lambda share: progress(_READ * share))
    sample = read_sample(video, tell, setup.click_frame - video.first_frame)
    if len(sample.times) < _FEWEST:
        raise InputError(f"it has {len(sample.times)} frames, a motion needs {_FEWEST} or more")
    return sample


def _checked(setup: Setup, video: Video) -> Setup:
    """Return a set-up that is complete, with places in the frame and balls in the region."""
    if (setup.stick is None) != (setup.stick_length is None):
        missing = "stick" if setup.stick is None else "stick_length"
        raise InputError(f"{missing} is missing: both ends of a stick and its length are needed")
    named = [("ball", place) for place in setup.balls]
    named += [("end of the stick", place) for place in setup.stick or ()]
    if setup.pivot is not None:
        named.insert(0, ("pivot", setup.pivot))
    if setup.region is not None:
        left, top, right, bottom = setup.region
        named += [("corner of the region", corner) for corner in ((left, top), (right, bottom))]
        for u, v in setup.balls:
            if not (left <= u <= right and top <= v <= bottom):
                raise InputError(
                    f"ball at ({u:g}, {v:g}) lies outside the region from ({left:g}, {top:g}) to "
                    f"({right:g}, {bottom:g})"
                )
    for name, (u, v) in named:
        if not (0 <= u <= video.width - 1 and 0 <= v <= video.height - 1):
            raise InputError(
                f"{name} at ({u:g}, {v:g}) lies outside the frame of {video.width} x "
                f"{video.height} pixels"
            )
    return setup


def _tracked(
    task: Task,
    sample: Sample,
    pivot: np.ndarray,
    balls: list[np.ndarray],
    progress: Progress | None,
) -> xr.Dataset:
    """Return the table about a pivot in the picture."""
    video, setup = task.video, task.setup
    size, radius = (video.width, video.height), setup.radius
    arm = float(np.mean([np.hypot(*(ball - pivot)) for ball in balls]))
    scale = scale_of(setup, size, (arm, 0.0))
    expected = radius / scale.metres if radius and scale else None
    if min(np.hypot(*(ball - pivot)) for ball in balls) < 8.0:
        raise InputError("pivot and ball must lie apart, 8 pixels or more")
    tell = _part(progress, _READ, _LEARNED)
    if setup.shape == "template":
        half = 0.5 * setup.patch if setup.patch else _PATCH * expected if expected else None
        scene = learn_template_model(video, sample, pivot, balls, half, tell)
    else:
        scene = learn_image_model(video, sample, pivot, balls, expected, tell)
    if (
        setup.shape == "disc"
        and expected
        and abs(scene.look.radius / expected - 1.0) > _doubt(scene)
    ):
        # A declared radius that is wrong may lead astray: without it more may be explained.
        try:
            free = learn_image_model(video, sample, pivot, balls, None, None)
        except InputError:
            free = scene
        if free.explained > scene.explained:
            scene = free
    scale = scale_of(setup, size, (scene.arm, 0.0), (scene.look.radius, 0.0))
    stiffness = setup.gravity / (scale.metres * scene.arm) if scale else 0.0
    seen = follow(video, sample, scene, stiffness, _part(progress, _LEARNED, 1.0))
    share = float(seen.is_measured.mean())
    if share == 0.0:
        raise InputError("the ball was found in no frame", way_out="point at its centre")
    if share < _NEVER:
        raise InputError(
            f"what was pointed at as a ball is found in {100.0 * share:.0f} % of the samples only",
            way_out="point at the middle of the ball",
        )
    if share < _SELDOM:
        task.warnings.append(
            f"the ball was measured in only {100.0 * share:.0f} % of the samples: was it pointed "
            "at?"
        )
    declared = radius / scale.metres if radius and scale else None
    _examine(task, sample, seen, balls, declared)
    if not scene.pivot.is_still:
        seen.pivots = unsmeared(seen.times, seen.pivots, scene.look.exposure * sample.interval)
    measured = calibrate(seen, size, video.rotation, setup.optics)
    if scene.look.is_spinning:
        share = _PATTERN + _UNEXPLAINED * (1.0 - scene.explained)
        unsure = share * scene.look.radius / measured.hinge.arm
        measured.sigmas = np.hypot(measured.sigmas, unsure)
        task.warnings.append(
            "the ball has a pattern that turns with it: where the pattern resembles the "
            f"background, angles are off by {1e3 * unsure:.2g} mrad and more"
        )
    return _table(task, scene, seen, measured)


def _examine(
    task: Task,
    sample: Sample,
    seen: Positions,
    clicks: list[np.ndarray],
    radius: float | None = None,
) -> None:
    """Give up samples that are not to be believed, or refuse the track as a whole.

    Warnings join the task's list.
    """
    for finding in examine(sample, seen, clicks, radius):
        if finding.is_refusal:
            raise InputError(finding.reason, way_out=finding.way_out)
        task.warnings.append(f"{finding.reason}; {finding.way_out}")
        if finding.doubtful is not None:
            seen.give_up(finding.doubtful)


def _doubt(scene: ImageModel) -> float:
    """Return by which share the radius measured may differ from that declared."""
    return _TOLERANCE + scene.look.radius_sigma / scene.look.radius


def _part(progress: Progress | None, low: float, high: float) -> Progress | None:
    """Return a progress that goes from one share of the work to another."""
    if progress is None:
        return None
    tell = progress
    return lambda share: tell(low + (high - low) * share)


def _table(task: Task, scene: ImageModel, seen: Positions, measured: Calibration) -> xr.Dataset:
    """Return the table in metres, or in pixels where no scale is known."""
    video, setup, look = task.video, task.setup, scene.look
    size = (video.width, video.height)
    scale = scale_of(setup, size, measured.arm, (look.radius, look.radius_sigma))
    task.warnings += measured.warnings
    metres_per_pixel = scale.metres if scale else math.nan
    turn = measured.gravity.direction
    right = np.array([math.cos(turn), -math.sin(turn)])
    down = np.array([math.sin(turn), math.cos(turn)])
    origin = np.nanmean(measured.pivots, axis=0)

    def metres(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        away = (places - origin) * metres_per_pixel
        return away @ right, -(away @ down)

    columns: dict[str, Any] = _frames(task, seen.times)
    columns["pivot_x"], columns["pivot_y"] = metres(measured.pivots)
    if scale is None:
        columns["pivot_u"], columns["pivot_v"] = measured.pivots.T
        task.warnings.append(
            "the length is unknown: positions are in pixels only; give the length for the scale, "
            "or a stick, or the radius of a ball"
        )
    for b in range(seen.centres.shape[1]):
        columns[f"ball_{b + 1}_x"], columns[f"ball_{b + 1}_y"] = metres(measured.centres[:, b])
        columns[f"angle_{b + 1}"] = measured.angles[:, b]
        columns[f"angle_sigma_{b + 1}"] = measured.sigmas[:, b]
        columns[f"flag_{b + 1}"] = seen.flags[:, b]
        if scale is None:
            columns[f"ball_{b + 1}_u"], columns[f"ball_{b + 1}_v"] = measured.centres[:, b].T
    attributes = _declared(task, "metric" if scale else "angles")
    if scale is not None:
        arm, arm_sigma = measured.arm
        share = math.hypot(scale.share, arm_sigma / arm)
        attributes |= {
            "length": setup.length or arm * scale.metres,
            "length_sigma": None if setup.length else share * arm * scale.metres,
            "scale_source": scale.source,
            "metres_per_pixel": scale.metres,
            "metres_per_pixel_sigma": scale.share * scale.metres,
            "measured_radius": look.radius * scale.metres,
            "measured_radius_sigma": look.radius_sigma * scale.metres,
        }
        _compare(task, scale, look)
    attributes |= {
        "radius_pixels": look.radius,
        "origin_u": float(origin[0]),
        "origin_v": float(origin[1]),
        "gravity_direction": measured.gravity.direction,
        "gravity_source": measured.gravity.source,
        "angle_offset_sigma": measured.angle_offset_sigma,
        "exposure": look.exposure if setup.shape == "disc" else None,
        "pivot_offset_x": float(measured.hinge.offset[0]),
        "pivot_offset_y": float(measured.hinge.offset[1]),
        "pivot_offset_x_sigma": float(measured.hinge.sigma[0]),
        "pivot_offset_y_sigma": float(measured.hinge.sigma[1]),
        "arm_pixels": measured.hinge.arm,
        "arc": measured.hinge.arc,
        "circle_residual": measured.hinge.residual,
    }
    return track_table(columns, attributes)


def _compare(task: Task, scale: Scale, look: Look) -> None:
    """Warn of a radius and a stick that differ from what the scale says."""
    setup, video = task.setup, task.video
    about = "length from pivot to ball centre" if scale.source == "length" else scale.source
    sizes = [("radius of a ball", setup.radius, look.radius, look.radius_sigma)]
    if setup.stick is not None:
        pixels = stick_pixels(setup, (video.width, video.height))
        sizes.append(("stick", setup.stick_length, pixels, math.sqrt(2.0)))
    for name, declared, pixels, sigma in sizes:
        doubt = _TOLERANCE + math.hypot(sigma / pixels, scale.share)
        if declared and abs(pixels * scale.metres / declared - 1.0) > doubt:
            task.warnings.append(
                f"the {name} is {pixels * scale.metres * 1e3:.2f} mm by the scale of the "
                f"{scale.source}, declared were {declared * 1e3:.2f} mm: is the {about} right?"
            )


def _wandered(
    task: Task, sample: Sample, balls: list[np.ndarray], progress: Progress | None
) -> xr.Dataset:
    """Return the table of balls about an unseen pivot: their places in the image, no angles."""
    path = follow_path(task.video, sample, balls, _part(progress, _READ, 1.0))
    _examine(task, sample, path, balls)
    columns: dict[str, Any] = _frames(task, path.times)
    for b in range(len(balls)):
        columns[f"ball_{b + 1}_u"], columns[f"ball_{b + 1}_v"] = path.centres[:, b].T
        columns[f"flag_{b + 1}"] = path.flags[:, b]
    task.warnings.append(
        "no pivot is known: the geometry is unknown, there are no angles, the ball's places are in "
        "pixels; its period is in the table's attributes"
    )
    period, sigma = period_of(path.times, path.centres[:, 0])
    if math.isnan(period):
        task.warnings.append("no period: fewer than three swings were seen")
    attributes = {
        **_declared(task, "unknown"),
        "radius_pixels": path.radius,
        "period": None if math.isnan(period) else period,
        "period_sigma": None if math.isnan(sigma) else sigma,
    }
    return track_table(columns, attributes)


def _frames(task: Task, times: np.ndarray) -> dict[str, Any]:
    """Return the columns that say which frames the rows are of."""
    return {"frame": task.video.first_frame + np.arange(len(times)), "time": times}


def _declared(task: Task, geometry: str) -> dict[str, Any]:
    """Return the attributes that record the request."""
    video, setup = task.video, task.setup
    places = {} if setup.pivot is None else {"pivot": setup.pivot}
    places |= {f"ball_{k + 1}": ball for k, ball in enumerate(setup.balls)}
    clicks = {
        f"{name}_pixel_{axis}": number
        for name, place in places.items()
        for axis, number in zip("uv", place, strict=True)
    }
    return {
        "source": video.path.name,
        "source_sha256": digest_of(video.path),
        "geometry": geometry,
        "start": setup.start,
        "end": setup.end,
        "click_frame": setup.click_frame,
        "shape": setup.shape,
        "region": setup.region and ",".join(f"{edge:g}" for edge in setup.region),
        "length": setup.length,
        "radius": setup.radius,
        "gravity": setup.gravity,
        "slow_motion": setup.slow_motion,
        "row_time": setup.optics.row_time,
        "lens_k1": setup.optics.lens_k1,
        "lens_k2": setup.optics.lens_k2,
        "proposed": int(setup.is_proposed),
        **clicks,
    }
