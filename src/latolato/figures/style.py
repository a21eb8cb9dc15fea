"""The look of every picture: sizes, fonts and colours, and the few helpers that panels share.

Figures are made without pyplot, so that drawing has no global state and needs no screen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec

import numpy as np
from numpy.typing import NDArray

from latolato.core.atomic import atomic_path
from latolato.core.errors import InputError
from latolato.core.language import local, tr
from latolato.core.quantities import QUANTITIES, quantity_of
from latolato.io.shown_units import SIZES
from latolato.simulation.record import WHOSE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

P = ParamSpec("P")

PAGE = 7.0  # width of a page [inch]
# Width of a figure in one column of a journal [inch].
COLUMN = 3.4
# Height of one row of panels [inch].
ROW = 2.1
DPI = 200

# Told apart by colour-blind eyes, and in grey print by their lightness: INK 14, BLUE 35, RED 47,
# GREEN 56, GREY 63, ORANGE 74 (CIE L*).
INK = "#1f2430"
BLUE = "#1d4f9e"
RED = "#c8451b"
GREEN = "#0f967c"
GREY = "#9197a1"
ORANGE = "#f2a31b"
PAPER = "#ffffff"
# For pictures on a dark ground.
NIGHT = "#10141d"
FAINT = "#5b6579"
LIGHT = "#eef1f6"
SKY = "#6fb1ff"
AMBER = "#ffb454"
COLOURS = (BLUE, RED, GREEN, ORANGE, INK, GREY)
# Soft fills behind curves and for bodies.
PALE_BLUE = "#dbe6f5"
PALE_RED = "#f8e0d6"
PALE_GREY = "#eceef1"

LINE = 1.1
THIN = 0.6
SMALL = 7.0
TEXT = 8.0
LARGE = 9.5
# Where a legend stands clear of the curves.
ABOVE: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}


@contextmanager
def use_style() -> Iterator[None]:
    """Draw and save with the project's fonts, sizes and colours inside a ``with`` block."""
    import matplotlib as mpl
    from cycler import cycler

    with mpl.rc_context(
        {
            # The only family that every matplotlib brings along: pictures are the same everywhere.
            "font.family": "DejaVu Sans",
            "mathtext.fontset": "dejavusans",
            "font.size": TEXT,
            "axes.titlesize": TEXT,
            "axes.labelsize": TEXT,
            "xtick.labelsize": SMALL,
            "ytick.labelsize": SMALL,
            "legend.fontsize": SMALL,
            "figure.titlesize": LARGE,
            "text.color": INK,
            "axes.labelcolor": INK,
            "axes.edgecolor": INK,
            "xtick.color": INK,
            "ytick.color": INK,
            "axes.linewidth": THIN,
            "xtick.major.width": THIN,
            "ytick.major.width": THIN,
            "xtick.major.size": 3.0,
            "ytick.major.size": 3.0,
            "xtick.direction": "out",
            "ytick.direction": "out",
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.prop_cycle": cycler(color=COLOURS),
            "axes.titlelocation": "left",
            "axes.axisbelow": True,
            "axes.formatter.use_mathtext": True,
            "axes.formatter.limits": (-3, 4),
            "axes.xmargin": 0.0,
            "axes.ymargin": 0.06,
            "grid.color": PALE_GREY,
            "grid.linewidth": THIN,
            "lines.linewidth": LINE,
            "lines.solid_capstyle": "round",
            "lines.solid_joinstyle": "round",
            "patch.linewidth": THIN,
            "legend.frameon": False,
            "legend.handlelength": 1.6,
            "legend.borderaxespad": 0.2,
            "figure.facecolor": PAPER,
            "axes.facecolor": PAPER,
            "savefig.facecolor": PAPER,
            "figure.dpi": 100,
            "savefig.dpi": DPI,
            "image.cmap": "viridis",
            "image.interpolation": "nearest",
            "path.simplify": True,
            "path.simplify_threshold": 0.2,
            "agg.path.chunksize": 20000,
            # Text stays text in vector files, and files do not change from run to run.
            "svg.fonttype": "none",
            "svg.hashsalt": "latolato",
            "pdf.fonttype": 42,
        }
    ):
        yield


