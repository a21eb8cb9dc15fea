"""Pictures of fits: what was measured, what was fitted, what is left, and the verdict."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES
from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Where legends stand clear of the curves.
ABOVE: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
# Letters in a line of the verdict.
_LINE = 122


@style.styled
def draw_fit(dataset: xr.Dataset) -> Figure:
    """Return the picture of a fit's dataset.

    Raises
    ------
    InputError
        If the dataset holds no fit.
    """
    draw = {
        "decay": _decay,
        "drive": _drive,
        "restitution": _restitution,
        "model": _model,
    }.get(str(dataset.attrs.get("fit")))
    if draw is None:
        raise InputError("the dataset holds no fit that can be drawn")
    figure = draw(dataset)
    words = textwrap.fill(str(dataset.attrs["verdict"]), _LINE)
    figure.suptitle(words, fontsize=style.SMALL, x=0.01, ha="left")
    return figure


def _decay(dataset: xr.Dataset) -> Figure:
    """Return angle with envelope, residuals, their correlation, and the drag laws."""
    with_laws = "law_bic" in dataset
    if "angle_fit" not in dataset:
        figure, axes = style.new_figure(1, 1, height=3.0)
        draw_turning_points(axes[0, 0], dataset)
        axes[0, 0].set_xlabel(style.label(dataset.swing_time))
        axes[0, 0].set_ylabel(style.label(dataset.swing_angle))
        return figure
    layout = [["angle", "angle"], ["residual", "residual"], ["correlation", "laws"]]
    figure, panels = style.new_mosaic(layout, height=5.6, height_ratios=[1.6, 0.8, 1.0])
    draw_curve(panels["angle"], dataset, "angle", "angle_fit")
    if "swing_time" in dataset:
        draw_turning_points(panels["angle"], dataset)
    panels["angle"].legend(**ABOVE, ncols=3)
    draw_residual(panels["residual"], dataset, "angle_residual")
    _correlation(panels["correlation"], dataset, "angle_residual")
    if with_laws:
        _laws(panels["laws"], dataset)
    else:
        panels["laws"].set_visible(False)
    return figure


def _drive(dataset: xr.Dataset) -> Figure:
    """Return height, residuals, and overtones."""
    layout = [["height", "height"], ["residual", "residual"], ["correlation", "harmonics"]]
    figure, panels = style.new_mosaic(layout, height=5.6, height_ratios=[1.4, 0.8, 1.0])
    draw_curve(panels["height"], dataset, "pivot_height", "pivot_height_fit", 1e3, "mm")
    for start in dataset.stage_start.values[1:]:
        for name in ("height", "residual"):
            panels[name].axvline(start, color=style.ORANGE, lw=style.LINE)
    panels["height"].legend(**ABOVE, ncols=2)
    draw_residual(panels["residual"], dataset, "pivot_height_residual", 1e3, "mm")
    _correlation(panels["correlation"], dataset, "pivot_height_residual")
    axes = panels["harmonics"]
    order = dataset["harmonic"].values
    axes.errorbar(
        order,
        1e3 * dataset.harmonic_amplitude,
        2e3 * dataset.harmonic_amplitude_sigma,
        fmt="o",
        ms=3.0,
        color=style.BLUE,
        label="with two standard deviations",
    )
    axes.set_xlim(order[0] - 0.5, order[-1] + 0.5)
    axes.set_xticks(order)
    axes.set_ylim(0.0)
    axes.set_xlabel(QUANTITIES["harmonic"].long_name)
    axes.set_ylabel("amplitude $A_n$ [mm]")
    axes.legend(**ABOVE)
    return figure


def _restitution(dataset: xr.Dataset) -> Figure:
    """Return the separation with the impacts, and e over time and closing speed."""
    layout = [["gap", "gap"], ["time", "speed"]]
    figure, panels = style.new_mosaic(layout, height=4.2)
    axes = panels["gap"]
    axes.plot(dataset.time, dataset.separation, ".", ms=1.5, color=style.BLUE)
    axes.plot(
        dataset.contact_time, dataset.separation_at_contact, "o", ms=4.0, mfc="none",
        color=style.RED, label="impacts that count",
    )  # fmt: skip
    axes.set_xlabel(style.label(dataset.time))
    axes.set_ylabel(_label(dataset.separation, ""))
    axes.legend(**ABOVE)
    pooled, sigma = float(dataset.restitution), float(dataset.restitution_sigma)
    speeds = np.abs(dataset.angular_velocity_before)
    for name, values, text in (
        ("time", dataset.contact_time, style.label(dataset.time)),
        ("speed", speeds, "closing speed [rad/s]"),
    ):
        axes = panels[name]
        axes.axhspan(pooled - 2.0 * sigma, pooled + 2.0 * sigma, color=style.PALE_BLUE, lw=0.0)
        axes.axhline(pooled, color=style.BLUE)
        axes.errorbar(
            values, dataset.restitution_each, dataset.restitution_each_sigma, fmt="o", ms=2.5,
            lw=style.THIN, color=style.INK,
        )  # fmt: skip
        axes.set_xlabel(text)
        axes.set_ylabel(_label(dataset.restitution_each, ""))
        axes.margins(x=0.04)
    return figure


def _model(dataset: xr.Dataset) -> Figure:
    """Return the angles with the fitted ones, and the residuals, for each ball."""
    balls = np.unique(dataset.ball_number.values)
    rows = 2 * len(balls)
    figure, axes = style.new_figure(
        rows, 1, height=2.4 * len(balls) + 0.6, sharex=True, height_ratios=[1.6, 0.8] * len(balls)
    )
    for i, ball in enumerate(balls):
        own = dataset.isel(sample=np.flatnonzero(dataset.ball_number.values == ball))
        draw_curve(axes[2 * i, 0], own, "angle", "angle_fit")
        draw_residual(axes[2 * i + 1, 0], own, "angle_residual")
        for start in dataset.window_start.values[1:]:
            axes[2 * i + 1, 0].axvline(start, color=style.GREY, lw=style.THIN)
        if len(balls) > 1:
            axes[2 * i, 0].set_title("right ball" if ball == 1 else "left ball")
        axes[2 * i, 0].set_xlabel("")
        if i < len(balls) - 1:
            axes[2 * i + 1, 0].set_xlabel("")
    axes[0, 0].legend(**ABOVE, ncols=2)
    return figure


def draw_curve(
    axes: Axes, dataset: xr.Dataset, measured: str, fitted: str, scale: float = 1.0, unit: str = ""
) -> None:
    """Draw samples and the fitted curve, broken where frames are missing."""
    time = dataset.time.values
    axes.plot(
        time,
        scale * dataset[measured],
        ".",
        ms=1.8,
        color=style.GREY,
        label="synthetic" if "chain" in dataset.attrs else "measured",
    )
    curve = scale * dataset[fitted].values
    gaps = np.flatnonzero(np.diff(time) > 3.0 * np.median(np.diff(time))) + 1
    axes.plot(
        np.insert(time, gaps, np.nan), np.insert(curve, gaps, np.nan), color=style.BLUE,
        lw=0.6, label="fitted",
    )  # fmt: skip
    axes.set_xlabel(style.label(dataset.time))
    axes.set_ylabel(_label(dataset[measured], unit))


def draw_residual(
    axes: Axes, dataset: xr.Dataset, name: str, scale: float = 1e3, unit: str = "mrad"
) -> None:
    """Draw residuals, and outliers at the edge."""
    out = dataset.is_outlier.values.astype(bool)
    time, values = dataset.time.values, scale * dataset[name].values
    axes.axhline(0.0, color=style.GREY, lw=style.THIN)
    axes.plot(time[~out], values[~out], ".", ms=1.5, color=style.INK)
    reach = 1.15 * float(np.max(np.abs(values[~out]), initial=1e-9))
    axes.set_ylim(-reach, reach)
    if out.any():
        edge = np.clip(values[out], -0.95 * reach, 0.95 * reach)
        axes.plot(time[out], edge, "x", ms=4.0, color=style.RED, label="left out")
        axes.legend(loc="upper right")
    axes.set_xlabel(style.label(dataset.time))
    axes.set_ylabel(f"residual [{unit}]")


def _correlation(axes: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw how residuals some samples apart go together, with what chance alone gives."""
    values = dataset[name].values[~dataset.is_outlier.values.astype(bool)]
    values = values - values.mean()
    most = min(40, len(values) // 4)
    power = float(values @ values) or 1.0
    lags = np.arange(1, most + 1)
    correlations = [float(values[lag:] @ values[:-lag]) / power for lag in lags]
    chance = 2.0 / np.sqrt(len(values))
    axes.axhspan(-chance, chance, color=style.PALE_GREY, lw=0.0, label="by chance (95 %)")
    axes.axhline(0.0, color=style.GREY, lw=style.THIN)
    axes.vlines(lags, 0.0, correlations, color=style.BLUE, lw=1.0)
    axes.set_ylim(min(-0.25, 1.2 * min(correlations)), max(0.4, 1.2 * max(correlations)))
    axes.set_xlabel("residuals so many samples apart")
    axes.set_ylabel("correlation")
    axes.legend(loc="upper right")


def _laws(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw how much worse each drag law is than the best."""
    bic = dataset.law_bic.values
    order = np.argsort(bic)[::-1]
    ahead = bic[order] - bic.min()
    places = np.arange(len(order))
    axes.barh(places, np.maximum(ahead, 0.05), color=style.PALE_BLUE)
    axes.set_xscale("symlog", linthresh=10.0)
    axes.set_xlim(0.0, 20.0 * max(float(ahead.max()), 10.0))
    for place, value in zip(places, ahead, strict=True):
        style.note(
            axes,
            f"{value:.3g}" if value > 0.0 else "best",
            (float(value), float(place)),
            (4.0, 0.0),
        )
    axes.set_yticks(places, [str(dataset.law.values[i]) for i in order])
    axes.axvline(10.0, color=style.GREY, lw=style.THIN, ls="--")
    axes.set_xlabel("BIC above the best (beyond 10: excluded)")


def draw_turning_points(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the turning points under the envelope."""
    time = dataset.swing_time.values
    axes.plot(
        time, dataset.swing_angle, "o", ms=3.0, mfc="none", color=style.RED, label="turning points"
    )
    for sign in (1.0, -1.0):
        side = np.sign(dataset.swing_angle.values) == sign
        curve = dataset.swing_angle_fit.values[side]
        axes.plot(time[side], curve, color=style.RED, lw=style.THIN, ls="--")


def _label(variable: Any, unit: str) -> str:
    """Return a short axis label, in another unit where one is given."""
    text = style.label(variable, short=True)
    if not unit:
        return text
    return text.replace(f"[{style.pretty_unit(variable.attrs['units'])}]", f"[{unit}]")
