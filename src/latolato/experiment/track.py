"""Turns a video into a table of angles about the moving pivot."""

from __future__ import annotations

import math
import warnings as alarms
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from latolato.core.atomic import checked_path
from latolato.core.errors import InputError, reading
from latolato.experiment.calibration.calibrate import Calibration, calibrate, unsmeared
from latolato.experiment.calibration.circle import Circle, doubt_about, unseen_circle
from latolato.experiment.calibration.lens import Optics, undistorted
from latolato.experiment.calibration.pace import pace_warnings
from latolato.experiment.calibration.scale import Scale, scale_of, stick_pixels
from latolato.experiment.calibration.tilt import Tilt
from latolato.experiment.parameters import VIDEO_PARAMETERS
from latolato.experiment.period import halves_apart, period_of
from latolato.experiment.sidecar import (
    OUTSIDE,
    Setup,
    checked_correction,
    checked_place,
    checked_region,
    checked_stick,
    read_sidecar,
    with_changes,
    write_sidecar,
)
from latolato.experiment.track_table import MEASURED, balls_of, track_table
from latolato.experiment.tracking.appearance import Appearance
from latolato.experiment.tracking.dot import dot_radius
from latolato.experiment.tracking.gate import examine
from latolato.experiment.tracking.geometry import Geometry, fit_geometry
from latolato.experiment.tracking.learn import ImageModel, learn_dot_model, learn_image_model
from latolato.experiment.tracking.learn_template import ROUND, learn_template_model
from latolato.experiment.tracking.positions import Positions, meetings
from latolato.experiment.tracking.propose import proposal_text, propose
from latolato.experiment.tracking.refine import Corrections, refine
from latolato.experiment.tracking.route import Route, find_route
from latolato.experiment.tracking.sample import Sample, read_sample
from latolato.experiment.tracking.steady import Bar, Steadier, steadied
from latolato.experiment.video import Limits, Video, digest_of, open_video

if TYPE_CHECKING:
    import xarray as xr

Place = Sequence[float]
Pivot = Place | Literal["outside"]
Progress = Callable[[float], None]
# Share by which a declared size must differ from the measured one to be worth a warning.
_TOLERANCE = 0.03
# Frames that a whole file may declare and not show.
_FEW_MISSING = 3
# How near to each other a pivot and balls may be [pixels].
_APART = 8.0
# By which factor what moves may be larger or smaller than the declared ball.
_OTHER_SIZE = 5.0
# Shares of samples that are measured, and that are clean, below which no ball was followed; below
# which too few are clean; below which one in slow motion is measured too seldom, and below which
# something that is not known to swing was.
_NEVER, _HARDLY, _SELDOM, _OFTEN, _AT_LEAST = 0.25, 0.1, 0.7, 0.95, 0.5
# Share of frames from which a ball that is off its circle does not swing about the pivot, and the
# share of the arm by which it is off at least.
_ASTRAY, _OFF = 0.4, 0.03
# Fewest frames that show a motion.
_FEWEST = 8
# Error of a ball's place where its pattern resembles the background, as a share of its radius:
# where the colours learned explain all of the ball, and how much more where they explain nothing.
# Synthetic clips: 0.04 to 0.06 where they explain nine tenths, 0.12 where they explain a quarter.
_PATTERN, _UNEXPLAINED = 0.05, 0.1
# Shares of the work: the first reading; of the rest, learning the scene.
_READ, _LEARNED = 0.3, 0.2
# How far from where it is clicked, and from its rod, a ball may reach, as a share of the arm.
_ABOUT = 0.15
# By which factor the distances of two balls from one pivot differ whose arms are different.
_OTHER_ARM = 1.15
# How far from the picture a pivot may be, in diagonals of the picture.
_FARTHEST = 10.0


@dataclass
class Task:
    """A video that is ready to be tracked."""

    video: Video
    setup: Setup
    sample: Sample | None = None
    warnings: list[str] = field(default_factory=list)
    # Of a ball that was found, roughly [pixels].
    radius: float | None = None
    # Where the set-up was read from, None if it was given or found.
    setup_file: Path | None = None


@dataclass(frozen=True)
class _Track:
    """Balls that were followed about one pivot."""

    scene: ImageModel
    seen: Positions
    measured: Calibration


