"""The picture of basins of attraction: the plane of starts, coloured by where they lead."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.language import tr
from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "Each point is one start: its angle to the right, its speed upwards. Points of one colour"
    " end in the same motion. Where colours mix finely, a tiny change decides; at the dots "
    "even rounding does."
)
FIRST = {"angle_points": "40", "velocity_points": "40", "transient_periods": ""}

# By lightness far apart for neighbours in rank.
_COLOURS = (
    style.BLUE, style.ORANGE, style.PALE_BLUE, style.RED, style.GREEN, style.GREY, style.PALE_RED,
)  # fmt: skip
_OTHER = style.PALE_GREY
_UNRESOLVED = style.INK
# Size of the dots in uncertain cells and of their rim, as shares of a cell.
_DOT, _RIM = 0.5, 0.12


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the map of basins with the stroboscopic points of each attractor on it."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    figure, axes = style.new_figure(width=style.PAGE, height=3.6)
    panel = axes[0, 0]
    numbers = dataset["attractor"].values
    # Numbers, and so colours, stay those of a former map; those beyond the colours share one.
    table = np.minimum(dataset["basin"].values, len(_COLOURS))
    colours: Any = ListedColormap([_UNRESOLVED, *_COLOURS, _OTHER])
    norm = BoundaryNorm(np.arange(-1, len(_COLOURS) + 2) - 0.5, len(_COLOURS) + 2)
    x, y = dataset["initial_angle"], dataset["initial_angular_velocity"]
    edges = style.edges_of(x.values), style.edges_of(y.values)
    style.draw_cells(panel, *edges, table.T, cmap=colours, norm=norm)
    limits = panel.get_xlim(), panel.get_ylim()
    place, speed = np.nonzero(dataset["uncertain"].values)
    figure.draw_without_rendering()  # lays out the cells, which set the size of the dots
    box = panel.get_window_extent().transformed(figure.dpi_scale_trans.inverted())
    cell = 72.0 * min(box.width / len(x), box.height / len(y))
    panel.plot(
        x.values[place], y.values[speed], "o", ms=_DOT * cell, color=style.INK, mec=style.PAPER,
        mew=_RIM * cell, rasterized=True,
    )  # fmt: skip
    for number in numbers[numbers < len(_COLOURS)]:
        _draw_attractor(panel, dataset.sel(attractor=number), _COLOURS[number])
    panel.set_xlim(limits[0])
    panel.set_ylim(limits[1])
    style.show_unit(panel.xaxis, x)
    style.show_unit(panel.yaxis, y)
    panel.set_title(_title(dataset), fontsize=style.SMALL)
    figure.legend(handles=_legend(dataset), loc="outside right center")
    return figure


def _draw_attractor(panel: Any, attractor: xr.Dataset, colour: str) -> None:
    """Draw the points of an attractor at the drive phase of the starts."""
    angle, speed = (
        np.atleast_2d(attractor[f"section_{name}"].values)[0]
        for name in ("angle", "angular_velocity")
    )
    is_cloud = str(attractor["status"].values) == "aperiodic"
    panel.plot(
        angle, speed, "o", ms=2.0 if is_cloud else 5.0, color=colour, mec=style.INK,
        mew=0.3 if is_cloud else 0.8, clip_on=True,
    )  # fmt: skip


def _title(dataset: xr.Dataset) -> str:
    """Return the title of the map."""
    entropy, border = (dataset[n].item() for n in ("basin_entropy", "boundary_basin_entropy"))
    numbers = {"entropy": f"{entropy:.3f}", "border": f"{border:.3f}"}
    text = tr("basin entropy {entropy}, on boundaries {border}", **numbers)
    if border > math.log(2.0):
        text += f" > ln 2: {tr('fractal boundary')}"
    uncertain = 100.0 * dataset["uncertain_fraction"].item()
    if not uncertain:
        return text
    share = f"{uncertain:.3g}"
    dots = tr("{share} % of the starts depend on the tolerance (dots): uncertain", share=share)
    return f"{text}\n{dots}"


def _legend(dataset: xr.Dataset) -> list[Any]:
    """Return one entry for each attractor: what it is, and its share."""
    entries = []
    numbers = dataset["attractor"].values
    for number in numbers[numbers < len(_COLOURS)]:
        row = dataset.sel(attractor=number)
        share = 100.0 * row["basin_fraction"].item()
        half = 50.0 * (row["basin_fraction_high"] - row["basin_fraction_low"]).item()
        angle = math.degrees(row["largest_angle_watched"].item())
        status = str(row["status"].values)
        words = [] if status == "periodic" else [tr(status)]
        if status in ("periodic", "grazing"):
            words.append(tr("period {period}", period=f"{row['response_period']:.0f}"))
        words.append(tr("up to {angle}", angle=f"{angle:.0f}°"))
        turns = row["rotation_number"].item()
        if status != "rest" and math.isfinite(turns):
            words.append(tr("{turns} per period", turns=f"{turns:.3g}"))
        text = ", ".join(words)
        entries.append(style.swatch(_COLOURS[number], f"{text}\n{share:.2f} ± {half:.2f} %"))
    rest = numbers >= len(_COLOURS)
    if rest.any():
        share = 100.0 * dataset["basin_fraction"].values[rest].sum()
        entries.append(
            style.swatch(_OTHER, f"{tr('{count} further', count=rest.sum())}\n{share:.2f} %")
        )
    lost = 100.0 * dataset["unresolved_fraction"].item()
    if lost:
        moving = 100.0 * dataset["not_settled_fraction"].item()
        still = f", {moving:.2f} % {tr('not settled')}" if moving else ""
        entries.append(style.swatch(_UNRESOLVED, f"{tr('unresolved')}\n{lost:.2f} %{still}"))
    return entries
