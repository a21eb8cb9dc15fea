"""The picture of a Lyapunov spectrum: its exponents, and the sum that they must have."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.drawings import head, text_of, write_numbers
from latolato.figures.analyses.question import DISTURBANCE, Cost, Question, on_rods
from latolato.figures.analyses.sentences import e_folding, no_answer, number

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# What is written beside the picture.
_ROWS = ("divergence", "sum_rule_residual", "exponent_between_rests", "rests")
# What grows or shrinks exponentially.
_DISTANCE = "the distance between neighbouring starts"
# Between rests a perturbation must grow or shrink by so many e-folds to forget how it began.
_RARE = 10.0


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the exponents as bars; one of minus infinity is an arrow to the bottom."""
    figure, panels = style.new_figure(1, 2, height=3.0, width_ratios=[1.0, 1.3])
    axes, text = panels[0]
    exponents = dataset["lyapunov_exponents"]
    values = exponents.values
    places = range(1, len(values) + 1)
    finite = np.where(np.isfinite(values), values, 0.0)
    reach = float(np.max(np.abs(finite))) or 1.0
    bottom = -reach if np.isneginf(values).any() else finite.min()
    axes.axhline(0.0, color=style.INK, lw=style.THIN, zorder=3)
    for place, value in zip(places, values.tolist(), strict=True):
        colour = style.RED if value > 0.0 else style.BLUE
        name = text_of("lyapunov_exponents", value, "1")
        end = bottom if value == -math.inf else np.nan_to_num(value)
        if value == -math.inf:
            arrow = {"arrowstyle": "-|>", "color": colour, "lw": 2.0 * style.LINE}
            axes.annotate("", (place, bottom), (place, 0.0), arrowprops=arrow)
        else:
            axes.bar(place, end, width=0.55, color=colour)
        side, shift = ("top", -3.0) if value < 0.0 else ("bottom", 3.0)
        style.note(axes, name, (place, end), (0.0, shift), ha="center", va=side)
    axes.set_ylim(bottom - 0.18 * reach, max(0.0, finite.max()) + 0.18 * reach)
    axes.set_xlim(0.4, len(values) + 0.6)
    axes.set_xticks(places, [rf"$\lambda_{i}$" for i in places])
    axes.tick_params(axis="x", length=0.0)
    axes.spines["bottom"].set_visible(False)
    axes.set_ylabel(style.label(exponents))
    if not np.isfinite(values).any():
        axes.set_yticks([])
    write_numbers(text, dataset, [str(each) for each in dataset if each in _ROWS])
    head(figure, dataset)
    return figure


def _between_rare_rests(dataset: xr.Dataset) -> float | None:
    """Return the exponent between rests, None if they are too frequent for it to mean anything."""
    between = float(dataset.get("exponent_between_rests", math.nan))
    if not math.isfinite(between):
        return None
    observed = dataset.attrs["duration"] - dataset.attrs["transient"]
    return between if abs(between) * observed > _RARE * float(dataset["rests"]) else None


def verdict(dataset: xr.Dataset) -> str:
    """Tell whether neighbours part and how fast."""
    status, largest = str(dataset["status"].item()), float(dataset["lyapunov_exponents"].max())
    if status == "rest":
        between = _between_rare_rests(dataset)
        if between is None:
            return "No: the balls come to rest on each other, and the past is forgotten."
        way = "grows" if between > 0.0 else "shrinks"
        return (
            "No, strictly: now and then the balls rest on each other, and the past is forgotten. "
            f"Between such rests {_DISTANCE} {way} {e_folding(between)}."
        )
    if status not in ("chaotic", "regular", "marginal"):
        return no_answer(status)
    span = dataset.attrs.get("duration")
    watched = f", followed for {number(float(span))} s" if span is not None else ""
    tail = f" The largest exponent is {number(largest)} 1/s{watched}."
    if status == "chaotic":
        return f"Yes: {_DISTANCE} grows {e_folding(largest)}: chaos.{tail}"
    if status == "regular":
        return f"No: {_DISTANCE} shrinks {e_folding(largest)}.{tail}"
    return f"The run is too short to tell: follow it longer.{tail}"


QUESTION = Question(
    group=DISTURBANCE,
    title="Is it chaotic?",
    term="Lyapunov exponents",
    reading="Do two starts that almost agree drift apart? A red bar above zero means yes, ever "
    "faster, and nobody can predict the motion for long. Blue bars mean that they come "
    "together again.",
    first=("duration", "transient"),
    conditions=(on_rods,),
    quick={"duration": "300"},
    place=1,
    # It takes long to tell an exponent from zero.
    cost=Cost(decay_times=30.0),
    verdict=verdict,
)
