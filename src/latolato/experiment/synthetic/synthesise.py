"""Synthetic videos: a run filmed by a camera with known properties, with the true table."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.atomic import atomic_path, check_folder
from latolato.core.errors import InputError
from latolato.core.quantities import Quantity
from latolato.core.registry import describe
from latolato.experiment.encode import TICKS, import_av, write_video
from latolato.experiment.opencv import import_cv2
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.track_table import SUFFIXES as TABLES
from latolato.experiment.track_table import track_table, write_table
from latolato.experiment.video import digest_of
from latolato.io import files
from latolato.io.files import check_suffix

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.synthetic.picture import Projection, Renderer
    from latolato.experiment.synthetic.render import Floats

SUFFIXES = (".mp4",)
# The motion between two instants of the dense run is taken as straight: at 30 m/s^2 and 1 m this
# is wrong by at most 4e-8 m.
_DENSE = 1e-4
MOST_FRAMES = 100_000
# The motion and its surroundings fill this part of a picture whose scale is not given.
_FILLED = 0.86
# A ball of which more is hidden counts as occluded.
_OCCLUDED = 0.02
# Speed of the hand to the right [m/s].
_HAND_SPEED = 0.25
# Balls this near to the contact angle touch [rad].
_TOUCHING = 1e-6
# Motion between two averaged moments of an exposure [pixel]: smears look and measure as smooth.
_SMOOTH = 0.45
_LEAST_MOMENTS, _MOST_MOMENTS = 8, 400
# Frames that are painted ahead of the encoder.
_AHEAD = 4


@dataclass(frozen=True)
class Motion:
    """A run between whose dense samples one may interpolate.

    Parameters
    ----------
    time : ndarray, shape (time,)
        Evenly spaced [s].
    pivots : ndarray, shape (2, time)
        How far the pivot is to the right of its mean over the frames, and above it [m].
    angles : ndarray, shape (ball, time)
        Of the right ball and, if there is one, the left one [rad].
    lengths, radii : tuple of float
        Of the balls [m].
    contacts : ndarray
        Times of contact [s].
    separation : float
        Angle between touching balls [rad]; NaN for one ball.
    """

    time: Floats
    pivots: Floats
    angles: Floats
    lengths: tuple[float, ...]
    radii: tuple[float, ...]
    contacts: Floats
    separation: float

    def at(self, times: Floats) -> tuple[list[Floats], list[Floats]]:
        """Return x and y of the pivot [m], and the angles [rad], at instants [s] of any shape."""
        pivot, angles = (
            [np.interp(times, self.time, values) for values in rows]
            for rows in (self.pivots, self.angles)
        )
        return pivot, angles

    def balls(self, times: Floats) -> list[tuple[Floats, Floats]]:
        """Return x and y of each ball [m] at instants [s] of any shape."""
        (across, height), angles = self.at(times)
        return [
            (across + length * np.sin(angle), height - length * np.cos(angle))
            for angle, length in zip(angles, self.lengths, strict=True)
        ]


def synthesise_video(
    run: xr.Dataset,
    path: str | Path,
    scene: Scene | None = None,
    camera: Camera | None = None,
    *,
    seed: int = 0,
    truth: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Write a video of a run as H.264 in MP4 and return its true track table.

    Parameters
    ----------
    run : xarray.Dataset
        What `latolato.simulate` or `latolato.load` returned: a `Pendulum`, `LatoLato` or
        `BallPair` under any drive. Its whole duration is filmed.
    path : str or Path
        A name ending in ``.mp4``.
    scene, camera : Scene, Camera, optional
        What is seen and how.
    seed : int
        Seed of texture, noise and time stamps; the same seed gives the same frames.
    truth : str or Path, optional
        Where to write the table: ``.csv``, ``.parquet`` or ``.nc``.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    xarray.Dataset
        A track table (`latolato.experiment.track_table`) without noise, and on ``frame`` also
        ``covered_1`` (part of the ball that is hidden) and ``is_contact`` (balls touch during the
        exposure). The attributes hold the scale, the clicks of pivot and balls in the first frame
        as shown (``pivot_pixel_u`` and so on), and all parameters.

    Raises
    ------
    InputError
        For a dataset that is not a run, a run that stops early, or one that is too short.
        If the extra `video` is missing.
    OSError
        If a file cannot be written; no partial file remains.

    Notes
    -----
    Light is added up in linear values: covered parts of pixels, moments of the exposure (more
    where things move by over 0.45 pixel between two), a Gaussian blur; then come shot and read
    noise, the sRGB tone curve and BT.709 codes. Video time 0 is half an exposure into the run,
    as the attribute ``run_time`` says.
    """
    path = Path(path)
    check_target(path, truth)
    film = prepare(run, scene, camera, seed=seed)
    camera = film.camera
    with atomic_path(path) as unfinished:
        write_video(
            unfinished,
            _frames(film, progress),
            fps=camera.fps,
            crf=camera.crf,
            rotation=camera.rotation,
        )
    table = film.truth()
    table.attrs.update(source=path.name, source_sha256=digest_of(path), seed=seed)
    if truth is not None:
        write_table(table, truth)
    return table


@dataclass(frozen=True)
class Film:
    """A video before it is encoded.

    Parameters
    ----------
    run : xarray.Dataset
        What is filmed, in dense samples.
    motion : Motion
        The same, ready to be interpolated.
    renderer : Renderer
        What paints the frames.
    stamps : ndarray, shape (frame,)
        Time stamps [tick].
    begin : float
        The run's time at video time 0 [s].
    """

    run: xr.Dataset
    motion: Motion
    renderer: Renderer
    stamps: Any
    begin: float

    @property
    def camera(self) -> Camera:
        """The camera with its scale and pivot."""
        return self.renderer.camera

    @property
    def times(self) -> Floats:
        """Time of each frame [s], shape (frame,)."""
        return np.asarray(self.stamps / TICKS)

    def states(self, number: int) -> Floats:
        """Return undistorted u, v of pivot and balls in an exposure, (moment, line, point, 2)."""
        motion, camera, projection = self.motion, self.camera, self.renderer.projection
        rows = camera.rows if camera.row_time > 0.0 else 1
        times = self.begin + float(self.times[number]) + camera.row_time * np.arange(rows)
        half = 0.5 * camera.exposure / camera.fps
        ends = _states(motion, projection, times + half * np.array([[-1.0], [0.0], [1.0]]))
        # Twice the larger half, for the motion may turn round.
        steps = math.ceil(np.linalg.norm(np.diff(ends, axis=0), axis=-1).max() / _SMOOTH)
        count = 2 * min(steps, _MOST_MOMENTS) if steps > _LEAST_MOMENTS else _LEAST_MOMENTS
        moments = 2.0 * half * ((np.arange(count) + 0.5) / count - 0.5)
        return _states(motion, projection, times + moments[:, None])

    def hand_at(self, number: int) -> float | None:
        """Return where the hand is that passes in front of a frame [m]; None without one."""
        scene = self.renderer.scene
        if scene.hand_radius == 0.0:
            return None
        return _HAND_SPEED * (float(self.times[number]) - scene.hand_time)

    def frame(self, number: int) -> Any:
        """Return the 8-bit YUV planes of a frame as stored, shape (3 height/2, width)."""
        return self.renderer.frame(number, self.states(number), self.hand_at(number))

    def picture(self, number: int) -> Any:
        """Return a frame as shown in linear light, without noise, shape (height, width, 3)."""
        return self.renderer.picture(self.states(number), self.hand_at(number))

    def truth(self) -> xr.Dataset:
        """Return the track table that is true of the video, with the clicks as attributes."""
        motion, run, renderer, begin = self.motion, self.run, self.renderer, self.begin
        camera, projection, times = self.camera, renderer.projection, self.times
        (across, height), angles = motion.at(begin + times)
        columns: dict[str, Any] = {"time": times, "pivot_x": across, "pivot_y": height}
        more: dict[str, Any] = {}
        half = 0.5 * camera.exposure / camera.fps
        moments = begin + times + half * np.linspace(-1.0, 1.0, 33)[:, None]
        touches = _touches(motion, moments)
        clicked = {"pivot": (across[0], height[0])}
        for i, (x, y) in enumerate(motion.balls(begin + times)):
            angle = angles[i]
            columns[f"ball_{i + 1}_x"], columns[f"ball_{i + 1}_y"] = x, y
            columns[f"angle_{i + 1}"] = angle
            columns[f"angle_sigma_{i + 1}"] = np.zeros_like(angle)
            places = zip(*projection.flat(x, y), strict=True)
            hidden = np.array(
                [renderer.covered(u, v, i, self.hand_at(k)) for k, (u, v) in enumerate(places)]
            )
            flags = np.where(touches, "collision", "ok")
            columns[f"flag_{i + 1}"] = np.where(hidden > _OCCLUDED, "occluded", flags)
            about = Quantity("1", "", f"hidden part of ball {i + 1}")
            more[f"covered_{i + 1}"] = ("frame", hidden, about.attributes)
            clicked[f"ball_{i + 1}"] = x[0], y[0]
        if renderer.scene.is_parked:
            clicked["parked"] = renderer.scene.parked_x, renderer.scene.parked_y
        about = Quantity("1", "", "whether balls touch during the exposure")
        more["is_contact"] = ("frame", touches, about.attributes)
        clicks = {
            f"{name}_pixel_{axis}": float(number)
            for name, place in clicked.items()
            for axis, number in zip("uv", projection.in_picture(*place), strict=True)
        }
        attributes = {
            **{
                k: v for k, v in run.attrs.items() if isinstance(v, (int, float)) and k != "samples"
            },
            "title": f"truth of a synthetic video of {run.attrs['system']}",
            "length": max(motion.lengths),
            "radius": motion.radii[0],
            "metres_per_pixel": 1.0 / projection.scale,
            "gravity_direction": camera.roll,
            **clicks,
            "run_time": begin,
            "system": run.attrs["system"],
            "drive": run.attrs["drive"],
            "scenario": run.attrs["scenario"],
            "scene": json.dumps(describe(renderer.scene)),
            "camera": json.dumps(describe(camera)),
        }
        return track_table(columns, attributes).assign(more)


def prepare(
    run: xr.Dataset, scene: Scene | None = None, camera: Camera | None = None, *, seed: int = 0
) -> Film:
    """Return the video of a run before it is encoded; see `synthesise_video`."""
    from latolato.experiment.synthetic.picture import Renderer

    scene, camera = scene or Scene(), camera or Camera()
    if seed < 0:
        raise InputError("must be a whole number of at least 0", parameter="seed", value=seed)
    stamps, begin = frame_stamps(run, camera, seed)
    times = stamps / TICKS
    motion, run = filmed_motion(run, begin + times, scene)
    camera = framed(camera, scene, motion)
    if np.ptp(motion.pivots[0]) > 0.0:  # no rail guides it
        scene = replace(scene, rail_width=0.0)
    renderer = Renderer(
        scene,
        camera,
        radii=motion.radii,
        heights=(float(motion.pivots[1].min()), float(motion.pivots[1].max())),
        length=max(motion.lengths),
        seed=seed,
    )
    return Film(run, motion, renderer, stamps, begin)


def _frames(film: Film, progress: Callable[[float], None] | None) -> Iterator[tuple[int, Any]]:
    """Yield stamp and planes of every frame, painted by two threads a little ahead."""
    count = len(film.stamps)
    with ThreadPoolExecutor(2) as pool:
        ahead: list[Future[Any]] = []
        try:
            for number in range(count + _AHEAD):
                if number < count:
                    ahead.append(pool.submit(film.frame, number))
                done = number - _AHEAD
                if done >= 0:
                    yield int(film.stamps[done]), ahead.pop(0).result()
                    if progress is not None:
                        progress((done + 1) / count)
        finally:
            for waiting in ahead:
                waiting.cancel()


def check_target(path: str | Path, truth: str | Path | None = None) -> None:
    """Raise before any work if a file cannot be written."""
    check_suffix(path, SUFFIXES, "the name of a synthetic video")
    check_folder(Path(path))
    import_av()
    import_cv2()
    if truth is not None:
        check_suffix(truth, TABLES, "the name of a track table")
        files.check_target(truth)


def frame_stamps(run: xr.Dataset, camera: Camera, seed: int) -> tuple[Any, float]:
    """Return time stamps [tick] and the run's time at video time 0 [s].

    Raises
    ------
    InputError
        If it is no run, or if fewer than two frames fit into it.
    """
    if not hasattr(run, "attrs") or "angle" not in run or "scenario" not in run.attrs:
        raise InputError("a synthetic video needs a run: what simulate or load returned")
    pause = 1.0 / camera.fps
    half = 0.5 * camera.exposure * pause
    readout = camera.row_time * (camera.rows - 1)
    room = float(run["time"][-1]) - 2.0 * half - readout
    count = math.floor(room / pause + 1e-9) + 1
    if count < 2:
        raise InputError(
            f"the run must last at least two frames of {pause:g} s",
            value=float(run["time"][-1]),
            way_out="give a longer duration",
        )
    if count > MOST_FRAMES:
        raise InputError(
            f"a video must have at most {MOST_FRAMES} frames",
            value=count,
            way_out="give a shorter duration or lower fps",
        )
    random = np.random.default_rng([seed, 2])
    times = pause * np.arange(count)
    if camera.jitter > 0.0:
        late = camera.jitter * np.clip(random.standard_normal(count), -1.5, 1.5)
        times[1:-1] += pause * late[1:-1]
    if camera.drop > 0.0:
        kept = random.uniform(size=count) >= camera.drop
        kept[0] = kept[-1] = True
        times = times[kept]
    stamps = np.round(times * TICKS).astype(np.int64)
    # The last stamp may round up beyond the run's end.
    stamps[-1] = min(stamps[-1], math.floor(max(room, 0.0) * TICKS))
    return stamps, half


