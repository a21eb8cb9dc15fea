"""The picture of a sweep or an analysis: a heat map over two dimensions, or curves over one."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.language import spoken, tr
from latolato.core.registry import suggest
from latolato.figures import contours, style, word_classes
from latolato.figures import overlays as marks
from latolato.figures.map_title import in_words, plain_text, title_of
from latolato.figures.sides import Side, side_of, values_along
from latolato.numerics.records import EVENT_LIMIT, STATUS_NAMES
from latolato.sweeps.statuses import codes_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from latolato.sweeps.plan import Plan

    Floats = NDArray[np.float64]

# What the values of a variable mean, with colours that keep their order in grey print.
CLASSES: dict[str, dict[str, str]] = {
    "motion_class": {"none": style.PALE_BLUE, "weak": style.ORANGE, "strong": style.RED},
    "self_start": {"stays": style.PALE_BLUE, "starts": style.RED},
    "status": dict(
        zip(
            (name.replace("_", " ") for name in STATUS_NAMES),
            (
                *(style.PALE_BLUE, style.ORANGE, style.BLUE, style.RED, style.INK, style.GREEN),
                style.SKY,
            ),
            strict=True,
        )
    ),
}
NO_ANSWER = style.GREY
NOT_YET = "#c9cdd3"
ZERO = style.PAPER
_HEIGHT = 4.1  # inch
# Logarithmic axes of more decades have powers of ten.
_MOST_PLAIN = 3.0
# More curves than this cannot be told apart.
_MOST_CURVES = 12
# Colours of rates and other values of both signs; one value in fifty is beyond the scale.
_BOTH_SIGNS = (style.BLUE, style.PAPER, style.RED)
_WITHIN = 0.98
# The statuses of analyses that have a colour of their own, and lines about the cells of any.
STATUS_COLOURS = {
    **dict.fromkeys(("unstable", "chaotic", "broken"), style.RED),
    **dict.fromkeys(("stable", "regular", "valid", "rest"), style.BLUE),
}
_OTHER_STATUSES = (
    *(style.GREEN, style.ORANGE, style.INK, style.SKY),
    *(style.PALE_RED, style.PALE_BLUE, style.FAINT),
)
# A parameter is followed in these directions.
WAYS = {"up": style.RED, "down": style.BLUE}
_OUTLINES = ("-", "--", ":", "-.")


def check_drawable(plan: Plan, variable: str | None) -> None:
    """Raise InputError unless the sweep of a plan can be drawn without selecting anything."""
    from latolato.sweeps.labels import dims_of, lengths_of, template

    name = _variable(list(template(plan)), variable)
    lengths = lengths_of(plan)
    lengths = {dim: lengths[dim] for dim in dims_of(plan, name)}
    _check_dims({dim: n for dim, n in lengths.items() if dim not in _constant(lengths)}, name)


def _variable(known: list[str], name: str | None) -> str:
    """Return the variable of this name, or the first."""
    if name is None:
        return known[0]
    if name not in known:
        raise InputError(f"unknown variable '{name}': {suggest(name, known)}")
    return name


def _constant(lengths: Mapping[str, int], most: int = 2) -> list[str]:
    """Return the dimensions of one value where there are more than `most` dimensions."""
    return [dim for dim, length in lengths.items() if length == 1 and len(lengths) > most]


def _check_dims(lengths: Mapping[str, int], variable: str) -> None:
    """Raise InputError unless one or two dimensions are left."""
    if len(lengths) > 2:
        dims = ", ".join(f"{dim} ({length})" for dim, length in lengths.items())
        raise InputError(
            f"varies over {dims}; a picture shows two of them",
            parameter=variable,
            way_out="select a value of all but two: `select` in Python, `--select NAME=VALUE` on "
            "the command line",
        )
    if not lengths:
        raise InputError("is a single value", parameter=variable, way_out="select fewer dimensions")


def _order(dims: list[str], right: str | None) -> list[str]:
    """Return dimensions with one, usually a frequency, last, for it goes to the right."""
    return sorted(dims, key=lambda dim: dim == right if right else dim in marks.FREQUENCIES)


def _select(
    grid: xr.Dataset, variable: str, select: Mapping[str, Any]
) -> tuple[xr.Dataset, dict[str, str]]:
    """Return the part of a dataset at given values, and these in words."""
    selection: dict[str, str] = {}
    for name, value in select.items():
        dims = list(map(str, grid[variable].dims))
        if name not in dims:
            raise InputError(
                f"has no dimension '{name}': {suggest(name, dims)}", parameter=variable
            )
        coordinate = grid[name].values
        if coordinate.dtype.kind == "U":
            if value not in coordinate:
                raise InputError(
                    f"must be one of {', '.join(coordinate)}", parameter=name, value=value
                )
            index = int(np.flatnonzero(coordinate == value)[0])
        elif name not in grid.coords:
            index = int(value)
            if not 0 <= index < grid.sizes[name]:
                raise InputError(
                    f"is an index below {grid.sizes[name]}", parameter=name, value=value
                )
        else:
            index = _nearest(name, coordinate, float(value))
        grid = grid.isel({name: index})
        if name in grid.coords and coordinate.dtype.kind != "U":
            selection[name] = in_words(grid, name, float(grid[name]))
        else:
            selection[name] = f"{spoken(name)} {tr(str(value))}"
    return grid, selection


def _nearest(name: str, values: Floats, value: float) -> int:
    """Return the index of the nearest value; half a spacing beyond the ends is too far."""
    ordered = np.sort(values)
    slack = 0.5 * float(np.max(np.diff(ordered), initial=0.0)) + 1e-9 * float(np.abs(ordered).max())
    if not ordered[0] - slack <= value <= ordered[-1] + slack:
        raise InputError(
            f"{name} runs from {ordered[0]:g} to {ordered[-1]:g} here",
            value=value,
            way_out="select a value in between",
        )
    return int(np.argmin(np.abs(values - value)))


@dataclass(frozen=True)
class Look:
    """How a map is drawn: its colours, their ends, and lines over it with the unit of their values.

    Attributes
    ----------
    colours : str
        A scale of matplotlib; by default one that changes at zero for values of both signs.
    limits : tuple of float, optional
        Values of the darkest and the brightest colour; by default the least and the largest.
    lines : sequence of latolato.figures.contours.Line
        Lines of equal values.
    unit : tuple of str and float
        Name of the unit of these, and how many SI units it is.
    label : str
        What is equal along them.
    """

    colours: str = ""
    limits: tuple[float, float] | None = None
    lines: Sequence[contours.Line] = ()
    unit: tuple[str, float] = ("", 1.0)
    label: str = ""


class Drawing:
    """One variable of a sweep or an analysis over one or two dimensions, ready to be drawn.

    A cell reaches halfway to its neighbours. Points without an answer are grey and counted in the
    legend, by status; they never look like a value. Contact words are classes, and `numbers` holds
    their codes; of other variables it holds the values. Values of both signs have colours that
    change at zero. The status of an analysis is a result: it outlines cells and colours points.
    Dimensions of one value are selected where more are left than a picture shows; of an analysis,
    always beside others.
    """

    def __init__(
        self,
        grid: xr.Dataset,
        variable: str | None,
        *,
        log: bool,
        select: Mapping[str, Any],
        right: str | None = None,
    ) -> None:
        self.name = _variable(list(map(str, grid.data_vars)), variable)
        lengths = {str(dim): grid.sizes[dim] for dim in grid[self.name].dims if dim not in select}
        constant = _constant(lengths, most=1 if "analysis" in grid.attrs else 2)
        single = {dim: grid[dim].item() for dim in constant}
        grid, selection = _select(grid, self.name, {**single, **select})
        rest = _order(list(map(str, grid[self.name].dims)), right)
        _check_dims({d: grid.sizes[d] for d in rest}, self.name)
        self.sides = [side_of(grid, dim) for dim in rest]
        for side in self.sides:
            order = np.argsort(values_along(grid, side.dim), kind="stable")
            grid = grid.isel({side.dim: order})
        data = grid[self.name].transpose(*rest)
        self.grid, self.data, self.log = grid, data, log
        self.title = title_of(grid, selection, self.name)
        self.status = np.zeros(data.shape, dtype=np.int8)
        self.words: NDArray[np.str_] | None = None
        status = grid.get("status")
        if status is not None and set(status.dims) <= set(data.dims):
            status = status.broadcast_like(data).transpose(*data.dims)
            if "analysis" in grid.attrs:
                self.words = status.values.astype(str)
            else:
                self.status = codes_of(status)
        self.classes = CLASSES.get(self.name, {})
        shown = self.status if self.name == "status" else data.values
        if self.name == "status" and self.words is not None:
            self.classes = _colours_of(self.words)
            shown = np.searchsorted(list(self.classes), self.words)
        self.values = np.array(shown, dtype=np.float64)
        if self.name == "status":
            self.values[self.status < 0] = np.nan
        else:
            self.values[(self.status < 0) | (self.status >= EVENT_LIMIT)] = np.nan
        if self.classes:
            self.values = np.round(self.values)
        self.numbers = self.values
        if self.name == "contact_word":
            self.classes, self.values = word_classes.classes_of(self.numbers)
        if log and self.classes:
            raise InputError(
                "has classes, not a scale", parameter=self.name, way_out="leave out log"
            )
        if log and np.nanmin(self.values, initial=0.0) < 0.0:
            raise InputError(
                "must not be negative on a log scale",
                parameter=self.name,
                value=float(np.nanmin(self.values)),
                way_out="leave out log",
            )

    @property
    def limits(self) -> tuple[float, float]:
        """Ends of the colour scale."""
        if self.name.startswith("probability_") and not self.log:
            return 0.0, 1.0
        usable = self.values[np.isfinite(self.values) & ((self.values > 0.0) | (not self.log))]
        if not usable.size:
            return (0.1, 1.0) if self.log else (0.0, 1.0)
        low, high = float(usable.min()), float(usable.max())
        if low == high:
            return (low / 2.0, high * 2.0) if self.log else (low - 0.5, high + 0.5)
        return low, high

    @style.styled
    def map(
        self,
        overlays: Sequence[str | xr.Dataset],
        points: str | Path | None,
        look: Look | None = None,
    ) -> Figure:
        """Return the heat map, with theory and trials over it."""
        look = look or Look()
        context = None
        y, x = self.sides
        if points or any(isinstance(each, str) for each in overlays):
            context = marks.Context.of(self.grid, x.name, y.name)
        figure, panels = style.new_figure(width=0.75 * style.PAGE, height=_HEIGHT)
        axes = panels[0, 0]
        self._draw_cells(axes, look)
        handles = self._legend_of_cells() + self._outline(axes)
        for side, axis in zip(self.sides, ("y", "x"), strict=True):
            if side.is_log:
                getattr(axes, f"set_{axis}scale")("log")
                _number(getattr(axes, f"{axis}axis"), side)
            side.label(getattr(axes, f"{axis}axis"))
            edges = side.edges
            getattr(axes, f"set_{axis}lim")(float(edges[0]), float(edges[-1]))
        if look.lines:
            handles.append(contours.draw(axes, look.lines, look.unit, look.label))
        for each in overlays:
            if context is not None and isinstance(each, str):
                handles.append(marks.draw(axes, context, each))
            elif not isinstance(each, str):
                handles += marks.draw_curve(axes, self.grid, (x.name, y.name), each)
        if context is not None and points is not None:
            handles += marks.draw_points(axes, context, points)
        _finish(figure, axes, self.title, handles)
        return figure

    def _draw_cells(self, axes: Axes, look: Look) -> None:
        """Draw the cells and their colour bar."""
        from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize

        y, x = self.sides
        values = np.ma.masked_invalid(self.values)
        low, high = look.limits or self.limits
        least, most = (end(self.values, initial=0.0) for end in (np.nanmin, np.nanmax))
        has_signs = not (look.colours or look.limits or self.classes) and least < 0.0 < most
        if has_signs:
            high = float(np.nanquantile(np.abs(self.values[np.isfinite(self.values)]), _WITHIN))
            low = -high
            values = np.ma.masked_invalid(np.maximum(self.values, low))
        if self.classes:
            colours: Any = ListedColormap(list(self.classes.values()))
            norm: Any = BoundaryNorm(np.arange(len(self.classes) + 1) - 0.5, len(self.classes))
        else:
            import matplotlib as mpl

            colours = _about_zero() if has_signs else mpl.colormaps[look.colours or "viridis"]
            norm = LogNorm(low, high) if self.log else Normalize(low, high)
        if self.log:
            values = np.ma.masked_less_equal(values, 0.0)
        cells = style.draw_cells(axes, x.edges, y.edges, values, cmap=colours, norm=norm)
        for mask, colour in self._special():
            if mask.any():
                style.fill_cells(axes, x.edges, y.edges, mask, colour)
        if not self.classes:
            bar = style.colour_bar(cells, aspect=28, extend="both" if has_signs else "neither")
            style.show_unit(bar.long_axis, self.data)

    def _special(self) -> list[tuple[Any, str]]:
        """Return the cells that have a colour of their own, and it."""
        nothing = np.isnan(self.values)
        special = [
            (nothing & (self.status >= 0), NO_ANSWER),
            (nothing & (self.status < 0), NOT_YET),
        ]
        return [*special, (self.values == 0.0, ZERO)] if self.log else special

    def _legend_of_cells(self) -> list[Any]:
        """Return legend entries for classes and for cells without a value."""
        entries = []
        for number, (text, colour) in enumerate(self.classes.items()):
            count = np.count_nonzero(self.values == number)
            text = tr(text)
            if self.name == "contact_word":
                text = f"{text} ({100.0 * count / self.values.size:.1f} %)"
            if self.name != "status" or count:
                entries.append(style.swatch(colour, text))
        nothing = np.isnan(self.values)
        late, lost = nothing & (self.status < 0), nothing & (self.status >= 0)
        if lost.any():
            entries.append(style.swatch(NO_ANSWER, self._without_answer(lost)))
        if late.any():
            text = tr("not computed yet ({count})", count=int(late.sum()))
            entries.append(style.swatch(NOT_YET, text))
        if self.log and (self.values == 0.0).any():
            entries.append(style.swatch(ZERO, tr("zero")))
        return entries

    def _without_answer(self, lost: NDArray[np.bool_]) -> str:
        """Return how many points of a mask have no answer, by status."""
        if self.words is None:
            answers = ["without value"] * EVENT_LIMIT
            words = np.array([*answers, *STATUS_NAMES[EVENT_LIMIT:]])[self.status[lost]]
        else:
            words = self.words[lost]
        counts = Counter(words).items()
        reasons = ", ".join(f"{n} {spoken(word)}" for word, n in counts)
        return tr("no answer ({reasons})", reasons=reasons)

    def _outline(self, axes: Axes) -> list[Any]:
        """Outline all statuses of an analysis but the most frequent one; return legend entries."""
        from matplotlib.lines import Line2D
        from matplotlib.patheffects import Normal, Stroke

        y, x = self.sides
        if self.words is None or self.name == "status" or min(self.words.shape) < 2:
            return []
        if y.words or x.words:  # nothing lies between two words
            return []
        known = Counter(self.words[~np.isnan(self.values)].tolist()).most_common()
        halo = [Stroke(linewidth=3.0 * style.LINE, foreground=style.PAPER), Normal()]
        handles = []
        for (word, count), look in zip(known[1:], _OUTLINES, strict=False):
            mask = (self.words == word).astype(float)
            lines = axes.contour(
                x.values, y.values, mask, [0.5], colors=style.INK, linewidths=style.LINE,
                linestyles=look,
            )  # fmt: skip
            lines.set_path_effects(halo)
            share = f"{100.0 * count / self.words.size:.0f}"
            text = tr("{word} ({share} % of the cells)", word=tr(word), share=share)
            handles.append(Line2D([], [], color=style.INK, lw=style.LINE, ls=look, label=text))
        return handles

    @style.styled
    def curves(self) -> Figure:
        """Return curves over the longer dimension, or over the one of numbers beside text."""
        values, sides = self.values, self.sides
        if len(sides) == 1:
            values, sides = values[None], [sides[0], sides[0]]
        elif sides[1].words or (not sides[0].words and len(sides[0].values) > len(sides[1].values)):
            values, sides = values.T, sides[::-1]
        if len(values) > _MOST_CURVES:
            raise InputError(
                f"at most {_MOST_CURVES} curves can be told apart",
                value=len(values),
                way_out="leave out curves for a map, or select a value",
            )
        figure, panels = style.new_figure(width=0.75 * style.PAGE, height=_HEIGHT)
        axes = panels[0, 0]
        along = sides[1]
        few = len(along.values) <= 60
        handles: list[Any] = []
        names = [sides[0].name_of(i) for i in range(len(values))] if len(values) > 1 else [""]
        shades = zip(names, _shades(len(names)), strict=True)
        colours = [WAYS.get(name, shade) for name, shade in shades]
        if self.words is not None and len(values) == 1:
            colours = [style.GREY]
            handles = _mark_statuses(axes, along.values, values[0], self.words)
        for name, colour, row in zip(names, colours, values, strict=True):
            (line,) = axes.plot(
                along.values,
                row,
                color=colour,
                lw=0.0 if along.words else style.LINE,
                marker="o" if few else "",
                ms=2.5,
                label=tr(name),
            )
            handles += [line] if name else []
        if np.nanmin(values, initial=0.0) < 0.0 < np.nanmax(values, initial=0.0):
            axes.axhline(0.0, color=style.INK, lw=style.THIN, zorder=1)
        if not np.isfinite(values).all():
            self._mark_missing(axes, along, values, handles)
        if along.is_log:
            axes.set_xscale("log")
        if self.log:
            axes.set_yscale("log")
        ends = along.edges if along.words or len(along.values) == 1 else along.values
        axes.set_xlim(float(ends[0]), float(ends[-1]))
        along.label(axes.xaxis)
        style.show_unit(axes.yaxis, self.data)
        if self.classes:
            axes.set_yticks(range(len(self.classes)), [tr(each) for each in self.classes])
        _finish(figure, axes, self.title, handles)
        return figure

    def _mark_missing(self, axes: Axes, along: Side, values: Floats, handles: list[Any]) -> None:
        """Mark where curves have no value by ticks at the bottom."""
        where = np.flatnonzero(~np.isfinite(values).all(axis=0))
        (ticks,) = axes.plot(
            along.values[where],
            np.zeros(len(where)),
            transform=axes.get_xaxis_transform(),
            color=NO_ANSWER,
            marker="|",
            ms=8,
            ls="",
            clip_on=False,
            label=self._without_answer(~np.isfinite(self.values)),
        )
        handles.append(ticks)


def _number(axis: Any, side: Side) -> None:
    """Write plain numbers along a logarithmic axis of few decades."""
    decades = math.log10(side.edges[-1] / side.edges[0])
    if decades <= _MOST_PLAIN:
        narrow = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)
        style.plain_ticks(axis, (1.0, 2.0, 5.0) if decades > 1.0 else narrow)


def _about_zero() -> Any:
    """Return colours that change at the middle of their scale."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("about zero", list(_BOTH_SIGNS))


