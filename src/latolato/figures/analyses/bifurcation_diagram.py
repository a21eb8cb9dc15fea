"""The picture of a bifurcation diagram: stroboscopic angles and largest angles, both ways."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points
from latolato.figures.analyses.question import LONG_RUN, Cost, Question, is_shaken, on_rods, settles
from latolato.figures.analyses.sentences import listed, percent, range_of, shakes, times
from latolato.figures.map import WAYS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the samples above and the largest angle below, the ways up and down in two colours."""
    figure, axes = style.new_figure(2, 1, width=0.75 * style.PAGE, height=4.6, sharex=True)
    samples, largest = axes[:, 0]
    knob = dataset[dataset.attrs["parameter"]]
    angle, way = dataset["section_angle"], "way " + dataset["direction"].astype(object)
    angle = angle.isel(ball=0) if "ball" in angle.dims else angle
    size = float(np.clip(120.0 / knob.size, 0.7, 2.5))
    colours = [WAYS[each] for each in dataset["direction"].values]
    look: dict[str, Any] = {"colours": colours, "short": True}
    draw_points(samples, knob, angle, way, **look, ms=size)
    angle = dataset["largest_angle_watched"]
    draw_points(largest, knob, angle, way, **look, ms=max(size, 1.2))
    if "is_hysteretic" in dataset:
        differ = dataset["is_hysteretic"].values
        for panel in (samples, largest):
            for where, text, hatch in (
                (differ == 1, "both ways differ", ""),
                (np.isnan(differ), "undecided", "////"),
            ):
                if where.any():
                    panel.fill_between(
                        knob, 0.0, 1.0, where, step="mid", label=text, hatch=hatch, lw=0.0,
                        transform=panel.get_xaxis_transform(), zorder=0, edgecolor=style.PALE_GREY,
                        facecolor="none" if hatch else style.PALE_GREY,
                    )  # fmt: skip
    samples.set_xlabel("")
    style.show_unit(largest.xaxis, knob)
    largest.set_xlim(float(knob[0]), float(knob[-1]))
    style.panel_title(samples, "a", "angle once per drive period")
    style.panel_title(largest, "b", "largest angle")
    handles = largest.get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=len(handles[0]), markerscale=2.0)
    return figure


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
