"""The amplitude that starts the toy from rest, over the driving frequency."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis import self_start
from latolato.figures import style
from latolato.figures.analyses.question import (
    BEGINNING,
    Question,
    drags_with_pivot,
    has_contacts,
)
from latolato.figures.analyses.sentences import millimetres, number
from latolato.figures.analyses.stored_system import drive_of, system_of
from latolato.figures.analyses.tongues import RATIO_LABEL, answers, mark_answer, new_panel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_SAMPLES = 41


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of `latolato.analysis.self_start`."""
    system, drive = system_of(dataset), drive_of(dataset)
    place, amplitude = dataset.attrs["frequency_ratio"], float(dataset.drive_amplitude)
    ratios = np.geomspace(0.5 * place, 2.0 * place, _SAMPLES)
    (amplitudes,) = answers(lambda r: self_start(system, r, drive), ratios, "drive_amplitude")
    cosine = system.gravity / (ratios * system.natural_frequency) ** 2
    figure, axes = new_panel(dataset, "leaves rest inside")
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
    axes.set_xlabel(RATIO_LABEL)
    style.show_unit(axes.yaxis, dataset.drive_amplitude)
    return figure


def verdict(dataset: xr.Dataset) -> str:
    """Tell the amplitude."""
    amplitude = float(dataset["drive_amplitude"])
    if not math.isfinite(amplitude):
        return "It never starts by itself at this speed: the crank would jam first."
    text = (
        f"At ω/ω₀ = {number(dataset.attrs['frequency_ratio'])} the balls part by themselves from "
    )
    text += f"{millimetres(amplitude)} on"
    return (
        f"{text}, where the pivot reaches {number(float(dataset['drive_acceleration_ratio']))} g."
    )


QUESTION = Question(
    group=BEGINNING,
    title="How far must the hand move for it to start by itself?",
    term="lift-off from resting contact",
    reading="The drive speed runs to the right, the amplitude upwards. In the coloured part the "
    "pivot drops faster than the balls fall, and they part without a push.",
    first=("frequency_ratio", "check"),
    conditions=(has_contacts, drags_with_pivot),
    place=3,
    labels={"check": "Check with simulated runs"},
    verdict=verdict,
)
