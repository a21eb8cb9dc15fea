"""Largest angles of sweeps of the driving frequency, up and down."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points
from latolato.figures.map import WAYS
from latolato.figures.map_title import in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

READING = (
    "The drive frequency slowly rises, then falls; the curves show the largest swing. Where "
    "the area between them is shaded, the motion depends on its past; hollow points differ only "
    "for a while."
)
FIRST = {"frequency_ratio": "{ratios} : 41", "duration": "60"}

_MOST_PANELS = 4


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return a panel for each of up to four amplitudes, the loop shaded, jumps dashed."""
    count = dataset.sizes["drive_amplitude"]
    indices = np.unique(np.linspace(0, count - 1, min(count, _MOST_PANELS)).round().astype(int))
    columns = min(len(indices), 2)
    rows = math.ceil(len(indices) / columns)
    figure, panels = style.new_figure(
        rows, columns, height=2.5 * rows if rows > 1 else 2.9, sharex=True, sharey=True
    )
    for axis in panels.flat[len(indices) :]:
        axis.set_visible(False)
    for letter, axis, i in zip("abcd", panels.flat, indices, strict=False):
        row = dataset.isel(drive_amplitude=int(i))
        ways = [tr("frequency {direction}", direction=tr(way)) for way in row.direction.values]
        amplitude = in_words(dataset, "drive_amplitude", row.drive_amplitude.item())
        draw_points(
            axis,
            row.frequency_ratio,
            row.largest_angle,
            row.direction.copy(data=ways),
            colours=[WAYS[way] for way in row.direction.values],
            ls="-",
            lw=style.THIN,
            ms=2.5,
        )
        differ, two = (
            np.abs(np.diff(angles.values, axis=0)[0]) >= dataset.attrs["least_jump"]
            for angles in (row.largest_angle, row.settled_angle)
        )
        _shade(axis, row, two)
        passing = row.sel(frequency_ratio=differ & ~two)
        if passing.sizes["frequency_ratio"]:
            for mark, (way, colour) in zip("os", WAYS.items(), strict=True):
                axis.scatter(
                    passing.frequency_ratio, passing.largest_angle.sel(direction=way), s=7.0,
                    marker=mark, color=style.PAPER, ec=colour, lw=style.THIN, zorder=3,
                    label=tr("only for a while"),
                )  # fmt: skip
        for way, colour in WAYS.items():
            jump, text = (
                float(row.jump_ratio.sel(direction=way)),
                tr("largest jump {direction}", direction=tr(way)),
            )
            axis.axvline(jump, color=colour, lw=style.THIN, ls=(0, (3, 3)), zorder=0, label=text)
        style.panel_title(axis, letter, f"{amplitude}: {tr(row.status.item())}")
        axis.label_outer()
    panels[0, 0].set_xlim(dataset.frequency_ratio.min(), dataset.frequency_ratio.max())
    panels[0, 0].set_ylim(bottom=0.0)
    entries = [zip(*axis.get_legend_handles_labels(), strict=True) for axis in panels.flat]
    legend = {text: handle for pairs in entries for handle, text in pairs}
    columns = 4 if len(legend) == 4 else 3
    figure.legend(legend.values(), legend, loc="outside lower center", ncols=columns)
    return figure


def _shade(axis: Axes, row: xr.Dataset, two: NDArray[np.bool_]) -> None:
    """Shade the loop where there are two answers, half a step to both sides of each."""
    ratios = row.frequency_ratio.values
    places = np.sort(np.append(ratios, 0.5 * (ratios[1:] + ratios[:-1])))
    up, down = (np.interp(places, ratios, angles) for angles in row.largest_angle.values)
    mask = np.zeros(len(places), dtype=bool)
    mask[::2] = two
    mask[1::2] = two[1:] | two[:-1]
    axis.fill_between(places, up, down, where=mask, color=style.PALE_GREY, lw=0)
