"""Animations of a run: pivot, rods or strings and balls to scale, beside curves with a cursor."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.atomic import atomic_path, check_folder, checked_path
from latolato.core.errors import InputError, import_extra
from latolato.core.language import local, tr
from latolato.core.quantities import Range
from latolato.core.registry import checked_number, in_unit
from latolato.figures import style
from latolato.figures.run import ball_angles
from latolato.io.files import check_suffix

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Pixels = NDArray[np.uint8]

SUFFIXES = (".mp4", ".gif")
# Width and height [pixel]; video codecs need even numbers.
SIZES = {".mp4": (960, 540), ".gif": (640, 360)}
# More frames than this are refused: nobody would watch them.
MOST_FRAMES = 100_000
FRAME_RATES = Range(low=1.0, high=100.0)
SPEEDS = Range(low=0.0, high=1e6, open_low=True)
_ALMOST_WHITE = 246
# Palette entry of a GIF that leaves a pixel as it was.
_UNCHANGED = 255
# A ball of unknown or zero radius is drawn with this share of the length.
_SHOWN_RADIUS = 0.04
# A string is slack below this share of its length, and drawn with so many points.
_TAUT, _POINTS = 1.0 - 1e-6, 33
# Length of the zoomed curve, in natural periods.
_WINDOW = 8.0


def animate(
    run: xr.Dataset,
    path: str | Path,
    *,
    speed: float = 1.0,
    fps: float = 30.0,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write an animation of a run as MP4 or GIF by suffix and return the path.

    Parameters
    ----------
    run : xarray.Dataset
        What `latolato.simulate` or `latolato.load` returned.
    path : str or Path
        A name ending in ``.mp4`` (needs the extra `video`) or ``.gif``.
    speed : float
        How much faster than reality it plays.
    fps : float
        Frames per second, in [1, 100]; a GIF rounds the time of a frame to 10 ms.
    progress : callable, optional
        Called with the fraction done.

    Raises
    ------
    InputError
        For an unknown suffix, a number out of range or more than 100000 frames.
        For MP4 without the extra `video`.
    OSError
        If the file cannot be written; nothing is left of it.
    """
    path = checked_path("path", path)
    check_target(path, speed, fps)
    suffix = path.suffix.lower()
    pause = 1 / Fraction(in_unit("fps", fps, "Hz"))
    if suffix == ".gif":
        pause = Fraction(max(2, round(100 * pause)), 100)  # s; most viewers slow down below 20 ms
    write = _write_gif if suffix == ".gif" else _write_mp4
    note = tr("speed {speed}", speed=f"{speed:g}")
    frames = _frames(run, SIZES[suffix], float(pause) * speed, note, progress)
    with atomic_path(path) as unfinished:
        write(frames, SIZES[suffix], pause, unfinished)
    return path


def check_target(path: str | Path, speed: float, fps: float) -> None:
    """Raise unless `animate` can do this: a known suffix, its extra, a folder, numbers in range."""
    checked_number("speed", speed, SPEEDS, "1")
    checked_number("fps", fps, FRAME_RATES, "Hz")
    if check_suffix(path, SUFFIXES, "the name of an animation") == ".mp4":
        _av()
    check_folder(Path(path))


def _frames(
    run: xr.Dataset,
    size: tuple[int, int],
    step: float,
    note: str,
    progress: Callable[[float], None] | None,
) -> Iterator[Pixels]:
    """Yield the pictures, shape (height, width, 4), every `step` seconds of the run.

    The array is the same one each time: use it before asking for the next.
    """
    import xarray as xr

    if not isinstance(run, xr.Dataset):
        raise InputError("animate needs a run: what simulate or load returned", value=run)
    if "angle" not in run or "time" not in run.dims:
        raise InputError("animate needs a run: a dataset with angle over time")
    finite = np.isfinite(next(iter(ball_angles(run).values())))
    run = run.isel(time=slice(0, int(np.count_nonzero(finite))))
    span = float(run["time"][-1] - run["time"][0])
    count = math.floor(span / step) + 1
    if count > MOST_FRAMES:
        raise InputError(
            f"an animation may have {MOST_FRAMES} frames",
            value=count,
            way_out=f"raise speed to {math.ceil(span / step / MOST_FRAMES)} times as much, or "
            "lower fps",
        )
    instants = float(run["time"][0]) + step * np.arange(count)
    with style.use_style():
        scene = Scene(run, size, note)
        for i, instant in enumerate(instants.tolist()):
            yield scene.picture(instant)
            if progress is not None and (i % 16 == 15 or i == count - 1):
                progress((i + 1) / count)


