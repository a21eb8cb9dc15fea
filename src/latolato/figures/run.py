"""The picture of one run: angles with contacts, energies, their ledger and the pivot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.core.quantities import QUANTITIES
from latolato.figures import style
from latolato.figures.curves import with_contacts

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

ENERGIES = {
    "kinetic_energy": style.ORANGE,
    "potential_energy": style.BLUE,
    "total_energy": style.INK,
}
LEDGER = {
    "drive_work": style.GREEN,
    "damping_loss": style.GREY,
    "impact_loss": style.RED,
    "capture_loss": style.ORANGE,
    "noise_work": style.BLUE,
}
# Marker and colour of every kind of contact.
MARKS = {
    "bottom": ("v", style.INK),
    "top": ("^", style.GREEN),
    "rest": ("s", style.RED),
    "release": ("o", style.ORANGE),
}
_MARK_SIZE = 7.0  # points squared
# Works and losses below this share of the largest energy are rounding.
_INVISIBLE = 1e-9


def ball_angles(run: xr.Dataset, name: str = "angle") -> dict[str, Floats]:
    """Return the angle of every ball [rad] by name, shape (time,); a mirrored ball too."""
    angle = run[name].values
    if "ball" in run[name].dims:
        return {str(ball): angle[i] for i, ball in enumerate(run["ball"].values)}
    if run.attrs.get("system") == "latolato":
        return {"right": angle, "left": -angle}
    return {"ball": angle}


def draw_angles(axes: Axes, run: xr.Dataset) -> None:
    """Draw the angle of every ball over time."""
    balls = ball_angles(run)
    colours = {"left": style.RED}
    for name, angle in balls.items():
        axes.plot(
            run["time"],
            angle,
            color=colours.get(name, style.BLUE),
            lw=style.THIN,
            label=f"{name} ball",
        )
    style.show_unit(axes.yaxis, run["angle"], short=True)
    if len(balls) > 1:
        _legend(axes)


@style.styled
def draw_angle_strip(run: xr.Dataset) -> Figure:
    """Return a small figure of the angle of every ball over time."""
    figure, panels = style.new_figure(1)
    angles = panels[0, 0]
    draw_angles(angles, run)
    angles.set_xlabel(style.label(run["time"]))
    return figure


@style.styled
def draw_run(run: xr.Dataset) -> Figure:
    """Return the figure of a run."""
    figure, panels = style.new_figure(
        4, sharex=True, height=1.15 * style.PAGE, height_ratios=[1.5, 1.0, 1.0, 0.6]
    )
    angles, energies, ledger, pivot = panels[:, 0]
    curves = with_contacts(run)
    draw_angles(angles, curves)
    _draw_contacts(angles, curves)
    _draw_curves(energies, curves, ENERGIES)
    _draw_curves(ledger, curves, LEDGER)
    _draw_balance(ledger, curves)
    pivot.plot(run["time"], run["pivot_height"], color=style.INK)
    style.show_unit(pivot.yaxis, run["pivot_height"], short=True)
    pivot.set_xlabel(style.label(run["time"]))
    for axes, letter, text in zip(
        panels[:, 0],
        "abcd",
        (_angles_title(run), f"Energies{_whose(run)}", f"Ledger{_whose(run)}", "Pivot"),
        strict=True,
    ):
        style.panel_title(axes, letter, text)
    return figure


def _draw_contacts(axes: Axes, run: xr.Dataset) -> None:
    """Mark every contact that `with_contacts` put on the curves."""
    if "contact_angle" not in run:
        return
    kinds = run["contact_kind"].values
    for kind, (marker, colour) in MARKS.items():
        times = run["contact_time"].values[kinds == kind]
        for i, angle in enumerate(ball_angles(run, "contact_angle").values()):
            if times.size:
                axes.scatter(
                    times,
                    angle[kinds == kind],
                    s=_MARK_SIZE,
                    linewidths=0.0,
                    zorder=3,
                    label=None if i else f"{kind} ({times.size})",
                    marker=marker,
                    color=colour,
                )
    _legend(axes)


def _draw_curves(axes: Axes, run: xr.Dataset, curves: dict[str, str]) -> None:
    """Draw several energies over time, summed over balls; what is zero throughout is left out."""
    visible = _INVISIBLE * float(np.nanmax(_of_all(run, "total_energy"), initial=0.0))
    for name, colour in curves.items():
        if name not in run:
            continue
        values = _of_all(run, name)
        if name in ENERGIES or np.nanmax(np.abs(values), initial=0.0) > visible:
            text = f"{name.replace('_', ' ')} ${QUANTITIES[name].symbol}$"
            axes.plot(run["time"], values, color=colour, lw=style.THIN, label=text)
    axes.set_ylabel(f"energy [{QUANTITIES['total_energy'].unit}]")
    _legend(axes)


def _draw_balance(axes: Axes, run: xr.Dataset) -> None:
    """Draw the energy gained since the start and write how well the ledger closes."""
    energy = _of_all(run, "total_energy")
    axes.plot(
        run["time"], energy - energy[0], color=style.INK, lw=style.THIN, label="energy gained"
    )
    _legend(axes)
    if "energy_residual" in run.attrs:
        axes.annotate(
            f"closes to {run.attrs['energy_residual']:.1e} J",
            xy=(0.0, 1.0),
            xycoords="axes fraction",
            xytext=(3, -2),
            textcoords="offset points",
            va="top",
            fontsize=style.SMALL,
        )


def _of_all(run: xr.Dataset, name: str) -> Floats:
    """Return a quantity summed over the balls that it is given for, shape (time,)."""
    values: Floats = run[name].values
    return values.sum(axis=0) if values.ndim == 2 else values


def _angles_title(run: xr.Dataset) -> str:
    """Return the title of the angles, which warns of the clamp."""
    if run.attrs.get("contact") == "clamp":
        return "Angles (a fixed-step artefact)"
    return "Angles and contacts" if len(ball_angles(run)) > 1 else "Angle"


def _whose(run: xr.Dataset) -> str:
    """Return whose energy is drawn."""
    if "ball" in run.dims:
        return " of both balls"
    return " per ball" if run.attrs.get("system") == "latolato" else ""


def _legend(axes: Axes) -> None:
    """Put the legend above the panel, where it hides nothing."""
    handles, texts = axes.get_legend_handles_labels()
    if handles:
        legend = axes.legend(
            handles,
            texts,
            **style.ABOVE,
            ncols=len(handles),
            columnspacing=1.2,
            borderpad=0.0,
        )
        for line in legend.get_lines():
            line.set_linewidth(style.LINE)
