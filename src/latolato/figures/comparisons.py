"""Pictures of comparisons: motions with residual and phase, trials on a map, response curves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.quantities import QUANTITIES
from latolato.figures import cells, style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Marker and colour of each class. Paper: orange dots, green triangles, blue diamonds (Fig. 9).
TRIALS = {
    "none": ("o", style.ORANGE),
    "weak": ("^", style.GREEN),
    "strong": ("D", style.BLUE),
}
# Grounds that these markers and a white line stand out from.
GROUNDS = {"none": "#d9d3bd", "weak": "#b9a9ad", "strong": "#8d7f96"}


def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of a comparison's dataset."""
    kind = dataset.attrs["comparison"]
    if kind == "motion":
        return _motion(dataset)
    figure, axes = style.new_figure(width=0.85 * style.PAGE, height=4.4 if kind == "map" else 3.8)
    if kind == "map":
        handles = draw_trials(axes[0, 0], dataset)
        figure.legend(handles=handles, loc="outside lower center", ncols=4)
    else:
        draw_responses(axes[0, 0], dataset)
    return figure


def _motion(dataset: xr.Dataset) -> Figure:
    """Return angles, residuals and phase over time, a column for each ball."""
    balls = np.unique(dataset.ball_number.values)
    figure, panels = style.new_figure(
        3, len(balls), height=4.8, sharex=True, sharey="row", height_ratios=[1.8, 0.9, 0.8]
    )
    for column, ball in enumerate(balls):
        own = dataset.isel(sample=np.flatnonzero(dataset.ball_number.values == ball))
        angle, residual, phase = panels[:, column]
        draw_angles(angle, own)
        draw_residual(residual, own)
        draw_phase(phase, own)
        phase.set_xlabel(style.label(dataset.time))
        if len(balls) > 1:
            angle.set_title("right ball" if ball == 1 else "left ball")
        if column:
            for axes in panels[:, column]:
                axes.set_ylabel("")
    panels[0, -1].legend(**style.ABOVE, ncols=2)
    return figure


def _source(dataset: xr.Dataset) -> str:
    """Return the word for data that are compared: synthetic ones are never called measured."""
    return "synthetic" if "chain" in dataset.attrs else "measured"


