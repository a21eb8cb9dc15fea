"""The colliding pair's map of Fig. 5 on strings beside rods, from rest and with a push."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import cells, style
from latolato.paper import fig05, grids
from latolato.paper import systems as paper
from latolato.paper.cases import Floats
from latolato.paper.claim import Numbers
from latolato.paper.string_toys import on_one_engine

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The colliding pair of Fig. 5 on strings"
CAPTION = (
    "The maps of Fig. 5 (elastic impacts, no drag, 300 s) on a coarser grid. Columns: mean energy "
    "of one ball on rods; on strings that snap taut without a rebound; the ratio of the two, grey "
    "where both motions are the same. Rows: from rest, and with a push. Dashed: lift-off from "
    "rest, A0 ω² = g."
)
FINDING = (
    "From rest, strings and rods move differently at {differ_rest:.0%} of the points and disagree "
    "at {class_rest:.1%} on whether the balls ever pass 2 rad; with a push at {differ_push:.0%} "
    "and {class_push:.1%}. At {less_rest:.0%} of all points (push: {less_push:.0%}) strings carry "
    "less than half of the rods' energy, as strings that snap taut lose some, and at "
    "{more_rest:.0%} (push: {more_push:.0%}) more than twice as much: there, at small amplitudes "
    "and high frequencies, a rod holds down a ball that a string lets fly."
)
CHECK = (
    "Where no rod is ever pushed, strings and rods must agree. They do to the last digit at all "
    "{same:.0f} points of this kind, and every one of the {different:.0f} points that differ has a "
    "rod that is pushed for some of the time. For this the rods run through the same steps as the "
    "strings: by the faster program of Fig. 5 they differ by rounding, which chaotic motion makes "
    "as large as the motion."
)
STARTS = {"rest": 0.0, "push": fig05.PUSH}
POINTS, QUICK_POINTS = 50, 12  # along each axis
OBSERVABLES = ("mean_energy", "crossings", "largest_angle", "top_contacts")
KEPT = (*OBSERVABLES, "compression_fraction")
_RODS, _STRINGS = "rods", "strings"


def data(quick: bool = False) -> xr.Dataset:
    """Return the maps on rods and on strings, from rest and with a push."""
    from latolato import sweep

    toy = on_one_engine(fig05.TOY)
    systems = {_RODS: toy, _STRINGS: replace(toy, suspension="string")}
    maps: dict[str, xr.Dataset] = {}
    for start, offset in STARTS.items():
        for name, system in systems.items():
            pushed_or_slack = "compression_fraction" if name == _RODS else "slack_fraction"
            grid = sweep(
                system,
                axes=grids.paper_axes(system.length, QUICK_POINTS if quick else POINTS),
                duration=paper.SWEEP_DURATION,
                initial_offset=offset,
                observables=(*OBSERVABLES, pushed_or_slack),
            )
            if name == _STRINGS:  # a string is never pushed
                grid["compression_fraction"] = 0.0 * maps[f"{_RODS}_{start}"].compression_fraction
            maps[f"{name}_{start}"] = grid
    return grids.gather(maps, title=TITLE, keep=KEPT)


def _pair(dataset: xr.Dataset, start: str) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the maps on rods and on strings of a start."""
    return dataset.sel(case=f"{_RODS}_{start}"), dataset.sel(case=f"{_STRINGS}_{start}")


def _differ(dataset: xr.Dataset, start: str) -> grids.Mask:
    """Return the mask of points at which any number of the two motions differs."""
    rods, strings = _pair(dataset, start)
    different = [rods[name].values != strings[name].values for name in OBSERVABLES]
    mask: grids.Mask = np.logical_or.reduce(different)
    return mask


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return shares of points that differ, and the check of where they may."""
    result = {"same": 0.0, "different": 0.0, "outside": 0.0}
    for start in STARTS:
        rods, strings = _pair(dataset, start)
        differ, pushed = _differ(dataset, start), rods.compression_fraction.values > 0.0
        active = [each.crossings.values > 0.0 for each in (rods, strings)]
        ratio: Floats = (strings.mean_energy / rods.mean_energy).values
        result |= {
            f"differ_{start}": float(differ.mean()),
            f"class_{start}": float((active[0] != active[1]).mean()),
            f"pushed_{start}": float(pushed.mean()),
            f"less_{start}": float((ratio < 0.5).mean()),
            f"more_{start}": float((ratio > 2.0).mean()),
        }
        result["same"] += float((~pushed).sum())
        result["different"] += float(differ.sum())
        result["outside"] += float((differ & ~pushed).sum())
    return result


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (f)."""
    from matplotlib.colors import LogNorm

    figure, axes = style.new_figure(2, 3, sharex=True, sharey=True, height=4.9)
    name, norm, cmap = cells.SCALES[0]
    for row, start in enumerate(STARTS):
        words = "from rest" if start == "rest" else "with a push"
        for column, part in enumerate(_pair(dataset, start)):
            panel = axes[row, column]
            mesh = cells.draw_cells(panel, part[name], norm=norm(), cmap=cmap)
            title = f"{'rods' if column == 0 else 'strings'}, {words}"
            style.panel_title(panel, "abcdef"[3 * row + column], title)
        panel = axes[row, 2]
        rods, strings = _pair(dataset, start)
        differ = _differ(dataset, start)
        ratio = (strings[name] / rods[name]).where(differ)
        panel.set_facecolor(style.PALE_GREY)
        ratios = cells.draw_cells(panel, ratio, norm=LogNorm(0.1, 10.0), cmap="PuOr")
        style.panel_title(panel, "abcdef"[3 * row + 2], "strings over rods")
        for each in axes[row]:
            handle = grids.draw_overlay(each, fig05.TOY, "lift_off")
        axes[row, 0].set_ylabel(style.label(dataset.drive_amplitude))
    for panel in axes[1]:
        panel.set_xlabel(style.label(dataset.frequency_ratio, short=True))
    style.colour_bar(
        mesh, grids.label(dataset[name]), ax=list(axes[:, :2].ravel()), location="bottom",
        aspect=40, shrink=0.8,
    )  # fmt: skip
    style.colour_bar(
        ratios, "ratio of mean energies", ax=list(axes[:, 2]), location="bottom", aspect=20
    )
    figure.legend(handles=[handle], loc="outside lower center")
    return figure
