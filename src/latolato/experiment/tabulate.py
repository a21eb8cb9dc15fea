"""Tracks as a table: in metres where a scale is known, with what was asked for and measured."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.experiment.calibration.scale import TOLERANCE, Scale, scale_of, stick_pixels
from latolato.experiment.calibration.tilt import Tilt
from latolato.experiment.follow import PathOnly, Track
from latolato.experiment.period import halves_apart, period_of
from latolato.experiment.rules import broken, place_text, said
from latolato.experiment.task import Task
from latolato.experiment.track_table import track_table
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.video import digest_of

if TYPE_CHECKING:
    import xarray as xr

# Share of clean samples below which something that is not known to swing was no ball.
_AT_LEAST = 0.5


def angle_table(task: Task, tracks: list[Track]) -> xr.Dataset:
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
        task.warnings.append(said("no_scale"))
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


def _scale(task: Task, tracks: list[Track]) -> Scale | None:
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
    doubt = TOLERANCE + 2.0 * math.hypot(*(arms[:, 1] / arms[:, 0]))
    if setup.length and longest[0] / shortest[0] - 1.0 > doubt:
        one, other = (f"{arm:.0f}" for arm in arms[:, 0])
        raise broken("two_lengths", {"one": one, "other": other})
    arm, radius = arms.mean(axis=0), looks.mean(axis=0)
    return scale_of(setup, (video.width, video.height), tuple(arm), tuple(radius))


def _warn_of(task: Task, track: Track, scale: Scale | None) -> None:
    """Warn of a pivot that was fitted from the arc, and of sizes that do not fit the scale."""
    setup, video = task.setup, task.video
    hinge, look = track.measured.hinge, track.scene.look
    if hinge.source == "arc":
        has_scale = scale and scale.source == "length"
        rule = "pivot_and_scale_of_arc" if has_scale else "pivot_of_arc"
        place, percent = place_text(track.measured.pivots[0]), 100.0 * hinge.scale_sigma
        task.warnings.append(said(rule, place=place, percent=percent))
    if scale is None:
        return
    sizes = [("radius", setup.radius, look.radius, look.radius_sigma)]
    if setup.stick is not None:
        pixels = stick_pixels(setup, (video.width, video.height))
        sizes.append(("stick", setup.stick_length, pixels, math.sqrt(2.0)))
    for name, declared, pixels, sigma in sizes:
        doubt = TOLERANCE + math.hypot(sigma / pixels, 2.0 * scale.share)
        if declared and abs(pixels * scale.metres / declared - 1.0) > doubt:
            measured, told = (f"{1e3 * size:.2f}" for size in (pixels * scale.metres, declared))
            rule = f"other_{name}_by_{scale.source}"
            task.warnings.append(said(rule, measured=measured, declared=told))


def _measured(task: Task, track: Track, scale: Scale | None) -> dict[str, Any]:
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
        "pivot_source": "paths" if track.scene.pivot.motion is not None else hinge.source,
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


def path_table(task: Task, sample: Sample, path: PathOnly) -> xr.Dataset:
    """Return the table of balls about an unknown pivot: their places in the image, no angles."""
    seen = path.seen
    columns = _frames(task, seen.times)
    for b in range(seen.centres.shape[1]):
        columns[f"ball_{b + 1}_u"], columns[f"ball_{b + 1}_v"] = seen.centres[:, b].T
        columns[f"flag_{b + 1}"] = seen.flags[:, b]
    task.warnings.append(said("unknown_geometry", doubt=path.doubt))
    period, sigma = period_of(seen.times, seen.centres[:, 0])
    apart = halves_apart(seen.times, seen.centres[:, 0])
    if apart is not None:
        task.warnings.append(said("period_changes", before=apart[0], after=apart[1]))
    if math.isnan(period):
        share = seen.clean_share(~sample.repeats)
        if share < _AT_LEAST:  # nothing says that it swings
            place = {"place": place_text(task.setup.balls[0]), "frame": task.setup.click_frame}
            why = {"percent": f"{100.0 * share:.0f}", "doubt": path.doubt}
            raise broken("rarely_found_path", {**place, **why})
        task.warnings.append(said("no_period"))
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
        **vars(setup.optics),
        "proposed": int(setup.is_proposed),
        **clicks,
    }