class Scene:
    """A picture in which only the moving parts are redrawn.

    Parameters
    ----------
    run : xarray.Dataset
        The run, without NaN.
    size : tuple of int
        Width and height [pixel].
    note : str
        How fast it plays.
    """

    def __init__(self, run: xr.Dataset, size: tuple[int, int], note: str) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self._time = run["time"].values
        self._angles = ball_angles(run)
        self._pivot = run["pivot_height"].values
        in_plane = "pivot_across" in run
        self._across = run["pivot_across"].values if in_plane else np.zeros_like(self._pivot)
        self._lengths, self._radii = _sizes(run)
        self._distances = _distances(run, self._lengths)
        width, height = size
        dpi = width / style.PAGE
        figure = Figure(figsize=(style.PAGE, height / dpi), dpi=dpi)
        make_canvas: Any = FigureCanvasAgg
        self._canvas = make_canvas(figure)
        self._moving: list[tuple[Any, Any]] = []
        self._draw_mechanism(figure, note)
        self._draw_curves(figure, run)
        self._canvas.draw()
        self._background = self._canvas.copy_from_bbox(figure.bbox)

    def picture(self, instant: float) -> Pixels:
        """Return the picture at an instant [s], shape (height, width, 4)."""

        def now(values: Floats) -> float:
            return float(np.interp(instant, self._time, values))

        across, height = now(self._across), now(self._pivot)
        self._block.set_x(across - 0.5 * self._block.get_width())
        self._block.set_y(height - 0.5 * self._block.get_height())
        for name, angle in self._angles.items():
            turned, distance = now(angle), now(self._distances[name])
            x, y = distance * math.sin(turned), -distance * math.cos(turned)
            string = string_points(x, y, self._lengths[name])
            self._rods[name].set_data(across + string[0], height + string[1])
            self._balls[name].set_center((across + x, height + y))
        self._clock.set_text(local(f"t = {instant:.2f} s"))
        self._cursor.set_xdata([instant, instant])
        half = 0.5 * self._window
        first, last = np.searchsorted(self._time, [instant - half, instant + half])
        for name, line in self._zoomed.items():
            part = slice(max(first - 1, 0), last + 1)
            line.set_data(self._time[part] - instant, self._angles[name][part])
        self._canvas.restore_region(self._background)
        for axes, artist in self._moving:
            axes.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())

    def _add(self, axes: Any, artist: Any) -> Any:
        """Return an artist that is redrawn in every picture."""
        artist.set_animated(True)
        self._moving.append((axes, artist))
        return artist

    def _draw_mechanism(self, figure: Any, note: str) -> None:
        """Draw the guide; prepare pivot, rods and balls in a view that holds the whole motion."""
        from matplotlib.patches import Circle, Rectangle

        axes = figure.add_axes((0.01, 0.02, 0.42, 0.96))
        axes.set_axis_off()
        longest = max(self._lengths.values())
        reach, low, high = 0.0, self._pivot.min(), self._pivot.max()
        for name, angle in self._angles.items():
            distance, radius = self._distances[name], self._radii[name]
            heights = self._pivot - distance * np.cos(angle)
            ways = self._across + distance * np.sin(angle)
            reach = max(reach, float(np.abs(ways).max()) + radius)
            low = min(low, float(heights.min()) - radius)
            high = max(high, float(heights.max()) + radius)
        # Both directions get the scale at which the motion fits with a margin.
        box = axes.get_window_extent()
        margin = 0.08 * longest
        scale = max(2.0 * (reach + margin) / box.width, (high - low + 2.0 * margin) / box.height)
        middle = 0.5 * (low + high)
        axes.set_xlim(-0.5 * scale * box.width, 0.5 * scale * box.width)
        axes.set_ylim(middle - 0.5 * scale * box.height, middle + 0.5 * scale * box.height)
        axes.plot(self._across, self._pivot, color=style.PALE_GREY, lw=6.0, solid_capstyle="round")
        width, height = 0.10 * longest, 0.05 * longest
        block = Rectangle((-0.5 * width, 0.0), width, height, fc=style.GREY, ec=style.INK)
        self._rods: dict[str, Any] = {}
        self._balls: dict[str, Any] = {}
        for name in self._angles:
            (rod,) = axes.plot([], [], color=style.INK)
            self._rods[name] = self._add(axes, rod)
        self._block = self._add(axes, axes.add_patch(block))
        for name in self._angles:
            colour = style.RED if name == "left" else style.BLUE
            ball = Circle((0.0, 0.0), self._radii[name], fc=colour, ec=style.INK)
            self._balls[name] = self._add(axes, axes.add_patch(ball))
        figure.text(0.02, 0.03, note, color=style.GREY)
        clock = figure.text(0.02, 0.95, "", fontsize=style.LARGE, va="top")
        self._clock = self._add(figure, clock)

    def _draw_curves(self, figure: Any, run: xr.Dataset) -> None:
        """Draw the whole curve; prepare its cursor and, for a long run, the part around now."""
        span = float(self._time[-1] - self._time[0])
        self._window = _WINDOW * 2.0 * math.pi / float(run.attrs["natural_frequency"])
        is_long = span > 2.0 * self._window
        whole = figure.add_axes((0.52, 0.60 if is_long else 0.14, 0.46, 0.36 if is_long else 0.82))
        colours = {name: style.RED if name == "left" else style.BLUE for name in self._angles}
        for name, angle in self._angles.items():
            whole.plot(self._time, angle, color=colours[name], lw=style.THIN)
        style.show_unit(whole.yaxis, run["angle"], short=True)
        whole.set_xlabel(style.label(run["time"]))
        cursor = whole.axvline(self._time[0], color=style.INK, lw=style.LINE)
        self._cursor = self._add(whole, cursor)
        self._zoomed: dict[str, Any] = {}
        if not is_long:
            return
        part = figure.add_axes((0.52, 0.14, 0.46, 0.30))
        part.set_xlim(-0.5 * self._window, 0.5 * self._window)
        part.set_ylim(whole.get_ylim())
        part.axvline(0.0, color=style.INK, lw=style.LINE)
        style.show_unit(part.yaxis, run["angle"], short=True)
        part.set_xlabel(f"{tr('time from now')} [{run['time'].attrs['units']}]")
        for name in self._angles:
            (line,) = part.plot([], [], color=colours[name])
            self._zoomed[name] = self._add(part, line)


