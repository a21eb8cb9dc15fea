"""The first push over frequency and phase of the drive, with the frequency of lift-off."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses import drawings
from latolato.figures.analyses.question import BEGINNING, Cost, Question, is_shaken, settles
from latolato.figures.analyses.sentences import listed, number, times

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return curves or a map of the first push, and where balls at rest lift off by themselves."""
    figure = drawings.draw(dataset)
    lift, ratio = dataset["drive_acceleration_ratio"].values, dataset["frequency_ratio"].values
    if dataset.attrs["system"] != "pendulum" and lift[0] < 1.0 < lift[-1]:
        panel, place = figure.axes[0], float(np.interp(1.0, lift, ratio))
        panel.axvline(place, color=style.ORANGE, lw=style.LINE, ls=(0, (4, 3)))
        text = r"lift-off from rest ($A_0\omega^2 = g$)"
        style.note(panel, text, (place, panel.get_ylim()[1]), (-4.0, -8.0), ha="right")
    return figure


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
    reading="The drive speed runs to the right, the smallest push that starts lasting motion "
    "upwards. At zero the toy starts by itself; where a point is missing, no push helps.",
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
