"""The picture of a response period: stroboscopic samples over drive periods and in the plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "The angle is noted once per drive period. Dots that jump between p heights mean that the"
    " motion repeats after p periods; dots without order never repeat."
)
FIRST = {"longest": "", "transient_periods": ""}

# The first panel shows so many drive periods, or two cycles.
_SHOWN = 16
# Panels are no narrower than so many tolerances, within which samples are one.
_LEAST = 100.0


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return samples once per drive period, joined in order, and as points of the phase plane."""
    figure, axes = style.new_figure(1, 2, height=2.4, width_ratios=[1.6, 1.0])
    course, plane = axes[0]
    period = dataset["response_period"].item()
    cycle = int(period) if np.isfinite(period) else 0
    count = dataset.sizes["sample"]
    number = dataset["section_angle"]["sample"].assign_attrs(
        long_name="drive periods after the transient"
    )
    dataset = dataset.assign_coords(sample=np.arange(count))
    place = number % cycle if cycle else None
    balls = [dataset.sel(ball=b) for b in dataset["ball"]] if "ball" in dataset.dims else [dataset]
    for own, mark in zip(balls, "os", strict=False):
        angle, speed = own["section_angle"], own["section_angular_velocity"]
        course.plot(number, angle, color=style.GREY, lw=style.THIN, zorder=1)
        draw_points(course, number, angle, place, short=True, marker=mark, ms=4.0)
        draw_points(plane, angle, speed, place, short=True, marker=mark, ms=4.0)
        if len(balls) > 1:
            style.note(course, tr(str(own["ball"].item())), (0.0, float(angle[0])), (6.0, 7.0))
    least = _LEAST * dataset.attrs["angle_tolerance"]
    style.keep_span(course, y=least)
    style.keep_span(plane, x=least, y=least * dataset.attrs["drive_frequency"])
    course.set_xlim(-0.5, min(count, max(_SHOWN, 2 * cycle + 1)) - 0.5)
    style.panel_title(course, "a", _title(dataset, cycle))
    style.panel_title(plane, "b", tr("once per drive period"))
    return figure


def _title(dataset: xr.Dataset, cycle: int) -> str:
    """Return the answer in words."""
    status = str(dataset["status"].item())
    if status == "not settled":
        count = f"{dataset.attrs['transient_periods']:g}"
        return tr("not settled after {count} drive periods", count=count)
    if status == "aperiodic":
        return tr("aperiodic: no period up to {count}", count=dataset.attrs["longest"])
    if status not in ("periodic", "grazing"):
        hops = tr("hops straight up and down on its string")
        return hops if status == "slackens" else tr(status)
    turns = f"{dataset['rotation_number'].item():.4g}"
    words = tr("period {period}", period=cycle), tr("rotation number {turns}", turns=turns)
    return ", ".join([tr(status), *words])
