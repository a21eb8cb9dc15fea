"""The page on one track table: what was found, how well, and which frames deserve a look."""

from __future__ import annotations

import base64
import io
import math
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.versions import version_of
from latolato.experiment.overlay import Artist, encoded, picture_of
from latolato.experiment.quality import (
    circle_distances,
    clock_text,
    flag_shares,
    pivot_harmonic,
    pivot_numbers,
    pivot_places,
    pivot_text,
    typical_sigma,
)
from latolato.experiment.track_table import FLAGS, balls_of
from latolato.experiment.video import Frame, Video
from latolato.figures.style import BLUE, GREEN, GREY, INK, ORANGE, RED, THIN, new_figure, use_style
from latolato.report.templates import environment

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Colour and shape of a flag in graphs.
MARKS = {
    "collision": (GREEN, "^"),
    "occluded": (ORANGE, "s"),
    "manual": (GREEN, "o"),
    "predicted": (RED, "D"),
    "lost": (INK, "x"),
}
BALL_COLOURS = (BLUE, RED)
MEANINGS = {
    "ok": "measured, apart from the other ball",
    "collision": "measured while the balls touch",
    "occluded": "measured, partly hidden",
    "manual": "set by hand",
    "predicted": "not seen for a moment: on a smooth curve between before and after",
    "lost": "not seen, and no number given",
}
GEOMETRIES = {
    "metric": "positions in metres, angles about the moving pivot",
    "angles": "no scale was given: angles are known, positions in pixels only",
    "unknown": "no pivot is known: positions of the ball in pixels, no angles",
}
# Frames shown as thumbnails, and their half width in radii of the ball.
_WORST, _AROUND = 8, 4.0
_THUMB = 260


def write_track_report(table: xr.Dataset, video: Video, path: str | Path) -> Path:
    """Write the page on a track table as one HTML file and return the path.

    The page holds everything it shows and asks nothing of a network. It appears whole or not at
    all.

    Parameters
    ----------
    table : xarray.Dataset
        The track table of the video.
    video : Video
        As `open_video` returns it.
    path : str or Path
        A name ending in ``.html``.
    """
    from latolato.core.atomic import atomic_path
    from latolato.io.files import check_suffix

    path = Path(path)
    check_suffix(path, (".html",), "the name of a report")
    page = render(table, video)
    with atomic_path(path) as unfinished:
        unfinished.write_text(page, encoding="utf-8")
    return path


def render(table: xr.Dataset, video: Video) -> str:
    """Return the page."""
    worst = worst_frames(table)
    frames = {0, *(number for number, _ in worst)}
    kept: dict[int, Frame] = {}
    for frame in video.frames():
        if frame.number in frames:
            kept[frame.number] = Frame(*frame[:2], *(plane.copy() for plane in frame[2:]))
        if frame.number >= max(frames):
            break
    artist = Artist(table, (video.width, video.height))
    first = artist.drawn(picture_of(kept[0], video), 0)
    notes = [text for text in str(table.attrs.get("warnings", "")).split("; ") if text]
    source = str(table.attrs["source"])
    template = environment("report").get_template("track.html")
    return template.render(
        version=version_of(),
        title=f"Tracked: {source}",
        meta=f"latolato {version_of()}, {datetime.now(UTC):%Y-%m-%d}. "
        f"{video.width} x {video.height} pixels, {table.sizes['frame']} frames, "
        f"{float(table.time[-1] - table.time[0]):.4g} s. SHA-256 "
        f"{table.attrs['source_sha256'][:16]}…",
        warnings=notes,
        numbers=_numbers(table),
        first=_base64(encoded(_fitted(first, 1100), ".jpg")),
        graphs=[(_png(figure), text) for figure, text in _figures(table)],
        flags=_flags(table),
        worst=_thumbnails(worst, kept, artist, video),
    )