def _colours_of(words: NDArray[np.str_]) -> dict[str, str]:
    """Return the statuses of an analysis in alphabetical order, each with a colour."""
    others = cycle(_OTHER_STATUSES)
    return {word: STATUS_COLOURS.get(word) or next(others) for word in np.unique(words).tolist()}


def _mark_statuses(axes: Axes, x: Floats, y: Floats, words: NDArray[np.str_]) -> list[Any]:
    """Colour the points of a curve by their statuses; return legend entries."""
    handles = []
    for word, colour in _colours_of(words).items():
        mask = (words == word) & np.isfinite(y)
        if not mask.any():
            continue
        handles += axes.plot(x[mask], y[mask], "o", ms=3.0, color=colour, label=tr(word), zorder=3)
    return handles


def _shades(count: int) -> list[Any]:
    """Return colours in order, or one for a single curve."""
    if count == 1:
        return [style.BLUE]
    import matplotlib as mpl

    return list(mpl.colormaps["viridis"](np.linspace(0.0, 0.88, count)))


def _finish(figure: Figure, axes: Axes, title: list[str], handles: list[Any]) -> None:
    """Put the title above and the legend below the panel, where it hides nothing.

    Curves of one kind look the same: they share an entry.
    """
    axes.set_title("\n".join(title), fontsize=style.SMALL, loc="left")
    handles = list({str(handle.get_label()): handle for handle in handles}.values())
    if handles:
        columns = min(
            len(handles),
            max(
                1, math.floor(90 / (6 + max(len(plain_text(str(h.get_label()))) for h in handles)))
            ),
        )
        figure.legend(handles=handles, loc="outside lower center", ncols=columns)
