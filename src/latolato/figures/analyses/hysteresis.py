"""Largest angles of sweeps of the driving frequency, up and down."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points
from latolato.figures.analyses.question import (
    BEGINNING,
    Cost,
    Question,
    is_shaken,
    on_rods,
    settles,
)
from latolato.figures.analyses.sentences import listed, number
from latolato.figures.map import WAYS
from latolato.figures.map_title import in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

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
        amplitude = in_words(dataset, "drive_amplitude", row.drive_amplitude.item())
        draw_points(
            axis,
            row.frequency_ratio,
            row.largest_angle,
            "frequency " + row.direction.astype(object),
            colours=[WAYS[way] for way in row.direction.values],
            ls="-",
            lw=style.THIN,
            ms=2.5,
        )
        axis.fill_between(row.frequency_ratio, *row.largest_angle, color=style.PALE_GREY, lw=0)
        for way, colour in WAYS.items():
            jump, text = float(row.jump_ratio.sel(direction=way)), f"largest jump {way}"
            axis.axvline(jump, color=colour, lw=style.THIN, ls=(0, (3, 3)), zorder=0, label=text)
        style.panel_title(axis, letter, f"{amplitude}: {row.status.item()}")
        axis.label_outer()
    panels[0, 0].set_xlim(dataset.frequency_ratio.min(), dataset.frequency_ratio.max())
    panels[0, 0].set_ylim(bottom=0.0)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def verdict(dataset: xr.Dataset) -> str:
    """Tell the range with two answers and the jumps."""
    row = dataset.isel(drive_amplitude=0)
    status = str(row["status"].item())
    if status == "no hysteresis":
        return "No: on the way up and on the way down it does the same."
    if status == "not settled":
        return "Both ways differ, but the runs are too short, or too wild, to tell: lengthen them."
    if status != "hysteresis":
        return "There is no verdict: at some of these speeds a run has no answer."
    low, high = (number(float(row[f"bistable_{end}"])) for end in ("low", "high"))
    where = f"at ω/ω₀ = {low}" if low == high else f"from ω/ω₀ = {low} to {high}"
    text = f"Yes: {where} the past decides what it does"
    ratios = np.sort(dataset["frequency_ratio"].values)
    step = float(np.diff(ratios).max(initial=math.nan))
    up = float(row["jump_ratio"].sel(direction="up"))
    down = float(row["jump_ratio"].sel(direction="down"))
    jumps = [
        f"at {number(place)} on the way {way}"
        for place, way in ((up, "up"), (down, "down"))
        if math.isfinite(place)
    ]
    text += f" (every {number(step, 1)} was tried)." if math.isfinite(step) else "."
    if float(row["bistable_high"]) == ratios[-1] or float(row["bistable_low"]) == ratios[0]:
        text += " It may go on beyond the speeds that were tried."
    return f"{text} The largest jumps are {listed(jumps)}." if jumps else text


QUESTION = Question(
    group=BEGINNING,
    title="Does it remember where it came from?",
    term="hysteresis, bistability",
    reading="The drive slowly gets faster, then slower; the curves show the largest swing. Where "
    "they part, the toy does one thing or the other, depending on its past.",
    first=("frequency_ratio", "duration"),
    quick={"frequency_ratio": "{ratios} : 41", "duration": "60"},
    conditions=(settles, is_shaken, on_rods),
    place=5,
    cost=Cost(decay_times=6.0),
    labels={
        "least_jump": "A jump is a change of at least",
        "least_motion": "Smallest swing to keep going",
    },
    verdict=verdict,
)
