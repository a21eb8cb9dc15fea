"""A video becomes a table of angles about the moving pivot."""

from __future__ import annotations

import math
import warnings as alarms
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.atomic import checked_path
from latolato.core.errors import InputError, reading
from latolato.core.quantities import POSITIVE, QUANTITIES
from latolato.core.registry import checked_number
from latolato.experiment.calibration.calibrate import Calibration, calibrate, unsmeared
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.sidecar import (
    Setup,
    checked_place,
    read_sidecar,
    with_changes,
    write_sidecar,
)
from latolato.experiment.track_table import track_table
from latolato.experiment.tracking.follow import follow
from latolato.experiment.tracking.gate import examine
from latolato.experiment.tracking.learn import ImageModel, learn_image_model
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.propose import proposal_text, propose
from latolato.experiment.tracking.sample import Sample, read_sample
from latolato.experiment.tracking.wander import follow_path, period_of
from latolato.experiment.video import Limits, Video, digest_of, open_video

if TYPE_CHECKING:
    import xarray as xr

Place = Sequence[float]
Progress = Callable[[float], None]
# Difference of declared and measured radius that is worth a warning.
_RADIUS_TOLERANCE = 0.03
# Frames that a whole file may declare and not show.
_FEW_MISSING = 3
# Shares of samples below which no ball was followed, and hardly one.
_NEVER, _SELDOM = 0.25, 0.5
# Fewest frames that show a motion.
_FEWEST = 8
# Error of a ball's place where its pattern resembles the background, as a share of its radius:
# where the colours learned explain all of the ball, and how much more where they explain nothing.
# Synthetic clips: 0.04 to 0.06 where they explain nine tenths, 0.12 where they explain a quarter.
_PATTERN, _UNEXPLAINED = 0.05, 0.1
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
    length: float | None = None,
    radius: float | None = None,
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
        Column and row of the pivot in the first frame as displayed [pixels].
    balls : int or sequence of sequence of float, optional
        How many balls swing, 1 or 2; or column and row of each ball's centre in the first frame.
        What is not pointed at is found in the video, and a warning names it.
    length : float, optional
        From pivot to ball centre [m]: the scale of the picture. Without it angles are known, and
        positions in pixels only (columns ``pivot_u``, ``ball_1_u`` and so on).
    radius : float, optional
        Radius of a ball [m], which is checked against the length's scale.
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
        One row per decoded frame on the dimension ``frame``: ``time``, positions of pivot and balls
        [m] with the origin at the mean pivot and y up, ``angle_1`` from the direction of gravity
        about the moving pivot [rad], its ``angle_sigma_1`` and ``flag_1``, and the same of a second
        ball; ball 1 is the right-hand one. Flags are ok, collision (balls touch), occluded (partly
        hidden), predicted (carried on by the equation of motion) and lost. The attribute
        ``geometry`` is ``metric``; ``angles`` without a length; ``unknown`` without a pivot in the
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
        For a set-up that was read, what was found instead of pointed at, a radius that does not fit
        the length, a path that is no circle, an unknown direction of gravity, an unknown geometry.

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
        "length": length,
        "radius": radius,
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
    for name in ("length", "radius", "gravity"):
        if settings.get(name) is not None:
            checked_number(name, settings[name], POSITIVE, QUANTITIES[name].unit)
    slower = settings.get("slow_motion")
    video = open_video(
        path, slow_motion=1.0 if slower is None else slower, limits=settings.get("limits")
    )
    clicks = None if isinstance(balls, int) or balls is None else list(balls)
    count = balls if isinstance(balls, int) else len(clicks) if clicks else None
    if count is not None and count not in (1, 2):
        raise InputError("must be 1 or 2", parameter="balls", value=count)
    with reading(path):
        if pivot is None and clicks is None and sidecar is not None and Path(sidecar).is_file():
            setup = with_changes(read_sidecar(sidecar, path), settings)
            if count is not None and count != len(setup.balls):
                raise InputError(
                    f"'{sidecar}' is made for {len(setup.balls)} balls, not {count}",
                    way_out="remove it, or point at pivot and balls",
                )
            video = open_video(path, slow_motion=setup.slow_motion, limits=setup.limits)
            messages = [proposal_text(setup)] if setup.is_proposed else []
            return Task(video, _checked(setup, video), warnings=messages, setup_file=Path(sidecar))
        setup = Setup(
            pivot=None if pivot is None else checked_place("pivot", pivot),
            balls=tuple(checked_place("ball", ball) for ball in clicks or ()),
        )
        setup = with_changes(_checked(setup, video), settings)
        if pivot is not None and clicks is not None:
            return Task(video, setup)
        sample = _sample_of(video, progress)
        proposal, size = propose(
            video, sample, pivot=pivot, balls=clicks, count=count, optics=setup.optics
        )
        setup = with_changes(proposal, settings)
        return Task(video, setup, sample, [proposal_text(setup)], size)


