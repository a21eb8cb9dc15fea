"""Curves, a map, points and numbers, drawn from the dimensions and labels of an analysis."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.map import STATUS_COLOURS, Drawing
from latolato.figures.map_title import title_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Base lines of the status and of the first row below the top, height of a row, and where names
# of numbers begin [inch].
_STATUS, _FIRST, _ROW, _COLUMN = 0.22, 0.54, 0.21, 1.1
# More curves than this are drawn as a map.
_MOST_CURVES = 4
_MARKS = "os^DvP"


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the picture of an analysis that has none of its own.

    The first variable over dimensions is drawn as curves over one dimension, or over two of which
    one is short; as a map over two longer ones. Single numbers are written in rows.

    Raises
    ------
    InputError
        If that variable has more than two dimensions with more than one value.
    """
    arrays = (str(n) for n, each in dataset.items() if each.size > 1 and each.dtype.kind in "iuf")
    name = next(arrays, None)
    if name is None:
        figure, panels = style.new_figure(width=0.75 * style.PAGE, height=0.9 + _ROW * len(dataset))
        write_numbers(panels[0, 0], dataset, map(str, dataset))
        head(figure, dataset)
        return figure
    drawing = Drawing(dataset, name, log=False, select={})
    if len(drawing.sides) == 1 or min(drawing.values.shape) <= _MOST_CURVES:
        return drawing.curves()
    return drawing.map((), None)


def draw_points(
    axes: Axes,
    x: xr.DataArray,
    y: xr.DataArray,
    by: xr.DataArray | None = None,
    *,
    colours: Sequence[str] = style.COLOURS,
    short: bool = False,
    **look: Any,
) -> None:
    """Draw samples as points, in a colour and a mark for each word or number of `by`.

    Parameters
    ----------
    x, y : xarray.DataArray
        Samples over the same dimensions, or over some of those of the other.
    by : xarray.DataArray, optional
        Which points belong together, over some of these dimensions.
    colours : sequence of str
        A colour for each of these; they repeat where there are too few.
    short : bool
        Label both axes by symbols where there are any.
    """
    import xarray as xr

    x, y, kind = xr.broadcast(x, y, xr.DataArray("") if by is None else by)
    # Few points are dots, many a cloud.
    size = float(np.clip(60.0 / math.sqrt(max(y.size, 1)), 0.7, 4.0))
    looks = zip(cycle(colours), cycle(_MARKS), strict=False)
    for word, (colour, mark) in zip(dict.fromkeys(kind.values.flat), looks, strict=False):
        mask = kind.values == word
        axes.plot(
            x.values[mask], y.values[mask], color=colour, label=tr(str(word)),
            **{"ls": "", "marker": mark, "ms": size, "mew": 0.0, "rasterized": True, **look},
        )  # fmt: skip
    axes.margins(0.1)
    style.show_unit(axes.xaxis, x, short=short)
    style.show_unit(axes.yaxis, y, short=short)


def head(figure: Figure, dataset: xr.Dataset) -> None:
    """Write above a figure what system and drive it is of."""
    style.head(figure, "\n".join(title_of(dataset, {}, "")))


def write_numbers(axes: Axes, dataset: xr.Dataset, names: Iterable[str]) -> None:
    """Write the status, and some variables in rows: a value, then what it is.

    A variable over one dimension has a row for each value. What is missing (NaN) or has no bound
    (infinity) is left out.
    """
    axes.set_axis_off()

    def put(text: str, right: float, down: float, size: float, ink: str) -> None:
        axes.annotate(
            text, (0.0, 1.0), xycoords="axes fraction", xytext=(72.0 * right, -72.0 * down),
            textcoords="offset points", va="baseline", fontsize=size, color=ink,
            annotation_clip=False,
        )  # fmt: skip

    status = str(dataset["status"].item()) if "status" in dataset else ""
    put(tr(status), 0.0, _STATUS, 1.4 * style.LARGE, STATUS_COLOURS.get(status, style.INK))
    down = _FIRST
    for name in names:
        about = dataset[name].attrs
        for i, value in enumerate(dataset[name].values.ravel().tolist(), start=1):
            if isinstance(value, str) or np.isnan(value) or value == math.inf:
                continue
            label = f"${about['symbol']}_{i}$" if dataset[name].dims else tr(about["long_name"])
            put(text_of(name, value, about["units"]), 0.0, down, style.SMALL, style.INK)
            put(label, _COLUMN, down, style.SMALL, style.GREY)
            down += _ROW


def text_of(name: str, value: complex, unit: str) -> str:
    """Return a real or complex value of a variable as it is printed, with its unit.

    Examples
    --------
    >>> text_of("multipliers", 0.5 + 0.25j, "1"), text_of("growth_rate", 2.0, "1/s")
    ('0.5 + 0.25 i', '2 1/s')
    """
    if np.isnan(value):
        return tr("no value")
    if value.imag:
        sign = "\N{MINUS SIGN}" if value.imag < 0 else "+"
        return f"{text_of(name, value.real, unit)} {sign} {text_of(name, abs(value.imag), unit)} i"
    text = style.shown_value(name, value.real, unit).replace("inf", "∞")
    return text if "$" in text else text.replace("-", "\N{MINUS SIGN}")
