"""Fig. 3c and d: mean energy and crossings of 2 rad over amplitude and frequency, without walls."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import grids, paper, style
from latolato.figures.claim import Limit, Numbers, Statement

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
# The start is not printed; the text speaks of the minimum angle as the usual one.
START_WORDS = "The sweep starts at rest at θmin = asin(r/l); the paper does not print its start."

STATEMENTS = (
    Statement(
        name="map-free",
        where="Fig. 3c, d",
        words=(
            "beyond the unstable region near ω/ω0 = 2, Fig. 3(c) shows a narrow dark-red band "
            "near ω/ω0 = 1 … The absence of this feature in Fig. 3(d)"
        ),
        assumed=(
            Limit("tip_ratio", "ω/ω0 at the smallest A0 that leads to 2 rad", 1.7, 2.1),
            Limit("band_gain", "mean energy near ω/ω0 = 1 over that beside it, at most", low=3.0),
            Limit("band_crossings", "most crossings of 2 rad near ω/ω0 = 1", high=0.0),
        ),
        assumption=START_WORDS,
        finding=(
            "In the map of Fig. 3c, d the pendulum passes 2 rad from A0 = {tip_amplitude:.3f} m "
            "on, first at ω/ω0 = {tip_ratio:.2f}; near ω/ω0 = 1 the mean energy is up to "
            "{band_gain:.0f} times that beside this band, yet the largest angle there is "
            "{band_angle:.2f} rad."
        ),
        why=(
            "Both are tongues 2ω0/n of eq14, n = 1 and 2; a swing in the second one detunes "
            "before it reaches 2 rad."
        ),
    ),
    Statement(
        name="left-edge-sharper",
        where="text on Fig. 3cd",
        words="the left boundary is more distinct than the right boundary",
        assumed=(
            Limit("energy_widths", "width of the right edge over the left one, energy", low=2.0),
        ),
        assumption=f"{START_WORDS} Distinct means a short rise of the mean energy, as in Fig. 3c.",
        finding=(
            "In Fig. 3c the energy rises from 10 to 90 % over {left_width:.3f} in ω/ω0 at the "
            "left edge, no more than the points' spacing of {spacing:.4f}, and over "
            "{right_width:.3f} at the right edge (medians over A0); the crossings of Fig. 3d jump "
            "within {left_jump:.3f} and {right_jump:.3f}."
        ),
        why=(
            "A pendulum softens: just inside the left edge growth goes on to large swings, towards "
            "the right edge it ends at ever smaller ones. Fig. 3d cannot show that, as small "
            "swings do not count: by criterion 2 both edges are equally sharp."
        ),
    ),
    Statement(
        name="abrupt-left-edge",
        where="text on Fig. 3cd",
        words=(
            "when the driving amplitude A0 is relatively small and fixed, and … the ratio … "
            "crosses a critical value from above, the system abruptly transitions from an unstable "
            "state to a stable state"
        ),
        assumed=(Limit("left_width", "width of the left edge in ω/ω0, median", high=0.1),),
        assumption=START_WORDS,
        finding=(
            "At A0 = 0.2, 0.3 and 0.4 m the left edge of Fig. 3c is at ω/ω0 = {left_2:.3f}, "
            "{left_3:.3f} and {left_4:.3f}; the tongue of eq14 begins at {tongue_2:.3f}, "
            "{tongue_3:.3f} and {tongue_4:.3f}."
        ),
        why=(
            "The edge is that of linear stability, up to what the finite start of 0.1 rad adds on "
            "its left."
        ),
    ),
    Statement(
        name="map-damping",
        where="text on Fig. 3cd",
        words=(
            "The damping coefficient C was set to zero …, as its influence can be neglected when "
            "the focus is solely on determining whether the amplitude grows"
        ),
        printed=(
            Limit(
                "changed", "part of the unstable points (2 rad) that C = 0.05 changes", high=0.05
            ),
        ),
        assumed=(
            Limit("changed_away", "the same, further than 0.5 from the right edge", high=0.05),
            Limit("gained", "points that damping makes unstable, same measure", high=0.01),
        ),
        assumption="Points within 0.5 in ω/ω0 of the right edge are left out.",
        finding=(
            "In the map of Fig. 3c, d, C = 0.05 kg m/s makes {changed:.1%} of the unstable points "
            "stable ({changed_all:.1%} of the map changes) and {gained:.1%} more points unstable; "
            "away from the right edge it makes {changed_away:.1%} stable."
        ),
        why=(
            "Damping shifts the right edge of large motion: at A0 = 0.25 m from ω/ω0 = "
            "{right_free:.2f} to {right_damped:.2f}. The left edge moves by {left_shift:.1g} "
            "(median)."
        ),
    ),
)


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
    from latolato.analysis.boundary import map_boundary
    from latolato.analysis.closed_forms import mathieu_tongue_edges

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
    found = {
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
        found[f"left_{tenths}"] = float(edge)
        found[f"tongue_{tenths}"] = mathieu_tongue_edges(
            drive_amplitude=amplitude, length=paper.UNDAMPED.length
        )[0]
    return found


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (c) and (d)."""
    from latolato.analysis.boundary import map_boundary

    figure, axes = style.new_figure(1, 2, sharey=True, height=3.3)
    c, d = axes[0]
    free, damped = (dataset.sel(case=case) for case in (UNDAMPED, DAMPED))
    for panel, letter, (name, norm, cmap) in zip((c, d), "cd", grids.SCALES, strict=True):
        values = free[name]
        mesh = grids.draw_cells(panel, values, norm=norm(), cmap=cmap)
        bar = figure.colorbar(mesh, ax=panel, aspect=26, pad=0.02)
        bar.outline.set_visible(False)
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