def string_points(x: float, y: float, length: float) -> Floats:
    """Return a string from the pivot to a ball at (x, y) [m], shape (2, point).

    A slack one is the arc of a parabola, ``u (x, y) - (0, 4 sag u (1 - u))``, of its own length.
    """
    from scipy.optimize import brentq

    if math.hypot(x, y) >= _TAUT * length:
        return np.array([[0.0, x], [0.0, y]])
    h = max(abs(x), 1e-9 * length)

    def area(rise: float) -> float:
        return 0.5 * (rise * math.hypot(h, rise) + h * h * math.asinh(rise / h))

    def excess(sag: float) -> float:  # the slope changes steadily along the arc
        return (area(y + 4.0 * sag) - area(y - 4.0 * sag)) / (8.0 * sag) - length

    sag = brentq(excess, 1e-6 * length, length)
    u = np.linspace(0.0, 1.0, _POINTS)
    return np.array([u * x, u * y - 4.0 * sag * u * (1.0 - u)])


def _distances(run: xr.Dataset, lengths: dict[str, float]) -> dict[str, Floats]:
    """Return how far every ball is from the pivot [m], shape (time,)."""
    if "distance" not in run:
        return {name: np.full(run.sizes["time"], length) for name, length in lengths.items()}
    by_ball = "ball" in run["distance"].dims
    return {
        name: run["distance"].sel(ball=name).values if by_ball else run["distance"].values
        for name in lengths
    }


