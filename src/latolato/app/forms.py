"""What the pages' forms are made from: laws, options, units, ranges and scenarios as plain values.

Nothing is listed here by name but the units in which people like to read a quantity; a new law,
parameter, observable or scenario appears in the forms by itself.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from functools import lru_cache
from inspect import Parameter, signature
from typing import Any

from latolato.app.given import options_of
from latolato.core.quantities import QUANTITIES, Quantity
from latolato.core.registry import types_of
from latolato.core.versions import version_of
from latolato.observables import observables
from latolato.physics.contacts import contact_laws
from latolato.physics.drives import drives
from latolato.physics.pendulum import systems
from latolato.scenario.options import law_options
from latolato.scenario.scenario import Scenario, scenarios
from latolato.scenario.units import to_si
from latolato.simulation.run import simulate
from latolato.simulation.summary import plain

# Units offered for an SI unit, the first being the one that a form begins with.
UNITS: dict[str, tuple[str, ...]] = {
    "m": ("cm", "mm", "m", "in"),
    "kg": ("g", "kg"),
    "s": ("s", "ms", "min"),
    "rad": ("deg", "rad"),
    "rad/s": ("rad/s", "Hz", "rpm", "deg/s"),
    "m/s^2": ("m/s^2",),
    "1": ("1",),
}
# Where another unit than the first is usual.
FIRST_UNIT = {"drive_amplitude": "mm", "radius": "mm", "tolerance": "rad", "rest_speed": "rad/s"}
# Ranges of sliders for what is no field of a law, in SI units.
SUGGESTED: dict[str, tuple[float, float]] = {
    "initial_angle": (-3.1415926535, 3.1415926535),
    "initial_angular_velocity": (-20.0, 20.0),
    "initial_offset": (0.0, 1.5),
    "duration": (1.0, 300.0),
    "frequency_ratio": (0.0, 5.0),
}
# What a form begins with where a law has no default: the toy in the hand, in SI units.
USUAL: dict[str, Any] = {
    "length": 0.245,
    "mass": 0.1,
    "radius": 0.02,
    "drive_amplitude": 0.02,
    "drive_frequency": 15.1,
    "drive_frequency_final": 20.0,
    "drive_frequencies": [19.8, 15.1],
    "drive_amplitudes": [0.034, 0.034],
    "ramps": [0.1, 0.5],
    "times": [0.0, 4.0],
    "sweep_time": 30.0,
    "connecting_rod_length": 0.1,
    "duration": 20.0,
    "initial_angle": 0.35,
}

_making = threading.Lock()


def registry() -> dict[str, Any]:
    """Return what every page needs to know once, ready for JSON."""
    with _making:  # the first page need not make again what is being made
        return _registry()


@lru_cache(maxsize=1)
def _registry() -> dict[str, Any]:
    found = {
        "version": version_of(),
        "systems": {name: _law(law, "system") for name, law in systems.items()},
        "drives": {name: _law(law, "drive") for name, law in drives.items()},
        "contacts": list(contact_laws),
        "options": {name: _option(name) for name in law_options()},
        "quantities": {name: _quantity(q) for name, q in QUANTITIES.items()},
        "observables": {name: _observable(law) for name, law in observables.items()},
        "scenarios": {name: _scenario(s) for name, s in scenarios().items()},
    }
    result: dict[str, Any] = plain(found)
    return result


def _law(law: type, table: str) -> dict[str, Any]:
    """Return the name, the options and the abilities of a system or a drive."""
    return {
        "title": law.__name__,
        "description": (law.__doc__ or "").splitlines()[0].partition(":")[0],
        "options": list(_option_names(law, table)),
        "angles": getattr(law, "angles", 0),
        "contacts": getattr(law, "has_contacts", False),
    }


def _option_names(law: type, table: str) -> Iterator[str]:
    """Yield the options that set the fields of a law, in their order."""
    paths = {option.path: name for name, option in law_options().items()}
    hints = types_of(law)
    for field in fields(law):
        if is_dataclass(hints[field.name]):
            inner = fields(hints[field.name])
            yield from (paths[table, field.name, part.name] for part in inner)
        elif field.init:
            yield paths[table, field.name]


@lru_cache(maxsize=256)
def label_of(name: str) -> str:
    """Return what pages call an option."""
    path = law_options()[name].path
    field = _field_of(path)
    quantity = (field.metadata if field else {}).get("quantity") or QUANTITIES.get(path[-1])
    return quantity.long_name if quantity else name.replace("_", " ")


def _option(name: str) -> dict[str, Any]:
    """Return how an option is shown and what it may be."""
    option = law_options()[name]
    field = _field_of(option.path)
    metadata = field.metadata if field is not None else {}
    allowed = metadata.get("range")
    quantity = metadata.get("quantity") or QUANTITIES.get(option.path[-1])
    if field is not None:
        default = None if field.default is MISSING else field.default
    else:
        known = signature(simulate).parameters.get(name)
        default = None if known is None or known.default is Parameter.empty else known.default
    return {
        "label": label_of(name),
        "symbol": quantity.symbol if quantity else "",
        "description": option.description,
        "unit": option.unit,
        "units": units_of(name, option.path[-1], option.unit),
        "several": option.several,
        "choices": list(metadata.get("choices", ())),
        "switch": option.kind is bool,
        "whole": option.kind is int,
        "default": default,
        "usual": USUAL.get(option.path[-1]),
        "low": allowed.low if allowed else None,
        "high": allowed.high if allowed else None,
        "suggested": metadata.get("suggested") or SUGGESTED.get(option.path[-1]),
    }


def _field_of(path: tuple[str, ...]) -> Any:
    """Return the field of the first law that an option sets, None for an entry of ``[run]``."""
    table, *inner, key = path
    for law in {"system": systems, "drive": drives}.get(table, {}).values():
        hints = types_of(law)
        owner = hints.get(inner[0]) if inner else law
        for field in fields(owner) if is_dataclass(owner) else ():
            if field.name == key:
                return field
    return None


def units_of(name: str, key: str, unit: str) -> list[dict[str, Any]]:
    """Return the units to choose from with their size in SI units, the usual one first."""
    known = list(UNITS.get(unit, (unit,) if unit else ()))
    first = FIRST_UNIT.get(name, FIRST_UNIT.get(key))
    known.sort(key=lambda each: each != first)
    return [{"name": each, "size": 1.0 if each == unit else _size(each, unit)} for each in known]


def _size(unit: str, wanted: str) -> float:
    """Return how many SI units one unit is."""
    size: float = to_si("unit", f"1 {unit}", wanted)
    return size


def _quantity(quantity: Quantity) -> dict[str, str]:
    return {"unit": quantity.unit, "symbol": quantity.symbol, "label": quantity.long_name}


def _observable(law: Any) -> dict[str, Any]:
    return {
        "description": (law.__doc__ or "").splitlines()[0],
        "variables": {name: _quantity(q) for name, q in law.variables.items()},
    }


def _scenario(scenario: Scenario) -> dict[str, Any]:
    """Return the title of a scenario, what it sets, and what varies if it is a sweep."""
    return {
        "title": scenario.title,
        "description": scenario.description,
        "figure": scenario.figure,
        "options": options_of(scenario),
        "sweep": scenario.to_dict().get("sweep"),
    }
