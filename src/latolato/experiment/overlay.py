"""Draws the tracked pivot and balls onto the video, for inspection."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.atomic import atomic_path
from latolato.experiment.calibration.lens import Optics, distorted
from latolato.experiment.calibration.tilt import tilt_of
from latolato.experiment.encode import TICKS, write_video
from latolato.experiment.opencv import import_cv2
from latolato.experiment.sidecar import Setup
from latolato.experiment.track_table import OUTSIDE_SOURCES, balls_of, has_own_pivots
from latolato.experiment.tracking.kernels.layers import colour_coefficients
from latolato.experiment.video import Frame, Video
from latolato.io.files import check_suffix

if TYPE_CHECKING:
    import xarray as xr

# Okabe and Ito's colours, told apart by colour-blind eyes (red, green, blue); shapes differ too.
COLOURS = {
    "ok": (86, 180, 233),
    "collision": (240, 228, 66),
    "occluded": (230, 159, 0),
    "manual": (0, 158, 115),
    "predicted": (204, 121, 167),
    "lost": (213, 94, 0),
}
_PIVOT = (255, 255, 255)
_DARK = (20, 22, 28)
_CRF, _QUALITY = 23, 82
# Subpixels per pixel, as a power of two, in which OpenCV takes places.
_SHIFT = 4


def places_of(table: xr.Dataset, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return pivot (frame, 2) and balls (frame, ball, 2) of a table in the picture [pixels].

    Parameters
    ----------
    table : xarray.Dataset
        A track table.
    size : tuple of int
        Width and height of the picture [pixels].
    """
    names = ["pivot", *(f"ball_{b}" for b in range(1, balls_of(table) + 1))]
    pivot, *centres = (place_of(table, name, size) for name in names)
    return pivot, np.stack(centres, axis=1)


def place_of(table: xr.Dataset, name: str, size: tuple[int, int]) -> np.ndarray:
    """Positions of ``pivot``, ``pivot_2`` or ``ball_1`` in the picture [pixels]; NaN is unknown.

    Shape (frame, 2).
    """
    attrs = table.attrs
    ends = "xy" if "metres_per_pixel" in attrs else "uv"
    columns = [f"{name}_{end}" for end in ends]
    if columns[0] not in table.variables:
        return np.full((table.sizes["frame"], 2), np.nan)
    first, second = (table[column].values for column in columns)
    place = np.stack([first, second], axis=-1)
    if ends == "xy":
        tilt, scale = float(attrs["gravity_direction"]), float(attrs["metres_per_pixel"])
        right = np.array([math.cos(tilt), -math.sin(tilt)])
        down = np.array([math.sin(tilt), math.cos(tilt)])
        origin = np.array([attrs["origin_u"], attrs["origin_v"]])
        flat = (np.outer(first, right) - np.outer(second, down)) / scale
        place = origin + tilt_of(attrs, name).seen(flat)
    source = {"pivot": "pivot_source", "pivot_2": "pivot_source_2"}.get(name)
    if attrs.get(source) in OUTSIDE_SOURCES:
        return place  # far out of the picture the lens's polynomial means nothing
    optics = Optics(
        lens_k1=float(attrs.get("lens_k1", 0.0)), lens_k2=float(attrs.get("lens_k2", 0.0))
    )
    return distorted(place, size, optics)


def write_overlay(
    table: xr.Dataset,
    video: Video,
    path: str | Path,
    *,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write the video with pivot, rods and balls drawn on it, and return the path.

    Circles have the colour of the sample's flag, which is written next to them unless it is ok;
    the number and time of the frame are in the corner. The frames keep their times. The file is
    written completely or not at all.

    Parameters
    ----------
    table : xarray.Dataset
        The track table of this video.
    video : Video
        As `open_video` returns it.
    path : str or Path
        Name of the new video, ending in ``.mp4``.
    progress : callable, optional
        Called with the fraction done, from 0 to 1.
    """
    path = Path(path)
    check_suffix(path, (".mp4",), "the name of an overlay")
    even = video.width // 2 * 2, video.height // 2 * 2
    times = table["time"].values
    rate = 1.0 / float(np.median(np.diff(times))) if len(times) > 1 else 30.0

    def frames() -> Iterator[tuple[int, Any]]:
        cv2 = import_cv2()
        artist = Artist(table, (video.width, video.height))
        stamp = -1
        for frame in video.frames():
            if frame.number >= len(times):
                break
            picture = artist.drawn(picture_of(frame, video), frame.number)
            planes = cv2.cvtColor(picture[: even[1], : even[0]], cv2.COLOR_RGB2YUV_I420)
            stamp = max(round((frame.time - times[0]) * TICKS), stamp + 1)
            yield stamp, planes
            if progress:
                progress((frame.number + 1) / len(times))

    with atomic_path(path) as unfinished:
        write_video(unfinished, frames(), fps=min(rate, 1000.0), crf=_CRF, rotation=0)
    return path


def picture_of(frame: Frame, video: Video) -> np.ndarray:
    """Return a frame as red, green and blue of 0 to 255, shape (row, column, 3)."""
    cv2 = import_cv2()
    height, width = frame.luma.shape
    blue, red = (
        cv2.resize(np.ascontiguousarray(plane), (width, height)).astype(np.float32) - 128.0
        for plane in frame[3:]
    )
    gain, black, *weights = colour_coefficients(video.matrix, video.is_full_range)
    light = gain * (frame.luma - black)
    colours = [weights[0] * red, weights[1] * blue + weights[2] * red, weights[3] * blue]
    picture = np.dstack([light + colour for colour in colours])
    return np.clip(picture + 0.5, 0.0, 255.0).astype(np.uint8)


class Artist:
    """Draws one table's samples on frames."""

    def __init__(self, table: xr.Dataset, size: tuple[int, int]) -> None:
        pivot, self.centres = places_of(table, size)
        self.pivots = (
            [pivot, place_of(table, "pivot_2", size)] if has_own_pivots(table) else [pivot] * 2
        )
        radius = float(table.attrs.get("radius_pixels", 0.02 * min(size)))
        self.radii = [radius, float(table.attrs.get("radius_pixels_2", radius))]
        self.times, self.numbers = table["time"].values, table["frame"].values
        balls = range(1, balls_of(table) + 1)
        self.flags = np.stack([table[f"flag_{b}"].values for b in balls], axis=-1)
        self.angles = np.stack([table[f"angle_{b}"].values for b in balls], axis=-1)
        self.line = max(1, round(min(size) / 500.0))
        self.text = max(0.35, min(size) / 1300.0)

    def drawn(self, picture: np.ndarray, number: int, *, has_text: bool = True) -> np.ndarray:
        """Return a picture with the samples of a frame on it, and with what they are in words."""
        picture = np.ascontiguousarray(picture)
        for b, flag in enumerate(self.flags[number]):
            centre, colour = self.centres[number, b], COLOURS[str(flag)]
            pivot, radius = self.pivots[b][number], self.radii[b]
            if has_text and flag != "ok":
                self._write(picture, f"ball {b + 1} {flag}", 2 + b, colour)
            if not np.isfinite(centre).all():
                continue
            away = centre - pivot
            if np.isfinite(away).all():
                end = centre - away * min(radius / max(float(np.hypot(*away)), 1e-9), 1.0)
                _line(picture, pivot, end, colour, self.line)
            _circle(picture, centre, radius, colour, self.line)
            _circle(picture, centre, 1.0, colour, self.line)
        for pivots in self.pivots:
            if np.isfinite(pivots[number]).all():
                _cross(picture, pivots[number], 0.5 * self.radii[0] + 3.0, self.line)
        if not has_text:
            return picture
        degrees = ", ".join(
            f"{math.degrees(angle):.1f} deg"
            for angle in self.angles[number]
            if math.isfinite(angle)
        )
        text = f"frame {self.numbers[number]}   {self.times[number]:.3f} s   {degrees}"
        self._write(picture, text, 1, _PIVOT)
        return picture

    def _write(self, picture: Any, text: str, row: int, colour: Any) -> None:
        """Write a line of text in the lower left corner; `row` counts from below."""
        cv2 = import_cv2()
        font, step = cv2.FONT_HERSHEY_SIMPLEX, round(42 * self.text)
        u, v = round(14 * self.text), picture.shape[0] - step * row + step // 2
        (width, height), low = cv2.getTextSize(text, font, self.text, self.line)
        corner, other = (u - 4, v - height - 4), (u + width + 4, v + low)
        cv2.rectangle(picture, corner, other, _DARK, cv2.FILLED)
        cv2.putText(picture, text, (u, v), font, self.text, colour, self.line, cv2.LINE_AA)


def _line(picture: Any, begin: Any, end: Any, colour: Any, line: int) -> None:
    """Draw a line over a darker one, to be seen on any ground."""
    cv2 = import_cv2()
    for width, ink in ((2 * line, _DARK), (line, colour)):
        cv2.line(picture, _fixed(begin), _fixed(end), ink, width, cv2.LINE_AA, _SHIFT)


def _circle(picture: Any, centre: Any, radius: float, colour: Any, line: int) -> None:
    """Draw a circle over a darker one."""
    cv2 = import_cv2()
    size = round(radius * 2**_SHIFT)
    for width, ink in ((2 * line, _DARK), (line, colour)):
        cv2.circle(picture, _fixed(centre), size, ink, width, cv2.LINE_AA, _SHIFT)


def _cross(picture: Any, centre: Any, half: float, line: int) -> None:
    """Draw the pivot."""
    for away in (np.array([half, 0.0]), np.array([0.0, half])):
        _line(picture, centre - away, centre + away, _PIVOT, line)


def _fixed(place: Any) -> tuple[int, int]:
    """Return a place in OpenCV's fixed-point numbers."""
    u, v = np.clip(np.rint(np.asarray(place) * 2**_SHIFT), -(2**24), 2**24)
    return int(u), int(v)


def draw_proposal(
    video: Video, setup: Setup, path: str | Path, radius: float | None = None
) -> Path:
    """Write the clicked frame with pivot and balls marked as PNG and return the path."""
    path = Path(path)
    check_suffix(path, (".png",), "the name of a picture")
    whole = replace(video, start=-math.inf, end=math.inf)
    at = setup.click_frame - video.first_frame
    frame = next(frame for frame in whole.frames() if frame.number >= at)
    picture = np.ascontiguousarray(picture_of(frame, video))
    side = min(video.width, video.height)
    line, size = max(1, round(side / 400.0)), radius or 0.03 * side
    for ball, pivot, flag in zip(setup.balls, setup.pivots, ("ok", "occluded"), strict=False):
        if pivot is not None:
            _line(picture, pivot, ball, COLOURS[flag], line)
            _cross(picture, np.array(pivot), size, line)
        _circle(picture, ball, size, COLOURS[flag], line)
    with atomic_path(path) as unfinished:
        unfinished.write_bytes(encoded(picture, ".png"))
    return path


def encoded(picture: np.ndarray, suffix: str) -> bytes:
    """Return a picture of red, green and blue as the content of a file, ``.png`` or ``.jpg``."""
    cv2 = import_cv2()
    flags = [cv2.IMWRITE_JPEG_QUALITY, _QUALITY] if suffix == ".jpg" else []
    _, content = cv2.imencode(suffix, cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), flags)
    return bytes(content)