def draw_angles(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw samples over the computed curve, in degrees."""
    time = dataset.time.values
    axes.plot(
        time, np.degrees(_broken(time, dataset.angle_computed.values)), color=style.RED, lw=0.6,
        label="computed",
    )  # fmt: skip
    axes.plot(
        time, np.degrees(dataset.angle), ".", ms=1.6, color=style.BLUE, label=_source(dataset),
        zorder=1.5,
    )  # fmt: skip
    if float(dataset.followed_until) < time[-1]:
        axes.axvline(float(dataset.followed_until), color=style.GREY, lw=style.LINE, ls="--")
    axes.set_ylabel(style.label(dataset.angle, short=True, unit="°"))


def draw_residual(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the residual over the deviation of the computed motion."""
    time = dataset.time.values
    wide = 2e3 * dataset.angle_computed_sigma.values
    axes.fill_between(
        time, -wide, wide, color=style.PALE_RED, lw=0.0, label="two deviations of the computed"
    )
    axes.axhline(0.0, color=style.GREY, lw=style.THIN)
    values = 1e3 * dataset.angle_residual.values
    axes.plot(time, values, ".", ms=1.4, color=style.INK)
    reach = 1.15 * float(np.max(np.abs(values)))
    axes.set_ylim(-reach, reach)
    axes.set_ylabel("residual [mrad]")
    axes.legend(**style.ABOVE)


def draw_phase(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the phase difference, pale where both swings are unlike."""
    axes.axhline(0.0, color=style.GREY, lw=style.THIN)
    alike = np.nan_to_num(dataset.coherence.values)
    time, phase = dataset.time.values, dataset.phase_difference.values
    for mask, colour in (
        ((alike > 0.0) & (alike <= 0.9), style.GREY),
        (alike > 0.9, style.GREEN),
    ):
        axes.plot(time[mask], phase[mask], ".", ms=1.4, color=colour)
    sizes = np.abs(phase[alike > 0.0])
    reach = min(max(1.2 * float(np.max(sizes, initial=0.0)), 0.02), np.pi)
    axes.set_ylim(-reach, reach)
    axes.set_ylabel("phase [rad]")


def draw_trials(axes: Axes, dataset: xr.Dataset) -> list[Any]:
    """Draw a map of classes with trials and boundary over it; return the legend's entries."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    ground = (dataset.motion_class + 1.0).rename("motion_class")
    cells.draw_cells(
        axes, ground, norm=BoundaryNorm([0.5, 1.5, 2.5, 3.5], 3),
        cmap=ListedColormap(list(GROUNDS.values())),
    )  # fmt: skip
    handles: list[Any] = [
        style.swatch(colour, f"computed: {name}") for name, colour in GROUNDS.items()
    ]
    limits = axes.get_xlim(), axes.get_ylim()
    handles += _draw_boundary(axes, dataset)
    x, y, wrong = dataset.x.values, dataset.y.values, dataset.agrees.values == 0
    for number, (name, (marker, colour)) in enumerate(TRIALS.items()):
        own = dataset.class_measured.values == number
        if own.any():
            handles.append(
                axes.scatter(
                    x[own], y[own], s=24.0, marker=marker, color=colour, edgecolors=style.PAPER,
                    linewidths=0.6, zorder=4, label=f"trial: {name}",
                )
            )  # fmt: skip
    if wrong.any():
        handles.append(
            axes.scatter(
                x[wrong], y[wrong], s=90.0, marker="o", facecolors="none",
                edgecolors=style.RED, linewidths=1.0, zorder=3, label="classes differ",
            )
        )  # fmt: skip
    handles += _draw_squares(axes, dataset, x, y)
    axes.set_xlim(limits[0])
    axes.set_ylim(limits[1])
    up, across = ground.dims
    axes.set_xlabel(style.label(dataset[across]))
    axes.set_ylabel(style.label(dataset[up]))
    return handles


def _draw_boundary(axes: Axes, dataset: xr.Dataset) -> list[Any]:
    """Draw the measured boundary as a white dashed line through its points."""
    from matplotlib.patheffects import Normal, Stroke

    handle = None
    side = dataset.boundary_side.values.astype(str)
    for name in ("left", "right"):
        own = np.flatnonzero(side == name)
        own = own[np.argsort(dataset.boundary_y.values[own])]
        if own.size:
            (handle,) = axes.plot(
                dataset.boundary_x.values[own], dataset.boundary_y.values[own],
                color=style.PAPER, lw=1.6, ls=(0, (4, 2)), zorder=3.5,
                label=f"{_source(dataset)} boundary",
                path_effects=[Stroke(linewidth=2.8, foreground=style.INK), Normal()],
            )  # fmt: skip
    return [] if handle is None else [handle]


def _draw_squares(axes: Axes, dataset: xr.Dataset, x: Any, y: Any) -> list[Any]:
    """Draw a square around each trial by synthetic video, and say where the others come from."""
    if "by_video" not in dataset:
        return []
    own = dataset.by_video.values == 1
    if not own.any():
        axes.set_title("all trials simulated")
        return []
    axes.set_title("trials simulated or by synthetic video")
    squares = axes.scatter(
        x[own], y[own], s=70.0, marker="s", facecolors="none", edgecolors=style.INK,
        linewidths=0.9, zorder=5, label="by synthetic video",
    )  # fmt: skip
    return [squares]


def draw_responses(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw measured points and computed curves of each set, and where they peak."""
    import matplotlib as mpl

    shades = mpl.colormaps["viridis"]
    names = dataset.set_name.values
    for i, name in enumerate(names):
        colour = shades(0.85 * (1.0 - i / max(len(names) - 1, 1)))
        own = np.flatnonzero(dataset.set.values == name)
        own = own[np.argsort(dataset.trial_ratio.values[own])]
        axes.plot(
            dataset.frequency_ratio, np.degrees(dataset.angle_computed[i]), color=colour, lw=0.7
        )
        size = f"$A_0$ = {1e3 * float(dataset.set_amplitude[i]):.3g} mm"
        axes.errorbar(
            dataset.trial_ratio[own], np.degrees(dataset.largest_angle_after_transient[own]),
            np.degrees(dataset.largest_angle_after_transient_sigma[own]), fmt="o", ms=3.2,
            lw=style.THIN, color=colour, label=size,
        )  # fmt: skip
        high = float(np.degrees(dataset.peak_measured_height[i]))
        axes.errorbar(
            float(dataset.peak_measured_place[i]), high * 1.04 + 2.0,
            xerr=float(dataset.peak_measured_sigma[i]), fmt="v", ms=4.0, lw=1.0, color=colour,
            mec=style.INK, mew=0.5, capsize=2.0, zorder=4,
        )  # fmt: skip
    angle = np.degrees(dataset.largest_angle_after_transient.values)
    _draw_squares(axes, dataset, dataset.trial_ratio.values, angle)
    axes.plot([], [], "v", ms=4.0, color=style.GREY, mec=style.INK, mew=0.5, label="peak")
    axes.plot([], [], color=style.GREY, lw=0.7, label="computed")
    axes.set_xlim(float(dataset.frequency_ratio[0]), float(dataset.frequency_ratio[-1]))
    axes.set_ylim(0.0)
    axes.set_xlabel(style.label(dataset.frequency_ratio))
    symbol = QUANTITIES["largest_angle_after_transient"].symbol
    axes.set_ylabel(f"largest angle after the transient ${symbol}$ [°]")
    axes.legend(loc="upper right")


def _broken(time: Any, values: Any) -> Any:
    """Return a curve with its first sample after a gap left out."""
    gaps = np.concatenate([[False], np.diff(time) > 6.0 * np.median(np.diff(time))])
    return np.where(gaps, np.nan, values)
