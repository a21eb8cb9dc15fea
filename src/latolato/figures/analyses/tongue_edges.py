"""The tongues up to twice the amplitude, with the edges at one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.figures import style
from latolato.figures.analyses.question import REST, Question, can_hang, is_shaken
from latolato.figures.analyses.sentences import POSITION_WORDS, millimetres, number
from latolato.figures.analyses.stored_system import system_of
from latolato.figures.analyses.tongues import draw_tongues, mark_answer, new_panel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# The least A0/l that the picture reaches.
_LEAST = 0.1


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.tongue_edges`."""
    about, length = dataset.attrs, system_of(dataset).balls[0].length
    amplitude, position = about["drive_amplitude"], about["position"]
    rod = about.get("connecting_rod_length", math.inf)
    largest = min(max(2.0 * amplitude, _LEAST * length), max(0.9 * rod, amplitude))
    figure, axes = new_panel(dataset, f"{position} is unstable inside")
    draw_tongues(axes, dataset, largest=largest, position=position)
    height = amplitude / length
    axes.axhline(height, color=style.GREY, lw=style.THIN, ls=(0, (4, 3)), zorder=1)
    for name, side, shift in (("low", "right", -5.0), ("high", "left", 5.0)):
        edge = float(dataset[name]) or math.nan  # of a tongue that begins at zero
        mark_answer(axes, (edge, height), f"{edge:.6f}", (shift, 5.0), ha=side, va="bottom")
    return figure


def verdict(dataset: xr.Dataset) -> str:
    """Tell both edges."""
    low, high = float(dataset["low"]), float(dataset["high"])
    where = POSITION_WORDS[dataset.attrs["position"]]
    with_amplitude = f"With an amplitude of {millimetres(dataset.attrs['drive_amplitude'])}"
    if str(dataset["status"].item()) == "slackens":
        return f"{with_amplitude} the string goes slack before the tongue ends."
    if not math.isfinite(low):
        return f"{with_amplitude} tongue {dataset.attrs['order']} is closed: drag is too strong."
    if not math.isfinite(high):
        return f"{with_amplitude} {where} is unstable at all speeds above ω/ω₀ = {number(low, 5)}."
    return (
        f"{with_amplitude} {where} is unstable from ω/ω₀ = {number(low, 5)} to {number(high, 5)}."
    )


QUESTION = Question(
    group=REST,
    title="At which speeds does hanging still become impossible?",
    term="parametric resonance, Mathieu-Hill tongue",
    reading="In the coloured tongues the smallest swing grows by itself, as on a garden swing. The "
    "dashed line marks the chosen amplitude; the dots are the edges on it.",
    first=("drive_amplitude", "order", "position"),
    conditions=(can_hang, is_shaken),
    place=1,
    verdict=verdict,
)
