"""The amplitude that starts the toy from rest, over the driving frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis import self_start
from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.stored_system import drive_of, system_of
from latolato.figures.analyses.tongues import answers, mark_answer, new_panel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "The drive frequency runs to the right, the amplitude upwards. In the coloured part the "
    "pivot drops faster than the balls fall, and they part without a push."
)
FIRST = {"frequency_ratio": "", "check": ""}

_SAMPLES = 41


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.self_start`."""
    system, drive = system_of(dataset), drive_of(dataset)
    place, amplitude = dataset.attrs["frequency_ratio"], float(dataset.drive_amplitude)
    ratios = np.geomspace(0.5 * place, 2.0 * place, _SAMPLES)
    (amplitudes,) = answers(lambda r: self_start(system, r, drive), ratios, "drive_amplitude")
    cosine = system.gravity / (ratios * system.natural_frequency) ** 2
    figure, axes = new_panel(dataset, tr("leaves rest inside"))
    ceiling = 2.0 * float(np.nanmax([amplitudes, cosine]))
    axes.fill_between(ratios, amplitudes, ceiling, color=style.PALE_RED, lw=0.0)
    axes.plot(ratios, amplitudes, color=style.RED)
    if not np.allclose(amplitudes, cosine, equal_nan=True):
        axes.plot(ratios, cosine, color=style.GREY, lw=style.THIN, ls=(0, (4, 3)))
        style.note(axes, r"$A_0\omega^2 = g$", (float(ratios[0]), cosine[0]), (6.0, 5.0))
    text = style.shown_value("drive_amplitude", amplitude, "m")
    mark_answer(axes, (place, amplitude), text, (6.0, 6.0))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(float(ratios[0]), float(ratios[-1]))
    axes.set_ylim(0.8 * float(np.nanmin([amplitudes, cosine])), ceiling / 1.5)
    style.plain_ticks(axes.xaxis)
    style.plain_ticks(axes.yaxis)
    axes.set_xlabel(style.label_of("frequency_ratio"))
    style.show_unit(axes.yaxis, dataset.drive_amplitude)
    return figure