def worst_frames(table: xr.Dataset) -> list[tuple[int, str]]:
    """Return frames that deserve a look, with the reason: some of each flag, largest errors."""
    balls = range(1, balls_of(table) + 1)
    reasons: dict[int, str] = {}
    for flag in reversed(FLAGS[1:]):
        for b in balls:
            numbers = np.flatnonzero(table[f"flag_{b}"].values == flag)
            for number in numbers[:: max(1, len(numbers) // 2)][:1]:
                reasons.setdefault(int(number), f"ball {b} {flag}")
    for b in balls:
        ok = table[f"flag_{b}"].values == "ok"
        off = np.where(ok, np.abs(circle_distances(table, b)), np.nan)
        sigma = np.where(ok, table[f"angle_sigma_{b}"].values, np.nan)
        for values, text in ((off, "far off the circle"), (sigma, "large sigma")):
            order = np.argsort(np.where(np.isfinite(values), -values, np.inf))
            for number in order[:2]:
                if np.isfinite(values[number]):
                    reasons.setdefault(int(number), f"ball {b}: {text}")
    return sorted(reasons.items())[:_WORST]


def _figures(table: xr.Dataset) -> list[tuple[Figure, str]]:
    """Return the graphs with what they show."""
    with use_style():
        if table.attrs["geometry"] == "unknown":
            return [(_path_figure(table), "The ball's places in the picture over time.")]
        return [
            (
                _angle_figure(table),
                "Angle from the direction of gravity about the moving pivot, and its standard "
                "deviation. Marked samples are not ok.",
            ),
            (
                _circle_figure(table),
                "How far the ball is from its circle about the pivot, over time and over the "
                "angle. A wave over the angle means lens, perspective or a pivot beside the hinge.",
            ),
            (_pivot_figure(table), "The pivot's height with one harmonic, and the rest."),
            (_sigma_figure(table), "Standard deviations of the angles flagged ok."),
        ]


def _angle_figure(table: xr.Dataset) -> Figure:
    """Draw angles and their standard deviations over time."""
    figure, axes = new_figure(2, 1, height=3.8, sharex=True, height_ratios=[2.2, 1.0])
    upper, lower = axes[:, 0]
    times = table["time"].values
    for b in range(1, balls_of(table) + 1):
        angle = np.degrees(table[f"angle_{b}"].values)
        sigma = 1e3 * table[f"angle_sigma_{b}"].values
        flags, colour = table[f"flag_{b}"].values, BALL_COLOURS[b - 1]
        upper.plot(times, angle, color=colour, lw=0.9, label=f"ball {b}")
        known = sigma > 0.0
        lower.plot(times[known], sigma[known], ".", color=colour, ms=1.6)
        _mark(upper, times, angle, flags)
        _mark(lower, times, sigma, flags)
    upper.set_ylabel("angle [deg]")
    lower.set_ylabel("sigma [mrad]")
    lower.set_yscale("log")
    low, high = lower.get_ylim()
    if high < 10.0 * low:  # a narrow range of a logarithmic axis has no readable ticks
        lower.set_yscale("linear")
        lower.set_ylim(0.0, 1.5 * high)
    lower.set_xlabel("time [s]")
    handles, names = upper.get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    upper.legend(unique.values(), unique.keys(), ncols=6, loc="lower left", bbox_to_anchor=(0, 1))
    return figure


def _mark(axes: Axes, times: np.ndarray, values: np.ndarray, flags: np.ndarray) -> None:
    """Mark the samples that are not ok; lost ones stand at the foot of the panel."""
    for flag, (colour, shape) in MARKS.items():
        mask = flags == flag
        if not mask.any():
            continue
        if flag == "lost":
            transform = axes.get_xaxis_transform()
            axes.plot(times[mask], np.full(mask.sum(), 0.02), shape, color=colour, ms=3,
                      label=flag, transform=transform, clip_on=False)  # fmt: skip
        else:
            axes.plot(times[mask], values[mask], shape, color=colour, ms=3, mew=0.5, label=flag)


def _circle_figure(table: xr.Dataset) -> Figure:
    """Draw the distance from the circle over time and over the angle."""
    figure, axes = new_figure(1, 2, height=2.3, sharey=True)
    scale, unit = (1e3, "mm") if table.attrs["geometry"] == "metric" else (1.0, "pixel")
    for b in range(1, balls_of(table) + 1):
        ok = table[f"flag_{b}"].values == "ok"
        off = scale * circle_distances(table, b)[ok]
        around = np.degrees(np.angle(np.exp(1j * table[f"angle_{b}"].values[ok])))
        for panel, x in zip(axes[0], (table["time"].values[ok], around), strict=True):
            panel.plot(x, off, ".", ms=1.6, color=BALL_COLOURS[b - 1])
    for panel, text in zip(axes[0], ("time [s]", "angle [deg]"), strict=True):
        panel.axhline(0.0, color=GREY, lw=THIN, zorder=0)
        panel.set_xlabel(text)
    axes[0, 0].set_ylabel(f"off the circle [{unit}]")
    return figure


def _pivot_figure(table: xr.Dataset) -> Figure:
    """Draw the pivot's height, its harmonic and the rest."""
    figure, axes = new_figure(2, 1, height=3.2, sharex=True, height_ratios=[2.0, 1.0])
    scale, unit = (1e3, "mm") if table.attrs["geometry"] == "metric" else (1.0, "pixel")
    times, heights = table["time"].values, scale * pivot_places(table)
    harmonic = pivot_harmonic(table)
    axes[0, 0].plot(times, heights, ".", ms=2, color=BLUE, label="measured")
    rest = heights
    if harmonic is not None:
        wave, frequency = scale * harmonic.places, harmonic.frequency
        axes[0, 0].plot(
            times,
            wave,
            color=ORANGE,
            lw=0.8,
            label=f"{scale * harmonic.amplitude:.4g} {unit} at {frequency:.5g} rad/s "
            f"({frequency / math.tau:.4g} Hz)",
        )
        rest = heights - wave
    axes[1, 0].plot(times, rest, ".", ms=1.6, color=BLUE)
    axes[0, 0].set_ylabel(f"height [{unit}]")
    axes[1, 0].set_ylabel(f"rest [{unit}]")
    axes[1, 0].set_xlabel("time [s]")
    axes[0, 0].legend(ncols=2, loc="lower left", bbox_to_anchor=(0, 1))
    return figure


def _sigma_figure(table: xr.Dataset) -> Figure:
    """Draw the histogram of standard deviations."""
    figure, axes = new_figure(1, 1, width=5.0, height=2.0)
    for b in range(1, balls_of(table) + 1):
        ok = table[f"flag_{b}"].values == "ok"
        sigma = 1e3 * table[f"angle_sigma_{b}"].values[ok]
        sigma = sigma[np.isfinite(sigma) & (sigma > 0.0)]
        if sigma.size:
            low, high = sigma.min() * 0.95, np.quantile(sigma, 0.995) * 1.05
            bins = np.linspace(low, max(high, 1.01 * low), 40)
            kind: dict[str, Any] = {"histtype": "step", "color": BALL_COLOURS[b - 1]}
            axes[0, 0].hist(np.minimum(sigma, bins[-1]), bins=bins, label=f"ball {b}", **kind)
    axes[0, 0].set_xlabel("sigma of the angle [mrad]")
    axes[0, 0].set_ylabel("samples")
    if balls_of(table) == 2:
        axes[0, 0].legend()
    return figure


def _path_figure(table: xr.Dataset) -> Figure:
    """Draw columns and rows of the balls over time."""
    figure, axes = new_figure(2, 1, height=3.6, sharex=True)
    for b in range(1, balls_of(table) + 1):
        for panel, axis in zip(axes[:, 0], "uv", strict=True):
            values = table[f"ball_{b}_{axis}"].values
            panel.plot(table["time"].values, values, color=BALL_COLOURS[b - 1], lw=0.9)
            _mark(panel, table["time"].values, values, table[f"flag_{b}"].values)
    axes[0, 0].set_ylabel("column [pixel]")
    axes[1, 0].set_ylabel("row [pixel]")
    axes[1, 0].invert_yaxis()
    axes[1, 0].set_xlabel("time [s]")
    return figure


def _numbers(table: xr.Dataset) -> list[tuple[str, str]]:
    """Names and values of what was measured over the whole clip."""
    attrs = table.attrs
    rows = [("geometry", GEOMETRIES[attrs["geometry"]])]
    sigma = typical_sigma(table)
    if sigma is not None:
        rows.append(("typical sigma of an angle", f"{1e3 * sigma:.3g} mrad"))
    if "angle_offset_sigma" in attrs:
        common = 1e3 * attrs["angle_offset_sigma"]
        rows.append(("sigma of what all angles have in common", f"{common:.3g} mrad"))
    if attrs["geometry"] != "unknown":
        numbers = pivot_numbers(table)
        whole = ", as harmonics over the whole clip" if any(numbers.values()) else ""
        rows.append(("pivot", pivot_text({**attrs, **numbers}) + whole))
    source = attrs.get("scale_source", "length")
    length = "declared" if source == "length" else f"by the scale of the {source}"
    texts = {
        "length": (f"length, {length}", 1e3, "mm"),
        "length_sigma": ("its standard deviation", 1e3, "mm"),
        "metres_per_pixel": ("scale", 1e3, "mm a pixel"),
        "radius": ("radius, declared", 1e3, "mm"),
        "measured_radius": ("radius, measured by that scale", 1e3, "mm"),
        "circle_residual": ("scatter about the circle", 1.0, "pixels"),
        "exposure": ("exposure", 100.0, "% of the time between frames"),
        "period": ("period of the swing", 1.0, "s"),
        "period_sigma": ("its standard deviation", 1.0, "s"),
    }
    for name, (text, scale, unit) in texts.items():
        if name in attrs and math.isfinite(attrs[name]):
            rows.append((text, f"{scale * attrs[name]:.4g} {unit}"))
    if "gravity_direction" in attrs:
        tilt = math.degrees(attrs["gravity_direction"])
        source = {
            "image": "assumed",
            "drive axis": "from the drive's axis",
            "vertical drive": "from the drive's axis, taken as vertical",
            "swing": "from the swing",
        }[attrs["gravity_source"]]
        rows.append(("gravity, from straight down", f"{tilt:z.2f} degrees, {source}"))
    if clock := clock_text(attrs):
        rows.append(("slow motion", clock))
    if attrs.get("proposed"):
        rows.append(("pivot and balls", "found in the video where nobody pointed at them"))
    return rows


def _flags(table: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return the flags with their shares and meanings."""
    meanings = MEANINGS if balls_of(table) == 2 else MEANINGS | {"ok": "measured"}
    shares = flag_shares(table)
    return [(flag, f"{100.0 * share:.3g} %", meanings[flag]) for flag, share in shares.items()]


def _png(figure: Figure) -> str:
    """Return a graph as it is embedded in a page."""
    content = io.BytesIO()
    with use_style():
        figure.savefig(content, format="png", dpi=140, metadata={"Software": None})
    return _base64(content.getvalue())


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")


def _fitted(picture: np.ndarray, width: int) -> np.ndarray:
    """Return a picture at most so wide."""
    from latolato.experiment.opencv import import_cv2

    cv2 = import_cv2()
    if picture.shape[1] <= width:
        return picture
    size = (width, round(picture.shape[0] * width / picture.shape[1]))
    smaller: np.ndarray = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return smaller


def _thumbnails(
    worst: list[tuple[int, str]], kept: dict[int, Frame], artist: Artist, video: Video
) -> list[tuple[str, int, str]]:
    """Return cut-outs of frames about the ball in question, plain and marked, with their texts."""
    result = []
    for number, reason in worst:
        if number not in kept:
            continue
        plain = picture_of(kept[number], video)
        marked = artist.drawn(plain.copy(), number, has_text=False)
        b = 1 if reason.startswith("ball 2") else 0
        parts = [_cut(one, artist, number, b) for one in (plain, marked)]
        text = f"frame {artist.numbers[number]}, {artist.times[number]:.3f} s: {reason}"
        picture = _base64(encoded(np.hstack(parts), ".jpg"))
        result.append((picture, int(artist.numbers[number]), text))
    return result


def _cut(picture: np.ndarray, artist: Artist, number: int, b: int) -> np.ndarray:
    """Return the part of a picture about a ball, or where it was last seen, as a square."""
    from latolato.experiment.opencv import import_cv2

    centres = artist.centres[: number + 1, b]
    places = centres[np.isfinite(centres).all(axis=1)]
    height, width = picture.shape[:2]
    centre = places[-1] if len(places) else np.array([width / 2.0, height / 2.0])
    half = int(max(_AROUND * max(artist.radii), 24.0))
    u, v = np.rint(centre).astype(int)
    padded = np.pad(picture, ((half, half), (half, half), (0, 0)), mode="edge")
    u, v = int(np.clip(u, 0, width - 1)), int(np.clip(v, 0, height - 1))
    part = padded[v : v + 2 * half, u : u + 2 * half]
    square: np.ndarray = import_cv2().resize(part, (_THUMB, _THUMB))
    return square
