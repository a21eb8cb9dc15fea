"""Fig. 1: the model, drawn to scale from the geometry that is simulated."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.paper import systems as paper
from latolato.paper.cases import quantity, variable
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "The model"
CAPTION = (
    "The mirror-symmetric pair, drawn to scale with the parameters of Fig. 4a (l = 1 m, r = 0.1 "
    "m, A0 = 0.2 m). (a) The pivot moves up and down by A0; the balls touch at the two contact "
    "angles, arcsin(r/l) from the vertical at the bottom and the same from the vertical at the "
    "top (the paper's θmin and θmax). (b) Coordinates and parameters; the curve is the pivot's "
    "height over two periods."
)
LOW, HIGH, BETWEEN = "low", "high", "between"
SHOWN_ANGLE = math.radians(52.0)  # of panel (b)


def data(quick: bool = False) -> xr.Dataset:
    """Return the poses of the right ball and two periods of the pivot."""
    import xarray as xr

    toy, drive = paper.TOY, paper.STRONG_DRIVE
    poses = {LOW: toy.contact_angle_low, BETWEEN: SHOWN_ANGLE, HIGH: toy.contact_angle_high}
    angles = np.array(list(poses.values()))
    times = np.linspace(0.0, 4.0 * np.pi / drive.drive_frequency, 201)
    heights = drive.drive_amplitude * np.cos(drive.drive_frequency * times)
    return xr.Dataset(
        {
            "angle": quantity("angle", "pose", angles),
            "ball_x": variable(
                "pose",
                toy.length * np.sin(angles),
                units="m",
                symbol="x",
                long_name="right of pivot",
            ),
            "ball_y": variable(
                "pose", -toy.length * np.cos(angles), units="m", symbol="y", long_name="above pivot"
            ),
            "pivot_height": quantity("pivot_height", "time", heights),
            "length": quantity("length", (), toy.length),
            "radius": quantity("radius", (), toy.radius),
            "drive_amplitude": quantity("drive_amplitude", (), drive.drive_amplitude),
        },
        coords={
            "pose": variable("pose", list(poses), units="1", long_name="pose of the pair"),
            "time": quantity("time", "time", times),
        },
        attrs={"title": TITLE},
    )


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 1's statement needs."""
    radius = float(dataset.radius)
    low, high = (float(dataset.angle.sel(pose=pose)) for pose in (LOW, HIGH))
    return {
        "low": low,
        "high": high,
        "low_degrees": math.degrees(low),
        "high_degrees": math.degrees(high),
        "gap_low": 2.0 * (float(dataset.ball_x.sel(pose=LOW)) - radius),
        "gap_high": 2.0 * (float(dataset.ball_x.sel(pose=HIGH)) - radius),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the drawing with panels (a) and (b)."""
    figure, axes = style.new_figure(1, 2, height=4.0)
    ((a, b),) = axes
    for axis in (a, b):
        axis.set_aspect("equal")
        axis.set_axis_off()
        axis.set_xlim(-1.2, 1.2)
        axis.set_ylim(-1.3, 1.3)
    _draw_contacts(dataset, a)
    _draw_coordinates(dataset, b)
    style.panel_letter(a, "a")
    style.panel_letter(b, "b")
    return figure


def _draw_contacts(dataset: xr.Dataset, axis: Axes) -> None:
    """Draw both contacts, the path between them and the pivot's travel."""
    length = float(dataset.length)
    low, high = (float(dataset.angle.sel(pose=pose)) for pose in (LOW, HIGH))
    path = np.linspace(low, high, 200)
    for side in (1.0, -1.0):
        axis.plot(
            side * length * np.sin(path),
            -length * np.cos(path),
            color=style.GREY,
            lw=style.THIN,
            ls=(0, (4, 3)),
            zorder=0,
        )
        _draw_ball(dataset, axis, LOW, side, strength=1.0)
        _draw_ball(dataset, axis, HIGH, side, strength=0.35)
    axis.plot([0, 0], [-1.28, 1.28], color=style.GREY, lw=style.THIN, ls=":", zorder=0)
    _draw_arc(axis, 0.0, low, 0.62, r"$\theta_{\min}$", shift=(17, -3))
    _draw_arc(axis, 0.0, high, 0.36, r"$\theta_{\max}$", shift=(12, 0))
    amplitude = float(dataset.drive_amplitude)
    axis.annotate(
        "",
        (-0.3, amplitude),
        (-0.3, -amplitude),
        arrowprops={
            "arrowstyle": "<->",
            "color": style.RED,
            "lw": style.LINE,
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )
    for height in (-amplitude, amplitude):
        axis.plot([-0.36, 0.0], [height, height], color=style.RED, lw=style.THIN)
        axis.plot(0.0, height, "o", ms=3, mfc=style.PAPER, mec=style.RED, mew=style.THIN)
    axis.plot(0.0, 0.0, "o", ms=4, color=style.INK, zorder=5)
    _write(axis, "$2A_0$", (-0.33, 0.0), (-4, 0), ha="right", colour=style.RED)


def _draw_coordinates(dataset: xr.Dataset, axis: Axes) -> None:
    """Draw the axes, one pose, its symbols and the pivot's height over time."""
    length, radius = float(dataset.length), float(dataset.radius)
    angle = float(dataset.angle.sel(pose=BETWEEN))
    arrow = {"arrowstyle": "-|>", "color": style.INK, "lw": style.THIN, "shrinkA": 0, "shrinkB": 0}
    axis.annotate("", (1.15, 0.0), (-0.45, 0.0), arrowprops=arrow)
    axis.annotate("", (0.0, 0.7), (0.0, -1.25), arrowprops=arrow)
    _write(axis, "$x$", (1.15, 0.0), (0, -8))
    _write(axis, "$y$", (0.0, 0.7), (5, -2))
    for side, strength in ((1.0, 1.0), (-1.0, 0.35)):
        _draw_ball(dataset, axis, BETWEEN, side, strength=strength)
    centre = np.array([length * math.sin(angle), -length * math.cos(angle)])
    _draw_arc(axis, 0.0, angle, 0.32, r"$\theta$", shift=(6, -5))
    across = np.array([math.cos(angle), math.sin(angle)])
    _write(axis, "$l$", tuple(0.55 * centre + 0.05 * across), (2, 3))
    edge = centre + radius * np.array([1.0, 0.0])
    axis.plot(*np.transpose([centre, edge]), color=style.PAPER, lw=style.THIN, zorder=6)
    _write(axis, "$r$", tuple(edge), (3, 0))
    style.note(
        axis, "$m$", tuple(centre - 1.2 * radius * np.array([0.0, 1.0])), (0, -5), ha="center"
    )
    axis.annotate("", (-1.05, -1.2), (-1.05, -0.8), arrowprops=arrow)
    _write(axis, "$g$", (-1.05, -1.0), (4, 0))
    axis.plot(0.0, 0.0, "o", ms=4, color=style.INK, zorder=5)
    # The pivot's height over two periods, at the same scale of height.
    time, height = dataset.time.values, dataset.pivot_height.values
    x = 0.12 + 0.95 * time / time[-1]
    axis.plot(x, 1.05 + height, color=style.RED, lw=style.LINE)
    axis.plot([0.12, 1.15], [1.05, 1.05], color=style.GREY, lw=style.THIN)
    _write(axis, "$t$", (1.15, 1.05), (2, 0))
    style.note(
        axis, r"$y_0 = A_0\,\cos\,\omega t$", (0.02, 1.05), (0, 0), ha="right", colour=style.RED
    )


def _draw_ball(dataset: xr.Dataset, axis: Axes, pose: str, side: float, *, strength: float) -> None:
    """Draw a rod and its ball, the right (side 1) or the left one (side -1)."""
    from matplotlib.patches import Circle

    x = side * float(dataset.ball_x.sel(pose=pose))
    y = float(dataset.ball_y.sel(pose=pose))
    colour = style.BLUE if side > 0 else style.ORANGE
    axis.plot([0.0, x], [0.0, y], color=style.INK, lw=style.LINE, alpha=strength, zorder=2)
    axis.add_patch(
        Circle(
            (x, y),
            float(dataset.radius),
            fc=colour,
            ec=style.PAPER,
            lw=style.THIN,
            alpha=strength,
            zorder=3,
        )
    )


def _draw_arc(
    axis: Axes, first: float, last: float, size: float, text: str, *, shift: tuple[float, float]
) -> None:
    """Draw the arc of an angle from the downward vertical and write its symbol."""
    angles = np.linspace(first, last, 100)
    axis.plot(size * np.sin(angles), -size * np.cos(angles), color=style.INK, lw=style.THIN)
    middle = 0.5 * (first + last)
    _write(axis, text, (size * math.sin(middle), -size * math.cos(middle)), shift)


def _write(
    axis: Axes, text: str, at: tuple[float, float], shift: tuple[float, float], **how: str
) -> None:
    """Write a symbol beside a point, at the size of the drawing's text."""
    style.note(
        axis,
        text,
        at,
        shift,
        ha=how.get("ha", "left"),
        colour=how.get("colour", style.INK),
        size=style.LARGE,
    )
