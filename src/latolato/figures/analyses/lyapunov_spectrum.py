"""The picture of a Lyapunov spectrum: its exponents, and the sum that they must have."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.question import DISTURBANCE, Cost, Question, on_rods
from latolato.figures.analyses.sentences import e_folding, no_answer, number
from latolato.figures.analyses.words import head, tex_number, write_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MEANING = {
    "regular": "neighbours come together",
    "chaotic": "neighbours part exponentially",
    "marginal": "undecided in this time",
    "rest": "the motion forgets its past",
}

# What grows or shrinks exponentially.
_DISTANCE = "the distance between neighbouring starts"
# Between rests a deviation must grow or shrink by so many e-folds to forget how it began.
_RARE = 10.0


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the exponents as bars; one of minus infinity is an arrow to the bottom."""
    figure, panels = style.new_figure(
        1, 2, width=0.9 * style.PAGE, height=3.0, width_ratios=[1.0, 0.95]
    )
    axes, text = panels[0]
    values = np.asarray(dataset["lyapunov_exponents"].values, dtype=np.float64)
    places = range(1, len(values) + 1)
    finite = values[np.isfinite(values)]
    reach = float(np.max(np.abs(finite), initial=0.0)) or 1.0
    low, high = min(0.0, finite.min(initial=0.0)), max(0.0, finite.max(initial=0.0))
    bottom = (-reach if np.isneginf(values).any() else low) - 0.18 * reach
    axes.axhline(0.0, color=style.INK, lw=style.THIN, zorder=3)
    for place, value in zip(places, values, strict=True):
        colour = style.RED if value > 0.0 else style.BLUE
        if math.isfinite(value):
            axes.bar(place, value, width=0.55, color=colour)
            up = value >= 0.0
            style.note(
                axes, tex_number(value), (place, value), (0.0, 3.0 if up else -3.0), ha="center",
                va="bottom" if up else "top",
            )  # fmt: skip
        elif np.isneginf(value):
            axes.annotate(
                "", xy=(place, bottom), xytext=(place, 0.0),
                arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2.0 * style.LINE},
            )  # fmt: skip
            style.note(axes, "\N{MINUS SIGN}∞", (place, 0.5 * bottom), (6.0, 0.0))
        else:
            style.note(axes, "no value", (place, 0.0), (0.0, 4.0), ha="center", va="bottom")
    axes.set_ylim(bottom, high + 0.18 * reach)
    axes.set_xlim(0.4, len(values) + 0.6)
    axes.set_xticks(places, [rf"$\lambda_{i}$" for i in places])
    axes.tick_params(axis="x", length=0.0)
    axes.spines["bottom"].set_visible(False)
    axes.set_ylabel(style.label(dataset["lyapunov_exponents"]))
    if not finite.size:
        axes.set_yticks([])
    status = str(dataset["status"].item())
    write_words(text, status, _MEANING.get(status, ""), _rows(dataset, values), column=0.5)
    head(figure, dataset)
    return figure


def _between_rare_rests(dataset: xr.Dataset) -> float | None:
    """Return the exponent between rests, None if they are too frequent for it to mean anything."""
    between = float(dataset.get("exponent_between_rests", math.nan))
    if not math.isfinite(between):
        return None
    observed = dataset.attrs["duration"] - dataset.attrs["transient"]
    return between if abs(between) * observed > _RARE * float(dataset["rests"]) else None


def _rows(dataset: xr.Dataset, values: np.ndarray) -> list[tuple[str, str]]:
    """Return names and values of the sum rule and of the time."""
    total = float(np.sum(values))
    rows = [
        ("sum of exponents", total),
        ("mean divergence", float(dataset["divergence"])),
        ("difference", float(dataset["sum_rule_residual"]) if math.isfinite(total) else math.nan),
    ]
    observed = dataset.attrs["duration"] - dataset.attrs["transient"]
    rests = float(dataset.get("rests", 0.0))
    if rests > 0.0:
        rows.append(("between rests", float(dataset["exponent_between_rests"])))
    return [
        *((name, f"{tex_number(value)} 1/s") for name, value in rows if not math.isnan(value)),
        *([("rests", f"{rests:g}")] if rests > 0.0 else []),
        ("observed", f"{observed:g} s"),
    ]


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
