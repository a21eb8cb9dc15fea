"""Fig. 5: the maps of Fig. 3cd for the colliding pair, from rest, with a push, and by a clamp."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato import ClampContact
from latolato.figures import cells, style
from latolato.paper import grids
from latolato.paper import systems as paper
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "Where the colliding pair becomes unstable"
STEP = 1e-3  # s, of the clamp
PUSH = 0.05  # rad above the low contact angle
CAPTION = (
    "Fig. 3cd with both walls and elastic impacts, on the scales of Fig. 3cd. Upper row: mean "
    "energy of one ball; lower row: passages of 2 rad, white: none. Columns: exact contact from "
    f"rest on the wall; exact contact from {PUSH:g} rad above it; a fixed-step code (1 ms) that "
    "reflects on overlap, from rest, on a coarser grid, which moves where nothing can leave the "
    "wall. Solid: the primary tongue of eq14; dashed: lift-off from rest, A0 ω² = g."
)
FREE, REST, PUSHED, CLAMP = "free", "rest", "push", "clamp"
POINTS, QUICK_POINTS = 300, 80  # along each axis
CLAMP_POINTS, QUICK_CLAMP_POINTS = 50, 20
QUICK_CLAMP_DURATION = 150.0  # s
MOVED = 0.01  # rad above the wall: a ball has visibly left it
TOY = replace(paper.TOY, damping=0.0)


def data(quick: bool = False) -> xr.Dataset:
    """Return the maps without walls, from rest, with a push and by the clamp."""
    from latolato import sweep

    def run(count: int, duration: float, offset: float, step: float = 0.0) -> xr.Dataset:
        return sweep(
            TOY,
            axes=grids.paper_axes(TOY.length, count),
            duration=duration,
            initial_offset=offset,
            observables=grids.PAIR_OBSERVABLES,
            contact=ClampContact(clamp_step=step) if step else "exact",
        )

    count, long = QUICK_POINTS if quick else POINTS, paper.SWEEP_DURATION
    maps = {
        FREE: grids.without_walls(paper.UNDAMPED, count),
        REST: run(count, long, 0.0),
        PUSHED: run(count, long, PUSH),
    }
    count, long = (QUICK_CLAMP_POINTS, QUICK_CLAMP_DURATION) if quick else (CLAMP_POINTS, long)
    return grids.gather(
        maps,
        title=TITLE,
        keep=grids.KEPT,
        apart={CLAMP: run(count, long, 0.0, STEP)},
    )


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statements on the pair's maps need."""
    from latolato import map_boundary

    low = TOY.contact_angle_low
    below = grids.acceleration_ratio(dataset) < 1.0
    below_clamp = grids.acceleration_ratio(dataset, f"{CLAMP}_") < 1.0
    active = {case: dataset.crossings.sel(case=case) > 0.0 for case in (FREE, REST, PUSHED)}
    result: dict[str, float] = {}
    for case, points in active.items():
        part = dataset.sel(case=case)
        result[f"agree_{case}"] = float((points.values == active[FREE].values).mean())
        result[f"outliers_{case}"] = grids.outliers(points.values)
        result[f"band_{case}"] = grids.band_gain(part.mean_energy)
        result[f"tip_{case}"], result[f"at_{case}"] = grids.smallest_amplitude(points)
        column = points.sel(frequency_ratio=4.0, method="nearest").values
        result[f"four_{case}"] = float(dataset.drive_amplitude[int(np.argmax(column))])
        edge = map_boundary(part, "crossings", 1.0).left_edge
        for name, amplitude in (("_2", 0.2), ("", 0.3), ("_5", 0.5)):
            here = edge.sel(drive_amplitude=amplitude, method="nearest")
            result[f"left_{case}{name}"] = float(here)
    rise = dataset.largest_angle.sel(case=REST).values - low
    clamp_rise = dataset.clamp_largest_angle.values - low
    return result | {
        "blur_push": result["outliers_push"] / result["outliers_free"],
        "lift_off": (TOY.length / 0.3) ** 0.5,
        "more_rest": result["tip_rest"] / result["tip_free"],
        "more_push": result["tip_push"] / result["tip_free"],
        "rest_moved": float((rise[below] > MOVED).mean()),
        "clamp_moved": float((clamp_rise[below_clamp] > MOVED).mean()),
        "clamp_crossed": float((dataset.clamp_crossings.values[below_clamp] > 0.0).mean()),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (f)."""
    figure, axes = style.new_figure(2, 3, sharex=True, sharey=True, height=4.9)
    columns = (
        ("from rest", dataset.sel(case=REST), ""),
        (f"with a push of {PUSH:g} rad", dataset.sel(case=PUSHED), ""),
        ("clamp artefact, from rest", dataset, f"{CLAMP}_"),
    )
    handles = []
    for row, (name, norm, cmap) in enumerate(cells.SCALES):
        for column, (title, part, prefix) in enumerate(columns):
            panel = axes[row, column]
            values = part[f"{prefix}{name}"]
            mesh = cells.draw_cells(panel, values, norm=norm(), cmap=cmap)
            handles = [grids.draw_overlay(panel, TOY, each) for each in ("tongue", "lift_off")]
            style.panel_title(panel, "abcdef"[3 * row + column], title)
            if row == 1:
                panel.set_xlabel(style.label(dataset.frequency_ratio, short=True))
            if column == 0:
                panel.set_ylabel(style.label(dataset.drive_amplitude))
        style.colour_bar(mesh, grids.label(dataset[name]), ax=list(axes[row]), pad=0.01, aspect=22)
    axes[0, 0].set_xlim(0.0, paper.LARGEST_FREQUENCY_RATIO)
    axes[0, 0].set_ylim(0.0, paper.LARGEST_AMPLITUDE_RATIO * TOY.length)
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure
