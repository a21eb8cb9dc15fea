"""Which first stages and which pushes reach the upper branch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

READING = (
    "On the left each cell is a first stage: its duration to the right, its frequency "
    "upwards; bright cells succeed. On the right stands the push by hand that does the same. "
    "If nothing was searched, a curve shows how far each push leads."
)
FIRST = {"frequency_ratio": "", "first_frequency_ratio": "", "dwell_time": "", "phases": "4"}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the map of successful protocols, and the pushes that do the same.

    Where no protocol was searched for, the settled angles after pushes say why.
    """
    push = dataset["push"]
    if not np.isfinite(dataset.success_share.values).any():
        figure, panels = style.new_figure(height=3.0)
        draw_points(panels[0, 0], push, dataset.angle_after_push, ls="-", ms=3.0)
        panels[0, 0].set_ylim(bottom=0.0)
        panels[0, 0].set_ylabel(tr("settled angle, median over drive phases [°]"))
        return figure
    figure, panels = style.new_figure(1, 2, height=3.0, width_ratios=[1.35, 1.0])
    left, right = panels[0]
    _draw_map(dataset, left)
    style.panel_title(left, "a", tr("protocols: {status}", status=tr(dataset.status.item())))
    draw_points(right, push, dataset.push_share, ls="-", ms=3.0)
    style.mark_level(right, float(dataset.attrs["required_share"]), tr("required"))
    smallest = float(dataset.smallest_push)
    if math.isfinite(smallest):
        energy = 1e3 * float(dataset.smallest_push_energy)
        place = smallest, float(dataset.push_share.sel(push=smallest))
        _mark(right, place, f"{smallest:.3g} rad/s, {energy:.3g} mJ")
    right.set_ylim(-0.03, 1.05)
    right.set_ylabel(tr("share of drive phases"))
    right.set_xlabel(f"{tr('push of each ball')} ${push.attrs['symbol']}$ [rad/s]")
    style.panel_title(right, "b", tr("pushes at the target frequency"))
    return figure


def _draw_map(dataset: xr.Dataset, axis: Axes) -> None:
    """Draw the share of success over dwell and first stage, and mark the shortest protocol."""
    dwell, ratio = dataset.dwell_time, dataset.first_frequency_ratio
    edges = style.edges_of(dwell.values), style.edges_of(ratio.values)
    cells = style.draw_cells(axis, *edges, dataset.success_share.values, vmin=0.0, vmax=1.0)
    style.colour_bar(cells, tr("share of drive phases"))
    best = float(dataset.best_dwell_time), float(dataset.best_first_ratio)
    if math.isfinite(best[0]):
        _mark(axis, best, f"{float(dataset.lead_time):.3g} s")
    about = dataset.attrs
    if about["system"] == "latolato" and about.get("drive_amplitude"):
        lift_off = math.sqrt(about["length"] / about["drive_amplitude"])
        if ratio[0] < lift_off < ratio[-1]:
            axis.axhline(lift_off, color=style.ORANGE, lw=style.LINE, ls=(0, (4, 3)))
            place = float(dwell[-1]), lift_off
            style.note(axis, tr("lift-off"), place, (-2.0, -4.0), ha="right", va="top")
    axis.set_xlabel(style.label(dwell))
    axis.set_ylabel(style.label(ratio))


def _mark(axis: Axes, place: tuple[float, float], text: str) -> None:
    """Put a ring about the best point of a panel, and its numbers beside it."""
    axis.plot(*place, "o", ms=7.0, mfc="none", mec=style.RED, mew=1.6)
    style.note(axis, text, place, (7.0, -3.0), va="top", colour=style.RED)