def new_figure(
    rows: int = 1,
    columns: int = 1,
    *,
    width: float = PAGE,
    height: float | None = None,
    sharex: bool | str = False,
    sharey: bool | str = False,
    height_ratios: list[float] | None = None,
    width_ratios: list[float] | None = None,
) -> tuple[Figure, NDArray[Any]]:
    """Return a figure and its panels, shape ``(rows, columns)``.

    Parameters
    ----------
    rows, columns : int
        Number of panels.
    width, height : float
        Size [inch]; the default height is `ROW` per row.
    sharex, sharey : bool or {"row", "col"}
        As in ``matplotlib.figure.Figure.subplots``.
    height_ratios, width_ratios : list of float, optional
        Relative sizes of rows and columns.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, ROW * rows if height is None else height), layout="constrained")
    axes = figure.subplots(
        rows,
        columns,
        squeeze=False,
        sharex=sharex,  # type: ignore[arg-type]
        sharey=sharey,  # type: ignore[arg-type]
        height_ratios=height_ratios,
        width_ratios=width_ratios,
    )
    return figure, axes


def new_mosaic(
    layout: list[Any],
    *,
    width: float = PAGE,
    height: float | None = None,
    height_ratios: list[float] | None = None,
    width_ratios: list[float] | None = None,
) -> tuple[Figure, dict[str, Axes]]:
    """Return a figure and its panels by name; a name that repeats spans its cells."""
    from matplotlib.figure import Figure

    size = (width, ROW * len(layout) if height is None else height)
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplot_mosaic(layout, height_ratios=height_ratios, width_ratios=width_ratios)
    return figure, axes


def save_figure(figure: Figure, path: Path | str, *, dpi: float = DPI) -> Path:
    """Write a figure as PNG, SVG or PDF by its suffix, complete or not at all, and return its path.

    Dates and versions are left out of the file, so that equal pictures are equal files.
    """
    path = Path(path)
    kind = path.suffix.lower().removeprefix(".")
    nameless: dict[str, dict[str, Any]] = {
        "png": {"Software": None},
        "svg": {"Date": None, "Creator": None},
        "pdf": {"CreationDate": None, "ModDate": None, "Creator": None, "Producer": None},
    }
    if kind not in nameless:
        raise InputError("a picture's name must end in .png, .svg or .pdf", value=path.name)
    with use_style(), atomic_path(path) as unfinished:
        figure.savefig(unfinished, format=kind, dpi=dpi, metadata=nameless[kind])
    return path


def head(figure: Figure, text: str) -> None:
    """Write small text above a whole figure."""
    figure.suptitle(text, fontsize=SMALL, x=0.01, ha="left")


def label(variable: xr.DataArray, *, short: bool = False, unit: str = "") -> str:
    r"""Return an axis label from a variable's metadata, e.g. ``angle $\theta$ [rad]``.

    Parameters
    ----------
    variable : xarray.DataArray
        With the attributes ``long_name``, ``symbol`` and ``units``; a missing one is left out.
    short : bool
        Leave the long name out where there is a symbol.
    unit : str
        Unit of what is drawn, where it is not that of the variable.
    """
    name, symbol, units = (
        str(variable.attrs.get(key, "")) for key in ("long_name", "symbol", "units")
    )
    words = [] if short and symbol else [named(name)]
    if symbol:
        words.append(f"${symbol}$")
    if units not in ("", "1"):
        words.append(f"[{unit or pretty_unit(units)}]")
    return " ".join(word for word in words if word)


def named(long_name: str) -> str:
    """Return the name of a quantity, and whose it is, in the language that is spoken."""
    what, _, whose = long_name.rpartition(", ")
    return f"{tr(what)}, {tr(whose)}" if whose in WHOSE else tr(long_name)


def label_of(name: str) -> str:
    """Return the axis label of a quantity that is a plain number, by its name."""
    quantity = QUANTITIES[name]
    return f"{tr(quantity.long_name)} ${quantity.symbol}$"


def pretty_unit(unit: str) -> str:
    """Return a unit as it is printed: ``kg*m/s^2`` becomes ``kg m/s²``, ``deg`` the sign."""
    if unit == "deg":
        return "°"
    return unit.replace("*", " ").replace("^2", "²").replace("^(3/2)", "³ᐟ²")


def unit_after(number: str, unit: str) -> str:
    """Return a number with its unit, if it has one: ``0.05 kg m/s``."""
    return number if unit in ("", "1") else f"{number} {pretty_unit(unit)}"


def shown_value(name: str, value: float, unit: str) -> str:
    """Return a value of a variable in an SI unit as people read it, with the unit: ``20 mm``."""
    shown = quantity_of(name, unit).shown_unit
    text = raised(f"{value / float(SIZES.get(shown, 1)):.4g}")
    return f"{text}°" if shown == "deg" else unit_after(text, shown)


def raised(number: str) -> str:
    """Return a number such as ``2e-05`` with its power of ten as mathematics."""
    digits, has_power, power = number.partition("e")
    return rf"${digits}\times10^{{{int(power)}}}$" if has_power else number


def edges_of(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the borders of cells about increasing values, midway between them."""
    if len(values) == 1:
        half = 0.5 * abs(values[0]) or 0.5
        return np.array([values[0] - half, values[0] + half])
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2.0 * values[0] - middle[0]], middle, [2.0 * values[-1] - middle[-1]]])


