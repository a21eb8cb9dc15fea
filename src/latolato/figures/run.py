"""The picture of one run: angles with contacts, energies, their ledger and the pivot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.core.language import spoken, tr
from latolato.core.quantities import QUANTITIES
from latolato.figures import style
from latolato.figures.curves import OF_STRINGS, with_contacts

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
    "retension_loss": style.SKY,
    "noise_work": style.BLUE,
}
# Marker and colour of every kind of contact; those of strings stand on the curve of either ball.
MARKS = {
    "bottom": ("v", style.INK),
    "top": ("^", style.GREEN),
    "rest": ("s", style.RED),
    "release": ("o", style.ORANGE),
    "slack": ("<", style.GREY),
    "taut": (">", style.INK),
}
_MARK_SIZE = 7.0  # points squared
# Works and losses below this share of the largest energy are rounding.
_INVISIBLE = 1e-9
# Entries of a legend that have room beside a title.
_MOST = 4


def ball_angles(run: xr.Dataset, name: str = "angle") -> dict[str, Floats]:
    """Return the angle of every ball [rad] by name, shape (time,); a mirrored ball too."""
    angle = run[name].values
    if "ball" in run[name].dims:
        return {str(ball): angle[i] for i, ball in enumerate(run["ball"].values)}
    if run.attrs.get("system") == "latolato":
        return {"right": angle, "left": -angle}
    return {"ball": angle}


def _words(ball: str) -> str:
    """Return the name of a ball in a legend."""
    return {"right": tr("right ball"), "left": tr("left ball")}.get(ball) or tr("ball")


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
            label=_words(name),
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
    goes_slack = "slack" in run and bool(run["slack"].any())
    rows = {"angles": 1.5, "distances": 0.8, "energies": 1.0, "ledger": 1.0, "pivot": 0.6}
    if not goes_slack:
        del rows["distances"]
    heights = list(rows.values())
    figure, panels = style.new_figure(
        len(rows), sharex=True, height=0.28 * style.PAGE * sum(heights), height_ratios=heights
    )
    axes = dict(zip(rows, panels[:, 0], strict=True))
    curves = with_contacts(run)
    draw_angles(axes["angles"], curves)
    _draw_contacts(axes["angles"], curves)
    if goes_slack:
        _draw_distances(axes["distances"], run, curves)
    _draw_curves(axes["energies"], curves, ENERGIES)
    _draw_curves(axes["ledger"], curves, LEDGER)
    _draw_balance(axes["ledger"], curves)
    _draw_pivot(axes["pivot"], run)
    axes["pivot"].set_xlabel(style.label(run["time"]))
    titles = {
        "angles": _angles_title(run),
        "distances": tr("Distance from the pivot (shaded while the string is slack)"),
        "energies": _of_balls(tr("Energies"), run),
        "ledger": _of_balls(tr("Ledger"), run),
        "pivot": tr("Pivot"),
    }
    for letter, name in zip("abcde", rows, strict=False):
        style.panel_title(axes[name], letter, titles[name])
    return figure


@style.styled
def draw_variable(run: xr.Dataset) -> Figure:
    """Return a figure of the only variable over time; tensions are those of rod or string.

    Derivatives have a panel for each parameter.
    """
    (values,) = run.data_vars.values()
    if "parameter" not in values.dims:
        figure, panels = style.new_figure(1)
        _draw_balls(panels[0, 0], values)
        style.show_unit(panels[0, 0].yaxis, values, short=True)
        text = str(values.attrs.get("long_name", values.name))
        if "tension of the rod" in text:
            text += " (negative: the rod is pushed, and a string would be slack)"
        panels[0, 0].set_title(f"{text[:1].upper()}{text[1:]}", loc="left", fontsize=style.SMALL)
    else:
        figure, panels = style.new_figure(values.sizes["parameter"], sharex=True)
        motion = str(values.attrs["long_name"]).split(",")[0]
        for axes, name in zip(panels[:, 0], values["parameter"].values, strict=True):
            own = values.sel(parameter=name)
            per = str(own["parameter_unit"].item())
            unit = style.pretty_unit(values.attrs["units"] + (f" per {per}" if per != "1" else ""))
            _draw_balls(axes, own)
            axes.set_ylabel(f"${values.attrs['symbol']}$ [{unit}]")
            text = f"{motion} with respect to {name.replace('_', ' ')}"
            axes.set_title(f"{text[:1].upper()}{text[1:]}", loc="left", fontsize=style.SMALL)
            axes.label_outer(remove_inner_ticks=False)
    return figure


def _draw_balls(axes: Axes, values: xr.DataArray) -> None:
    """Draw a variable over time, one curve for each ball."""
    balls = [str(ball) for ball in values["ball"].values] if "ball" in values.dims else ["ball"]
    for ball, row in zip(balls, np.atleast_2d(values.values), strict=True):
        colour = style.RED if ball == "left" else style.BLUE
        axes.plot(values["time"], row, color=colour, lw=style.THIN, label=_words(ball))
    if len(balls) > 1:
        _legend(axes)
    if float(values.min()) < 0.0 < float(values.max()):
        axes.axhline(0.0, color=style.GREY, lw=style.THIN, zorder=1)
    axes.set_xlabel(style.label(values["time"]))


def _draw_distances(axes: Axes, run: xr.Dataset, curves: xr.Dataset) -> None:
    """Draw the distance of every ball over time, shaded where its string is slack."""
    distances = np.atleast_2d(curves["distance"].values)
    for i, slack in enumerate(np.atleast_2d(run["slack"].values)):
        colour, pale = (style.RED, style.PALE_RED) if i else (style.BLUE, style.PALE_BLUE)
        axes.plot(curves["time"], distances[i], color=colour, lw=style.THIN)
        axes.fill_between(
            run["time"],
            0.0,
            1.0,
            where=slack == 1,
            transform=axes.get_xaxis_transform(),
            color=pale,
            alpha=0.6,
            lw=0.0,
            zorder=0,
        )
    style.show_unit(axes.yaxis, run["distance"], short=True)


def _draw_pivot(axes: Axes, run: xr.Dataset) -> None:
    """Draw the pivot's height over time, and its way to the right if it has one."""
    axes.plot(run["time"], run["pivot_height"], color=style.INK, label=tr("upwards"))
    style.show_unit(axes.yaxis, run["pivot_height"], short=True)
    if "pivot_across" in run and np.nanmax(np.abs(run["pivot_across"].values), initial=0.0) > 0.0:
        axes.plot(run["time"], run["pivot_across"], color=style.GREEN, label=tr("to the right"))
        axes.set_ylabel("")
        style.show_unit(axes.yaxis, run["pivot_height"].assign_attrs(symbol="x_0, y_0"), short=True)
        _legend(axes)


