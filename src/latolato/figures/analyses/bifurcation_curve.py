"""The picture of a curve of bifurcations over two parameters, alone or over a map."""

from __future__ import annotations

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
    "On the curve one periodic motion is at a bifurcation: solid where stable motions end there, "
    "dashed where the motion is unstable anyway. Marks show where something else happens too."
)
FIRST = {
    "kind": "",
    "parameters": "drive_amplitude, frequency_ratio",
    "low": "{corner_low}",
    "high": "{corner_high}",
    "period": "",
    "points": "100",
}
# Colours of the kinds, and marker of every kind of special point.
COLOURS = {
    "fold": style.ORANGE,
    "period_doubling": style.RED,
    "symmetry_breaking": style.GREEN,
    "grazing": style.SKY,
    "lift_off": style.BLUE,
    "slack_onset": style.INK,
}
MARKS = {
    "cusp": "v",
    "resonance_1_1": "s",
    "resonance_1_2": "D",
    "fold_flip": "p",
    "generalised_flip": "h",
    "degenerate_pitchfork": "d",
    "meets_fold": "o",
    "meets_flip": "^",
    "degenerate": "X",
}
DASHES = (0, (3.0, 2.0))


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the curve over both parameters, the first of them upwards."""
    figure, panels = style.new_figure(width=0.75 * style.PAGE, height=3.6)
    axes = panels[0, 0]
    first, second = (str(name) for name in dataset.attrs["parameters"])
    handles = draw_over(axes, dataset, dataset[second].values, dataset[first].values)
    if not dataset.sizes["point"]:
        text = tr("no curve: {status}", status=tr(dataset["status"].item()))
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center")
    axes.margins(0.04)
    style.show_unit(axes.xaxis, dataset[second])
    style.show_unit(axes.yaxis, dataset[first])
    axes.set_title("\n".join(title_of(dataset, {}, "")), fontsize=style.SMALL)
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def draw_over(axes: Axes, dataset: xr.Dataset, x: Floats, y: Floats, **look: Any) -> list[Any]:
    """Draw a curve whose points are at these places; return the entries of the legend.

    Parameters
    ----------
    x, y : ndarray, shape (point,)
    look : dict
        Further properties of the lines.
    """
    kind = str(dataset.attrs["bifurcation"])
    look = {"color": COLOURS[kind], "lw": style.LINE + 0.3, **look}
    edges = dataset["is_edge"].values == 1
    handles: list[Any] = []
    changes = np.flatnonzero(np.diff(edges)) + 1
    named = set()
    for begin, end in pairwise([0, *changes, len(edges)]):
        if begin == end:
            continue
        # A piece reaches to the first point of the next one, so that no gap is left.
        word = spoken(kind)
        text = word if edges[begin] else tr("{kind}, of an unstable motion", kind=word)
        lines = axes.plot(
            x[begin : end + 1], y[begin : end + 1], ls="-" if edges[begin] else DASHES,
            dash_capstyle="butt", solid_capstyle="butt",
            label=text, **look,
        )  # fmt: skip
        if text not in named:
            named.add(text)
            handles += lines
    return handles + _marks(axes, dataset, x, y, look["color"])


def _marks(axes: Axes, dataset: xr.Dataset, x: Floats, y: Floats, colour: Any) -> list[Any]:
    """Draw the special points on a curve, and return an entry of the legend for each kind."""
    names = [str(name) for name in dataset.attrs["parameters"]]
    own = np.array([dataset[name].values for name in names])
    units = np.array([max(np.ptp(row), 1e-300) if row.size else 1.0 for row in own])
    handles = {}
    for i, kind in enumerate(dataset["special_kind"].values.astype(str)):
        there = np.array([float(dataset[f"special_{name}"][i]) for name in names])
        # It lies between two points: where the curve is nearest to it, in the curve's own plane.
        near = int(np.argmin(np.linalg.norm((own - there[:, None]) / units[:, None], axis=0)))
        (handles[kind],) = axes.plot(
            x[near], y[near], MARKS.get(kind, "o"), ms=5.0, mfc=colour, mec=style.PAPER, mew=0.6,
            ls="", zorder=5, clip_on=False, label=spoken(kind),
        )  # fmt: skip
    return list(handles.values())
