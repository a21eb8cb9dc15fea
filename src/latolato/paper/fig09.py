"""Fig. 9, its theoretical part: the map of the single-pendulum experiment and its classes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import cells, style
from latolato.figures.map import CLASSES
from latolato.paper import grids
from latolato.paper import systems as paper
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "Where the single pendulum of the experiment resonates"
CAPTION = (
    "Length, mass and damping of the single pendulum. (a) Mean energy of the last 60 s of 300 s, "
    "with contours: the angle after 240 s reaches 45°, and the angle reaches 90° at any time. (b) "
    "The paper's classes: strong for 90° at any time, weak for 45° after 240 s, none. Solid: the "
    "tongue of eq14 with damping. At the upper left the ball rotates in some runs. The "
    "trials are not printed."
)
AMPLITUDES = (0.005, 0.060)  # m, assumed: not printed
RATIOS = (1.6, 2.4)
POINTS, QUICK_POINTS = (221, 321), (56, 81)
TRANSIENT = 240.0  # s
LATE = "largest_angle_after_transient"
WEAK, STRONG = math.pi / 4.0, math.pi / 2.0
# A start at 1 degree that is above this after the transient has grown.
GROWN = math.radians(5.0)


def data(quick: bool = False) -> xr.Dataset:
    """Return the map of the single pendulum."""
    from latolato import sweep

    up, across = QUICK_POINTS if quick else POINTS
    grid = sweep(
        paper.SINGLE,
        axes={
            "drive_amplitude": np.linspace(*AMPLITUDES, up),
            "frequency_ratio": np.linspace(*RATIOS, across),
        },
        duration=paper.SWEEP_DURATION,
        transient=TRANSIENT,
        initial_angle=paper.SINGLE_START,
        observables=grids.PENDULUM_OBSERVABLES,
    )
    keep = ("mean_energy", "largest_angle", LATE, "motion_class")
    # Classes are whole numbers.
    return grids.gather(
        {"single": grid.assign(motion_class=grid.motion_class.round())}, title=TITLE, keep=keep
    )


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 9's statements need."""
    from latolato.analysis import tongue_edges

    ratio = dataset.frequency_ratio.values
    amplitudes = dataset.drive_amplitude.values
    late = dataset[LATE].values[0]
    grown = late > GROWN
    # A tenth of a millimetre less, for rounding.
    rows = [int(i) for i in np.flatnonzero(amplitudes >= 0.0099) if grown[i].any()]
    first = np.array([int(np.argmax(grown[i])) for i in rows])
    last = np.array([len(ratio) - 1 - int(np.argmax(grown[i][::-1])) for i in rows])
    tongues = [tongue_edges(paper.SINGLE, drive_amplitude=float(amplitudes[i])) for i in rows]
    edges = np.array([(float(each.low), float(each.high)) for each in tongues])
    ends = last < len(ratio) - 1
    shifts = ratio[first] - edges[:, 0]
    right_shifts = (ratio[last] - edges[:, 1])[ends]
    at = rows.index(int(np.argmin(np.abs(amplitudes - 0.020))))
    return {
        "below": float((grown & (late < WEAK)).sum() / grown.sum()),
        "left_jumps": float(
            np.mean([late[i, j] >= WEAK for i, j in zip(rows, first, strict=True)])
        ),
        "left_angle": math.degrees(late[rows[at], first[at]]),
        "left_edge": float(ratio[first[at]]),
        "right_edge": float(ratio[last[at]]),
        "edge_shift": float(max(np.abs(shifts).max(), np.abs(right_shifts).max())),
        "all_below_mm": 1e3 * float(amplitudes[(late < WEAK).all(axis=1)].max()),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) and (b)."""
    from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
    from matplotlib.lines import Line2D

    figure, axes = style.new_figure(1, 2, sharey=True, height=3.5)
    a, b = axes[0]
    grid = dataset.isel(case=0)
    ratio, amplitude = dataset.frequency_ratio.values, dataset.drive_amplitude.values
    mesh = cells.draw_cells(a, grid.mean_energy, norm=LogNorm(1e-4, 1.0, clip=True), cmap="viridis")
    style.colour_bar(mesh, aspect=26, extend="min")
    colours = CLASSES["motion_class"]
    # Zero is a class here, not a missing value.
    classes = (grid.motion_class + 1.0).rename("motion_class")
    cells.draw_cells(
        b,
        classes,
        norm=BoundaryNorm([0.5, 1.5, 2.5, 3.5], 3),
        cmap=ListedColormap(list(colours.values())),
    )
    handles = [grids.draw_overlay(panel, paper.SINGLE, "tongue") for panel in (a, b)][:1]
    for values, level, colour, text in (
        (grid[LATE], WEAK, style.ORANGE, "45° after 240 s"),
        (grid.largest_angle, STRONG, style.RED, "90° at any time"),
    ):
        a.contour(ratio, amplitude, values.values, levels=[level], colors=[colour], linewidths=1.1)
        handles.append(Line2D([], [], color=colour, lw=1.1, label=text))
    handles += [style.swatch(colour, name) for name, colour in colours.items()]
    for panel, letter, text in (
        (a, "a", grids.label(grid.mean_energy)),
        (b, "b", "class of motion"),
    ):
        style.panel_title(panel, letter, text)
        panel.set_xlabel(style.label(dataset.frequency_ratio))
    a.set_ylabel(style.label(dataset.drive_amplitude))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure
