"""The picture of a map of response periods, with the shares of all classes of motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.language import tr
from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "Each cell is one run: the drive frequency runs to the right, the amplitude upwards. The "
    "colour shows after how many drive periods the motion repeats; pale cells rest, red ones "
    "never repeat."
)
FIRST = {"drive_amplitude": "{amplitudes} : 16", "frequency_ratio": "{ratios} : 16"}

# Classes with colours of their own; the rest of the periods share one.
_CLASSES: dict[str, str] = {
    "rest": style.PALE_GREY,
    "period 1": style.SKY,
    "period 2": style.BLUE,
    "period 3": style.GREEN,
    "period 4": style.ORANGE,
    "longer period": style.GREY,
    "grazing": style.PALE_RED,
    "aperiodic": style.RED,
    "not settled": style.PAPER,
    "slackens": style.PALE_BLUE,
    "no answer": style.INK,
}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the map of classes and a bar for the share of each among cells with motion."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    figure, axes = style.new_figure(1, 2, width=style.PAGE, height=3.2, width_ratios=[1.7, 1.0])
    cells, bars = axes[0]
    names = list(_CLASSES)
    colours = ListedColormap(list(_CLASSES.values()))
    norm = BoundaryNorm(np.arange(len(names) + 1) - 0.5, len(names))
    x, y = dataset["frequency_ratio"], dataset["drive_amplitude"]
    edges = style.edges_of(x.values), style.edges_of(y.values)
    style.draw_cells(cells, *edges, _numbers(dataset), cmap=colours, norm=norm)
    style.show_unit(cells.xaxis, x)
    style.show_unit(cells.yaxis, y)
    style.panel_title(cells, "a", tr("response period in drive periods"))
    _draw_shares(bars, dataset)
    style.panel_title(bars, "b", tr("shares of the cells with motion"))
    return figure


def _numbers(dataset: xr.Dataset) -> Any:
    """Return the class of each cell by its place in `_CLASSES`."""
    place = {name: k for k, name in enumerate(_CLASSES)}
    words = dataset["status"].values.astype(object)
    regular = words == "periodic"
    words[regular] = [
        f"period {p:.0f}" if p <= 4 else "longer period"
        for p in dataset["response_period"].values[regular]
    ]
    return np.vectorize(lambda word: place.get(word, place["no answer"]))(words)


def _draw_shares(axes: Any, dataset: xr.Dataset) -> None:
    """Draw one bar for each class that occurs, in the colours of the map, with its interval."""
    cells = dataset["cells"].values
    rows = []
    for place, name in enumerate(str(each) for each in dataset["motion"].values):
        if name != "rest" and cells[place] > 0:
            rows.append((name, dataset.isel(motion=place)))
    for height, (name, row) in enumerate(rows):
        share = row["active_share"].item()
        low, high = row["active_share_low"].item(), row["active_share_high"].item()
        colour = _CLASSES.get(name, _CLASSES["longer period"])
        axes.barh(height, share, color=colour, edgecolor=style.INK, linewidth=style.THIN)
        axes.plot([low, high], [height, height], color=style.INK, lw=style.LINE)
        style.note(axes, f"{100.0 * share:.1f} %", (high, height), (4.0, 0.0))
    axes.set_yticks(range(len(rows)), [in_words(name) for name, _ in rows])
    axes.set_ylim(len(rows) - 0.5 if rows else 0.5, -0.5)
    axes.set_xlim(0.0, 1.0)
    rest = dataset.isel(motion=0)["share"].item()
    text = tr("{share} % of all cells are at rest (pale grey)", share=f"{100.0 * rest:.0f}")
    lost = dataset["status"].size - int(cells.sum())
    if lost:
        text += "\n" + tr("{count} without an answer (black)", count=lost)
    axes.set_xlabel(f"{tr('share, with its 95 % interval')}\n{text}", fontsize=style.SMALL)


def in_words(motion: str) -> str:
    """Return a class of motion in the language that is spoken."""
    head, _, period = motion.partition("period ")
    return tr("period {period}", period=period) if period and not head else tr(motion)