def draw_cells(axes: Axes, x: Any, y: Any, values: Any, **look: Any) -> Any:
    """Draw a framed map of cells between the edges x and y; NaN and masked cells stay empty."""
    cells = axes.pcolormesh(
        x, y, np.ma.masked_invalid(values), shading="flat", rasterized=True, **look
    )
    for spine in axes.spines.values():
        spine.set_visible(True)
    return cells


def fill_cells(axes: Axes, x: Any, y: Any, mask: NDArray[np.bool_], colour: str) -> None:
    """Fill the cells of a mask with one colour."""
    from matplotlib.colors import ListedColormap

    draw_cells(axes, x, y, np.where(mask, 0.0, np.nan), cmap=ListedColormap([colour]))


def colour_bar(cells: Any, text: str = "", **options: Any) -> Any:
    """Add the scale of colours of a map, beside its panel or the panels ``ax``, and return it."""
    bar = cells.axes.get_figure(root=True).colorbar(
        cells, **{"ax": cells.axes, "pad": 0.02, **options}
    )
    bar.set_label(text)
    bar.outline.set_visible(False)
    return bar


def swatch(colour: str, text: str) -> Any:
    """Return the legend entry of a filled colour."""
    from matplotlib.patches import Patch

    return Patch(facecolor=colour, edgecolor=INK, linewidth=THIN, label=text)


def plain_ticks(axis: Axis, digits: tuple[float, ...] = (1.0, 2.0, 5.0)) -> None:
    """Write the ticks of a logarithmic axis as plain numbers with these first digits."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=digits))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def panel_letter(axes: Axes, letter: str, *, dx: float = 0.0, dy: float = 4.0) -> None:
    """Write ``(a)`` above the upper left corner of a panel, shifted by (dx, dy) points."""
    axes.annotate(
        f"({letter})",
        xy=(0.0, 1.0),
        xycoords="axes fraction",
        xytext=(dx, dy),
        textcoords="offset points",
        ha="left",
        va="bottom",
        fontsize=LARGE,
        fontweight="bold",
        color=INK,
    )


def panel_title(axes: Axes, letter: str, text: str) -> None:
    """Write ``(a)`` and a short description above a panel."""
    panel_letter(axes, letter)
    axes.set_title(text, loc="left", x=0.0, pad=4.0, fontsize=TEXT)
    axes.title.set_visible(True)
    # The title stands right of the letter, at the same height.
    from matplotlib.transforms import ScaledTranslation

    figure = axes.get_figure(root=True)
    assert figure is not None
    shift = ScaledTranslation(20.0 / 72.0, 0.0, figure.dpi_scale_trans)
    left = axes._left_title  # type: ignore[attr-defined]
    left.set_transform(left.get_transform() + shift)


def pi_ticks(axis: Axis, *, parts: int = 2) -> None:
    """Put ticks at multiples of pi/`parts` and write them as fractions of pi."""
    from matplotlib.ticker import FuncFormatter, MultipleLocator

    axis.set_major_locator(MultipleLocator(math.pi / parts))
    axis.set_major_formatter(FuncFormatter(lambda value, _: pi_text(value, parts)))


def pi_text(value: float, parts: int = 2) -> str:
    r"""Return a multiple of pi/`parts` as text, e.g. ``$3\pi/4$``."""
    count = round(value * parts / math.pi)
    divisor = math.gcd(count, parts)
    over, under = abs(count) // divisor, parts // divisor
    if over == 0:
        return "0"
    sign = "-" if count < 0 else ""
    factor = "" if over == 1 else str(over)
    tail = "" if under == 1 else f"/{under}"
    return f"${sign}{factor}\\pi{tail}$"


def show_unit(axis: Axis, variable: xr.DataArray, *, short: bool = False) -> None:
    """Label an axis of values in SI units, in the unit in which people read the variable."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    name, units = str(variable.name), str(variable.attrs.get("units", ""))
    unit = quantity_of(name, units).shown_unit
    size = float(SIZES.get(unit, 1))
    axis.set_label_text(label(variable, short=short, unit=pretty_unit(unit)))
    if size == 1.0:
        return

    class Round(MaxNLocator):
        """Ticks at round numbers of the unit."""

        def tick_values(self, vmin: float, vmax: float) -> Any:
            return size * np.asarray(super().tick_values(vmin / size, vmax / size))

    steps = [1, 1.5, 3, 4.5, 6, 9, 10] if unit == "deg" else [1, 2, 2.5, 5, 10]
    if axis.get_scale() == "linear":
        axis.set_major_locator(Round(6, steps=steps))
    axis.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value / size:g}".replace("-", "\N{MINUS SIGN}"))
    )


