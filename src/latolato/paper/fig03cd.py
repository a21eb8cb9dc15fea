"""Fig. 3c and d: mean energy and crossings of 2 rad over amplitude and frequency, without walls."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import cells, style
from latolato.paper import grids
from latolato.paper import systems as paper
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "Where a single pendulum becomes unstable"
CAPTION = (
    "The pendulum without walls and damping for 300 s. (c) Mean energy. (d) Passages of the "
    "positions ±2 rad; white: none. Solid: the primary tongue of eq14. Dashed in (d): where "
    "the region ends on the right with the damping of Fig. 2, C = 0.05 kg m/s (running median)."
)
UNDAMPED, DAMPED = "undamped", "damped"
POINTS, QUICK_POINTS = 400, 100  # along each axis
# Mean energy above which motion counts as unstable: that of a ball as high as the pivot.
LEVEL = paper.UNDAMPED.mass * paper.UNDAMPED.gravity * paper.UNDAMPED.length  # J
# Points further from the right edge than this in w/w0 are away from it.
AWAY = 0.5
_SMOOTHED = 9  # rows


def data(quick: bool = False) -> xr.Dataset:
    """Return the maps without damping and with that of Fig. 2."""
    count = QUICK_POINTS if quick else POINTS
    dampings = {UNDAMPED: 0.0, DAMPED: paper.PENDULUM.damping}
    maps = {
        label: grids.without_walls(replace(paper.UNDAMPED, damping=damping), count)
        for label, damping in dampings.items()
    }
    return grids.gather(maps, title=TITLE, keep=grids.KEPT)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statements on the maps need."""
    from latolato import map_boundary
    from latolato.analysis import tongue_edges

    free, damped = (dataset.sel(case=case) for case in (UNDAMPED, DAMPED))
    by_energy = map_boundary(free, "mean_energy", LEVEL)
    by_count, by_count_damped = (map_boundary(each, "crossings", 1.0) for each in (free, damped))
    both = np.isfinite(by_energy.left_width) & np.isfinite(by_energy.right_width)
    widths = {
        side: float(by_energy[f"{side}_width"].where(both).median()) for side in ("left", "right")
    }
    active, left_over = free.crossings.values > 0.0, damped.crossings.values > 0.0
    # Where the map ends before the region does, its edge is the map's.
    right = by_count.right_edge.fillna(np.inf)
    away = np.abs(right - dataset.frequency_ratio).values > AWAY
    tip_amplitude, tip_ratio = grids.smallest_amplitude(free.crossings > 0.0)
    at = {"drive_amplitude": 0.25, "method": "nearest"}
    result = {
        "tip_amplitude": tip_amplitude,
        "tip_ratio": tip_ratio,
        "band_gain": grids.band_gain(free.mean_energy),
        "band_crossings": grids.in_band(free.crossings),
        "band_angle": grids.in_band(free.largest_angle),
        "left_width": widths["left"],
        "right_width": widths["right"],
        "energy_widths": widths["right"] / widths["left"],
        "left_jump": float(by_count.left_width.median()),
        "right_jump": float(by_count.right_width.median()),
        "spacing": by_energy.attrs["spacing"],
        "changed": float((active & ~left_over).sum() / active.sum()),
        "changed_all": float((active != left_over).mean()),
        "gained": float((left_over & ~active).sum() / active.sum()),
        "changed_away": float((active & ~left_over & away).sum() / (active & away).sum()),
        "right_free": float(by_count.right_edge.sel(**at)),
        "right_damped": float(by_count_damped.right_edge.sel(**at)),
        "left_shift": float(np.abs(by_count.left_edge - by_count_damped.left_edge).median()),
    }
    for tenths in (2, 3, 4):
        amplitude = 0.1 * tenths
        edge = by_energy.left_edge.sel(drive_amplitude=amplitude, method="nearest")
        result[f"left_{tenths}"] = float(edge)
        tongue = tongue_edges(paper.UNDAMPED, drive_amplitude=amplitude)
        result[f"tongue_{tenths}"] = float(tongue.low)
    return result


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (c) and (d)."""
    from latolato import map_boundary

    figure, axes = style.new_figure(1, 2, sharey=True, height=3.3)
    c, d = axes[0]
    free, damped = (dataset.sel(case=case) for case in (UNDAMPED, DAMPED))
    for panel, letter, (name, norm, cmap) in zip((c, d), "cd", cells.SCALES, strict=True):
        values = free[name]
        mesh = cells.draw_cells(panel, values, norm=norm(), cmap=cmap)
        style.colour_bar(mesh, aspect=26)
        style.panel_title(panel, letter, grids.label(values))
        panel.set_xlabel(style.label(dataset.frequency_ratio))
        tongue = grids.draw_overlay(panel, paper.UNDAMPED, "tongue")
    right = map_boundary(damped, "crossings", 1.0).right_edge
    # The edge is ragged, for motion beside it is chaotic: a running median shows where it lies.
    smooth = right.rolling(drive_amplitude=_SMOOTHED, center=True).median()
    (edge,) = d.plot(
        smooth,
        dataset.drive_amplitude,
        color=style.RED,
        ls=(0, (4, 2)),
        label="right edge of the region with C = 0.05 kg m/s",
    )
    c.set_ylabel(style.label(dataset.drive_amplitude))
    figure.legend(handles=[tongue, edge], loc="outside lower center", ncols=2)
    return figure
