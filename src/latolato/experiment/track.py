"""A video becomes a table of angles about the moving pivot."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.experiment.calibrate import Calibration, Optics, calibrate
from latolato.experiment.table import track_table
from latolato.experiment.tracking.follow import Followed, follow
from latolato.experiment.tracking.learn import Scene, learn_scene
from latolato.experiment.tracking.sample import read_sample
from latolato.experiment.video import Limits, Video, digest_of, open_video
from latolato.physics.pendulum import GRAVITY

if TYPE_CHECKING:
    import xarray as xr

Place = Sequence[float]


def track(
    path: str | Path,
    *,
    pivot: Place,
    balls: Sequence[Place],
    length: float | None = None,
    radius: float | None = None,
    gravity: float = GRAVITY,
    optics: Optics | None = None,
    slow_motion: float = 1.0,
    limits: Limits | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    video = open_video(path, slow_motion=slow_motion, limits=limits)
    hinge = _place("pivot", pivot, video)
    starts = [_place("ball", ball, video) for ball in balls]
    sample = read_sample(video)
    arm = float(np.mean([np.hypot(*(ball - hinge)) for ball in starts]))
    expected = radius / length * arm if radius and length else None
    scene = learn_scene(video, sample, hinge, starts, expected)
    stiffness = gravity / length if length else 0.0
    seen = follow(video, scene, sample.interval, len(sample.times), stiffness)
    measured = calibrate(seen, (video.width, video.height), video.rotation, optics)
    return _table(video, scene, seen, measured, length, radius)


def _place(name: str, place: Place, video: Video) -> np.ndarray:
    at = np.array([float(number) for number in place])
    if at.shape != (2,) or not np.isfinite(at).all():
        raise ValueError(f"{name} must be a column and a row in pixels, got {tuple(place)}")
    if not (0 <= at[0] <= video.width - 1 and 0 <= at[1] <= video.height - 1):
        raise ValueError(
            f"{name} at ({at[0]:g}, {at[1]:g}) lies outside the frame of {video.width} x "
            f"{video.height} pixels"
        )
    return at


def _table(
    video: Video,
    scene: Scene,
    seen: Followed,
    measured: Calibration,
    length: float | None,
    radius: float | None,
) -> xr.Dataset:
    warnings = list(measured.warnings)
    scale = length / measured.arm if length else math.nan
    found_radius = scene.look.radius * scale
    turn = measured.tilt
    right = np.array([math.cos(turn), -math.sin(turn)])
    down = np.array([math.sin(turn), math.cos(turn)])
    origin = np.nanmean(measured.pivots, axis=0)

    def metres(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        away = (places - origin) * scale
        return away @ right, -(away @ down)

    columns: dict[str, Any] = {"time": seen.times}
    columns["pivot_x"], columns["pivot_y"] = metres(measured.pivots)
    for b in range(seen.centres.shape[1]):
        columns[f"ball_{b + 1}_x"], columns[f"ball_{b + 1}_y"] = metres(measured.centres[:, b])
        columns[f"angle_{b + 1}"] = measured.angles[:, b]
        columns[f"angle_sigma_{b + 1}"] = measured.sigmas[:, b]
        columns[f"flag_{b + 1}"] = seen.flags[:, b]
    if radius and length and abs(found_radius / radius - 1.0) > 0.03:
        warnings.append(
            f"the balls' radius is {found_radius * 1e3:.2f} mm by the length's scale, declared "
            f"were {radius * 1e3:.2f} mm: is the length from pivot to ball centre right?"
        )
    attributes = {
        "source": video.path.name,
        "source_sha256": digest_of(video.path),
        "length": length,
        "radius": radius,
        "metres_per_pixel": scale if length else None,
        "measured_radius": found_radius if length else None,
        "gravity_direction": measured.tilt,
        "gravity_source": measured.tilt_source,
        "exposure": scene.look.exposure,
        "pivot_offset_x": float(measured.offset[0]),
        "pivot_offset_y": float(measured.offset[1]),
        "arm_pixels": measured.arm,
        "arc": measured.arc,
        "circle_residual": measured.circle_residual,
        "warnings": "; ".join(warnings) or None,
    }
    return track_table(columns, attributes)
