"""The tongues up to twice the amplitude, with the edges at one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.figures import style
from latolato.figures.analyses.question import REST, Question, can_hang, is_shaken
from latolato.figures.analyses.sentences import POSITION_WORDS, millimetres, number
from latolato.figures.analyses.stored_system import drive_of, system_of
from latolato.figures.analyses.tongues import draw_tongues, parameters_in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# The least A0/l that the picture reaches.
_LEAST = 0.1


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.tongue_edges`."""
    about = dataset.attrs
    system, drive = system_of(dataset), drive_of(dataset)
    length = system.balls[0].length
    amplitude = about["drive_amplitude"]
    largest = max(2.0 * amplitude, _LEAST * length)
    if "connecting_rod_length" in about:
        largest = min(largest, max(0.9 * about["connecting_rod_length"], amplitude))
    figure, panels = style.new_figure(width=0.7 * style.PAGE, height=3.2)
    axes = panels[0, 0]
    draw_tongues(axes, system, drive, largest=largest, position=about["position"])
    axes.axhline(amplitude / length, color=style.GREY, lw=style.THIN, ls=(0, (4, 3)), zorder=1)
    for name, side in (("low", "right"), ("high", "left")):
        edge = float(dataset[name])
        if math.isfinite(edge) and edge > 0.0:
            axes.plot(edge, amplitude / length, "o", ms=4.0, color=style.INK, clip_on=False)
            shift = (-5.0, 5.0) if side == "right" else (5.0, 5.0)
            style.note(axes, f"{edge:.6f}", (edge, amplitude / length), shift, ha=side, va="bottom")
    names = ("length", "mass", "damping", "connecting_rod_length")
    axes.set_title(
        f"{about['position']} is unstable inside\n{parameters_in_words(dataset, *names)}"
    )
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
