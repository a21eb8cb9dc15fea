"""The picture of the first push: curves or a map over frequency and phase of the drive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.question import BEGINNING, Cost, Question, is_shaken, settles
from latolato.figures.analyses.sentences import listed, number, times

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# More phases than this are a map.
_MOST_CURVES = 4


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the first push over frequency: points for few phases, or a map with many."""
    figure, axes = style.new_figure(width=0.75 * style.PAGE, height=3.4)
    panel = axes[0, 0]
    x = dataset["frequency_ratio"].values
    if dataset.sizes["drive_phase"] <= _MOST_CURVES:
        _draw_curves(panel, dataset)
    else:
        _draw_map(figure, panel, dataset)
    lift = dataset["drive_acceleration_ratio"].values
    risen = np.flatnonzero(np.diff((lift > 1.0).astype(int)) == 1)
    if dataset.attrs.get("system") != "pendulum" and risen.size:
        first = int(risen[0])
        share = (1.0 - lift[first]) / (lift[first + 1] - lift[first])
        place = x[first] + share * (x[first + 1] - x[first])
        colour = style.INK if dataset.sizes["drive_phase"] <= _MOST_CURVES else style.ORANGE
        panel.axvline(place, color=colour, lw=style.LINE, ls=(0, (4, 3)))
        panel.annotate(
            r"lift-off from rest ($A_0\omega^2 = g$)", (place, 1.0), (0, 3),
            ("data", "axes fraction"), textcoords="offset points", ha="center", va="bottom",
            fontsize=style.SMALL, color=style.INK,
        )  # fmt: skip
    panel.set_xlabel(style.label(dataset["frequency_ratio"]))
    return figure


def _draw_curves(panel: Any, dataset: xr.Dataset) -> None:
    """Draw points for each phase, and ticks where no push was enough.

    Steps join neighbours: the push jumps where a stripe ends, and is not known between.
    """
    x = dataset["frequency_ratio"].values
    few = len(x) <= 60
    for k, phase in enumerate(dataset["drive_phase"].values):
        column = dataset["first_push"].sel(drive_phase=phase).values
        colour = style.COLOURS[k]
        panel.step(x, column, where="mid", color=colour, lw=style.THIN, clip_on=False)
        panel.plot(
            x, column, "o", color=colour, ms=3.0 if few else 1.5,
            label=rf"$\varphi$ = {phase:.3g} rad", clip_on=False,
        )  # fmt: skip
    none = np.isnan(dataset["first_push"].values).all(axis=1)
    if none.any():
        panel.plot(
            x[none], np.zeros(none.sum()), "|", color=style.GREY, ms=8.0, clip_on=False,
            transform=panel.get_xaxis_transform(), label="no push is enough",
        )  # fmt: skip
    panel.set_ylim(bottom=0.0)
    panel.set_ylabel(style.label(dataset["first_push"]))
    panel.legend(loc="best")


def _draw_map(figure: Any, panel: Any, dataset: xr.Dataset) -> None:
    """Draw a map over frequency and phase; white where no push is needed."""
    values = dataset["first_push"].transpose("drive_phase", "frequency_ratio").values
    x, y = dataset["frequency_ratio"], dataset["drive_phase"]
    edges = style.edges_of(x.values), style.edges_of(y.values)
    cells = style.draw_cells(panel, *edges, np.where(values > 0.0, values, math.nan))
    style.fill_cells(panel, *edges, np.isnan(values), style.GREY)
    style.colour_bar(cells, style.label(dataset["first_push"]), aspect=28)
    style.show_unit(panel.yaxis, y)
    handles = []
    for mask, colour, text in (
        (values == 0.0, style.PAPER, "no push needed"),
        (np.isnan(values), style.GREY, "no push is enough"),
    ):
        if mask.any():
            handles.append(style.swatch(colour, text))
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=2)


def verdict(dataset: xr.Dataset) -> str:
    """Tell at how many settings which push is needed."""
    status = dataset["status"].values.astype(str).ravel()
    push = dataset["first_push"].values.ravel()
    error = dataset["push_error"].values.ravel()
    ratio = np.repeat(dataset["frequency_ratio"].values, dataset.sizes["drive_phase"])
    unit = str(dataset["first_push"].attrs["units"])
    alone, none = np.isin(status, ("self-start", "any push")), status == "none"
    tried, largest = status.size, number(float(dataset.attrs["largest_push"]))
    if alone.all():
        return f"No push is needed: it starts by itself at all {times(tried, 'drive speed')}."
    helped = np.flatnonzero(status == "push")
    speeds, lost = times(tried, "drive speed"), tried - int((alone | none).sum()) - helped.size
    parts = [f"{alone.sum()} need no push"] if alone.any() else []
    if helped.size:
        best = helped[np.argmin(push[helped])]
        least, width = number(float(push[best])), number(float(error[best]), 1)
        at = number(float(ratio[best]))
        text = f"The least push that starts it is {least} {unit}, at ω/ω₀ = {at}."
        parts.append(f"{helped.size} need one (the least is known to within {width} {unit})")
    elif alone.any():
        text = "At some speeds it starts by itself, at others not."
    elif none.any():
        text = f"No push up to {largest} {unit} starts it."
    else:
        return "There is no answer: at no drive speed did a run give one."
    if none.any():
        parts.append(f"at {none.sum()} no push up to {largest} {unit} helps")
    if lost:
        parts.append(f"{lost} have no answer")
    return f"{text} Of {speeds}, {listed(parts)}."


QUESTION = Question(
    group=BEGINNING,
    title="How hard must I push to get it going?",
    term="basin boundary on a line of starts",
    reading="To the right the speed of the drive, upwards the smallest push that starts lasting "
    "motion. At zero it starts by itself; where a point is missing no push helps.",
    first=("frequency_ratio", "push", "largest_push"),
    quick={"frequency_ratio": "{ratios} : 16", "scan_points": "30"},
    conditions=(settles, is_shaken),
    place=1,
    cost=Cost(counts=("scan_points",), most_shakes=5_000),
    labels={
        "drive_phase": "Phase of the drive at the push",
        "largest_push": "Largest push to try",
        "refinements": "Rounds of refinement",
        "scan_points": "Number of pushes to try",
        "sustained_angle": "It counts as going beyond",
    },
    verdict=verdict,
)
