"""The line at half the driving frequency, and how long the answer keeps its phase."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points
from latolato.figures.map_title import in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

READING = (
    "The left curve shows how well the motion remembers a beat of twice the drive period: "
    "near 1 it keeps it, near 0 it has lost it, as under strong noise."
)
FIRST = {"noise_strength": "0", "trajectories": "1", "periods": ""}

# More curves than this cannot be told apart.
_MOST_CURVES = 6
# Letters of the caption in one line over the width of a page.
_LINE = 122


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return panels of the subharmonic line against detuning, and of its survival."""
    many = dataset.sizes["frequency_ratio"] > 1
    rows = [["line", "place"], ["survival", "order"]] if many else [["survival", "order"]]
    figure, panels = style.new_mosaic(rows, height=2.3 * len(rows) + 0.55)
    letters = iter("abcd")
    if many:
        _draw_detuning(dataset, panels["line"], panels["place"])
        style.panel_title(panels["line"], next(letters), tr("height of the line"))
        style.panel_title(panels["place"], next(letters), tr("its place, bar: full width at half"))
    point = _strongest(dataset)
    varied = ("frequency_ratio", "drive_amplitude")
    name = ", ".join(in_words(point, each, point[each].item()) for each in varied)
    _draw_survival(point, panels["survival"])
    style.panel_title(panels["survival"], next(letters), tr("memory of the phase"))
    _draw_order(point, panels["order"])
    style.panel_title(panels["order"], next(letters), name)
    figure.supxlabel(
        textwrap.fill(tr(str(dataset.attrs["caution"])), _LINE),
        fontsize=style.SMALL,
        x=0.02,
        ha="left",
    )
    return figure


def _draw_detuning(dataset: xr.Dataset, height: Axes, place: Axes) -> None:
    """Draw amplitude and place of the line against the frequency ratio, for some amplitudes."""
    count = dataset.sizes["drive_amplitude"]
    indices = np.unique(np.linspace(0, count - 1, min(count, _MOST_CURVES)).round().astype(int))
    dataset = dataset.isel(drive_amplitude=indices)
    ratio, amplitude = dataset.frequency_ratio, dataset.drive_amplitude
    names = [in_words(dataset, "drive_amplitude", value) for value in amplitude.values.tolist()]
    name = amplitude.copy(data=names)
    draw_points(height, ratio, dataset.peak_amplitude, name, short=True, ls="-", ms=2.5)
    draw_points(place, ratio, dataset.peak_frequency, name, short=True, ms=2.5)
    low, high = (dataset.peak_frequency + side * dataset.peak_width for side in (-0.5, 0.5))
    for i, colour in zip(range(len(names)), style.COLOURS, strict=False):
        place.vlines(ratio, low[i], high[i], color=colour, lw=style.THIN)
    style.mark_level(place, 0.5, tr("half the driving frequency"), where=0.0)
    reach = max(1.2 * float(np.nan_to_num([0.5 - low, high - 0.5]).max()), 0.01)
    place.set_ylim(0.5 - reach, 0.5 + reach)
    height.set_ylim(bottom=0.0)
    height.legend(loc="best")


def _strongest(dataset: xr.Dataset) -> xr.Dataset:
    """Return the point with the strongest line."""
    heights = dataset.peak_amplitude.fillna(-1.0)
    best = np.unravel_index(int(np.argmax(heights.values)), heights.shape)
    return dataset.isel(dict(zip(map(str, heights.dims), best, strict=True)))


def _draw_survival(point: xr.Dataset, axis: Axes) -> None:
    """Draw the autocorrelation of the phase against the lag, and that of independent slips."""
    lag = point.lag.values
    axis.plot(lag, point.sign_autocorrelation, color=style.BLUE)
    life = float(point.lifetime)
    if math.isfinite(life):
        curve = np.exp(-2.0 * lag * float(point.drive_period) / life)
        text = tr("independent slips, one in {life} s", life=f"{life:.0f}")
        axis.plot(lag, curve, color=style.RED, ls="--", label=text)
        axis.legend(loc="best")
    elif math.isfinite(float(point.lifetime_low)):
        text = tr("no slip: one in more than {life} s", life=f"{float(point.lifetime_low):.0f}")
        style.note(axis, text, (0.5 * lag[-1], 0.85), ha="center")
    else:
        style.note(axis, tr(str(point.status.item())), (0.5 * lag[-1], 0.5), ha="center")
    axis.set_xlim(0, lag[-1])
    axis.set_ylim(min(0.0, float(point.sign_autocorrelation.fillna(0.0).min())) - 0.05, 1.05)
    axis.set_xlabel(style.label(point.lag))
    axis.set_ylabel(tr("autocorrelation $C$"))


def _draw_order(point: xr.Dataset, axis: Axes) -> None:
    """Draw the order parameter of each period."""
    style.mark_level(axis, 0.0, tr("phase forgotten"))
    draw_points(axis, point.period, point.order_parameter_decay, ls="-", marker="", short=True)
    axis.set_xlim(point.period.values[0], point.period.values[-1])
    axis.set_xlabel(style.label(point.period))
    axis.set_ylabel(f"{tr('order kept')} {axis.get_ylabel()}")
