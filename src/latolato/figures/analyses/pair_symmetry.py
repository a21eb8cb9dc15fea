"""The picture of where two equal balls stay mirror images: rates about zero, or one number."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import style
from latolato.figures.analyses.question import DISTURBANCE, Question, is_toy, on_rods
from latolato.figures.analyses.sentences import e_folding, no_answer, number, percent
from latolato.figures.analyses.words import head, tex_number, write_words
from latolato.figures.map_title import in_words, title_of
from latolato.figures.sides import side_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {"valid": style.BLUE, "broken": style.RED, "undecided": style.GREY}
_MEANING = {
    "valid": "departures die out: the one-ball model holds",
    "broken": "departures grow: the balls leave their mirror images",
    "undecided": "departures neither grow nor die in this time",
}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return a map, a curve or one number of the rate at which departures grow."""
    short = [str(d) for d, n in dataset["transverse_exponent"].sizes.items() if n == 1]
    dataset = dataset.isel(dict.fromkeys(short, 0))
    words = {name: in_words(dataset, name, float(dataset[name])) for name in short}
    rate = dataset["transverse_exponent"]
    if rate.ndim == 0:
        return _number(dataset)
    figure, panels = style.new_figure(width=0.75 * style.PAGE, height=3.9)
    axes = panels[0, 0]
    handles = _draw_map(axes, dataset) if rate.ndim == 2 else _draw_curve(axes, dataset)
    axes.set_title("\n".join(title_of(dataset, words, "")), fontsize=style.SMALL)
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def _draw_map(axes: Axes, dataset: xr.Dataset) -> list[Any]:
    """Draw the rate over amplitude and frequency; return the entries of the legend."""
    from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
    from matplotlib.lines import Line2D

    dataset = dataset.sortby(list(map(str, dataset["transverse_exponent"].dims)))
    y, x = (side_of(dataset, str(dim)) for dim in dataset["transverse_exponent"].dims)
    values = np.array(dataset["transverse_exponent"].values, dtype=np.float64)
    status = dataset["status"].values.astype(str)
    finite = values[np.isfinite(values)]
    # A few strong rates would take the colours from all others.
    low, high = np.quantile(finite, (0.01, 0.98)) if finite.size else (0.0, 0.0)
    # Colours of both signs in full, but no noise about zero in strong ones.
    least = 0.5 * max(high, -low, 0.0) or 1.0
    scale: Any = TwoSlopeNorm(0.0, min(low, -least), max(high, least))
    colours: Any = LinearSegmentedColormap.from_list(
        "about zero", [style.BLUE, style.PAPER, style.RED]
    )
    # Where balls rest on each other departures vanish at once.
    rates = np.where(np.isneginf(values), scale.vmin, values)
    cells = style.draw_cells(axes, x.edges, y.edges, rates, cmap=colours, norm=scale)
    lost = ~np.isfinite(rates)
    if lost.any():
        style.fill_cells(axes, x.edges, y.edges, lost, style.GREY)
    text = style.label(dataset["transverse_exponent"])
    style.colour_bar(cells, text, aspect=28, extend="both").ax.set_yscale("linear")
    for side, axis in ((x, "x"), (y, "y")):
        side.label(getattr(axes, f"{axis}axis"))
        if side.is_log:
            getattr(axes, f"set_{axis}scale")("log")
    handles: list[Any] = []
    for name, look in {"broken": "-", "valid": "--"}.items():
        mask = status == name
        if not mask.any():
            continue
        text = f"{name} ({100.0 * mask.mean():.0f} % of the cells)"
        handles.append(Line2D([], [], color=style.INK, lw=style.LINE, ls=look, label=text))
        if not mask.all():
            axes.contour(
                x.values, y.values, mask.astype(float), [0.5], colors=style.INK,
                linewidths=style.LINE, linestyles=look,
            )  # fmt: skip
    if lost.any():
        handles.append(style.swatch(style.GREY, f"no answer ({lost.sum()})"))
    return handles


def _draw_curve(axes: Axes, dataset: xr.Dataset) -> list[Any]:
    """Draw the rate over one parameter; return the entries of the legend."""
    name = str(dataset["transverse_exponent"].dims[0])
    dataset = dataset.sortby(name)
    x, y = dataset[name].values, dataset["transverse_exponent"].values
    status = dataset["status"].values.astype(str)
    axes.axhline(0.0, color=style.INK, lw=style.THIN, zorder=1)
    axes.plot(x, np.where(np.isfinite(y), y, np.nan), color=style.GREY, lw=style.THIN, zorder=2)
    handles = []
    for kind, colour in _COLOURS.items():
        mask = (status == kind) & np.isfinite(y)
        if mask.any():
            (points,) = axes.plot(x[mask], y[mask], "o", ms=3.0, color=colour, label=kind, zorder=3)
            handles.append(points)
    lost = ~np.isfinite(y)
    if lost.any():
        (ticks,) = axes.plot(
            x[lost], np.zeros(lost.sum()), "|", ms=8.0, color=style.INK, clip_on=False,
            transform=axes.get_xaxis_transform(), label=f"no rate ({lost.sum()})",
        )  # fmt: skip
        handles.append(ticks)
    axes.set_xlabel(style.label(dataset[name]))
    axes.set_ylabel(style.label(dataset["transverse_exponent"]))
    return handles


def _number(dataset: xr.Dataset) -> Figure:
    """Return one rate as text."""
    figure, panels = style.new_figure(width=0.6 * style.PAGE, height=1.75)
    status = str(dataset["status"].item())
    rate = tex_number(float(dataset["transverse_exponent"].item()), 5)
    angle = np.degrees(float(dataset["largest_angle_after_transient"].item()))
    rows = [
        ("growth rate of departures", f"{rate} 1/s"),
        ("largest angle of the motion", f"{angle:.1f}°"),
        ("observed", f"{dataset.attrs['duration'] - dataset.attrs['transient']:g} s"),
    ]
    write_words(panels[0, 0], status, _MEANING.get(status, ""), rows, column=0.5)
    head(figure, dataset)
    return figure


def verdict(dataset: xr.Dataset) -> str:
    """Tell whether departures grow, of one toy or of how many."""
    status = dataset["status"].values.astype(str)
    rate = dataset["transverse_exponent"].values.ravel()
    if status.size > 1:
        return f"They do in {percent(float((status == 'valid').mean()))} of {status.size} cases."
    state, value = str(status.ravel()[0]), float(rate[0])
    if math.isnan(value):
        return no_answer(state)
    if state == "valid" and math.isinf(value):
        return "Yes: they rest on each other, and every difference vanishes."
    if state == "valid":
        return f"Yes: differences between them die out, {e_folding(value)}."
    if state == "broken":
        return f"No: a small difference between them grows, {e_folding(value)}."
    return f"The run is too short to tell: a difference grows at {number(value)} 1/s."


QUESTION = Question(
    group=DISTURBANCE,
    title="Do both balls stay mirror images?",
    term="transverse stability of the symmetric motion",
    reading="Both balls start almost as mirror images. Below zero the difference dies out, and one "
    "ball tells you everything. Above zero it grows, and each ball goes its own way.",
    first=("duration", "transient"),
    quick={"duration": "300"},
    conditions=(is_toy, on_rods),
    place=4,
    verdict=verdict,
)
