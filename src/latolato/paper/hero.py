"""The README's picture: the toy photographed by a stroboscope, beside its angle and its energy.

``python -m latolato.paper.hero docs/images/hero.png`` draws it again.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import style
from latolato.paper import systems as paper
from latolato.paper.cases import instants, stack

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (16.0, 9.0)  # inch
DPI = 100
DURATION = 60.0  # s
SAMPLES_PER_PERIOD = 200
FLASHES_PER_PERIOD = 40


def data() -> xr.Dataset:
    """Return a run of Fig. 4's toy after a push, under the strong drive."""
    from latolato import simulate

    times = instants(DURATION, paper.STRONG_DRIVE.drive_frequency, per_period=SAMPLES_PER_PERIOD)
    run = simulate(paper.TOY, paper.STRONG_DRIVE, initial_offset=paper.PUSH, times=times)
    # The swing that first reaches the top begins at the bottom contact before it.
    when, kind = run.contact_time.values, run.contact_kind.values
    end = when[kind == "top"][0]
    start = when[(kind == "bottom") & (when < end)][-1]
    kept = ("angle", "angular_velocity", "total_energy", "pivot_height")
    return stack({"pushed": run}, title="README picture", keep=kept).assign_attrs(
        swing=[start, end]
    )


def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    run = dataset.sel(case="pushed")
    dark: Any = dict.fromkeys(
        ("text.color", "axes.labelcolor", "xtick.color", "ytick.color"), style.LIGHT
    )
    sizes: Any = dict.fromkeys(("axes.labelsize", "xtick.labelsize", "ytick.labelsize"), 15)
    with style.use_style(), mpl.rc_context({**dark, **sizes, "axes.edgecolor": style.FAINT}):
        figure = Figure(figsize=SIZE, dpi=DPI, facecolor=style.NIGHT)
        toy = figure.add_axes((0.0, 0.0, 0.5, 1.0))
        angle = figure.add_axes((0.575, 0.57, 0.39, 0.35))
        phase = figure.add_axes((0.575, 0.11, 0.39, 0.34))
        start, end = dataset.attrs["swing"]
        _draw_strobe(run.sel(time=slice(start, end)), toy)
        _draw_angle(run, angle, start, end)
        _draw_phase(run, phase)
        for axes in (angle, phase):
            axes.set_facecolor(style.NIGHT)
        figure.draw_without_rendering()
    return figure


def _draw_strobe(swing: xr.Dataset, axes: Axes) -> None:
    """Draw pivot, rods and balls at each flash of a swing to the top, the latest brightest."""
    from matplotlib.patches import Circle

    length, radius = paper.TOY.length, paper.TOY.radius
    amplitude = paper.STRONG_DRIVE.drive_amplitude
    spacing = SAMPLES_PER_PERIOD // FLASHES_PER_PERIOD
    # Counted back from the end, so that the last flash shows the balls touching.
    flashes = swing.isel(time=slice(None, None, -spacing)).isel(time=slice(None, None, -1))
    count = flashes.sizes["time"]
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set_xlim(-1.4, 1.4)
    axes.set_ylim(-1.5, 1.55)
    axes.plot([0, 0], [-amplitude, amplitude], color=style.LIGHT, lw=7, alpha=0.2)
    for i in range(count):
        brightness = 0.12 + 0.88 * ((i + 1) / count) ** 1.6
        is_last = i == count - 1
        height, angle = float(flashes.pivot_height[i]), float(flashes.angle[i])
        for side, colour in ((1.0, style.SKY), (-1.0, style.AMBER)):
            x, y = side * length * np.sin(angle), height - length * np.cos(angle)
            axes.plot(
                [0, x],
                [height, y],
                color=style.LIGHT,
                lw=2.2 if is_last else 0.9,
                alpha=1.0 if is_last else 0.45 * brightness,
                zorder=2 + 2 * i,
            )
            ball = Circle((x, y), radius, fc=colour, ec=style.NIGHT, lw=1.0, alpha=brightness)
            axes.add_patch(ball).set_zorder(3 + 2 * i)
        axes.plot(
            0, height, "o", color=style.LIGHT, ms=9 if is_last else 3, alpha=brightness, zorder=500
        )


def _draw_angle(run: xr.Dataset, axes: Axes, start: float, end: float) -> None:
    """Draw the angles of both balls over time, and when the flashes were."""
    axes.axvspan(start, end, color=style.LIGHT, alpha=0.22, lw=0)
    axes.plot(run.time, -run.angle, color=style.AMBER, lw=1.0)
    axes.plot(run.time, run.angle, color=style.SKY, lw=1.0)
    axes.set_xlim(0.0, DURATION)
    axes.set_ylim(-1.06 * np.pi, 1.06 * np.pi)
    style.pi_ticks(axes.yaxis, parts=1)
    axes.set_xlabel(style.label(run.time))
    axes.set_ylabel(style.label(run.angle, short=True))


def _draw_phase(run: xr.Dataset, axes: Axes) -> None:
    """Draw the phase portrait of the right ball, coloured by its energy."""
    from matplotlib import colormaps
    from matplotlib.collections import LineCollection
    from matplotlib.colors import ListedColormap

    points = np.transpose([run.angle.values, run.angular_velocity.values])
    segments = np.stack([points[:-1], points[1:]], axis=1)
    # An impact reverses the velocity: no line is drawn across it.
    smooth = np.abs(np.diff(points[:, 1])) < 1.0
    # Without its darkest part, which would vanish in the night.
    colours = ListedColormap(colormaps["plasma"](np.linspace(0.22, 1.0, 200)))
    lines: Any = LineCollection(
        list(segments[smooth]), array=run.total_energy.values[1:][smooth], cmap=colours, lw=0.8
    )
    axes.add_collection(lines)
    axes.set_xlim(0.0, np.pi)
    limit = 1.05 * float(np.abs(run.angular_velocity).max())
    axes.set_ylim(-limit, limit)
    axes.set_yticks([-10, -5, 0, 5, 10])
    style.pi_ticks(axes.xaxis, parts=2)
    axes.set_xlabel(style.label(run.angle, short=True))
    axes.set_ylabel(style.label(run.angular_velocity, short=True))
    style.colour_bar(lines, style.label(run.total_energy, short=True), aspect=25)


def write(path: Path | str) -> Path:
    """Draw the picture as PNG with a palette, which keeps the repository small, return its path."""
    from io import BytesIO

    from PIL import Image

    from latolato.core.atomic import atomic_path

    content = BytesIO()
    with style.use_style():
        draw(data()).savefig(content, format="png", dpi=DPI, facecolor=style.NIGHT)
    small = Image.open(content).convert("RGB").quantize(256, dither=Image.Dither.FLOYDSTEINBERG)
    with atomic_path(path) as unfinished:
        small.save(unfinished, optimize=True)
    return Path(path)


if __name__ == "__main__":
    print(write(sys.argv[1]))
