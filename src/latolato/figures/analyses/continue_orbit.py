"""The picture of a branch of periodic motions: angle and multipliers over the parameter."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.language import spoken, tr
from latolato.figures import style
from latolato.figures.map_title import title_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

READING = (
    "The curve follows one periodic motion while a parameter changes: solid where it is "
    "stable, dashed where it is not. Marks show where it turns back, splits or begins to "
    "touch."
)
FIRST = {
    "parameter": "frequency_ratio",
    "low": "",
    "high": "",
    "period": "",
    "direction": "",
    "points": "100",
}

# Marker and colour of every kind of special point.
MARKS = {
    "fold": ("o", style.ORANGE),
    "period_doubling": ("D", style.RED),
    "symmetry_breaking": ("s", style.GREEN),
    "branch_point": ("p", style.GREEN),
    "torus": ("^", style.INK),
    "grazing": ("v", style.GREY),
    "lift_off": ("P", style.BLUE),
    "rest_ends": ("X", style.BLUE),
    "slackens": ("*", style.RED),
}
_DASHES = (0, (3.0, 2.0))
# A ratio of moduli beyond which they are drawn on a logarithmic scale, and its lowest decade.
_WIDE, _FLOOR = 30.0, 1e-4
# Branches below this angle, such as hanging still, are shown as lying at zero [rad].
_FLAT = 0.01
# Special points within this many lengths of a piece are where its stability changes.
_NEAR = 1.5


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the largest angle with special points above, the moduli of multipliers below."""
    from matplotlib.lines import Line2D

    figure, panels = style.new_figure(
        2, 1, width=0.8 * style.PAGE, height=4.6, sharex=True, height_ratios=[1.7, 1.0]
    )
    angles, moduli = panels[:, 0]
    knob, angle = dataset[dataset.attrs["parameter"]], dataset["largest_angle"]
    x, y, stable = knob.values, angle.values, dataset["is_stable"].values == 1
    places = np.column_stack([dataset["special_value"].values, dataset["special_angle"].values])
    if knob.size:
        size = np.abs(dataset["multipliers"].values)
        _draw_branch(angles, x, y, stable, places, color=style.BLUE, lw=style.LINE + 0.3)
        moduli.axhline(1.0, color=style.INK, lw=style.THIN, zorder=1)
        for column in range(size.shape[1] - 1, -1, -1):
            curve = np.maximum(size[:, column], _FLOOR)
            colour = style.BLUE if column == 0 else style.GREY
            _draw_branch(moduli, x, curve, stable, places[:0], color=colour)
        if size.max() > _WIDE * max(size.min(), _FLOOR):
            moduli.set_yscale("log")
        else:
            moduli.set_ylim(0.0, 1.06 * max(float(size.max()), 1.1))
        angles.plot(x[0], y[0], "o", ms=3.5, mfc=style.PAPER, mec=style.BLUE, mew=1.0, zorder=3)
        for panel in (angles, moduli):
            panel.margins(x=0.04)
    else:
        moduli.set_xlim(dataset.attrs["low"], dataset.attrs["high"])
        angles.text(
            0.5, 0.5, tr("no branch: {status}", status=tr(dataset["status"].item())),
            transform=angles.transAxes, ha="center", va="center",
        )  # fmt: skip
    handles = [
        Line2D([], [], color=style.BLUE, lw=style.LINE + 0.3, label=tr("stable")),
        Line2D([], [], color=style.BLUE, lw=style.LINE + 0.3, ls=_DASHES, label=tr("unstable")),
        Line2D([], [], color=style.GREY, label=tr("smaller multipliers")),
        Line2D(
            [], [], color=style.BLUE, marker="o", ms=3.5, mfc=style.PAPER, mew=1.0, ls="",
            label=tr("first orbit"),
        ),
        *_mark(angles, dataset, places),
    ]  # fmt: skip
    top = float(np.max(y, initial=0.0))
    angles.set_ylim(0.0 if top > _FLAT else -_FLAT, max(1.06 * top, _FLAT))
    style.show_unit(angles.yaxis, angle)
    angles.set_title("\n".join(title_of(dataset, {}, "")), fontsize=style.SMALL)
    moduli.set_ylabel(tr(r"moduli of multipliers $|\mu|$"))
    style.show_unit(moduli.xaxis, knob)
    columns = len(handles) if len(handles) <= 5 else (len(handles) + 1) // 2
    figure.legend(handles=handles, loc="outside lower center", ncols=columns)
    return figure


def _draw_branch(
    axes: Axes, x: Floats, y: Floats, stable: NDArray[np.bool_], places: Floats, **look: Any
) -> None:
    """Draw a branch in pieces of one stability, which meet in special points or halfway."""
    points = np.column_stack([x, y])
    unit = np.ptp(points, axis=0)
    unit[unit == 0.0] = 1.0
    changes = np.flatnonzero(np.diff(stable)) + 1
    before, after = points[changes - 1], points[changes]
    joints = 0.5 * (before + after)
    for joint, length in zip(joints, np.linalg.norm((after - before) / unit, axis=1), strict=True):
        far = np.linalg.norm((places - joint) / unit, axis=1)
        if far.min(initial=math.inf) < _NEAR * length:
            joint[:] = places[np.argmin(far)]
    points = np.insert(points, changes, joints, axis=0)
    ends = [0, *(changes + np.arange(len(changes))), len(points)]
    for (first, last), is_stable in zip(pairwise(ends), stable[[0, *changes]], strict=True):
        # Round ends would fill the gaps of dashes.
        axes.plot(
            *points[first : last + 1].T, ls="-" if is_stable else _DASHES, dash_capstyle="butt",
            solid_capstyle="butt", **look,
        )  # fmt: skip


def _mark(axes: Axes, dataset: xr.Dataset, places: Floats) -> list[Any]:
    """Draw the special points and return an entry of the legend for each kind."""
    kinds = dataset["special_kind"].values.astype(str)
    handles = []
    for kind, (marker, colour) in MARKS.items():
        if kind in kinds:
            handles += axes.plot(
                *places[kinds == kind].T, marker, ms=5.0, mfc=colour, mec=style.PAPER, mew=0.6,
                ls="", zorder=4, clip_on=False, label=spoken(kind),
            )  # fmt: skip
    return handles
