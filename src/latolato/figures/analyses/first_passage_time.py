"""Waiting times of a noise-activated start, against the exponential of their mean."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.core.language import tr
from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "Random kicks act on many runs. The curve shows the share that has not yet reached the "
    "angle. A straight line means that the past does not matter: pure chance."
)
FIRST = {"noise_strength": "0.5", "threshold_angle": "", "trajectories": "100", "duration": "300"}

# Where all have arrived, the picture ends this much after the last one.
_AFTER = 1.3


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return two panels: the fraction that has passed, and on a logarithmic scale that at rest."""
    figure, panels = style.new_figure(1, 2, height=2.6)
    end = float(dataset.attrs["duration"])
    passages = dataset.first_passage.values
    known = np.sort(passages[np.isfinite(passages)])
    count = passages.size
    if known.size == count:  # nothing happens later
        end = min(end, _AFTER * float(known[-1]))
    time = np.concatenate([[0.0], known, [end]])
    share = np.concatenate([[0.0], np.arange(1, known.size + 1), [known.size]]) / count
    smooth = np.linspace(0.0, end, 400)
    mean, low, high = (
        float(dataset[f"mean_first_passage_time{tail}"]) for tail in ("", "_low", "_high")
    )
    for axis, letter, title in zip(
        panels[0], "ab", (tr("passed"), tr("not yet passed")), strict=True
    ):
        is_left = letter == "b"
        values = 1.0 - share if is_left else share
        if np.isfinite(low):
            band = [np.exp(-smooth / each) for each in (low, high)]
            if not is_left:
                band = [1.0 - each for each in band]
            axis.fill_between(smooth, *band, color=style.PALE_RED, lw=0, label=tr("95 % interval"))
        if np.isfinite(mean):
            curve = np.exp(-smooth / mean)
            text = tr("exponential, mean {mean} s", mean=f"{mean:.3g}")
            axis.plot(smooth, curve if is_left else 1.0 - curve, color=style.RED, label=text)
        text = tr("{passed} of {count} trajectories", passed=known.size, count=count)
        axis.step(time, values, where="post", color=style.BLUE, label=text)
        axis.set_xlim(0.0, end)
        axis.set_xlabel(tr("time $t$ [s]"))
        axis.set_ylabel(tr("fraction"))
        style.panel_title(axis, letter, title)
    panels[0, 0].set_ylim(0.0, 1.02)
    panels[0, 0].legend(loc="lower right")
    panels[0, 1].set_yscale("log")
    panels[0, 1].set_ylim(0.5 / count, 1.2)
    return figure
