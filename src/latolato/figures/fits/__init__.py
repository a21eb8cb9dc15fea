"""The pictures of fits, one module each with ``draw(dataset)``, and what they share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


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
    axes.set_ylabel(style.label(dataset[measured], short=True, unit=unit))


def draw_residual(
    axes: Axes, dataset: xr.Dataset, name: str, scale: float = 1e3, unit: str = "mrad"
) -> None:
    """Draw residuals, outliers at the edge, and where the model begins to fail."""
    out = dataset.is_outlier.values.astype(bool)
    time, values = dataset.time.values, scale * dataset[name].values
    axes.axhline(0.0, color=style.GREY, lw=style.THIN)
    axes.plot(time[~out], values[~out], ".", ms=1.5, color=style.INK)
    if "fails_at" in dataset.attrs:
        axes.axvline(dataset.attrs["fails_at"], color=style.RED, lw=style.LINE, ls="--")
    reach = 1.15 * float(np.max(np.abs(values[~out]), initial=1e-9))
    axes.set_ylim(-reach, reach)
    if out.any():
        edge = np.clip(values[out], -0.95 * reach, 0.95 * reach)
        axes.plot(time[out], edge, "x", ms=4.0, color=style.RED, label="left out")
        axes.legend(loc="upper right")
    axes.set_xlabel(style.label(dataset.time))
    axes.set_ylabel(f"residual [{unit}]")


def draw_correlation(axes: Axes, dataset: xr.Dataset, name: str) -> None:
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