@dataclass(frozen=True)
class _Path:
    """Balls whose pivot is not known, and why."""

    seen: Positions
    doubt: str


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
        ``pivot_source`` is ``picture``, ``declared`` (out of the picture) or ``arc``; with the last
        two all angles share the relative error ``angle_scale_sigma``, which is in no
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
    checks of `latolato.experiment.tracking.gate`. It can miss two balls of different sizes or
    colours, a perspective that the circle does not show, and what each of the checks can miss.
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
        "corrections": tuple(
            checked_correction((frame, ball, *place))
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


def prepare(
    path: Path,
    pivot: Pivot | Sequence[Pivot] | None,
    balls: int | Sequence[Place] | None,
    settings: dict[str, Any],
    sidecar: str | Path | None = None,
    progress: Progress | None = None,
) -> Task:
    """The tracking task, set up by the arguments, by a sidecar, or as found in the video."""
    for name, value in settings.items():
        if value is not None and name in VIDEO_PARAMETERS:
            VIDEO_PARAMETERS[name].checked(value)
    clicks = None if isinstance(balls, int) or balls is None else list(balls)
    count = balls if isinstance(balls, int) else len(clicks) if clicks else None
    if count is not None and count not in (1, 2):
        raise InputError("must be 1 or 2", parameter="balls", value=count)
    own = _own_pivots(pivot)
    if own:
        if count == 1:
            raise InputError("two pivots need two {parameter}", parameter="balls", value=count)
        count = 2
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
            both = {one[:2]: one for one in (*stored.corrections, *setup.corrections)}
            setup = replace(setup, corrections=tuple(sorted(both.values())))
            if count is not None and count != len(setup.balls):
                raise InputError(
                    f"'{sidecar}' is made for {len(setup.balls)} balls, not {count}",
                    way_out="remove it, or point at pivot and balls",
                )
            video = _video_of(path, setup, setup.slow_motion)
            messages = [proposal_text(setup)] if setup.is_proposed else []
            return Task(video, _checked(setup, video), warnings=messages, setup_file=Path(sidecar))
        pivots = own or (None if pivot is None else _checked_pivot(pivot), None)
        setup = Setup(
            pivot=pivots[0],
            pivot_2=pivots[1],
            has_own_pivots=bool(own),
            balls=tuple(checked_place("ball", ball) for ball in clicks or ()),
        )
        setup = with_changes(setup, settings)
        video = _video_of(path, setup, settings.get("slow_motion"))
        setup = replace(setup, slow_motion=video.slow_motion)
        if settings.get("click_frame") is None:
            setup = replace(setup, click_frame=video.first_frame)
        setup = _checked(setup, video)
        if pivot is not None and clicks is not None:
            return Task(video, _right_first(setup))
        video, sample = _read(video, setup, progress)
        known = OUTSIDE if own or (pivot is not None and setup.pivot is None) else setup.pivot
        proposal, size, sample = propose(
            video, sample, pivot=known, balls=clicks, count=count, optics=setup.optics,
            click_frame=settings.get("click_frame"),
        )  # fmt: skip
        pivot_1, pivot_2 = proposal.pivot, None
        if own:
            places = [place for place in own if place is not None]
            if clicks is None and len(places) == 2:
                pivots = tuple(sorted(places, reverse=True))
            pivot_1, pivot_2 = pivots
        setup = replace(
            setup, pivot=pivot_1, pivot_2=pivot_2, balls=proposal.balls, is_proposed=True,
            click_frame=proposal.click_frame if clicks is None else setup.click_frame,
        )  # fmt: skip
        return Task(video, setup, sample, [proposal_text(setup)], size)


def _checked_pivot(pivot: Any) -> tuple[float, float] | None:
    """Return a pivot's place [pixels], None where it is out of the picture and to be fitted."""
    return None if isinstance(pivot, str) and pivot == OUTSIDE else checked_place("pivot", pivot)


def _own_pivots(pivot: Any) -> tuple[tuple[float, float] | None, ...]:
    """Return the places of two pivots, nothing for one or none."""
    if pivot is None or isinstance(pivot, str) or all(isinstance(one, Real) for one in pivot):
        return ()
    if len(pivot) != 2:
        raise InputError("must be one pivot, or two", parameter="pivot", value=len(pivot))
    return tuple(_checked_pivot(one) for one in pivot)


def _right_first(setup: Setup) -> Setup:
    """Return a set-up whose right-hand ball comes first if balls have pivots of their own."""
    if not setup.has_own_pivots or setup.balls[0][0] >= setup.balls[1][0]:
        return setup
    return replace(setup, balls=setup.balls[::-1], pivot=setup.pivot_2, pivot_2=setup.pivot)


def run(task: Task, progress: Progress | None = None) -> xr.Dataset:
    """Return the track table of a prepared video; what is to be warned of joins the task's list."""
    video, setup = task.video, task.setup
    with reading(video.path):
        if task.sample is None:
            task.video, task.sample = _read(video, setup, progress)
        sample = task.sample
        if setup.has_own_pivots or _has_own_arms(setup, video):
            table = _apart(task, sample, progress)
        else:
            route = _route(task, sample)
            if setup.pivot is not None:
                route = route.ordered(np.array(setup.pivot))
            found = _found(task, sample, route, _part(progress, _READ, 1.0))
            if isinstance(found, _Track):
                table = _table(task, [found])
            else:
                table = _wandered(task, sample, found)
            _check_alone(route)
    if isinstance(task.video.steadier, Steadier):
        task.warnings.append(
            f"the camera moves by up to {task.video.steadier.moved:.1f} pixels: corrected on the "
            "background"
        )
        table.attrs["camera_motion"] = task.video.steadier.moved
    repeats = _telling_repeats(table, sample.repeats)
    if repeats:
        task.warnings.append(
            f"{_some_frames(repeats, 'repeats', 'repeat')} the previous picture: such frames are "
            "out of date and not measured"
            + (
                "; they do so regularly, as after a conversion to another frame rate: times are "
                "assumed to be even, not as in the file"
                if sample.is_converted
                else ""
            )
        )
    if sample.gaps.any():
        task.warnings.append(
            f"{_some_frames(sample.gaps.sum(), 'is', 'are')} missing according to the time "
            f"stamps, the longest gap is {np.diff(sample.times).max():.3g} s"
        )
    if progress:
        progress(1.0)
    missing = video.expected_count - table.sizes["frame"]
    if missing > _FEW_MISSING and video.end == math.inf:
        task.warnings.append(
            f"{missing} of the {video.expected_count} frames that the file declares "
            + ("are missing: it is cut off" if video.is_cut_off else "could not be decoded")
        )
    clock = video.clock
    if video.slow_motion == 1.0 and not clock.is_sure:
        task.warnings.append(
            f"the file says that {clock.capture_rate:.4g} frames a second were filmed and "
            f"{clock.shown_rate:.4g} are shown: if it is slow motion, declare one of "
            f"{clock.slow_motion:.3g}"
        )
    if task.warnings:
        # One text, whose parts a semicolon tells apart, and each part once.
        task.warnings[:] = dict.fromkeys(text.replace("; ", ", ") for text in task.warnings)
        table.attrs["warnings"] = "; ".join(task.warnings)
    return table


def _has_own_arms(setup: Setup, video: Video) -> bool:
    """Return whether two balls swing about one pivot in the picture at different distances."""
    if len(setup.balls) < 2 or setup.pivot is None or not _is_inside(setup.pivot, video):
        return False
    short, long = sorted(math.dist(ball, setup.pivot) for ball in setup.balls)
    return long > _OTHER_ARM * short


def _some_frames(count: int, one: str, many: str) -> str:
    return f"{count} frame {one}" if count == 1 else f"{count} frames {many}"


def _telling_repeats(table: xr.Dataset, repeats: np.ndarray) -> int:
    """Return how many repeated pictures are not measured although those around them are."""
    flags = [table[f"flag_{ball}"].values for ball in range(1, balls_of(table) + 1)]
    is_measured = np.all(np.isin(flags, MEASURED), axis=0)
    fresh = np.flatnonzero(~repeats)
    numbers = np.flatnonzero(repeats & ~is_measured)
    later = np.searchsorted(fresh, numbers)
    around = (fresh[np.clip(k, 0, len(fresh) - 1)] for k in (later - 1, later))
    return int(np.all([is_measured[k] for k in around], axis=0).sum())


def _video_of(path: Path, setup: Setup, slow_motion: float | None) -> Video:
    """Return the part of a video that a set-up names, at the file's own pace if none is known."""
    start = -math.inf if setup.start is None else setup.start
    end = math.inf if setup.end is None else setup.end
    if not start < end:
        raise InputError(f"must lie after start ({start:g} s)", parameter="end", value=end)
    video = open_video(path, slow_motion=slow_motion, limits=setup.limits, start=start, end=end)
    return replace(video, region=setup.region)


def _read(video: Video, setup: Setup, progress: Progress | None) -> tuple[Video, Sample]:
    """Return a video as a camera at rest would have taken it, and its first reading."""
    tell = progress and (lambda share: progress(_READ * share))
    sample = read_sample(video, tell, setup.click_frame - video.first_frame)
    if len(sample.times) < _FEWEST:
        raise InputError(
            f"it has too few frames, {len(sample.times)}: tracking needs {_FEWEST} or more"
        )
    hidden = []
    for k, ball in enumerate(setup.balls):
        own = setup.pivot_2 if k and setup.has_own_pivots else setup.pivot
        arm = math.dist(ball, own or (0.5 * video.width, 0.0))
        hidden.append(Bar(np.array(ball), np.array(own or ball), _ABOUT * arm))
    return steadied(video, sample, hidden)


def _checked(setup: Setup, video: Video) -> Setup:
    """Return a set-up that is complete: balls in frame and region, the pivot not too far away."""
    if (setup.stick is None) != (setup.stick_length is None):
        missing = "stick" if setup.stick is None else "stick_length"
        raise InputError(
            "is missing: both ends of a stick and its length are needed", parameter=missing
        )
    named = [("ball", place) for place in setup.balls]
    named += [("end of the stick", place) for place in setup.stick or ()]
    for frame, ball, u, v in setup.corrections:
        named.append((f"correction of ball {ball} in frame {frame}", (u, v)))
    if setup.region is not None:
        left, top, right, bottom = setup.region
        if min(right, bottom) < 0.0 or left > video.width - 1 or top > video.height - 1:
            raise InputError(
                f"the region from ({left:g}, {top:g}) to ({right:g}, {bottom:g}) lies outside the "
                f"frame of {video.width} x {video.height} pixels"
            )
        for u, v in setup.balls:
            if not (left <= u <= right and top <= v <= bottom):
                raise InputError(
                    f"ball at ({u:g}, {v:g}) lies outside the region from ({left:g}, {top:g}) to "
                    f"({right:g}, {bottom:g})"
                )
    for name, (u, v) in named:
        if not _is_inside((u, v), video):
            raise InputError(
                f"{name} at ({u:g}, {v:g}) lies outside the frame of {video.width} x "
                f"{video.height} pixels"
            )
    pivots = (setup.pivot, setup.pivot_2 if setup.has_own_pivots else setup.pivot)
    for own, centre in zip(pivots, setup.balls, strict=False):
        if own is not None and math.dist(own, centre) < _APART:
            raise InputError(f"pivot and ball must be at least {_APART:g} pixels apart")
    if len(setup.balls) == 2 and math.dist(setup.balls[0], setup.balls[1]) < _APART:
        raise InputError(
            f"two balls must be at least {_APART:g} pixels apart",
            way_out="point at each of them, or at one only",
        )
    readout = setup.optics.row_time * video.height
    if video.frame_rate and readout * video.frame_rate > 1.0:
        raise InputError(
            f"must let {video.height} rows fit between two frames", parameter="row_time",
            value=setup.optics.row_time,
        )  # fmt: skip
    reach = _FARTHEST * math.hypot(video.width, video.height)
    for u, v in filter(None, (setup.pivot, setup.pivot_2)):
        if math.hypot(u - 0.5 * video.width, v - 0.5 * video.height) > reach:
            raise InputError(
                f"the pivot at ({u:g}, {v:g}) is farther than {reach:.0f} pixels from the picture",
                way_out=f"use '{OUTSIDE}' to fit it from the arc",
            )
    return setup


def _is_inside(place: Place, video: Video) -> bool:
    return 0 <= place[0] <= video.width - 1 and 0 <= place[1] <= video.height - 1


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
            raise InputError(
                f"frame {number} is corrected, but only frames {first} to "
                f"{first + len(sample.times) - 1} are used"
            )
        if ball > count:
            raise InputError(f"ball {ball} is corrected in frame {number}, but there is only one")
        places.setdefault(number - first, {})[ball - 1] = np.array(place)
    steadier = task.video.steadier

    def placed(number: int) -> dict[int, np.ndarray]:
        fixed = places.get(number, {})
        if isinstance(steadier, Steadier):
            return {ball: steadier.place(number, place) for ball, place in fixed.items()}
        return fixed

    return placed


def _apart(task: Task, sample: Sample, progress: Progress | None) -> xr.Dataset:
    """Return the table of two balls, each of which was followed about a pivot of its own."""
    tracks: list[_Track] = []
    route = _route(task, sample)
    pivots = task.setup.pivot, task.setup.pivot_2 or task.setup.pivot
    for b, pivot in enumerate(pivots):
        corrections = ((n, 1, u, v) for n, ball, u, v in task.setup.corrections if ball == b + 1)
        alone = replace(
            task.setup,
            pivot=pivot,
            balls=task.setup.balls[b : b + 1],
            has_own_pivots=False,
            corrections=tuple(corrections),
        )
        low = _READ + 0.5 * b * (1.0 - _READ)
        tell = _part(progress, low, low + 0.5 * (1.0 - _READ))
        found = _found(replace(task, setup=alone), sample, route.ball(b), tell)
        if isinstance(found, _Path):
            return _wandered(task, sample, _Path(_positions(task, sample, route), found.doubt))
        tracks.append(found)
    right, left = (track.seen for track in tracks)
    is_meeting = meetings(right, left)
    for seen in (right, left):
        seen.flags[(is_meeting & (seen.flags[:, 0] == "ok"))[:, None]] = "collision"
    return _table(task, tracks)


def _route(task: Task, sample: Sample) -> Route:
    """Return where the balls of a set-up roughly are in all frames."""
    setup = task.setup
    radius, pivots = None, (setup.pivot, setup.pivot_2 if setup.has_own_pivots else setup.pivot)
    if setup.radius and setup.length and setup.pivot:
        radius = setup.radius / setup.length * math.dist(setup.balls[0], setup.pivot)
    return find_route(
        sample.copies, sample.times,
        [np.array(ball) for ball in setup.balls], sample.click, radius, sample.repeats,
        [None if pivot is None else np.array(pivot) for pivot in pivots[: len(setup.balls)]],
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


def _found(task: Task, sample: Sample, route: Route, progress: Progress | None) -> _Track | _Path:
    """Return balls about one pivot: in the picture, or where the arc shows it."""
    pivot = task.setup.pivot
    if pivot is not None and _is_inside(pivot, task.video):
        scene, seen = _followed(task, sample, np.array(pivot), route, progress)
        return _Track(scene, seen, _calibrated(task, sample, scene, seen))
    if task.setup.shape == "template":
        raise InputError(
            "a bob that is not a disc can only be followed about a pivot in the picture",
            way_out="point at the pivot, or at a disc on the bob",
        )
    path = _positions(task, sample, route)
    circle, doubt = _circle_of(task, path)
    if circle is None or doubt is not None:
        return _Path(path, f"{doubt}")
    before = len(task.warnings)
    scene, seen = _followed(task, sample, circle.centre, route, progress, is_unseen=True)
    circle, doubt = _circle_of(task, seen)
    if circle is None or doubt is not None:
        del task.warnings[before:]  # they are about a track that is given up
        return _Path(path, f"{doubt}")
    return _Track(scene, seen, _calibrated(task, sample, scene, seen, circle))


def _circle_of(task: Task, seen: Positions) -> tuple[Circle | None, str | None]:
    """Return the circle about a pivot that is not seen, and why it cannot be believed."""
    video, setup, optics = task.video, task.setup, task.setup.optics
    size = video.width, video.height
    clean = np.where((seen.flags == "ok")[..., None], seen.centres, np.nan)
    places = undistorted(clean, size, optics)
    declared = None if setup.pivot is None else np.array(setup.pivot)
    has_lens = bool(optics.lens_k1 or optics.lens_k2)
    circle = unseen_circle(places, size, declared=declared, has_lens=has_lens)
    return circle, doubt_about(seen.times, places, circle)


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
    tell = _part(progress, 0.0, _LEARNED)
    is_disc = setup.shape != "template"
    if is_unseen:
        geometry = Geometry.at_rest(pivot, len(sample.from_click))
    else:
        geometry = fit_geometry(sample, pivot, balls, route, size, setup.optics)
    dot = dot_radius(sample, route)

    def learned(radius: float | None) -> ImageModel:
        if not is_disc:
            half = 0.5 * setup.patch if setup.patch else ROUND * radius if radius else None
            return learn_template_model(video, sample, geometry, balls, half, route, tell)
        if math.isfinite(dot):
            return learn_dot_model(sample, geometry, balls, route, dot)
        rough = route.radius if is_unseen else None
        return learn_image_model(
            video, sample, geometry, balls, radius, route, tell, rough_radius=rough
        )

    if is_unseen:
        scene = learned(None)
        seen = refine(video, sample, scene, route, _part(progress, _LEARNED, 1.0), corrections)
        return scene, _believed(task, sample, seen, balls)
    scale = scale_of(setup, size, (geometry.arm(balls), 0.0))
    expected = radius / scale.metres if radius and scale else None
    seen_radius = math.nan if route.is_traced or math.isfinite(dot) else route.detected_radius
    if is_disc and expected and abs(math.log(expected / seen_radius)) > math.log(_OTHER_SIZE):
        raise InputError(
            f"what moves there has a radius of about {seen_radius:.0f} pixels, the declared radius "
            f"is {expected:.3g} pixels by the scale",
            way_out="check radius and length (from pivot to ball centre); without a radius it is "
            "measured",
        )
    scene = learned(expected)
    is_off = expected and abs(scene.look.radius / expected - 1.0) > _doubt(scene)
    if is_off and isinstance(scene.look, Appearance):
        # A declared radius that is wrong may lead astray: without it more may be explained.
        try:
            free = learned(None)
        except InputError:
            free = scene
        if free.explained > scene.explained:
            scene = free
    scale = scale_of(setup, size, (scene.arm, 0.0), (scene.look.radius, 0.0))
    seen = refine(video, sample, scene, route, _part(progress, _LEARNED, 1.0), corrections)
    _check_distances(scene, route, seen.pivots)
    declared = radius / scale.metres if radius and scale else None
    return scene, _believed(task, sample, seen, balls, declared)


def _check_alone(route: Route) -> None:
    """Refuse a ball that meets one of the same look that nobody pointed at."""
    if math.isfinite(route.meets):
        raise InputError(
            f"a second ball that looks the same meets this one, at {route.meets:.4g} s: from then "
            "on one may be taken for the other",
            way_out="point at both (--balls 2), or end before they meet (--end)",
        )


def _check_distances(scene: ImageModel, route: Route, pivots: np.ndarray) -> None:
    """Refuse balls that are often off the circle, or oval, about pivots (frame, 2)."""
    away = (route.places - pivots[:, None])[route.is_seen]
    off = scene.off(away) > max(route.radius, _OFF * scene.arm)
    if not len(away) or np.mean(off) < _ASTRAY:
        return
    low, high = np.quantile(np.hypot(*away.T), [0.05, 0.95])
    u, v = np.median(pivots, axis=0)
    raise InputError(
        f"what was taken for the ball is {low:.0f} to {high:.0f} pixels from the pivot at "
        f"({u:.0f}, {v:.0f}), so it does not swing about it",
        way_out="point at the middle of the ball and at the pivot about which it swings, or use "
        f"'{OUTSIDE}' if the picture does not show the pivot",
    )


def _believed(
    task: Task,
    sample: Sample,
    seen: Positions,
    balls: list[np.ndarray],
    radius: float | None = None,
) -> Positions:
    """Return a track without the samples that are not to be believed, or refuse it as a whole."""
    if isinstance(task.video.steadier, Steadier):
        unknown = np.isnan(task.video.steadier.deviations(len(seen.times)))
        seen.give_up(np.broadcast_to(unknown[:, None], seen.flags.shape))
    share = float(seen.is_measured.mean())
    places = " and ".join(f"({u:.0f}, {v:.0f})" for u, v in balls)
    factor = task.setup.slow_motion
    pace = f"check the slow motion of {factor:g}: a wrong one makes the ball hard to follow"
    clean = seen.clean_share(~sample.repeats)
    if share < _NEVER or clean < _HARDLY:
        raise InputError(
            f"what was taken for the ball, at {places} in frame {task.setup.click_frame}, is found "
            f"in {100.0 * share:.0f} % of the samples only ({100.0 * clean:.0f} % are ok)",
            way_out="point at the middle of the ball" + (f", or {pace}" if factor != 1.0 else ""),
        )
    _examine(task, sample, seen, balls, radius)
    share = float(seen.is_measured.mean())
    if factor != 1.0 and share < _OFTEN:
        task.warnings.append(
            f"the ball was measured in only {100.0 * share:.0f} % of the samples: {pace}"
        )
    elif seen.clean_share(~sample.repeats) < _SELDOM:
        task.warnings.append(f"{seen.gaps_text(~sample.repeats)}; look at the overlay")
    return seen


def _calibrated(
    task: Task, sample: Sample, scene: ImageModel, seen: Positions, circle: Circle | None = None
) -> Calibration:
    """Return angles about the hinge, or about the centre of a circle where no pivot is seen."""
    video, setup = task.video, task.setup
    if not scene.pivot.is_still:
        seen.pivots = unsmeared(seen.times, seen.pivots, scene.look.exposure * sample.interval)
    size = video.width, video.height
    measured = calibrate(seen, size, video.rotation, setup.optics, circle)
    if isinstance(video.steadier, Steadier):
        places = video.steadier.deviations(len(seen.times))
        measured.sigmas = np.hypot(measured.sigmas, places[:, None] / measured.hinge.arm)
    stiffness = setup.gravity / setup.length if setup.length else None
    swing = measured.gravity.swing
    task.warnings += pace_warnings(measured.motion, swing, stiffness, setup.slow_motion)
    if scene.look.is_spinning:
        share = _PATTERN + _UNEXPLAINED * (1.0 - scene.explained)
        unsure = share * scene.look.radius / measured.hinge.arm
        measured.sigmas = np.hypot(measured.sigmas, unsure)
        task.warnings.append(
            "the ball has a pattern that turns with it: where the pattern resembles the "
            f"background, angles are off by {1e3 * unsure:.2g} mrad or more"
        )
    return measured


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


def _table(task: Task, tracks: list[_Track]) -> xr.Dataset:
    """Return the table in metres, or in pixels where no scale is known.

    The second track, if there is one, is that of a ball about a pivot of its own.
    """
    first = tracks[0].measured
    for track in tracks:
        task.warnings += track.measured.warnings
    scale = _scale(task, tracks)
    metres_per_pixel = scale.metres if scale else math.nan
    turn = first.gravity.direction
    right = np.array([math.cos(turn), -math.sin(turn)])
    down = np.array([math.sin(turn), math.cos(turn)])
    origin = np.nanmean(first.pivots, axis=0)
    columns = _frames(task, tracks[0].seen.times)

    def put(name: str, places: np.ndarray, tilt: Tilt) -> None:
        away = tilt.flat(places - origin) * metres_per_pixel
        columns[f"{name}_x"], columns[f"{name}_y"] = away @ right, -(away @ down)
        if scale is None:
            columns[f"{name}_u"], columns[f"{name}_v"] = places.T

    for k, track in enumerate(tracks):
        seen, measured = track.seen, track.measured
        put("pivot_2" if k else "pivot", measured.pivots, measured.tilt)
        for b in range(seen.centres.shape[1]):
            number = k + b + 1
            put(f"ball_{number}", measured.centres[:, b], measured.tilt)
            columns[f"angle_{number}"] = measured.angles[:, b]
            columns[f"angle_sigma_{number}"] = measured.sigmas[:, b]
            columns[f"flag_{number}"] = seen.flags[:, b]
    for track in tracks:
        _warn_of(task, track, scale)
    if scale is None:
        task.warnings.append(
            "the length is unknown, so positions are in pixels only; to set the scale, give the "
            "length, a stick, or the radius of a ball"
        )
    attributes = {
        **_declared(task, "metric" if scale else "angles"),
        "scale_source": scale.source if scale else None,
        "metres_per_pixel": scale.metres if scale else None,
        "metres_per_pixel_sigma": scale.share * scale.metres if scale else None,
        "origin_u": float(origin[0]),
        "origin_v": float(origin[1]),
    }
    for k, track in enumerate(tracks):
        own = _measured(task, track, scale)
        attributes |= {f"{name}_2": each for name, each in own.items()} if k else own
    return track_table(columns, attributes)


def _scale(task: Task, tracks: list[_Track]) -> Scale | None:
    """Return the scale of the picture; from two balls about pivots of their own, by their means.

    Raises
    ------
    InputError
        If one length is declared for balls whose distances from their pivots differ by more than
        their errors and 3 %.
    """
    video, setup = task.video, task.setup
    arms = np.array([track.measured.arm for track in tracks])
    looks = np.array([(each.scene.look.radius, each.scene.look.radius_sigma) for each in tracks])
    longest, shortest = arms[np.argmax(arms[:, 0])], arms[np.argmin(arms[:, 0])]
    doubt = _TOLERANCE + 2.0 * math.hypot(*(arms[:, 1] / arms[:, 0]))
    if setup.length and longest[0] / shortest[0] - 1.0 > doubt:
        raise InputError(
            f"the balls are {arms[0, 0]:.0f} and {arms[1, 0]:.0f} pixels from their pivots: one "
            "length cannot fit both",
            way_out="omit the length here, and give it in the fit of each ball",
        )
    arm, radius = arms.mean(axis=0), looks.mean(axis=0)
    return scale_of(setup, (video.width, video.height), tuple(arm), tuple(radius))


def _warn_of(task: Task, track: _Track, scale: Scale | None) -> None:
    """Warn of a pivot that was fitted from the arc, and of sizes that do not fit the scale."""
    setup, video = task.setup, task.video
    hinge, look = track.measured.hinge, track.scene.look
    if hinge.source == "arc":
        u, v = track.measured.pivots[0]
        and_scale = ", and the scale," if scale and scale.source == "length" else ""
        task.warnings.append(
            "the pivot is not in the picture: it is assumed to be at rest at "
            f"({u:.0f}, {v:.0f}), the centre of the ball's arc; all angles{and_scale} share an "
            f"error of {100.0 * hinge.scale_sigma:.2g} %"
        )
    if scale is None:
        return
    about = "length from pivot to ball centre" if scale.source == "length" else scale.source
    sizes = [("radius of a ball", setup.radius, look.radius, look.radius_sigma)]
    if setup.stick is not None:
        pixels = stick_pixels(setup, (video.width, video.height))
        sizes.append(("stick", setup.stick_length, pixels, math.sqrt(2.0)))
    for name, declared, pixels, sigma in sizes:
        doubt = _TOLERANCE + math.hypot(sigma / pixels, 2.0 * scale.share)
        if declared and abs(pixels * scale.metres / declared - 1.0) > doubt:
            task.warnings.append(
                f"the {name} is {pixels * scale.metres * 1e3:.2f} mm by the scale of the "
                f"{scale.source}, declared were {declared * 1e3:.2f} mm: is the {about} right?"
            )


def _measured(task: Task, track: _Track, scale: Scale | None) -> dict[str, Any]:
    """Return the attributes of balls about one pivot."""
    look, measured = track.scene.look, track.measured
    hinge, gravity = measured.hinge, measured.gravity
    attributes: dict[str, Any] = {}
    if scale is not None:
        attributes["measured_radius"] = look.radius * scale.metres
        attributes["measured_radius_sigma"] = scale.metres * math.hypot(
            look.radius_sigma, look.radius * scale.share
        )
        if not task.setup.length:
            arm, arm_sigma = measured.arm
            attributes["length"] = arm * scale.metres
            attributes["length_sigma"] = scale.metres * math.hypot(arm_sigma, arm * scale.share)
    return attributes | {
        "radius_pixels": look.radius,
        "gravity_direction": gravity.direction,
        "gravity_source": gravity.source,
        "angle_offset_sigma": measured.angle_offset_sigma,
        "exposure": look.exposure if task.setup.shape == "disc" else None,
        "pivot_source": hinge.source,
        "angle_scale_sigma": None if hinge.is_seen else hinge.scale_sigma,
        "pivot_offset_x": float(hinge.offset[0]) if hinge.is_seen else None,
        "pivot_offset_y": float(hinge.offset[1]) if hinge.is_seen else None,
        "pivot_offset_x_sigma": float(hinge.sigma[0]),
        "pivot_offset_y_sigma": float(hinge.sigma[1]),
        "arm_pixels": hinge.arm,
        "arc": hinge.arc,
        "tilt": measured.tilt.angle or None,
        "tilt_sigma": measured.tilt.sigma or None,
        "tilt_axis": measured.tilt.axis if measured.tilt.angle else None,
        "circle_residual": hinge.residual,
    }


def _wandered(task: Task, sample: Sample, path: _Path) -> xr.Dataset:
    """Return the table of balls about an unknown pivot: their places in the image, no angles."""
    seen = _believed(task, sample, path.seen, [np.array(ball) for ball in task.setup.balls])
    columns = _frames(task, seen.times)
    for b in range(seen.centres.shape[1]):
        columns[f"ball_{b + 1}_u"], columns[f"ball_{b + 1}_v"] = seen.centres[:, b].T
        columns[f"flag_{b + 1}"] = seen.flags[:, b]
    task.warnings.append(
        f"{path.doubt}: the geometry is unknown, so there are no angles and the ball's positions "
        "are in pixels; its period is in the table's attributes"
    )
    period, sigma = period_of(seen.times, seen.centres[:, 0])
    apart = halves_apart(seen.times, seen.centres[:, 0])
    if apart is not None:
        task.warnings.append(
            f"the period changes from {apart[0]:.5g} to {apart[1]:.5g} s between the halves of the "
            "clip, as with the amplitude, with the length, or where films are joined"
        )
    if math.isnan(period):
        share = seen.clean_share(~sample.repeats)
        if share < _AT_LEAST:  # nothing says that it swings
            u, v = task.setup.balls[0]
            raise InputError(
                f"what was taken for the ball, at ({u:.0f}, {v:.0f}) in frame "
                f"{task.setup.click_frame}, is seen in only {100.0 * share:.0f} % of the samples, "
                f"and no swing is seen: {path.doubt}",
                way_out="point at the middle of the ball that swings, and at its pivot",
            )
        task.warnings.append("no period: fewer than three swings were seen")
    attributes = {
        **_declared(task, "unknown"),
        "radius_pixels": seen.radius,
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
    pivots = {"pivot": setup.pivot, "pivot_2": setup.pivot_2}
    places = {name: place for name, place in pivots.items() if place is not None}
    places |= {f"ball_{k + 1}": ball for k, ball in enumerate(setup.balls)}
    clicks = {
        f"{name}_pixel_{axis}": number
        for name, place in places.items()
        for axis, number in zip("uv", place, strict=True)
    }
    clock = video.clock
    is_other = clock.slow_motion != 1.0
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
        "capture_rate": clock.capture_rate if is_other else None,
        "shown_rate": clock.shown_rate if is_other else None,
        "row_time": setup.optics.row_time,
        "lens_k1": setup.optics.lens_k1,
        "lens_k2": setup.optics.lens_k2,
        "proposed": int(setup.is_proposed),
        **clicks,
    }
