"""Which first stages and which pushes reach the upper branch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.question import (
    BEGINNING,
    Cost,
    Question,
    ends_as_cosine,
    on_rods,
    settles,
)
from latolato.figures.analyses.sentences import degrees, number

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PUSH = "push $\\dot\\theta_p$ of each ball [rad/s]"


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the map of successful protocols, and the pushes that do the same.

    Where no protocol was searched for, the settled angles after pushes say why.
    """
    if not np.isfinite(dataset.success_share.values).any():
        figure, panels = style.new_figure(1, 1, height=3.0)
        _draw_angles(dataset, panels[0][0])
        return figure
    figure, panels = style.new_figure(1, 2, height=3.0, width_ratios=[1.35, 1.0])
    left, right = panels[0]
    _draw_map(dataset, left)
    style.panel_title(left, "a", f"protocols: {dataset.status.item()}")
    _draw_pushes(dataset, right)
    style.panel_title(right, "b", "pushes at the target frequency")
    return figure


def _draw_map(dataset: xr.Dataset, axis: Axes) -> None:
    """Draw the share of success over dwell and first stage, and mark the shortest protocol."""
    dwell, ratio = dataset.dwell_time.values, dataset.first_frequency_ratio.values
    x, y = style.edges_of(dwell), style.edges_of(ratio)
    share = dataset.success_share.values
    mesh = axis.pcolormesh(x, y, share, vmin=0.0, vmax=1.0, rasterized=True)
    style.colour_bar(mesh, "share of drive phases")
    axis.set_xlim(x[0], x[-1])
    axis.set_ylim(y[0], y[-1])
    best = float(dataset.best_dwell_time), float(dataset.best_first_ratio)
    if math.isfinite(best[0]):
        axis.plot(*best, "o", ms=7.0, mfc="none", mec=style.RED, mew=1.6)
        text = f"{float(dataset.lead_time):.3g} s"
        style.note(axis, text, best, (7.0, 0.0), colour=style.RED)
    about = dataset.attrs
    if about.get("system") == "latolato" and about.get("drive_amplitude"):
        lift_off = math.sqrt(about["length"] / about["drive_amplitude"])
        if ratio[0] < lift_off < ratio[-1]:
            axis.axhline(lift_off, color=style.ORANGE, lw=style.LINE, ls=(0, (4, 3)))
            place = float(dwell[-1]), lift_off
            style.note(axis, "lift-off", place, (-2.0, -4.0), ha="right", va="top")
    axis.set_xlabel(style.label(dataset.dwell_time))
    axis.set_ylabel(style.label(dataset.first_frequency_ratio))


def _draw_angles(dataset: xr.Dataset, axis: Axes) -> None:
    """Draw the settled angle against the push, which at zero is that from rest."""
    angles = np.rad2deg(dataset.angle_after_push.values)
    axis.plot(dataset.push, angles, "o-", ms=3.0, color=style.BLUE)
    axis.set_ylim(0.0, 1.1 * float(np.nanmax(angles)))
    axis.set_xlabel(_PUSH)
    axis.set_ylabel("settled angle, median over drive phases [°]")


def _draw_pushes(dataset: xr.Dataset, axis: Axes) -> None:
    """Draw the share of success against the push, and the smallest one that suffices."""
    axis.plot(dataset.push, dataset.push_share, "o-", ms=3.0, color=style.BLUE)
    style.mark_level(axis, float(dataset.attrs["required_share"]), "required")
    smallest = float(dataset.smallest_push)
    if math.isfinite(smallest):
        share = float(dataset.push_share.sel(push=smallest))
        axis.plot(smallest, share, "o", ms=7.0, mfc="none", mec=style.RED, mew=1.6)
        energy = 1e3 * float(dataset.smallest_push_energy)
        text = f"{smallest:.3g} rad/s, {energy:.3g} mJ"
        style.note(axis, text, (smallest, share), (7.0, -3.0), va="top", colour=style.RED)
    axis.set_ylim(-0.03, 1.05)
    axis.set_xlabel(_PUSH)
    axis.set_ylabel("share of drive phases")


def verdict(dataset: xr.Dataset) -> str:
    """Tell the shortest protocol and the least push."""
    status = str(dataset["status"].item())
    if status == "reached from rest":
        return "It is not needed: the large swing comes from rest by itself."
    push = float(dataset["smallest_push"])
    hand = f"a push of {number(push)} rad/s does it" if math.isfinite(push) else "no push does it"
    if status == "no upper branch":
        rest, most = (
            degrees(float(dataset["angle_from_rest"])),
            number(float(dataset["push"].max())),
        )
        return f"It cannot help: no push up to {most} rad/s leads beyond the {rest} from rest."
    if status != "found":
        return f"No first stage that was tried reaches the large swing; {hand}."
    ratio, lead = float(dataset["best_first_ratio"]), float(dataset["lead_time"])
    angle = float(dataset["upper_angle"])
    swing = "whole turns" if angle > math.pi else f"the large swing of {degrees(angle)}"
    tail = " as well" if math.isfinite(push) else ""
    return f"Yes: {number(lead)} s at ω/ω₀ = {number(ratio)} lead to {swing}; {hand}{tail}."


QUESTION = Question(
    group=BEGINNING,
    title="Does “first fast, then slow” help?",
    term="two-stage driving protocol",
    reading="On the left each cell is a first stage: to the right how long it is held, upwards how "
    "fast it is; bright ones succeed. On the right the push of a hand that does the same. If "
    "nothing was searched, a curve shows how far each push leads.",
    first=("frequency_ratio", "first_frequency_ratio", "dwell_time"),
    quick={"phases": "4"},
    conditions=(settles, ends_as_cosine, on_rods),
    place=4,
    cost=Cost(counts=("phases",), lengths={"first_frequency_ratio": 12, "dwell_time": 16}),
    labels={
        "dwell_time": "Times in the first stage",
        "first_frequency_ratio": "Drive speeds of the first stage, ω/ω₀",
        "phases": "Drive phases to try",
        "ramp": "Time to change the speed",
        "required_share": "Share of the phases that must succeed",
        "settling": "Time to settle afterwards",
    },
    verdict=verdict,
)
