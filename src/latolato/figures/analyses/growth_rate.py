"""The growth rate over the driving frequency, at one amplitude."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.analysis import growth_rate
from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.stored_system import drive_of, system_of
from latolato.figures.analyses.tongues import answers, mark_answer, new_panel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "The drive frequency runs to the right, the growth rate of a small swing upwards. Above "
    "zero the swing grows, below zero it dies away. The dot marks the present frequency."
)
FIRST = {"position": ""}

# Frequencies under a cosine, and under other waveforms.
_SAMPLES, _FEW_SAMPLES = 161, 81


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.growth_rate`."""
    position = dataset.attrs["position"]
    system, drive = system_of(dataset), drive_of(dataset)
    figure, axes = new_panel(dataset, tr(position))
    axes.axhline(0.0, color=style.GREY, lw=style.THIN, zorder=1)
    rate, w0 = float(dataset.growth_rate), system.natural_frequency
    frequency = dataset.attrs.get("drive_frequency", 0.0) if drive.moves else 0.0
    place = frequency / w0
    if frequency == 0.0:
        axes.axhline(rate, color=style.BLUE)
        axes.set_xlim(0.0, 3.2)
    else:
        plain = drive.is_cosine and position == "hanging"
        count = _SAMPLES if plain else _FEW_SAMPLES
        ratios = np.linspace(min(0.5, 0.7 * place), max(3.2, 1.4 * place), count)

        def at(ratio: float) -> xr.Dataset:
            shaken: Any = replace(drive, drive_frequency=ratio * w0)  # type: ignore[call-arg]
            return growth_rate(system, shaken, position=position)

        (rates,) = answers(at, ratios, "growth_rate")
        axes.plot(ratios, rates, color=style.BLUE)
        axes.fill_between(ratios, 0.0, np.maximum(rates, 0.0), color=style.PALE_BLUE, lw=0.0)
    mark_answer(axes, (place, rate), f"{rate:.5g} 1/s", (6.0, 6.0))
    axes.set_xlabel(style.label_of("frequency_ratio"))
    axes.set_ylabel(style.label(dataset.growth_rate))
    return figure