def _draw_contacts(axes: Axes, run: xr.Dataset) -> None:
    """Mark every contact that `with_contacts` put on the curves."""
    if "contact_angle" not in run:
        return
    kinds = run["contact_kind"].values
    for kind, (marker, colour) in MARKS.items():
        count = int((kinds == kind).sum())
        for i, angle in enumerate(ball_angles(run, "contact_angle").values()):
            these = kinds == kind
            if kind in OF_STRINGS and "contact_ball" in run:
                these &= run["contact_ball"].values == i + 1
            if count:
                axes.scatter(
                    run["contact_time"].values[these],
                    angle[these],
                    s=_MARK_SIZE,
                    linewidths=0.0,
                    zorder=3,
                    label=None if i else f"{tr(kind)} ({count})",
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
            text = f"{spoken(name)} ${QUANTITIES[name].symbol}$"
            axes.plot(run["time"], values, color=colour, lw=style.THIN, label=text)
    axes.set_ylabel(f"{tr('energy')} [{QUANTITIES['total_energy'].unit}]")
    _legend(axes)


def _draw_balance(axes: Axes, run: xr.Dataset) -> None:
    """Draw the energy gained since the start and write how well the ledger closes."""
    energy = _of_all(run, "total_energy")
    axes.plot(
        run["time"], energy - energy[0], color=style.INK, lw=style.THIN, label=tr("energy gained")
    )
    _legend(axes)
    if "energy_residual" in run.attrs:
        axes.annotate(
            tr("closes to {residual}", residual=f"{run.attrs['energy_residual']:.1e} J"),
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
        return tr("Angles (a fixed-step artefact)")
    return tr("Angles and contacts" if len(ball_angles(run)) > 1 else "Angle")


def _of_balls(energies: str, run: xr.Dataset) -> str:
    """Return the title of energies, with whose they are."""
    if "ball" in run.dims:
        return tr("{energies} of both balls", energies=energies)
    is_mirrored = run.attrs.get("system") == "latolato"
    return tr("{energies} per ball", energies=energies) if is_mirrored else energies


def _legend(axes: Axes) -> None:
    """Put the legend above the panel, where it hides nothing."""
    handles, texts = axes.get_legend_handles_labels()
    if handles:
        is_long = len(handles) > _MOST
        legend = axes.legend(
            handles,
            texts,
            **style.ABOVE,
            ncols=len(handles),
            columnspacing=0.8 if is_long else 1.2,
            handlelength=1.0 if is_long else None,
            handletextpad=0.4 if is_long else None,
            borderpad=0.0,
        )
        for line in legend.get_lines():
            line.set_linewidth(style.LINE)
