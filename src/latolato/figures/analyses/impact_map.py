"""The picture of an impact map: velocity against drive phase, and each against the one before."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points
from latolato.figures.analyses.question import LONG_RUN, Cost, Question, has_contacts, is_shaken
from latolato.figures.analyses.sentences import listed, times

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the impacts in the plane of phase and velocity, and the return map of the phase."""
    figure, axes = style.new_figure(1, 2, height=3.2, width_ratios=[1.2, 1.0])
    plane, returns = axes[0]
    phase, side = dataset["impact_phase"], dataset["impact_side"]
    following = phase.shift(impact=-1).assign_attrs(
        phase.attrs, long_name="phase at the next impact"
    )
    draw_points(plane, phase, dataset["angular_velocity_after"], side)
    draw_points(returns, phase, following.assign_attrs(symbol=r"\varphi_{j+1}"), side)
    returns.plot([0.0, math.tau], [0.0, math.tau], color=style.GREY, lw=style.THIN, zorder=0)
    for panel in (plane, returns):
        panel.set_xlim(0.0, math.tau)
    returns.set_ylim(0.0, math.tau)
    style.keep_span(plane, y=0.02 * float(np.abs(plane.get_ylim()).max()))
    rate = dataset["impacts_per_period"].item()
    style.panel_title(plane, "a", f"{rate:.4g} impacts per drive period")
    style.panel_title(returns, "b", "from one impact to the next")
    if dataset.sizes["impact"]:
        figure.legend(
            *plane.get_legend_handles_labels(), loc="outside lower center", ncols=2, markerscale=2.0
        )
    else:
        style.note(plane, str(dataset["status"].item()), (math.pi, 0.0), (0.0, 0.0), ha="center")
    return figure


def verdict(dataset: xr.Dataset) -> str:
    """Tell the rate of impacts and their sides."""
    count = dataset.sizes.get("impact", 0)
    if not count:
        return "The balls do not clack: they rest on each other, or swing without touching."
    side = dataset["impact_side"].values.astype(str)
    where = [f"the {name}" for name in ("bottom", "top") if (side == name).any()]
    rate = float(dataset["impacts_per_period"])
    phases = dataset["impact_phase"].values
    # On the circle, a little coarser than the drive's phase is stored.
    places = np.unique(np.round(np.exp(1j * phases), 2)).size
    steady = places <= 12
    often = {1.0: "once", 2.0: "twice"}.get(rate) or times(rate, "time")
    text = f"The balls clack {often} per shake, at {listed(where)}"
    rests = int(dataset["rests"])
    if rests:
        text += f", and come to rest {times(rests, 'time')} meanwhile"
    return f"{text}. The rhythm {'is steady' if steady else 'keeps changing'}."


QUESTION = Question(
    group=LONG_RUN,
    title="In what rhythm do the balls clack?",
    term="impact map",
    reading="Every dot is a clack: its moment within the shake to the right, its rebound speed "
    "upwards. Few dots mean a steady rhythm. On the right you see each clack against the one "
    "before.",
    first=("periods", "transient_periods"),
    conditions=(has_contacts, is_shaken),
    place=5,
    cost=Cost(most_shakes=20_000),
    verdict=verdict,
)