def _sizes(run: xr.Dataset) -> tuple[dict[str, float], dict[str, float]]:
    """Return length and drawn radius of every ball [m]."""
    lengths, radii = {}, {}
    for name in ball_angles(run):
        prefix = f"{name}_" if "ball" in run["angle"].dims else ""
        lengths[name] = float(run.attrs[f"{prefix}length"])
        radius = float(run.attrs.get(f"{prefix}radius", 0.0))
        radii[name] = radius or _SHOWN_RADIUS * lengths[name]
    return lengths, radii


def _write_mp4(
    frames: Iterator[Pixels], size: tuple[int, int], pause: Fraction, path: Path
) -> None:
    """Write pictures as H.264, which every browser plays."""
    av = _av()
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as file:
        stream = file.add_stream("libx264", rate=1 / pause)
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        stream.options = {"preset": "veryfast", "crf": "20"}
        for pixels in frames:
            file.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgba")))
        file.mux(stream.encode())


def _write_gif(
    frames: Iterator[Pixels], size: tuple[int, int], pause: Fraction, path: Path
) -> None:
    """Write pictures one by one; Pillow's own writer would keep them all in memory."""
    from PIL import GifImagePlugin, Image

    gif: Any = GifImagePlugin
    about: dict[str, Any] = {"duration": int(1000 * pause), "loop": 0}
    with path.open("wb") as file:
        palette, last = None, np.empty(0, np.uint8)
        for pixels in frames:
            picture = Image.frombytes("RGBA", size, pixels.tobytes()).convert("RGB")
            if palette is None:
                palette = _palette_of(picture)
                first = picture.quantize(palette=palette, dither=Image.Dither.NONE)
                last = np.asarray(first)
                file.writelines(gif.getheader(first.copy(), info=about)[0])
                file.writelines(gif.getdata(first, **about))
                continue
            new = np.asarray(picture.quantize(palette=palette, dither=Image.Dither.NONE))
            part, corner = _difference(new, last)
            change = Image.frombytes("P", part.shape[::-1], part.tobytes())
            file.writelines(
                gif.getdata(change, corner, transparency=_UNCHANGED, disposal=1, **about)
            )
            last = new
        file.write(b";")


def _palette_of(picture: Any) -> Any:
    """Return an image whose palette suits a picture and leaves one entry free."""
    reduced = picture.quantize(_UNCHANGED)
    colours = np.array(reduced.getpalette()).reshape(-1, 3)
    # Pillow takes any of several near-whites for white, which would tint the ground.
    colours[colours.min(axis=1) > _ALMOST_WHITE] = 255
    reduced.putpalette(colours.ravel().tolist() + [0] * (3 * 256 - colours.size))
    return reduced


def _difference(new: Pixels, last: Pixels) -> tuple[Pixels, tuple[int, int]]:
    """Return the smallest part that holds every changed pixel, and its left upper corner."""
    differs = new != last
    rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    if not rows.size:
        return np.full((1, 1), _UNCHANGED, np.uint8), (0, 0)
    box = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
    part = np.where(differs[box], new[box], np.uint8(_UNCHANGED))
    return part, (int(columns[0]), int(rows[0]))


def _av() -> Any:
    return import_extra("av", "video", "an MP4", way_out="write a .gif")
