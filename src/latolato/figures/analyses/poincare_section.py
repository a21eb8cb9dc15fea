"""The picture of a stroboscopic section: points of the phase plane."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.question import LONG_RUN, Cost, Question, is_shaken, settles
from latolato.figures.analyses.sentences import no_answer, shakes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# Panels are no narrower [rad]: the points of a periodic motion differ by rounding errors.
_LEAST = 1e-3


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the points of the section, of two balls in two colours."""
    figure, axes = style.new_figure(width=0.6 * style.PAGE, height=3.4)
    panel = axes[0, 0]
    two = "ball" in dataset.dims
    count = dataset.sizes["time"]
    # Few points are dots, many a cloud.
    size = float(np.clip(60.0 / math.sqrt(count), 0.6, 5.0))
    for ball in range(2 if two else 1):
        part = dataset.isel(ball=ball) if two else dataset
        panel.plot(
            part["angle"].values,
            part["angular_velocity"].values,
            "o",
            ms=size,
            mew=0.0,
            color=style.COLOURS[ball],
            label=f"{part['ball'].values} ball" if two else "",
            rasterized=count > 5000,
        )
    panel.margins(0.08)
    style.keep_span(panel, x=_LEAST, y=_LEAST * dataset.attrs["drive_frequency"])
    low, high = panel.get_xlim()
    if high - low > math.pi:
        style.pi_ticks(panel.xaxis)
    panel.set_xlabel(style.label(dataset["angle"]))
    panel.set_ylabel(style.label(dataset["angular_velocity"]))
    phase = dataset.attrs["section_phase"]
    panel.set_title(f"{count} drive periods, at drive phase {phase:.4g} rad", fontsize=style.SMALL)
    if two:
        panel.legend(loc="best", markerscale=3.0 / size if size < 3.0 else 1.0)
    return figure


def verdict(dataset: xr.Dataset) -> str:
    """Tell how many different points there are."""
    angle, speed = (
        dataset[name].values.reshape(-1, dataset.sizes["time"]).T
        for name in ("angle", "angular_velocity")
    )
    keep = np.isfinite(angle).all(axis=1) & np.isfinite(speed).all(axis=1)
    if not keep.any():
        return no_answer(str(dataset["status"].item()))
    scale = float(dataset.attrs["drive_frequency"])
    # Angles as points of a circle, which has no ends.
    points = np.concatenate([np.cos(angle[keep]), np.sin(angle[keep]), speed[keep] / scale], axis=1)
    count = len(np.unique(np.round(points, 3), axis=0))
    # Neighbours on both sides of an edge of rounding are one.
    near = np.abs(points[1:] - points[0]).max(axis=1) < 5e-3
    if near.all():
        return f"All {len(points)} flashes show the same place: it repeats every shake, or rests."
    period = int(np.argmax(near)) + 1 if near.any() else 0
    if period and near[period - 1 :: period].all() and period <= 64:
        return f"It visits {period} places in turn: it repeats {shakes(period)}."
    return f"The {len(points)} flashes fall on some {count} places. No short repetition is seen."


QUESTION = Question(
    group=LONG_RUN,
    title="What pattern does it draw, seen once per shake?",
    term="Poincaré (stroboscopic) section",
    reading="Every dot is one flash per shake: to the right the angle, upwards the speed. A few "
    "dots mean a rhythm, a closed curve two rhythms that do not fit, a cloud with layers chaos.",
    first=("periods", "section_phase"),
    conditions=(settles, is_shaken),
    place=3,
    cost=Cost(most_shakes=20_000),
    labels={"section_phase": "Drive phase of each sample"},
    verdict=verdict,
)