def filmed_motion(run: xr.Dataset, times: Floats, scene: Scene) -> tuple[Motion, xr.Dataset]:
    """Return the motion, run again with dense samples, and that run without its samples.

    Raises
    ------
    InputError
        If the run stops before the last frame.
    """
    from latolato.scenario.scenario import Scenario

    tables = json.loads(run.attrs["scenario"])
    end = float(run["time"][-1])
    dense = np.linspace(0.0, end, max(math.ceil(end / _DENSE), 1) + 1)
    tables["run"] = {k: v for k, v in tables["run"].items() if k not in ("times", "duration")}
    again = Scenario.from_dict(tables).simulate(times=dense, duration=end)
    angle = again["angle"].values
    mirrored = again.attrs["system"] == "latolato"
    angles = angle if angle.ndim == 2 else np.stack([angle, -angle] if mirrored else [angle])
    if not np.all(np.isfinite(angles)):
        raise InputError(f"the run must reach its end, got status '{again.attrs['status']}'")
    prefixes = ("right_", "left_") if angle.ndim == 2 else ("",) * len(angles)
    attrs = again.attrs
    lengths = tuple(scene.centre_length or float(attrs[f"{prefix}length"]) for prefix in prefixes)
    radii = tuple(
        float(attrs.get(f"{prefix}radius", 0.0)) or scene.ball_radius or length / 15.0
        for prefix, length in zip(prefixes, lengths, strict=True)
    )
    separation = attrs.get("contact_separation", 2.0 * attrs.get("contact_angle_low", math.nan))
    height = again["pivot_height"].values
    across = again["pivot_across"].values if "pivot_across" in again else np.zeros_like(height)
    pivots = [each - float(np.interp(times, dense, each).mean()) for each in (across, height)]
    motion = Motion(
        time=dense,
        pivots=np.array(pivots),
        angles=angles,
        lengths=lengths,
        radii=radii,
        contacts=again["contact_time"].values,
        separation=float(separation) if len(angles) == 2 else math.nan,
    )
    return motion, again


def framed(camera: Camera, scene: Scene, motion: Motion) -> Camera:
    """Return the camera with a scale and a pivot at which the whole motion is seen."""
    across, heights = motion.pivots
    xs, ys = [across], [np.array([heights.min(), heights.max() + 1.5 * scene.block_height])]
    margin = max(motion.radii) + 0.01
    for x, y in motion.balls(motion.time):
        for sign in (-margin, margin):
            xs.append(x + sign)
            ys.append(y + sign)
    if scene.is_parked:
        xs.append(scene.parked_x + np.array([-margin, margin]))
        ys.append(scene.parked_y + np.array([-margin, margin]))
    low_x, high_x = (float(f(f(x) for x in xs)) for f in (min, max))
    low_y, high_y = (float(f(f(y) for y in ys)) for f in (min, max))
    corners = np.array([(x, y) for x in (low_x, high_x) for y in (low_y, high_y)])
    c, s = math.cos(camera.roll), math.sin(camera.roll)
    u = c * corners[:, 0] - s * corners[:, 1]
    v = -s * corners[:, 0] - c * corners[:, 1]
    scale = camera.pixels_per_metre or _FILLED * min(
        camera.width / np.ptp(u), camera.height / np.ptp(v)
    )
    pivot_u, pivot_v = camera.pivot_u, camera.pivot_v
    if pivot_u == -1.0:
        pivot_u = 0.5 * (camera.width - 1) - scale * 0.5 * (u.min() + u.max())
    if pivot_v == -1.0:
        pivot_v = 0.5 * (camera.height - 1) - scale * 0.5 * (v.min() + v.max())
    return replace(
        camera, pixels_per_metre=float(scale), pivot_u=float(pivot_u), pivot_v=float(pivot_v)
    )


def _states(motion: Motion, projection: Projection, times: Floats) -> Floats:
    """Return undistorted u, v of pivot and balls at instants, shape (..., point, 2)."""
    pivot, _ = motion.at(times)
    points = [projection.flat(x, y) for x, y in (pivot, *motion.balls(times))]
    return np.moveaxis(np.array(points), (0, 1), (-2, -1)).copy()


def _touches(motion: Motion, moments: Floats) -> Any:
    """Return whether balls touch in each exposure; `moments` has the shape (moment, frame)."""
    if len(motion.angles) == 1:
        return np.zeros(moments.shape[1], bool)
    first = np.searchsorted(motion.contacts, moments[0])
    last = np.searchsorted(motion.contacts, moments[-1], side="right")
    _, (right, left) = motion.at(moments)
    apart = right - left
    near = np.minimum(apart - motion.separation, 2.0 * math.pi - motion.separation - apart)
    return (last > first) | (near.min(axis=0) < _TOUCHING)
