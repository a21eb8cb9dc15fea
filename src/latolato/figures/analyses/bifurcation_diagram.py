"""The picture of a bifurcation diagram: stroboscopic angles and largest angles, both ways."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.question import LONG_RUN, Cost, Question, is_shaken, on_rods, settles
from latolato.figures.analyses.sentences import listed, percent, range_of, shakes, times

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_HATCH = "////"
_WAYS = {"up": (style.RED, "o", "up"), "down": (style.BLUE, "s", "down")}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the samples above and the largest angle below, the ways up and down in two colours."""
    figure, axes = style.new_figure(2, 1, width=0.75 * style.PAGE, height=4.6, sharex=True)
    samples, largest = axes[:, 0]
    name = dataset.attrs["parameter"]
    x = dataset[name].values
    if "is_hysteretic" in dataset:
        for panel in (samples, largest):
            _shade(panel, x, dataset["is_hysteretic"].values == 1)
            _shade(panel, x, np.isnan(dataset["is_hysteretic"].values), hatch=_HATCH)
    for way in (str(each) for each in dataset["direction"].values):
        colour, mark, text = _WAYS[way]
        part = dataset.sel(direction=way)
        angle = part["section_angle"]
        if "ball" in angle.dims:
            angle = angle.isel(ball=0)
        values = angle.transpose(name, "sample").values
        size = float(np.clip(120.0 / len(x), 0.7, 2.5))
        samples.plot(
            np.repeat(x, values.shape[1]), values.ravel(), mark, color=colour, ms=size, mew=0.0,
            rasterized=True, zorder=3 if way == "up" else 2,
        )  # fmt: skip
        largest.plot(
            x, part["largest_angle_watched"].values, mark, color=colour, ms=max(size, 1.2),
            mew=0.0, label=f"followed {text}", zorder=3 if way == "up" else 2,
        )  # fmt: skip
    samples.set_ylabel(style.label(dataset["section_angle"], short=True))
    largest.set_ylabel(style.label(dataset["largest_angle_watched"], short=True))
    largest.set_xlabel(style.label(dataset[name]))
    largest.set_xlim(float(x[0]), float(x[-1]))
    style.panel_title(samples, "a", "angle once per drive period")
    style.panel_title(largest, "b", "largest angle")
    handles, texts = largest.get_legend_handles_labels()
    if "is_hysteretic" in dataset:
        from matplotlib.patches import Patch

        if (dataset["is_hysteretic"].values == 1).any():
            handles.append(Patch(facecolor=style.PALE_GREY))
            texts.append("both ways differ")
        if np.isnan(dataset["is_hysteretic"].values).any():
            handles.append(Patch(facecolor="none", edgecolor=style.PALE_GREY, hatch=_HATCH))
            texts.append("undecided")
    figure.legend(handles, texts, loc="outside lower center", ncols=len(handles), markerscale=2.0)
    return figure


def _shade(panel: Any, x: Any, where: Any, hatch: str = "") -> None:
    """Shade, or hatch, some values of a parameter."""
    half = 0.5 * (x[1] - x[0])
    padded = np.concatenate([[False], where, [False]]).astype(int)
    starts, ends = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
    for start, end in zip(starts, ends, strict=True):
        panel.axvspan(
            x[start] - half, x[end - 1] + half, facecolor="none" if hatch else style.PALE_GREY,
            edgecolor=style.PALE_GREY, hatch=hatch, lw=0.0, zorder=0,
        )  # fmt: skip


def verdict(dataset: xr.Dataset) -> str:
    """Tell how many settings move, which periods occur, and where both ways differ."""
    status = dataset["status"].values.astype(str)
    moving = np.isin(status, ("periodic", "grazing", "aperiodic"))
    knob = dataset[dataset.attrs["parameter"]]
    values = knob.values
    tried = f"{values.size} settings, {range_of(knob, values.min(), values.max())}"
    if not moving.any():
        share = (status == "rest").mean()
        if share == 1.0:
            return f"It ends at rest at all {tried}."
        return (
            f"It ends at rest at {percent(share)} of the {tried}. At the others {_other(status)}."
        )
    text = f"It keeps moving at {percent(moving.mean())} of the {tried}."
    periods = dataset["response_period"].values[np.isin(status, ("periodic", "grazing"))]
    known = [shakes(p) for p in np.unique(periods[np.isfinite(periods)])]
    parts = [f"repeats {listed(known[:4], 'or')}"] if known else []
    if len(known) > 4:
        parts.append("repeats more slowly")
    if (status == "aperiodic").any():
        parts.append("never repeats")
    text += f" There it {', or '.join(parts)}."
    lost = ~(moving | (status == "rest"))
    if lost.any():
        text += f" At {percent(lost.mean())} {_other(status)}."
    if "is_hysteretic" in dataset:
        both = values[dataset["is_hysteretic"].values == 1]
        if both.size:
            where = range_of(knob, both.min(), both.max())
            text += (
                f" At {times(both.size, 'setting')}, {where}, it depends on whether you come from "
                "below or from above."
            )
    return text


def _other(status: Any) -> str:
    """Tell what is known of settings that neither move nor rest."""
    if (status == "not settled").any():
        return "it has not settled yet"
    return "it has no answer"


QUESTION = Question(
    group=LONG_RUN,
    title="What happens when I turn one knob?",
    term="bifurcation diagram",
    reading="Above each setting of the knob you see the angles once per shake. One dot: the motion "
    "repeats every shake; two dots: every second shake; a smear: never. Red is the way up, "
    "blue the way back down: where they differ, the past decides.",
    first=("parameter", "low", "high", "points"),
    quick={"points": "41", "parameter": "frequency_ratio"},
    conditions=(settles, is_shaken, on_rods),
    place=1,
    cost=Cost(counts=("points",), most_shakes=1_000),
    verdict=verdict,
)
