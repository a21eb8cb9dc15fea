"""The tongues with the amplitude at which a frequency first meets one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.figures import style
from latolato.figures.analyses.question import REST, Question, can_hang, is_even
from latolato.figures.analyses.sentences import millimetres, number
from latolato.figures.analyses.stored_system import system_of
from latolato.figures.analyses.tongues import draw_tongues, mark_answer, new_panel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# The least A0/l that the picture reaches, and where it ends without an answer.
_LEAST, _WITHOUT = 0.05, 0.5


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.threshold_amplitude`."""
    about, length = dataset.attrs, system_of(dataset).balls[0].length
    ratio, amplitude = about["frequency_ratio"], float(dataset.drive_amplitude)
    exists = not math.isnan(amplitude)
    largest = max(2.0 * amplitude, _LEAST * length) if exists else _WITHOUT * length
    largest = min(largest, 0.9 * about.get("connecting_rod_length", math.inf))
    figure, axes = new_panel(dataset, "hanging is unstable inside")
    draw_tongues(axes, dataset, largest=largest)
    axes.set_xlim(min(0.5, 0.8 * ratio), max(3.2, 1.1 * ratio))
    axes.axvline(ratio, color=style.GREY, lw=style.THIN, ls=(0, (4, 3)), zorder=1)
    mark_answer(axes, (ratio, amplitude / length), f"{1e3 * amplitude:.4g} mm")
    return figure


def verdict(dataset: xr.Dataset) -> str:
    """Tell the amplitude."""
    at = f"At ω/ω₀ = {number(dataset.attrs['frequency_ratio'], 4)}"
    amplitude = float(dataset["drive_amplitude"])
    if str(dataset["status"].item()) == "slackens":
        return f"{at} the string goes slack before a small swing grows."
    if not math.isfinite(amplitude):
        return f"{at} no amplitude up to the limit of the search makes hanging unstable."
    return f"{at} a small swing grows once the amplitude exceeds {millimetres(amplitude)}."


QUESTION = Question(
    group=REST,
    title="How strongly must it be shaken to swing up by itself?",
    term="threshold of parametric resonance",
    reading="In the coloured tongues hanging still is impossible. The dot shows where this speed "
    "first meets a tongue; below it a small swing dies away.",
    first=("frequency_ratio", "order"),
    conditions=(can_hang, is_even),
    place=2,
    verdict=verdict,
)
