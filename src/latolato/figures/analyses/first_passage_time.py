"""Waiting times of a noise-activated start, against the exponential of their mean."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.question import BEGINNING, Cost, Question
from latolato.figures.analyses.sentences import degrees, number, percent, plus_minus

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

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
    for axis, letter, title in zip(panels[0], "ab", ("passed", "not yet passed"), strict=True):
        is_left = letter == "b"
        values = 1.0 - share if is_left else share
        if np.isfinite(low):
            band = [np.exp(-smooth / each) for each in (low, high)]
            if not is_left:
                band = [1.0 - each for each in band]
            axis.fill_between(smooth, *band, color=style.PALE_RED, lw=0, label="95 % interval")
        if np.isfinite(mean):
            curve = np.exp(-smooth / mean)
            text = f"exponential, mean {mean:.3g} s"
            axis.plot(smooth, curve if is_left else 1.0 - curve, color=style.RED, label=text)
        text = f"{known.size} of {count} trajectories"
        axis.step(time, values, where="post", color=style.BLUE, label=text)
        axis.set_xlim(0.0, end)
        axis.set_xlabel("time $t$ [s]")
        axis.set_ylabel("fraction")
        style.panel_title(axis, letter, title)
    panels[0, 0].set_ylim(0.0, 1.02)
    panels[0, 0].legend(loc="lower right")
    panels[0, 1].set_yscale("log")
    panels[0, 1].set_ylim(0.5 / count, 1.2)
    return figure


def verdict(dataset: xr.Dataset) -> str:
    """Tell the mean time with its error, or why there is none."""
    status, share = str(dataset["status"].item()), float(dataset["passage_fraction"])
    angle = degrees(dataset.attrs["threshold_angle"])
    mean = float(dataset["mean_first_passage_time"])
    count = dataset.sizes["trajectory"]
    span = f"in {number(float(dataset.attrs['duration']))} s"
    if status == "none passed":
        least = number(float(dataset["mean_first_passage_time_low"]))
        return f"None of {count} reached {angle} {span}. On average it takes more than {least} s."
    reached = (
        f"{f'All {count}' if share == 1.0 else f'{percent(share)} of {count}'} reached {angle}"
    )
    if status == "all at once":
        return (
            f"{reached} after {number(mean)} s, all at the same time. The drive takes them there, "
            "not chance."
        )
    time = plus_minus(mean, float(dataset["mean_first_passage_time_error"]))
    text = f"{reached}, after {time} s on average"
    if status == "not exponential":
        return f"{text}. It is not pure chance: first the motion must grow."
    return f"{text}, by pure chance."


QUESTION = Question(
    group=BEGINNING,
    title="How long until random jiggling sets it off?",
    term="noise activation, first passage",
    reading="Many toys are jiggled at random. The curve shows the share that has not yet reached "
    "the angle. A straight line here means that the toy does not age: pure chance.",
    first=("noise_strength", "threshold_angle", "trajectories", "duration"),
    quick={"noise_strength": "0.5", "trajectories": "100", "duration": "300"},
    place=6,
    cost=Cost(counts=("trajectories",)),
    labels={"noise_interval": "Time between random kicks"},
    verdict=verdict,
)
