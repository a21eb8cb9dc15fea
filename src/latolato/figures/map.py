"""The picture of a sweep: a heat map over two parameters, or curves over one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import overlays as marks
from latolato.figures import style
from latolato.numerics.records import EVENT_LIMIT, STATUS_NAMES
from latolato.quantities import QUANTITIES
from latolato.registry import suggest

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from latolato.sweep.plan import Plan

    Floats = NDArray[np.float64]

# What the values of a variable mean, with colours that keep their order in grey print.
CLASSES: dict[str, dict[str, str]] = {
    "motion_class": {"none": style.PALE_BLUE, "weak": style.ORANGE, "strong": style.RED},
    "self_start": {"stays": style.PALE_BLUE, "starts": style.RED},
    "status": dict(
        zip(
            (name.replace("_", " ") for name in STATUS_NAMES),
            (style.PALE_BLUE, style.ORANGE, style.BLUE, style.RED, style.INK, style.GREEN),
            strict=True,
        )
    ),
}
NO_ANSWER = style.GREY
NOT_YET = "#c9cdd3"
ZERO = style.PAPER
_HEIGHT = 3.6  # inch
# More curves than this cannot be told apart.
_MOST_CURVES = 12
# Parameters that the line above the picture tells.
_TOLD = (
    *("length", "mass", "radius", "restitution", "damping", "quadratic_damping"),
    *("coulomb_damping", "initial_angle", "initial_offset", "drive_amplitude", "frequency_ratio"),
    *("drive_frequency", "duration", "transient"),
)
# Parameters of observables, which the line tells with these only.
_OF_VARIABLE = {
    "crossings": ("crossing_angle",),
    "motion_class": ("strong_angle", "weak_angle"),
    "self_start": ("least_motion",),
}
# How closely a spacing must keep its ratio or its difference to count as even.
_EVEN = 1e-6


@dataclass(frozen=True)
class Side:
    """One axis of a picture: its dimension, the coordinate that labels it, cells and scale."""

    dim: str
    values: Floats
    attributes: Mapping[str, Any]
    name: str
    is_log: bool

    @property
    def label(self) -> str:
        """The axis label."""
        import xarray as xr

        return style.label(xr.DataArray(self.values, attrs=dict(self.attributes))) or self.name

    @property
    def edges(self) -> Floats:
        """Borders of the cells, midway between values; of amounts, never below zero."""
        values = np.log(self.values) if self.is_log else self.values
        if len(values) == 1:
            half = 0.5 if self.is_log else 0.5 * abs(values[0]) or 0.5
            found = np.array([values[0] - half, values[0] + half])
        else:
            middle = 0.5 * (values[1:] + values[:-1])
            first, last = 2.0 * values[0] - middle[0], 2.0 * values[-1] - middle[-1]
            found = np.concatenate([[first], middle, [last]])
        if self.is_log:
            return np.asarray(np.exp(found))
        return np.maximum(found, 0.0) if values[0] >= 0.0 else found


def plot_map(
    grid: xr.Dataset,
    variable: str | None = None,
    *,
    log: bool = False,
    curves: bool = False,
    select: Mapping[str, Any] | None = None,
    overlays: Sequence[str] = (),
    points: str | Path | None = None,
) -> Figure:
    """Return a figure of one variable of a sweep over one or two parameters.

    Parameters
    ----------
    grid : xarray.Dataset
        What `latolato.sweep` or `latolato.load` returned.
    variable : str, optional
        What to draw; by default the first.
    log : bool
        A logarithmic scale of the values. Zeros get a colour of their own.
    curves : bool
        Draw a curve for each value of the shorter of two dimensions, at most 12, not a map.
    select : mapping, optional
        Values of further dimensions, such as ``{"restitution": 0.9}``; the nearest one is taken
        and told. A dimension without numbers takes its text or its index.
    overlays : sequence of {"tongue", "lift_off"}
        Curves over a map of amplitude and frequency: the edges of the primary tongue of eq14 with
        the sweep's linear damping, and where the pivot's acceleration reaches gravity.
    points : str or Path, optional
        A CSV of trials with the columns `drive_amplitude`, `drive_frequency` or
        `frequency_ratio`, and `class` (none, weak or strong).

    Raises
    ------
    ValueError
        For unknown names, too many dimensions left, overlays that the axes cannot carry.

    Notes
    -----
    A cell reaches halfway to its neighbours. Points without an answer are grey and counted in the
    legend, by status; they never look like a value.
    """
    variable = _variable(list(map(str, grid.data_vars)), variable)
    grid, told = _selected(grid, variable, select or {})
    rest = _ordered(list(map(str, grid[variable].dims)))
    _check_dims({d: grid.sizes[d] for d in rest}, variable)
    sides = [_side(grid, dim) for dim in rest]
    for side in sides:
        order = np.argsort(_side_values(grid, side.dim), kind="stable")
        grid = grid.isel({side.dim: order})
    data = grid[variable].transpose(*rest)
    if not (overlays or points):
        context = None
    elif len(sides) != 2 or curves:
        raise ValueError("overlays and points belong to a map of amplitude and frequency")
    else:
        context = marks.Context.of(grid, sides[1].name, sides[0].name)
    drawn = _Drawing(grid, data, sides, log, told)
    if len(sides) == 1 or curves:
        return drawn.curves()
    return drawn.map(context, overlays, points)


def check_drawable(plan: Plan, variable: str | None) -> None:
    """Raise ValueError unless the sweep of a plan can be drawn without selecting anything."""
    from latolato.sweep.results import dims_of, lengths_of, template

    name = _variable(list(template(plan)), variable)
    lengths = lengths_of(plan)
    _check_dims({dim: lengths[dim] for dim in dims_of(plan, name)}, name)


def _variable(known: list[str], name: str | None) -> str:
    """Return the variable that is asked for, or the first."""
    if name is None:
        return known[0]
    if name not in known:
        raise ValueError(f"unknown variable '{name}': {suggest(name, known)}")
    return name


def _check_dims(lengths: Mapping[str, int], variable: str) -> None:
    """Raise ValueError unless one or two dimensions are left."""
    if len(lengths) > 2:
        shown = ", ".join(f"{dim} ({length})" for dim, length in lengths.items())
        raise ValueError(
            f"{variable} varies over {shown}; a picture shows two of them: select a value of the "
            f"others, as in `latolato plot FILE --select {next(iter(lengths))}=VALUE`"
        )
    if not lengths:
        raise ValueError(f"{variable} is a single value: select fewer dimensions")


def _ordered(dims: list[str]) -> list[str]:
    """Return dimensions with a frequency last, for it goes to the right."""
    return sorted(dims, key=lambda dim: dim in marks.FREQUENCIES)


def _selected(
    grid: xr.Dataset, variable: str, select: Mapping[str, Any]
) -> tuple[xr.Dataset, dict[str, str]]:
    """Return the part of a dataset at given values, and these in words."""
    told: dict[str, str] = {}
    for name, wanted in select.items():
        known = list(map(str, grid[variable].dims))
        if name not in known:
            raise ValueError(f"{variable} has no dimension '{name}': {suggest(name, known)}")
        coordinate = grid[name].values
        if coordinate.dtype.kind == "U":
            if wanted not in coordinate:
                raise ValueError(f"{name} must be one of {', '.join(coordinate)}, got {wanted!r}")
            index = int(np.flatnonzero(coordinate == wanted)[0])
        elif name not in grid.coords:
            index = int(wanted)
            if not 0 <= index < grid.sizes[name]:
                raise ValueError(f"{name} is an index below {grid.sizes[name]}, got {wanted!r}")
        else:
            index = _nearest(name, coordinate, float(wanted))
        grid = grid.isel({name: index})
        if name in grid.coords and coordinate.dtype.kind != "U":
            told[name] = _told(grid, name, float(grid[name]))
        else:
            told[name] = f"{name} {wanted}"
    return grid, told


def _nearest(name: str, values: Floats, wanted: float) -> int:
    """Return the index of the nearest value; half a spacing beyond the ends is too far."""
    ordered = np.sort(values)
    slack = 0.5 * float(np.max(np.diff(ordered), initial=0.0)) + 1e-9 * float(np.abs(ordered).max())
    if not ordered[0] - slack <= wanted <= ordered[-1] + slack:
        raise ValueError(
            f"{name} runs from {ordered[0]:g} to {ordered[-1]:g} here, got {wanted:g}; select a "
            "value in between"
        )
    return int(np.argmin(np.abs(values - wanted)))


def _side_values(grid: xr.Dataset, dim: str) -> Floats:
    """Return the numbers along a dimension: its own, those of its first parameter, or 0, 1, ..."""
    values: Floats = grid[_label_of(grid, dim)].values
    return values if values.dtype.kind in "iuf" else np.arange(float(len(values)))


def _label_of(grid: xr.Dataset, dim: str) -> str:
    """Return the coordinate that labels a dimension."""
    if dim in grid.coords:
        return dim
    own = [str(name) for name, c in grid.coords.items() if c.dims == (dim,)]
    usable = [name for name in own if len(np.unique(grid[name].values)) == grid.sizes[dim]]
    return usable[0] if usable else dim


def _side(grid: xr.Dataset, dim: str) -> Side:
    """Return an axis of the picture."""
    name = _label_of(grid, dim)
    values = np.sort(np.asarray(_side_values(grid, dim), dtype=np.float64))
    is_log = False
    if len(values) > 2 and values[0] > 0.0:
        steps, ratios = np.diff(values), values[1:] / values[:-1]
        is_log = bool(np.ptp(ratios) < _EVEN * ratios[0] and np.ptp(steps) > _EVEN * steps[0])
    about = grid[name].attrs if name in grid.coords else {}
    others = [str(n) for n, c in grid.coords.items() if c.dims == (dim,) and n != name]
    if others:
        long_name = f"{about.get('long_name', name)} (and {', '.join(others)})"
        about = {**about, "long_name": long_name}
    return Side(dim, values, about, name, is_log)


def _told(grid: xr.Dataset, name: str, value: float) -> str:
    """Return a parameter and its value as ``$e$ = 0.9``."""
    quantity = QUANTITIES.get(name)
    about = grid[name].attrs if name in grid.coords else {}
    symbol = about.get("symbol") or (quantity.symbol if quantity else "")
    unit = about.get("units") or (quantity.unit if quantity else "1")
    if name in {"strong_angle", "weak_angle", "least_motion"}:
        name, unit, value = name.replace("_", " "), "deg", math.degrees(value)
    if name == "transient":
        unit = "s"
    shown = f"{value:.4g}"
    if "e" in shown:
        digits, _, power = shown.partition("e")
        shown = rf"${digits}\times10^{{{int(power)}}}$"
    tail = "" if unit == "1" else "°" if unit == "deg" else f" {style.pretty_unit(unit)}"
    return f"{f'${symbol}$' if symbol else name} = {shown}{tail}"


class _Drawing:
    """One picture while it is made."""

    def __init__(
        self,
        grid: xr.Dataset,
        data: xr.DataArray,
        sides: list[Side],
        log: bool,
        told: Mapping[str, str],
    ) -> None:
        self.data, self.sides, self.log = data, sides, log
        self.values = np.array(data.values, dtype=np.float64)
        self.name = str(data.name)
        self.title = _title(grid, told, _OF_VARIABLE.get(self.name, ()))
        status = grid.get("status")
        if status is not None and set(status.dims) <= set(data.dims):
            self.status = status.broadcast_like(data).transpose(*data.dims).values
        else:
            self.status = np.zeros(data.shape, dtype=np.int8)
        self.classes = CLASSES.get(self.name, {})
        if self.name == "status":
            self.values[self.status < 0] = np.nan
        else:
            self.values[(self.status < 0) | (self.status >= EVENT_LIMIT)] = np.nan
        if self.classes:
            self.values = np.round(self.values)
        if log and self.classes:
            raise ValueError(f"{self.name} has classes, not a scale: leave out log")
        if log and np.nanmin(self.values, initial=0.0) < 0.0:
            raise ValueError(
                f"{self.name} goes down to {np.nanmin(self.values):g}: a log scale cannot show "
                "negative values; leave out log"
            )

    @property
    def limits(self) -> tuple[float, float]:
        """Ends of the colour scale."""
        usable = self.values[np.isfinite(self.values) & ((self.values > 0.0) | (not self.log))]
        if not usable.size:
            return (0.1, 1.0) if self.log else (0.0, 1.0)
        low, high = float(usable.min()), float(usable.max())
        if low == high:
            return (low / 2.0, high * 2.0) if self.log else (low - 0.5, high + 0.5)
        return low, high

    def map(
        self, context: marks.Context | None, overlays: Sequence[str], points: str | Path | None
    ) -> Figure:
        """Return the heat map."""
        with style.use_style():
            figure, panels = style.new_figure(width=0.75 * style.PAGE, height=_HEIGHT + 0.5)
            axes = panels[0, 0]
            self._draw_cells(axes)
            handles = self._legend_of_cells()
            for side, axis in zip(self.sides, ("y", "x"), strict=True):
                getattr(axes, f"set_{axis}label")(side.label)
                if side.is_log:
                    getattr(axes, f"set_{axis}scale")("log")
                edges = side.edges
                getattr(axes, f"set_{axis}lim")(float(edges[0]), float(edges[-1]))
            if context is not None:
                for name in overlays:
                    handles.append(marks.draw(axes, context, name))
                if points is not None:
                    handles += marks.draw_points(axes, context, points)
            _finish(figure, axes, self.title, handles)
            figure.draw_without_rendering()
            return figure

    def _draw_cells(self, axes: Axes) -> None:
        """Draw the cells and their colour bar."""
        from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize

        y, x = self.sides
        shown = np.ma.masked_invalid(self.values)
        low, high = self.limits
        if self.classes:
            colours: Any = ListedColormap(list(self.classes.values()))
            norm: Any = BoundaryNorm(np.arange(len(self.classes) + 1) - 0.5, len(self.classes))
        else:
            import matplotlib as mpl

            colours = mpl.colormaps["viridis"]
            norm = LogNorm(low, high) if self.log else Normalize(low, high)
        if self.log:
            shown = np.ma.masked_less_equal(shown, 0.0)
        options: dict[str, Any] = {"shading": "flat", "rasterized": True}
        cells = axes.pcolormesh(x.edges, y.edges, shown, cmap=colours, norm=norm, **options)
        for mask, colour in self._special():
            if mask.any():
                patch = np.ma.masked_array(np.zeros(mask.shape), ~mask)
                only: Any = ListedColormap([colour])
                axes.pcolormesh(x.edges, y.edges, patch, cmap=only, **options)
        if not self.classes:
            figure = axes.get_figure(root=True)
            assert figure is not None
            bar = figure.colorbar(cells, ax=axes, pad=0.02, aspect=28)
            bar.set_label(style.label(self.data))
            bar.outline.set_visible(False)
        for spine in axes.spines.values():
            spine.set_visible(True)

    def _special(self) -> list[tuple[Any, str]]:
        """Return the cells that have a colour of their own, and it."""
        nothing = np.isnan(self.values)
        found = [(nothing & (self.status >= 0), NO_ANSWER), (nothing & (self.status < 0), NOT_YET)]
        return [*found, (self.values == 0.0, ZERO)] if self.log else found

    def _legend_of_cells(self) -> list[Any]:
        """Return legend entries for classes and for cells without a value."""
        from matplotlib.patches import Patch

        def patch(colour: str, text: str) -> Any:
            return Patch(facecolor=colour, edgecolor=style.INK, linewidth=style.THIN, label=text)

        found = []
        for number, (text, colour) in enumerate(self.classes.items()):
            if self.name != "status" or (self.values == number).any():
                found.append(patch(colour, text))
        nothing = np.isnan(self.values)
        late, lost = nothing & (self.status < 0), nothing & (self.status >= 0)
        if lost.any():
            counts = [
                (int((lost & (self.status == number)).sum()), name.replace("_", " "))
                for number, name in enumerate(STATUS_NAMES)
            ]
            shown = ", ".join(
                f"{n} {name if number >= EVENT_LIMIT else 'without value'}"
                for number, (n, name) in enumerate(counts)
                if n
            )
            found.append(patch(NO_ANSWER, f"no answer ({shown})"))
        if late.any():
            found.append(patch(NOT_YET, f"not computed yet ({int(late.sum())})"))
        if self.log and (self.values == 0.0).any():
            found.append(patch(ZERO, "zero"))
        return found

    def curves(self) -> Figure:
        """Return curves over the longer dimension."""
        values, sides = self.values, self.sides
        if len(sides) == 1:
            values, sides = values[None], [sides[0], sides[0]]
        elif len(sides[0].values) > len(sides[1].values):
            values, sides = values.T, sides[::-1]
        if len(values) > _MOST_CURVES:
            raise ValueError(
                f"{len(values)} curves cannot be told apart, at most {_MOST_CURVES}: leave out "
                "curves for a map, or select a value"
            )
        with style.use_style():
            figure, panels = style.new_figure(width=0.75 * style.PAGE, height=_HEIGHT)
            axes = panels[0, 0]
            along = sides[1]
            few = len(along.values) <= 60
            colours = _shades(len(values))
            handles = []
            for i, row in enumerate(values):
                name = ""
                if len(values) > 1:
                    unit = str(sides[0].attributes.get("units", "1"))
                    symbol = sides[0].attributes.get("symbol", "")
                    tail = "" if unit == "1" else f" {style.pretty_unit(unit)}"
                    head = f"${symbol}$" if symbol else sides[0].name
                    name = f"{head} = {sides[0].values[i]:.4g}{tail}"
                (line,) = axes.plot(
                    along.values,
                    row,
                    color=colours[i],
                    lw=style.LINE,
                    marker="o" if few else "",
                    ms=2.5,
                    label=name,
                )
                handles += [line] if name else []
            missing = int(np.isnan(values).sum())
            if missing:
                self._mark_missing(axes, along, values, handles, missing)
            if along.is_log:
                axes.set_xscale("log")
            if self.log:
                axes.set_yscale("log")
            axes.set_xlim(float(along.values[0]), float(along.values[-1]))
            axes.set_xlabel(along.label)
            axes.set_ylabel(style.label(self.data))
            if self.classes:
                axes.set_yticks(range(len(self.classes)), list(self.classes))
            _finish(figure, axes, self.title, handles)
            figure.draw_without_rendering()
            return figure

    def _mark_missing(
        self, axes: Axes, along: Side, values: Floats, handles: list[Any], missing: int
    ) -> None:
        """Mark where curves have no value by ticks at the bottom."""
        where = np.flatnonzero(np.isnan(values).any(axis=0))
        (ticks,) = axes.plot(
            along.values[where],
            np.zeros(len(where)),
            transform=axes.get_xaxis_transform(),
            color=NO_ANSWER,
            marker="|",
            ms=8,
            ls="",
            clip_on=False,
            label=f"no answer ({missing})",
        )
        handles.append(ticks)


def _shades(count: int) -> list[Any]:
    """Return colours in order, or one for a single curve."""
    if count == 1:
        return [style.BLUE]
    import matplotlib as mpl

    return list(mpl.colormaps["viridis"](np.linspace(0.0, 0.88, count)))


def _title(grid: xr.Dataset, told: Mapping[str, str], further: Sequence[str]) -> list[str]:
    """Return what the picture is of, in lines: system and parameters that do not vary."""
    attributes = grid.attrs
    varied = {str(name) for name, c in grid.coords.items() if c.dims}
    words = [f"{attributes.get('system', 'sweep')}"]
    targets = {"drive_amplitude": marks.AMPLITUDES, "drive_frequency": marks.FREQUENCIES}
    named = []
    for name in (*_TOLD, *further):
        value = attributes.get(name)
        if not isinstance(value, (int, float)) or name in told or name in varied:
            continue
        if varied & set(targets.get(name, ())) or set(told) & set(targets.get(name, ())):
            continue
        if value == 0.0 and name not in ("damping", "initial_offset"):
            continue
        named.append(_told(grid, name, float(value)))
    if attributes.get("contact") == "clamp":
        words.append("a fixed-step artefact")
    if attributes.get("continuation"):
        words.append(f"following {attributes['continuation']}")
    first = ", ".join([*words, *told.values()])
    lines, line = [], first
    for word in named:
        if len(_plain_text(line)) + len(_plain_text(word)) > 84:
            lines.append(line)
            line = word
        else:
            line = f"{line}, {word}"
    return [*lines, line]


def _plain_text(text: str) -> str:
    """Return roughly what mathematics looks like, to measure its length."""
    return text.replace("$", "").replace("\\", "").replace("{", "").replace("}", "")


def _finish(figure: Figure, axes: Axes, title: list[str], handles: list[Any]) -> None:
    """Put the title above and the legend below the panel, where it hides nothing."""
    axes.set_title("\n".join(title), fontsize=style.SMALL, loc="left")
    if handles:
        columns = min(
            len(handles),
            max(
                1, math.floor(90 / (6 + max(len(_plain_text(str(h.get_label()))) for h in handles)))
            ),
        )
        figure.legend(handles=handles, loc="outside lower center", ncols=columns)
