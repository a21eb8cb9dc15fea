"""What a map may be made of: axes with ranges to begin with, and observables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.app.forms import units_of
from latolato.app.given import options_of
from latolato.core.errors import InputError
from latolato.core.parameters import Parameter
from latolato.core.quantities import ANY, Range
from latolato.core.registry import checked_number, suggest
from latolato.figures.sides import is_geometric
from latolato.observables import Observable, observables
from latolato.physics.drives import Drive, Harmonic
from latolato.scenario.options import law_options
from latolato.scenario.scenario import Scenario
from latolato.sweeps.axes import DERIVED
from latolato.sweeps.plan import DEFAULT_OBSERVABLES, checked_observable

# A logarithmic axis begins at this share of its end where nothing else is known.
_LOG_SPAN = 0.01


@dataclass(frozen=True)
class Span:
    """One axis: the parameter that varies along it and its first and last value [SI].

    An end of NaN stands for that of the range to begin with, an empty name for the parameter to
    begin with; `log` is None for the spacing to begin with.
    """

    name: str
    low: float
    high: float
    log: bool | None = None

    @classmethod
    def from_json(cls, which: str, value: Any) -> Span:
        """Return an axis, or raise InputError."""
        own = set(value) - {"log"} if isinstance(value, Mapping) else set()
        if not isinstance(value, Mapping) or own - {"name", "low", "high"}:
            raise InputError(f"{which} must be an object with name, low and high, got {value!r}")
        name, log = value.get("name", ""), value.get("log")
        if not isinstance(name, str):
            raise InputError(f"the name of {which} must be a text, got {name!r}")
        if log is not None and not isinstance(log, bool):
            raise InputError(f"log of {which} must be true or false, got {log!r}")
        low, high = (
            checked_number(f"{k} of {which}", value[k], ANY, "SI") if k in value else math.nan
            for k in ("low", "high")
        )
        return cls(name, low, high, log)

    @property
    def is_open(self) -> bool:
        """Whether an end is that of the range to begin with."""
        return math.isnan(self.low) or math.isnan(self.high)

    def values(self, count: int) -> NDArray[np.float64]:
        """Return the values at the middles of the cells, both ends included."""
        if count == 1:
            return np.array([self.low])
        make = np.geomspace if self.log else np.linspace
        return np.asarray(make(self.low, self.high, count))


def moving_drive(scenario: Scenario) -> Drive:
    """Return the drive; of a sweep over drives, the one in the middle; else a gentle one."""
    if scenario.drive.moves:
        return scenario.drive
    amplitude, ratio = 0.1 * scenario.system.balls[0].length, 2.0
    axes = scenario.varied.get("axes", {})
    if isinstance(axes.get("drive_amplitude"), tuple):
        amplitude = 0.5 * (min(axes["drive_amplitude"]) + max(axes["drive_amplitude"]))
    if isinstance(axes.get("frequency_ratio"), tuple):
        ratio = 0.5 * (min(axes["frequency_ratio"]) + max(axes["frequency_ratio"]))
    return Harmonic(
        drive_amplitude=amplitude, drive_frequency=ratio * scenario.system.natural_frequency
    )


def spans_of(
    known: Mapping[str, Parameter], scenario: Scenario, asked: tuple[Span | None, Span | None]
) -> tuple[Span, Span]:
    """Return both axes: those asked for, those of a sweep, or amplitude over frequency."""
    usual: list[Span] = []
    for name, values in scenario.varied.get("axes", {}).items():
        if isinstance(values, Mapping) or name not in known or len(usual) == 2:
            continue
        usual.append(_span(name, known, scenario))
    names = ("drive_amplitude", "frequency_ratio", "initial_angle", "initial_angular_velocity")
    for name in (*names, *known):
        taken = {DERIVED.get(s.name, s.name) for s in usual}
        if len(usual) < 2 and name in known and DERIVED.get(name, name) not in taken:
            usual.append(_span(name, known, scenario))
    y, x = sorted(usual, key=lambda s: s.name in ("frequency_ratio", "drive_frequency"))
    chosen = []
    for span, own in zip(asked, (x, y), strict=True):
        if span is not None and not span.name:
            span = replace(span, name=own.name)
        if span is not None and span.name not in known:
            raise InputError(f"unknown parameter '{span.name}': {suggest(span.name, list(known))}")
        if span is not None and span.is_open:
            span = _span(span.name, known, scenario, span.log, (span.low, span.high))
        chosen.append(_checked(span or own, known))
    if DERIVED.get(chosen[0].name, chosen[0].name) == DERIVED.get(chosen[1].name, chosen[1].name):
        a, b = (known[span.name].quantity.long_name for span in chosen)
        raise InputError(
            f"both axes show the {a}: choose another one"
            if a == b
            else f"{a} and {b} set the same thing: choose another axis"
        )
    return chosen[0], chosen[1]


def _span(
    name: str,
    known: Mapping[str, Parameter],
    scenario: Scenario,
    log: bool | None = None,
    given: tuple[float, float] = (math.nan, math.nan),
) -> Span:
    """Return an axis with the range to begin with; a logarithmic one ends two decades below.

    Ends that are given stay; NaN stands for one that is not.
    """
    usual = suggested_range(name, known, scenario)
    low, high = (u if math.isnan(g) else g for u, g in zip(usual, given, strict=True))
    if log is None:
        values = scenario.varied.get("axes", {}).get(name)
        listed = values is not None and not isinstance(values, Mapping)
        log = listed and is_geometric(np.sort(np.array(values, dtype=float)))
    if log and math.isnan(given[0]) and not low > 0.0 and high > 0.0:
        low = _LOG_SPAN * high
    return Span(name, low, high, log)


def _checked(span: Span, known: Mapping[str, Parameter]) -> Span:
    """Return an axis, or raise InputError in the words of the quantity along it."""
    parameter = known[span.name]
    label = named(span.name, parameter)
    low, high = (in_words(span.name, v, parameter) for v in (span.low, span.high))
    if not span.low < span.high:
        raise InputError(f"{label}: the end must lie above the start, got {low} to {high}")
    allowed = parameter.allowed
    for value, said in ((span.low, low), (span.high, high)):
        if value not in allowed:
            rule = rule_of(span.name, parameter)
            raise InputError(f"{label}: values must be {rule}, got {said}")
    if span.log and not span.low > 0.0:
        raise InputError(
            f"{label}: a logarithmic axis must begin above zero, got {low}: raise the start, or "
            "make the axis linear"
        )
    return replace(span, log=bool(span.log))


def named(name: str, parameter: Parameter) -> str:
    """Return what a parameter is called, with the ball that it belongs to."""
    side = next((s for s in ("right", "left") if s in name.split("_")), None)
    return parameter.quantity.long_name + (f", {side} ball" if side else "")


def rule_of(name: str, parameter: Parameter) -> str:
    """Return in words where the values of a parameter may lie."""
    allowed = parameter.allowed
    low, high = (in_words(name, v, parameter) for v in (allowed.low, allowed.high))
    least = f"above {low}" if allowed.open_low else f"at least {low}"
    most = f"below {high}" if allowed.open_high else f"at most {high}"
    parts = [least] if math.isfinite(allowed.low) else []
    return " and ".join([*parts, most] if math.isfinite(allowed.high) else parts)


def in_words(name: str, value: float, parameter: Parameter) -> str:
    """Return a value in the unit in which pages show it."""
    unit = units_of(parameter.quantity)[0]
    tail = "" if unit["name"] == "1" else f" {unit['name']}"
    return f"{value / unit['size']:.6g}{tail}"


def suggested_range(
    name: str, known: Mapping[str, Parameter], scenario: Scenario
) -> tuple[float, float]:
    """Return a range to begin with, inside what is allowed [SI]."""
    allowed = known[name].allowed
    axis = scenario.varied.get("axes", {}).get(name)
    if axis is not None and not isinstance(axis, Mapping) and min(axis) < max(axis):
        return float(min(axis)), float(max(axis))
    if name == "drive_amplitude":
        return 0.0, 0.5 * scenario.system.balls[0].length
    if name == "amplitude_ratio":
        return 0.0, 0.5
    option = law_options().get(name)
    if option is not None and option.suggested and (option.owner == "run" or name in DERIVED):
        low, high = option.suggested
    else:
        low, high = _around(options_of(scenario).get(name))
    return _inside(low, high, allowed)


def _around(value: Any) -> tuple[float, float]:
    """Return a range about a value."""
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not value:
        return 0.0, 1.0
    return (0.5 * value, 1.5 * value) if value > 0 else (1.5 * value, 0.5 * value)


def _inside(low: float, high: float, allowed: Range) -> tuple[float, float]:
    """Return a range moved into what is allowed."""
    least, most = max(low, allowed.low), min(high, allowed.high)
    size = most - least
    if allowed.open_low and least == allowed.low:
        least += 0.01 * size
    if allowed.open_high and most == allowed.high:
        most -= 0.01 * size
    return float(least), float(most)


def about_axis(name: str, parameter: Parameter, suggested: tuple[float, float]) -> dict[str, Any]:
    """Return how an axis is shown."""
    quantity = parameter.quantity
    limits = (parameter.allowed.low, parameter.allowed.high)
    return {
        "name": name,
        "label": named(name, parameter),
        "symbol": quantity.symbol,
        "unit": quantity.unit,
        "units": units_of(quantity),
        "allowed": [v if math.isfinite(v) else None for v in limits],
        "suggested": list(suggested),
    }


def watched_of(
    varied: Mapping[str, Any], chosen: str | None, angles: int
) -> tuple[tuple[str | Observable, ...], str, list[dict[str, Any]]]:
    """Return what is gathered, which variable of it is shown, and what else may be chosen.

    What a scenario gathers, or the usual three, is gathered together, so that a page changes
    between them at once; anything else alone.
    """
    own = [checked_observable(each) for each in varied.get("observables", DEFAULT_OBSERVABLES)]
    own = [each for each in own if mappable(each, angles)]
    kinds: list[Any] = [type(each) for each in own]
    everything = [*own, *(law() for law in observables.values() if law not in kinds)]
    variables = [
        {
            "name": name,
            "label": quantity.long_name,
            "symbol": quantity.symbol,
            "unit": quantity.unit,
            "description": (type(each).__doc__ or "").splitlines()[0],
            "together": each in own,
        }
        for each in everything
        for name, quantity in mappable(each, angles).items()
    ]
    names = [v["name"] for v in variables]
    if not own:
        own = [everything[0]]
    shown = chosen or next(iter(mappable(own[0], angles)))
    if shown not in names:
        raise InputError(f"unknown observable '{shown}': {suggest(shown, names)}")
    owner = next(each for each in everything if shown in mappable(each, angles))
    return tuple(own if owner in own else [owner]), shown, variables


def mappable(observable: Observable, angles: int) -> dict[str, Any]:
    """Return the variables of an observable that are one number a point, or start with one."""
    if observable.angles not in (0, angles):
        return {}
    return {
        name: quantity
        for name, quantity in observable.variables.items()
        if observable.dimension in ("", "exponent") or name in observable.plain
    }
