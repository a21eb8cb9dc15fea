"""What is drawn over a map of amplitude and frequency: theory curves and measured trials."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.language import tr
from latolato.core.parameters import law_parameters
from latolato.core.registry import first_difference, suggest
from latolato.core.rules import broken_rule
from latolato.experiment.trial_table import read_trials
from latolato.figures import style
from latolato.figures.analyses.stored_system import drive_of, system_of
from latolato.physics.pendulum import Pendulum
from latolato.simulation.vary import DERIVED

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

OVERLAYS = ("tongue", "lift_off")
AMPLITUDES = ("drive_amplitude", "amplitude_ratio", "drive_acceleration_ratio")
FREQUENCIES = ("drive_frequency", "frequency_ratio")
# Marker of the classes of trials (Paper: as in Fig. 9), with the colours of a map of classes.
TRIALS = {
    "none": ("o", style.PALE_BLUE),
    "weak": ("^", style.ORANGE),
    "strong": ("D", style.RED),
}
# The tongue has no upper frequency beyond this amplitude, and none at all beyond the second.
_OPEN_ENDED, _CLOSED = 0.454, 3.8  # lengths
_SAMPLES = 400


@dataclass(frozen=True)
class Context:
    """The axes of a map and the parameters that turn amplitudes and frequencies into them.

    Attributes
    ----------
    x, y : str
        Names of the parameters to the right and upwards.
    """

    x: str
    y: str
    length: float
    mass: float
    damping: float
    gravity: float
    has_walls: bool
    other_drag: bool

    @classmethod
    def of(cls, grid: xr.Dataset, x: str, y: str) -> Context:
        """Return the context of a map; raise InputError if it is not of amplitude and frequency."""
        if not ((x in FREQUENCIES and y in AMPLITUDES) or (y in FREQUENCIES and x in AMPLITUDES)):
            names = {"amplitudes": ", ".join(AMPLITUDES), "frequencies": ", ".join(FREQUENCIES)}
            raise broken_rule("overlay_axes", names, value=[y, x])
        side = "right_" if "right_length" in {*grid.attrs, *grid.coords} else ""
        if grid.attrs.get("drag_frame") == "lab" and _number(grid, side + "damping") > 0.0:
            raise broken_rule("overlay_drag", parameter="drag_frame", value="lab")
        drags = [_number(grid, side + n) for n in ("quadratic_damping", "coulomb_damping")]
        return cls(
            x=x,
            y=y,
            length=_number(grid, side + "length"),
            mass=_number(grid, side + "mass"),
            damping=_number(grid, side + "damping"),
            gravity=_number(grid, "gravity"),
            has_walls=grid.attrs.get("contact", "none") != "none",
            other_drag=any(drags),
        )

    @property
    def natural_frequency(self) -> float:
        """w0 [rad/s]."""
        return math.sqrt(self.gravity / self.length)

    def place(self, amplitude: Any, frequency: Any) -> tuple[Any, Any]:
        """Return the coordinates (x, y) of amplitudes [m] at frequencies [rad/s]."""
        along = {
            "drive_amplitude": amplitude,
            "amplitude_ratio": amplitude / self.length,
            "drive_acceleration_ratio": amplitude * frequency**2 / self.gravity,
            "drive_frequency": frequency,
            "frequency_ratio": frequency / self.natural_frequency,
        }
        return along[self.x], along[self.y]

    def plain(self, curve: xr.Dataset) -> tuple[Any, Any]:
        """Return amplitudes [m] and frequencies [rad/s] along a curve over x and y."""
        given = {name: curve[name].values for name in (self.x, self.y)}
        if "drive_frequency" in given:
            frequency = given["drive_frequency"]
        else:
            frequency = given["frequency_ratio"] * self.natural_frequency
        if "drive_amplitude" in given:
            return given["drive_amplitude"], frequency
        if "amplitude_ratio" in given:
            return given["amplitude_ratio"] * self.length, frequency
        return given["drive_acceleration_ratio"] * self.gravity / frequency**2, frequency


def _number(grid: xr.Dataset, name: str) -> float:
    """Return a parameter that does not vary over the picture."""
    if name in grid.coords:
        if grid[name].ndim:
            raise InputError(
                "overlays need one {parameter}, but it varies",
                parameter=name,
                way_out="select a value",
            )
        return float(grid[name])
    if name not in grid.attrs:
        raise broken_rule("overlay_parameter", parameter=name)
    return float(grid.attrs[name])


def draw_curve(axes: Axes, grid: xr.Dataset, sides: tuple[str, str], curve: xr.Dataset) -> Any:
    """Draw a curve of bifurcations over a map, and return the entries of the legend.

    Parameters
    ----------
    sides : pair of str
        What the map varies to the right and upwards.

    Raises
    ------
    InputError
        If it is no such curve, of another system, or over other parameters.
    """
    from matplotlib.patheffects import Normal, Stroke

    from latolato.figures.analyses.bifurcation_curve import draw_over

    if getattr(curve, "attrs", {}).get("analysis") != "bifurcation_curve":
        raise InputError(
            "must be 'tongue', 'lift_off' or a result of bifurcation_curve", parameter="overlays"
        )
    x, y = places_of(grid, sides, curve)
    limits = axes.get_xlim(), axes.get_ylim()
    ground = [Stroke(linewidth=3.5, foreground=style.PAPER), Normal()]
    handles = draw_over(axes, curve, x, y, path_effects=ground)
    axes.set_xlim(limits[0])
    axes.set_ylim(limits[1])
    return handles


def places_of(grid: xr.Dataset, sides: tuple[str, str], curve: xr.Dataset) -> tuple[Any, Any]:
    """Return the points of a curve of bifurcations in the coordinates of a map.

    Raises
    ------
    InputError
        If the curve is of another system than the map, or over other parameters.
    """
    _check_same(grid, sides, curve)
    own = [str(name) for name in curve.attrs["parameters"]]
    if {*sides} == {*own}:
        return curve[sides[0]].values, curve[sides[1]].values
    # Both are of amplitude and frequency, in other units.
    plain = Context.of(curve, *own).plain(curve)
    return Context.of(grid, *sides).place(*plain)


def _check_same(grid: xr.Dataset, sides: tuple[str, str], curve: xr.Dataset) -> None:
    """Raise InputError if a curve is of another system than a map."""
    varied = {*sides, *map(str, curve.attrs["parameters"])}
    varied |= {DERIVED.get(name, name) for name in varied}
    # The phase of the drive turns motions, and bifurcations with them.
    system = system_of(curve)
    laws = [(system, "system"), (drive_of(curve), "drive")]
    usual = {p.name: p.default for law, owner in laws for p in law_parameters(law, owner)}
    usual |= {"system": None, "drive": None}
    if system.has_contacts:
        usual["contact"] = "none"
    kinds = ("system", "drive")
    names = [*kinds, *sorted(usual.keys() - varied - {*kinds, "drive_phase"})]
    scalars = {str(name): c.item() for name, c in grid.coords.items() if not c.ndim}
    here, there = {**usual, **grid.attrs, **scalars}, {**usual, **curve.attrs}
    name = first_difference(names, here, there)
    if name is not None:
        values = {"name": name, "there": _said(there[name]), "here": _said(here[name])}
        raise broken_rule("other_system", values)


def _said(value: Any) -> str:
    """Return a value of a parameter as a text."""
    return f"{value:.9g}" if isinstance(value, (int, float)) else str(value)


def draw(axes: Axes, context: Context, name: str) -> Any:
    """Draw the overlay of that name and return its legend entry."""
    name = name.replace("-", "_")
    x, y = curve(context, name, axes.get_xlim(), axes.get_ylim())
    if name == "tongue":
        text = tr(
            "Mathieu tongue (theory), linear drag only"
            if context.other_drag
            else "Mathieu tongue (theory)"
        )
        return _line(axes, x, y, text, (0, ()))
    text = tr("lift-off from rest")
    return _line(axes, x, y, rf"{text} ($A_0\omega^2 = g$)", (0, (4, 2)))


def curve(
    context: Context, name: str, x_limits: tuple[float, float], y_limits: tuple[float, float]
) -> tuple[Floats, Floats]:
    """Return the curve of an overlay in the coordinates of a map with these limits.

    ``tongue`` is both edges of the primary Mathieu tongue, ``lift_off`` where the pivot's largest
    acceleration equals gravity.

    Raises
    ------
    InputError
        For an unknown name, and for lift-off without contact.
    """
    if name == "tongue":
        _, large, *_ = _limits(context, x_limits, y_limits)
        amplitudes, low, high = tongue(context, large)
        both = np.concatenate([amplitudes[::-1], amplitudes])
        x, y = context.place(both, np.concatenate([low[::-1], high]))
    elif name == "lift_off":
        if not context.has_walls:
            raise broken_rule("lift_off")
        _, _, slow, fast = _limits(context, x_limits, y_limits)
        slow = max(slow, 1e-3 * fast)
        # Even also along a logarithmic axis.
        even = [np.linspace(slow, fast, _SAMPLES), np.geomspace(slow, fast, _SAMPLES)]
        frequency = np.sort(np.concatenate(even))
        x, y = context.place(context.gravity / frequency**2, frequency)
    else:
        raise InputError(f"unknown overlay '{name}': {suggest(name, list(OVERLAYS))}")
    shape = np.broadcast_shapes(np.shape(x), np.shape(y))
    return np.broadcast_to(x, shape), np.broadcast_to(y, shape)


def _limits(
    context: Context, x_limits: tuple[float, float], y_limits: tuple[float, float]
) -> tuple[float, float, float, float]:
    """Return the amplitudes [m] and frequencies [rad/s] that a map spans."""
    spans = {context.x: x_limits, context.y: y_limits}
    name = context.x if context.x in FREQUENCIES else context.y
    slow, fast = spans[name]
    if name == "frequency_ratio":
        slow, fast = (each * context.natural_frequency for each in (slow, fast))
    name = context.y if context.y in AMPLITUDES else context.x
    small, large = spans[name]
    if name == "amplitude_ratio":
        small, large = small * context.length, large * context.length
    elif name == "drive_acceleration_ratio":
        factor = context.gravity / max(slow, 1e-3 * fast) ** 2
        small, large = 0.0, large * factor
    return small, large, slow, fast


def tongue(context: Context, largest: float) -> tuple[Floats, Floats, Floats]:
    """Return amplitudes [m] and the lower and upper edge of the primary tongue there [rad/s].

    The first row is the tip, where both edges meet; an upper edge of infinity is left out as NaN.
    """
    from latolato.analysis import linear

    problem = linear.linearised(
        Pendulum(
            length=context.length,
            mass=context.mass,
            damping=context.damping,
            gravity=context.gravity,
        ),
        None,
    )
    linear.check_oscillates(problem)

    def edges(amplitude: float) -> tuple[float, float]:
        return linear.tongue(problem, amplitude, 1, "determinant")

    largest = min(largest, _CLOSED * context.length)
    closed, opened = 0.0, largest
    if math.isnan(edges(opened)[0]):
        return (np.array([]),) * 3
    if context.damping > 0.0:
        for _ in range(50):
            middle = 0.5 * (closed + opened)
            closed, opened = (middle, opened) if math.isnan(edges(middle)[0]) else (closed, middle)
    else:
        opened = 0.0
    # Denser near the tip, where a damped tongue is round.
    amplitudes = opened + (largest - opened) * np.linspace(0.0, 1.0, _SAMPLES) ** 2
    frequencies = np.array([edges(float(a)) for a in amplitudes]) * context.natural_frequency
    frequencies[~np.isfinite(frequencies)] = np.nan
    return amplitudes, frequencies[:, 0], frequencies[:, 1]


def _line(axes: Axes, x: Any, y: Any, text: str, dashes: Any) -> Any:
    """Draw a curve that shows on dark and on light cells, without moving the limits."""
    from matplotlib.patheffects import Normal, Stroke

    limits = axes.get_xlim(), axes.get_ylim()
    ground = Stroke(linewidth=3.0, foreground=style.INK)
    solid = ground if not dashes[1] else Stroke(linewidth=3.0, foreground=style.INK, alpha=0.9)
    (line,) = axes.plot(
        x,
        y,
        color=style.PAPER,
        lw=1.5,
        ls=dashes,
        label=text,
        path_effects=[solid, Normal()],
        solid_capstyle="butt",
        dash_capstyle="butt",
    )
    axes.set_xlim(limits[0])
    axes.set_ylim(limits[1])
    return line


def draw_points(axes: Axes, context: Context, path: str | Path) -> list[Any]:
    """Draw the trials of a file and return their legend entries."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    trials = read_trials(path)
    plain = trials["drive_frequency"].values
    # On an axis of ratios: in natural frequencies of the measured toy where they are known.
    by_ratio = trials["frequency_ratio"].values * context.natural_frequency
    is_plain = "drive_frequency" in (context.x, context.y)
    first, second = (plain, by_ratio) if is_plain else (by_ratio, plain)
    frequency = np.where(np.isfinite(first), first, second)
    handles = []
    for name, (marker, colour) in TRIALS.items():
        chosen = trials["class"].values == name
        count = int(chosen.sum())
        if not count:
            continue
        x, y = context.place(trials["drive_amplitude"].values[chosen], frequency[chosen])
        outside = int(np.sum((x < left) | (x > right) | (y < bottom) | (y > top)))
        text = tr("trial, {kind}", kind=tr(name))
        if outside:
            text = tr(
                "{trial} ({outside} of {count} outside)", trial=text, outside=outside, count=count
            )
        handles.append(
            axes.scatter(
                x,
                y,
                s=26.0,
                marker=marker,
                color=colour,
                edgecolors=style.INK,
                linewidths=0.9,
                zorder=4,
                label=text,
            )
        )
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    return handles