def run(task: Task, progress: Progress | None = None) -> xr.Dataset:
    """Return the track table of a prepared video; what is to be warned of joins the task's list."""
    video, pivot = task.video, task.setup.pivot
    with reading(video.path):
        sample = task.sample or _sample_of(video, progress)
        balls = [np.array(ball) for ball in task.setup.balls]
        if pivot is None:
            table = _wandered(task, sample, balls, progress)
        else:
            table = _tracked(task, sample, np.array(pivot), balls, progress)
    if progress:
        progress(1.0)
    missing = video.frame_count - table.sizes["frame"]
    if missing > _FEW_MISSING:
        task.warnings.append(
            f"{missing} of the {video.frame_count} frames that the file declares could not be "
            "decoded: is it whole?"
        )
    if task.warnings:
        # One text, whose parts a semicolon tells apart.
        task.warnings[:] = [text.replace("; ", ", ") for text in task.warnings]
        table.attrs["warnings"] = "; ".join(task.warnings)
    return table


def _sample_of(video: Video, progress: Progress | None) -> Sample:
    """Return the first reading of a video that shows a motion."""
    sample = read_sample(video, progress and (lambda share: progress(_READ * share)))
    if len(sample.times) < _FEWEST:
        raise InputError(f"it has {len(sample.times)} frames, a motion needs {_FEWEST} or more")
    return sample


def _checked(setup: Setup, video: Video) -> Setup:
    """Return a set-up whose places lie inside the frame."""
    named = [("ball", place) for place in setup.balls]
    if setup.pivot is not None:
        named.insert(0, ("pivot", setup.pivot))
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
    length, radius = setup.length, setup.radius
    arm = float(np.mean([np.hypot(*(ball - pivot)) for ball in balls]))
    expected = radius / length * arm if radius and length else None
    if min(np.hypot(*(ball - pivot)) for ball in balls) < 8.0:
        raise InputError("pivot and ball must lie apart, 8 pixels or more")
    scene = learn_image_model(
        video, sample, pivot, balls, expected, _part(progress, _READ, _LEARNED)
    )
    if expected and abs(scene.look.radius / expected - 1.0) > _doubt(scene):
        # A declared radius that is wrong may lead astray: without it more may be explained.
        try:
            free = learn_image_model(video, sample, pivot, balls, None, None)
        except InputError:
            free = scene
        if free.explained > scene.explained:
            scene = free
    stiffness = setup.gravity / length if length else 0.0
    seen = follow(video, sample, scene, stiffness, _part(progress, _LEARNED, 1.0))
    share = float(seen.is_measured.mean())
    if share == 0.0:
        raise InputError(
            "the ball was found in no frame", way_out="point at its centre in the first frame"
        )
    if share < _NEVER:
        raise InputError(
            f"what was pointed at as a ball is found in {100.0 * share:.0f} % of the samples only",
            way_out="point at the ball's centre in the first frame",
        )
    declared = radius / length * scene.arm if radius and length else None
    _examine(task, sample, seen, balls, declared)
    share = float(seen.is_measured.mean())
    if share < _SELDOM:
        task.warnings.append(
            f"the ball was measured in only {100.0 * share:.0f} % of the samples: look at the "
            "overlay"
        )
    if not scene.pivot.is_still:
        seen.pivots = unsmeared(seen.times, seen.pivots, scene.look.exposure * sample.interval)
    measured = calibrate(seen, (video.width, video.height), video.rotation, setup.optics)
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
    return _RADIUS_TOLERANCE + scene.look.radius_sigma / scene.look.radius


