"""Turns a video into a table of angles about the moving pivot."""

from __future__ import annotations

import math
import warnings as alarms
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from latolato.core.atomic import checked_path
from latolato.core.errors import Sentence, reading
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.follow import PathOnly, follow
from latolato.experiment.rules import said
from latolato.experiment.sidecar import write_sidecar
from latolato.experiment.tabulate import angle_table, path_table
from latolato.experiment.task import Pivot, Place, Progress, Task, prepare, read_task
from latolato.experiment.track_table import MEASURED, balls_of
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.tracking.steady import Steadier
from latolato.experiment.video import Limits, Video

if TYPE_CHECKING:
    import xarray as xr

# Frames that a whole file may declare and not show.
_FEW_MISSING = 3


def track(
    path: str | Path,
    *,
    pivot: Pivot | Sequence[Pivot] | None = None,
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
    corrections: Mapping[int, Mapping[int, Place]] | None = None,
    gravity: float | None = None,
    optics: Optics | None = None,
    slow_motion: float | None = None,
    limits: Limits | None = None,
    sidecar: str | Path | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Track pivot and balls in every frame of a video; return angles with their errors.

    Parameters
    ----------
    path : str or Path
        The video.
    pivot : sequence of float or "outside", or a sequence of two of these, optional
        Column and row of the pivot in the clicked frame as displayed [pixels]. A pivot outside the
        picture must be at rest: declare its position (assumed known to 2 % of its distance from
        the ball), or pass ``"outside"`` to fit it from the arc of the ball. Give two if two balls
        have separate pivots, in the order of the balls if these are pointed at.
    balls : int or sequence of sequence of float, optional
        How many balls swing, 1 or 2; or column and row of each ball's centre in the clicked frame.
        Whatever you do not point at is found in the video, and a warning says where.
    start, end : float, optional
        First and last instant used, as in the column ``time`` [s].
    click_frame : int, optional
        Number of the clicked frame, in which pivot and balls are pointed at or found, counted
        from 0 at the start of the file; by default the first frame used.
    region : sequence of float, optional
        Left, top, right and bottom of the part of the picture in which to look for balls
        [pixels]; the pivot may lie outside.
    length : float, optional
        From pivot to ball centre [m]; it sets the scale of the picture. Without it the stick sets
        the scale, and without a stick the radius; the others are checked against the scale.
        Without any of them, angles are known, but positions only in pixels (columns ``pivot_u``,
        ``ball_1_u`` and so on).
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
        radii if radius and scale are known, otherwise 0.3 of the distance from pivot to click.
    corrections : mapping, optional
        Positions set by hand: ``{frame: {ball: (u, v)}}`` with the number of the frame as in
        the table, the ball's number, and column and row of its centre [pixels]. Tracking continues
        from there. They are added to those of a sidecar.
    gravity : float, optional
        Gravitational acceleration [m/s^2], by default 9.8.
    optics : Optics, optional
        Row time of a rolling shutter and radial distortion of the lens.
    slow_motion : float, optional
        How many times slower than life the video plays: 8 for 240 Hz played at 30 Hz. By default
        the factor that the file declares unambiguously, otherwise 1.
    limits : Limits, optional
        Largest duration, size and memory that a video may need.
    sidecar : str or Path, optional
        File that keeps the set-up. It is read if it exists and neither pivot nor balls are pointed
        at; it is always written. Arguments given here override the sidecar. Without it no earlier
        set-up is used.
    progress : callable, optional
        Called with the fraction done, from 0 to 1.

    Returns
    -------
    xarray.Dataset
        One row per frame used on the dimension ``frame``: ``time``, positions of pivot and balls
        [m] with the origin at the mean pivot and y up, ``angle_1`` from the direction of gravity
        about the moving pivot [rad], its ``angle_sigma_1`` and ``flag_1``, and the same of a second
        ball; ball 1 is the right-hand one. Flags are ok, collision (balls touch), occluded (partly
        hidden), manual (set by hand, to 1 pixel), predicted (on a smooth curve through a short gap)
        and lost. The attribute
        ``geometry`` is ``metric``; ``angles`` without a scale; ``unknown`` where no pivot is in
        the picture and the arc does not show one at rest: angles are then NaN, flags are about the
        ball's image alone, and ``period`` and ``period_sigma`` [s] come from its path.
        ``pivot_source`` is ``picture``, ``paths`` (nothing in the picture shows how the pivot
        moves, but the paths of the balls do), ``declared`` (out of the picture) or ``arc``; with
        the last two all angles share the relative error ``angle_scale_sigma``, which is in no
        ``angle_sigma_1``. The second ball's own pivot has columns ``pivot_2_x`` and so on, and
        attributes that end in ``_2``. ``warnings`` repeats the warnings.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    InputError
        If the file is not a video, cannot be decoded, exceeds a limit or has time stamps that do
        not increase; if a ball lies outside the frame or a pivot too far from it; if no ball is
        found, or the tracked object is not the ball; if the camera moves; if one length cannot fit
        two balls on separate pivots; or if the sidecar belongs to another video. If the extra
        `video` is missing.

    Warns
    -----
    RuntimeWarning
        For a set-up that was read, positions that were found instead of pointed at, a radius or a
        stick that does not fit the scale, a path that is not a circle, an unknown direction
        of gravity, or an unknown geometry.

    See Also
    --------
    latolato.experiment.track_table.write_table : Writes the table.

    Notes
    -----
    What moves is linked through the whole clip first; then pivot and balls are layers fitted to
    each frame in linear light, from there. Balls cannot pass each other. The track must pass the
    checks of `latolato.experiment.tracking.gate`. It can miss two balls of different sizes, two
    bobs that are no discs and look different, a perspective that the circle does not show, and
    what each of the checks can miss.
    """
    path = checked_path("path", path)
    settings = {
        "start": start,
        "end": end,
        "click_frame": click_frame,
        "region": region,
        "length": length,
        "radius": radius,
        "stick": stick,
        "stick_length": stick_length,
        "shape": shape,
        "patch": patch,
        "corrections": tuple(
            (frame, ball, *place)
            for frame, places in (corrections or {}).items()
            for ball, place in places.items()
        ),
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


def run(task: Task, progress: Progress | None = None) -> xr.Dataset:
    """Return the track table of a prepared video; what is to be warned of joins the task's list."""
    with reading(task.video.path):
        if task.sample is None:
            task.video, task.sample = read_task(task.video, task.setup, progress)
        sample = task.sample
        found = follow(task, sample, progress)
        if isinstance(found, PathOnly):
            table = path_table(task, sample, found)
        else:
            table = angle_table(task, found)
    if isinstance(task.video.steadier, Steadier):
        pixels = f"{task.video.steadier.moved:.1f}"
        task.warnings.append(said("moving_camera_corrected", pixels=pixels))
        table.attrs["camera_motion"] = task.video.steadier.moved
    task.warnings += _frame_warnings(task.video, sample, table)
    if task.warnings:
        task.warnings[:] = dict.fromkeys(task.warnings)
        # One text, whose parts a semicolon tells apart.
        table.attrs["warnings"] = "; ".join(text.replace("; ", ", ") for text in task.warnings)
    if progress:
        progress(1.0)
    return table


def _frame_warnings(video: Video, sample: Sample, table: xr.Dataset) -> list[Sentence]:
    """Return warnings of frames that repeat or are missing, and of an unsure pace."""
    result = []
    repeats = _telling_repeats(table, sample.repeats)
    if repeats:
        rule = "repeated_frame" if repeats == 1 else "repeated_frames"
        times = said("even_times") if sample.is_converted else ""
        result.append(said(rule, count=repeats, times=times))
    if sample.gaps.any():
        count, longest = int(sample.gaps.sum()), np.diff(sample.times).max()
        rule = "missing_frame" if count == 1 else "missing_frames"
        result.append(said(rule, count=count, gap=longest))
    missing = video.expected_count - table.sizes["frame"]
    if missing > _FEW_MISSING and video.end == math.inf:
        rule = "cut_off" if video.is_cut_off else "not_decoded"
        result.append(said(rule, count=missing, total=video.expected_count))
    clock = video.clock
    if video.slow_motion == 1.0 and not clock.is_sure:
        rates = {"filmed": clock.capture_rate, "shown": clock.shown_rate}
        result.append(said("unsure_pace", **rates, factor=clock.slow_motion))
    return result


def _telling_repeats(table: xr.Dataset, repeats: np.ndarray) -> int:
    """Return how many repeated pictures are not measured although those around them are."""
    flags = [table[f"flag_{ball}"].values for ball in range(1, balls_of(table) + 1)]
    is_measured = np.all(np.isin(flags, MEASURED), axis=0)
    fresh = np.flatnonzero(~repeats)
    numbers = np.flatnonzero(repeats & ~is_measured)
    later = np.searchsorted(fresh, numbers)
    around = (fresh[np.clip(k, 0, len(fresh) - 1)] for k in (later - 1, later))
    return int(np.all([is_measured[k] for k in around], axis=0).sum())
