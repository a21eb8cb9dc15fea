"""The picture of a posterior: the band over the samples, and each pair of unknown parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.figures.fits import draw_curve, draw_residual

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Draws that a panel shows, and bars of a histogram.
_DOTS, _BARS = 1000, 30
# Most parameters whose pairs are shown: more would be too small to read.
_MOST = 5
_SHARES = (0.025, 0.5, 0.975)


def draw(dataset: xr.Dataset) -> Figure:
    """Return angles and residuals with the 95 percent band, and a triangle of panels of pairs."""
    names = [str(name)[: -len("_draw")] for name in dataset if str(name).endswith("_draw")]
    names = [name for name in names if name != "nuisance"][:_MOST]
    balls = np.unique(dataset.ball_number.values)
    size = len(names)
    layout = [[f"angle{ball}"] * size for ball in balls]
    layout += [[f"residual{ball}"] * size for ball in balls]
    layout += [[f"{row},{column}" if column <= row else "." for column in range(size)]
               for row in range(size)]  # fmt: skip
    ratios = [1.3] * len(balls) + [0.8] * len(balls) + [1.1] * size
    figure, panels = style.new_mosaic(layout, height=1.25 * sum(ratios) + 0.6, height_ratios=ratios)
    for ball in balls:
        own = dataset.isel(sample=np.flatnonzero(dataset.ball_number.values == ball))
        angle, residual = panels[f"angle{ball}"], panels[f"residual{ball}"]
        angle.sharex(residual)
        draw_curve(angle, own, "angle", "angle_fit")
        half = 500.0 * (own.band_high - own.band_low).values
        residual.fill_between(
            own.time, -half, half, color=style.PALE_BLUE, lw=0.0, label="95 % of the draws"
        )
        draw_residual(residual, own, "angle_residual")
        reach = max(residual.get_ylim()[1], 1.1 * float(half.max()))
        residual.set_ylim(-reach, reach)
        residual.legend(**style.ABOVE, ncols=2)
        angle.set_xlabel("")
        if len(balls) > 1:
            angle.set_title("right ball" if ball == 1 else "left ball")
    panels[f"angle{balls[0]}"].legend(**style.ABOVE, ncols=2)
    _triangle(panels, dataset, names)
    return figure


def _triangle(panels: dict[str, Axes], dataset: xr.Dataset, names: list[str]) -> None:
    """Draw a histogram of each parameter, and the draws of each pair below."""
    shown = {name: dataset[f"{name}_draw"] for name in names}
    for row, name in enumerate(names):
        for column, other in enumerate(names[: row + 1]):
            axes = panels[f"{row},{column}"]
            if row == column:
                _histogram(axes, shown[name])
                axes.set_title(str(dataset[name].attrs["long_name"]))
            else:
                step = max(1, shown[name].size // _DOTS)
                axes.plot(
                    shown[other].values.ravel()[::step], shown[name].values.ravel()[::step],
                    ".", ms=1.6, alpha=0.5, mew=0.0, color=style.BLUE,
                )  # fmt: skip
                axes.sharex(panels[f"{column},{column}"])
            axes.tick_params(labelbottom=row == len(names) - 1)
            axes.locator_params(nbins=4)
            axes.tick_params(axis="x", rotation=30)
            if row == len(names) - 1:
                style.show_unit(axes.xaxis, dataset[other], short=True)
            if column == 0 and row:
                style.show_unit(axes.yaxis, dataset[name], short=True)


def _histogram(axes: Axes, values: xr.DataArray) -> None:
    """Draw how often values occur, with their middle and the ends of their central 95 percent."""
    axes.hist(values.values.ravel(), bins=_BARS, color=style.PALE_BLUE)
    low, middle, high = np.quantile(values.values, _SHARES)
    axes.axvline(middle, color=style.BLUE, lw=style.LINE)
    for end in (low, high):
        axes.axvline(end, color=style.BLUE, lw=style.THIN, ls="--")
    axes.set_yticks([])