def _part(progress: Progress | None, low: float, high: float) -> Progress | None:
    """Return a progress that goes from one share of the work to another."""
    if progress is None:
        return None
    tell = progress
    return lambda share: tell(low + (high - low) * share)


def _table(task: Task, scene: ImageModel, seen: Positions, measured: Calibration) -> xr.Dataset:
    """Return the table in metres, or in pixels where the length is unknown."""
    length, radius = task.setup.length, task.setup.radius
    task.warnings += measured.warnings
    scale = length / measured.hinge.arm if length else math.nan
    measured_radius = scene.look.radius * scale
    turn = measured.gravity.direction
    right = np.array([math.cos(turn), -math.sin(turn)])
    down = np.array([math.sin(turn), math.cos(turn)])
    origin = np.nanmean(measured.pivots, axis=0)

    def metres(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        away = (places - origin) * scale
        return away @ right, -(away @ down)

    columns: dict[str, Any] = {"time": seen.times}
    columns["pivot_x"], columns["pivot_y"] = metres(measured.pivots)
    if not length:
        columns["pivot_u"], columns["pivot_v"] = measured.pivots.T
        task.warnings.append(
            "the length is unknown: positions are in pixels only; give the length for the scale"
        )
    for b in range(seen.centres.shape[1]):
        columns[f"ball_{b + 1}_x"], columns[f"ball_{b + 1}_y"] = metres(measured.centres[:, b])
        columns[f"angle_{b + 1}"] = measured.angles[:, b]
        columns[f"angle_sigma_{b + 1}"] = measured.sigmas[:, b]
        columns[f"flag_{b + 1}"] = seen.flags[:, b]
        if not length:
            columns[f"ball_{b + 1}_u"], columns[f"ball_{b + 1}_v"] = measured.centres[:, b].T
    if radius and length and abs(measured_radius / radius - 1.0) > _doubt(scene):
        task.warnings.append(
            f"the balls' radius is {measured_radius * 1e3:.2f} mm by the length's scale, declared "
            f"were {radius * 1e3:.2f} mm: is the length from pivot to ball centre right?"
        )
    attributes = {
        **_declared(task, "metric" if length else "angles"),
        "metres_per_pixel": scale if length else None,
        "measured_radius": measured_radius if length else None,
        "measured_radius_sigma": scene.look.radius_sigma * scale if length else None,
        "radius_pixels": scene.look.radius,
        "origin_u": float(origin[0]),
        "origin_v": float(origin[1]),
        "gravity_direction": measured.gravity.direction,
        "gravity_source": measured.gravity.source,
        "angle_offset_sigma": measured.angle_offset_sigma,
        "exposure": scene.look.exposure,
        "pivot_offset_x": float(measured.hinge.offset[0]),
        "pivot_offset_y": float(measured.hinge.offset[1]),
        "pivot_offset_x_sigma": float(measured.hinge.sigma[0]),
        "pivot_offset_y_sigma": float(measured.hinge.sigma[1]),
        "arm_pixels": measured.hinge.arm,
        "arc": measured.hinge.arc,
        "circle_residual": measured.hinge.residual,
    }
    return track_table(columns, attributes)


def _wandered(
    task: Task, sample: Sample, balls: list[np.ndarray], progress: Progress | None
) -> xr.Dataset:
    """Return the table of balls about an unseen pivot: their places in the image, no angles."""
    path = follow_path(task.video, sample, balls, _part(progress, _READ, 1.0))
    _examine(task, sample, path, balls)
    columns: dict[str, Any] = {"time": path.times}
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
