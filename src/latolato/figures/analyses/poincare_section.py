"""The picture of a stroboscopic section: points of the phase plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points
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
    draw_points(panel, dataset["angle"], dataset["angular_velocity"], dataset.get("ball"))
    style.keep_span(panel, x=_LEAST, y=_LEAST * dataset.attrs["drive_frequency"])
    count, phase = dataset.sizes["time"], dataset.attrs["section_phase"]
    panel.set_title(f"{count} drive periods, at drive phase {phase:.4g} rad", fontsize=style.SMALL)
    if "ball" in dataset:
        figure.legend(loc="outside lower center", ncols=2, markerscale=2.0)
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
    reading="Every dot is one flash per shake: the angle to the right, the speed upwards. A few "
    "dots mean a rhythm, a closed curve two rhythms that do not fit together, a layered "
    "cloud chaos.",
    first=("periods", "section_phase"),
    conditions=(settles, is_shaken),
    place=3,
    cost=Cost(most_shakes=20_000),
    labels={"section_phase": "Drive phase of each sample"},
    verdict=verdict,
)