def degree_axis(axes: Axes, *, spacing: float | None = None) -> Axes:
    """Add an axis in degrees on the right of a panel in radians, every `spacing` degrees."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator

    right = axes.secondary_yaxis("right", functions=(np.rad2deg, np.deg2rad))
    right.set_color(INK)
    right.spines["right"].set_visible(True)
    right.yaxis.set_major_locator(
        MultipleLocator(spacing) if spacing else MaxNLocator(5, steps=[1, 1.5, 3, 4.5, 6, 9, 10])
    )
    right.yaxis.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value:g}°".replace("-", "\N{MINUS SIGN}"))
    )
    return right  # type: ignore[return-value]


def mark_level(
    axes: Axes,
    value: float,
    text: str,
    *,
    where: float = 1.0,
    above: bool = True,
    colour: str = GREY,
) -> None:
    """Draw a thin dashed horizontal line with its meaning written at its right or left end."""
    axes.axhline(value, color=colour, lw=THIN, ls=(0, (4, 3)), zorder=1)
    axes.annotate(
        text,
        xy=(where, value),
        xycoords=("axes fraction", "data"),
        xytext=(-2 if where > 0.5 else 2, 2 if above else -2),
        textcoords="offset points",
        ha="right" if where > 0.5 else "left",
        va="bottom" if above else "top",
        fontsize=SMALL,
        color=INK,
    )


def keep_span(axes: Axes, *, x: float = 0.0, y: float = 0.0) -> None:
    """Widen a panel to at least these spans, so that rounding errors do not fill it."""
    for least, limits, set_limits in (
        (x, axes.get_xlim(), axes.set_xlim),
        (y, axes.get_ylim(), axes.set_ylim),
    ):
        low, high = limits
        if high - low < least:
            middle = 0.5 * (low + high)
            set_limits(middle - 0.5 * least, middle + 0.5 * least)


def note(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    shift: tuple[float, float] = (4.0, 4.0),
    *,
    ha: str = "left",
    va: str = "center",
    colour: str = INK,
    size: float = SMALL,
) -> None:
    """Write small text beside a point of a panel, shifted by points, over a pale ground."""
    axes.annotate(
        text,
        xy=at,
        xytext=shift,
        textcoords="offset points",
        ha=ha,
        va=va,
        fontsize=size,
        color=colour,
        bbox={"boxstyle": "round,pad=0.15", "fc": PAPER, "ec": "none", "alpha": 0.8},
        annotation_clip=False,
    )


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Return `draw`, a figure's drawing function, made to run inside `use_style`.

    Its numbers get the decimal sign of the language that is spoken.
    """
    import functools

    @functools.wraps(draw)
    def inside(*args: P.args, **options: P.kwargs) -> Figure:
        with use_style():
            figure = draw(*args, **options)
            _localise(figure)
            # Lays the panels out under the style, whatever is in force when the figure is shown.
            figure.draw_without_rendering()
            return figure

    return inside


def _localise(figure: Figure) -> None:
    """Give texts and ticks of a figure the decimal sign of the language that is spoken."""
    from matplotlib.axis import Axis
    from matplotlib.text import Text

    if local("0.5") == "0.5":
        return
    for text in figure.findobj(Text):
        text.set_text(local(text.get_text()))
    for axis in figure.findobj(Axis):
        formatter: Any = axis.get_major_formatter()
        for name in ("format_ticks", "get_offset"):
            setattr(formatter, name, _localised(getattr(formatter, name)))


def _localised(write: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method of a formatter whose texts have the language's decimal sign."""

    def inside(*args: Any) -> Any:
        result = write(*args)
        return local(result) if isinstance(result, str) else [local(text) for text in result]

    return inside
