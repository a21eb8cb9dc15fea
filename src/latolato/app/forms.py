"""What the pages' forms are made from: laws, options, units, ranges and scenarios as plain values.

Nothing is listed here by name but the units of each kind of quantity; a new law, parameter,
observable or scenario appears in the forms by itself.
"""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Iterator
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

from latolato.app import CURVES, STATIC
from latolato.app.languages import languages
from latolato.app.run_request import options_of
from latolato.core.language import spoken
from latolato.core.parameters import Parameter, law_parameters
from latolato.core.quantities import QUANTITIES, UNITS, Quantity, quantity_of
from latolato.core.rules import RULES
from latolato.core.versions import FORMAT, version_of
from latolato.experiment.trial_table import COLUMN_UNITS
from latolato.figures import word_classes
from latolato.figures.analyses.bifurcation_curve import COLOURS, MARKS
from latolato.figures.cells import SCALES
from latolato.figures.map import CLASSES
from latolato.observables import observables
from latolato.observables.angles import MotionClass
from latolato.physics.contacts import (
    ClampContact,
    ContactLaw,
    ExactContact,
    PassThrough,
    contact_laws,
)
from latolato.physics.drives import FixedPivot, PeriodicDrive, drives
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import Pendulum, systems
from latolato.scenario.options import flat_options, law_options
from latolato.scenario.scenario import ALTERNATIVES, Scenario, load_scenario, read_tables, shipped
from latolato.scenario.tables import RATIOS
from latolato.scenario.units import to_si, to_si_list, unit_table
from latolato.simulation.summary import plain
from latolato.simulation.vary import DERIVED, TARGETS, parameters_of
from latolato.sweeps.plan import DEFAULT_OBSERVABLES, Plan

# Others would run on a page as exact contact: see `contactOf` in ``js/model/case.js``.
_PAGE_CONTACTS = (ExactContact, ClampContact, PassThrough)

# Symbols and units in the letters of docstrings, in this order, and as pages write them.
_LETTERS = {
    "w/w0": "ω/ω₀",
    "w0": "ω₀",
    r"A0 (?:omega|w)": "A₀ω",
    r"([Axy])0": r"\1₀",
    "phase ([xy])": r"φ\1",
    "w|omega": "ω",
    "gamma": "\N{GREEK SMALL LETTER GAMMA}",
    "-pi to pi": "-180° to 180°",
    r"(\d) pi": r"\1π",
    r"m/s\^2": "m/s²",
    r"eq(\d+)": r"eq. \1",
    "Poincare": "Poincaré",
}
# Names of parameters in a text.
_NAMES = re.compile(r"\b[a-z]+(?:_[a-z]+)+\b")

_making = threading.Lock()


def registry() -> dict[str, Any]:
    """The laws, options, units and scenarios that every page loads once, ready for JSON."""
    with _making:  # the first page need not make again what is being made
        return _registry()


@lru_cache(maxsize=1)
def _registry() -> dict[str, Any]:
    results = {
        "version": version_of(),
        "format": FORMAT,
        "systems": {
            name: _law(law, "system")
            | {"axes": [p.name for p in _varied(law, FixedPivot, "system", "run")]}
            for name, law in systems.items()
        },
        "drives": {
            name: _law(law, "drive")
            | {"axes": [p.name for p in _varied(Pendulum, law, "drive")]}
            | _motion(law)
            for name, law in drives.items()
        },
        "contact_laws": {name: _law(law, "run") for name, law in contact_laws.items()},
        "options": {name: shown_option(o) for name, o in law_options().items()},
        "quantities": {name: _quantity(q) for name, q in QUANTITIES.items()},
        "axes": _axes(),
        "noise_axes": [p.name for p in _varied(Pendulum, FixedPivot, "noise")],
        "observables": {name: _observable(law) for name, law in observables.items()},
        "default_observables": DEFAULT_OBSERVABLES,
        "sweep_tolerance": Plan.tolerance,
        "scenarios": {name: _scenario(path) for name, path in shipped().items()},
        "ratios": RATIOS,
        "rules": {name: rule._asdict() for name, rule in RULES.items()},
        "alternatives": [sorted(group) for group in ALTERNATIVES],
        "languages": languages(),
        "curves": {
            "kinds": {
                kind: {"label": spoken(kind).capitalize(), "colour": c}
                for kind, c in COLOURS.items()
            },
            "marks": {
                kind: {"label": spoken(kind).capitalize(), "mark": mark}
                for kind, mark in MARKS.items()
            },
        },
        "trials": {"columns": COLUMN_UNITS, **asdict(MotionClass())},
        **unit_table(),
    }
    result: dict[str, Any] = plain(results)
    return result


def pretty(text: str) -> str:
    """Return a text of a docstring with symbols and units as a page writes them.

    Examples
    --------
    >>> pretty("w/w0 of A0, by default 3 w0 (``eq10``)"), pretty("sqrt(2 g l) at -pi to pi")
    ('ω/ω₀ of A₀, by default 3 ω₀ (eq. 10)', '√(2 g l) at -180° to 180°')
    """
    text = re.sub(r"sqrt(?=\()", "√", text.replace("`", "")).replace("√(2)", "√2")
    for letters, shown in _LETTERS.items():
        text = re.sub(rf"(?<!\w)(?:{letters})(?!\w)", shown, text)
    return text


def described(text: str) -> str:
    """Return a sentence of a docstring with symbols, and names of parameters as words."""
    text = re.sub(r"(?<!`)`(\w+)`(?!`)", r"“\1”", text)
    return pretty(_NAMES.sub(lambda name: name[0].replace("_", " "), text))


def _law(law: type, table: str) -> dict[str, Any]:
    """Return the name, the options and the abilities of a system, a drive or a contact law."""
    return {
        "title": law.__name__,
        "description": described((law.__doc__ or "").splitlines()[0].partition(":")[0]),
        "options": list(_option_names(law, table)),
        "angles": getattr(law, "angles", 0),
        "contacts": getattr(law, "has_contacts", False),
        "compiled": _is_compiled(law),
    }


def _motion(drive: Any) -> dict[str, Any]:
    """Return how a kind of drive moves the pivot; see `Drive` and `PeriodicDrive`."""
    return {
        "moves": drive.moves,
        "sinusoidal": drive.is_sinusoidal,
        "across": drive.across_parameter,
        "periodic": issubclass(drive, PeriodicDrive),
        "amplitude_limit": getattr(drive, "amplitude_limit", None),
    }


def _is_compiled(law: type) -> bool:
    """Return whether the modules for pages have a law; a drive must be written by a formula."""
    if issubclass(law, ContactLaw):
        return law in _PAGE_CONTACTS
    return law.__module__.startswith("latolato.") and getattr(law, "write", ...) is not None


def _option_names(law: type, owner: str) -> Iterator[str]:
    """Yield the options that set the parameters of a law, in their order."""
    names = {(o.owner, o.path): name for name, o in law_options().items()}
    yield from (names[owner, parameter.path] for parameter in law_parameters(law, owner))


def _varied(system: Any, drive: Any, *owners: str) -> Iterator[Parameter]:
    """Yield what a page's map of these laws and noise can vary, of these owners."""
    known = parameters_of(system, drive, VelocityKicks)
    yield from (parameter for parameter in known.values() if parameter.owner in owners)


def _axes() -> dict[str, dict[str, Any]]:
    """Return how each parameter that maps can vary is shown, and what it may be."""
    parameters = [
        *(p for law in systems.values() for p in _varied(law, FixedPivot, "system", "run")),
        *(p for law in drives.values() for p in _varied(Pendulum, law, "drive")),
        *_varied(Pendulum, FixedPivot, "noise"),
    ]
    return {parameter.name: _axis(parameter) for parameter in parameters}


def _axis(parameter: Parameter) -> dict[str, Any]:
    """Return a parameter of maps: its label, what it sets, the interval to begin with, if any."""
    name = parameter.name
    side = next((s for s in ("right", "left") if s in name.split("_")), None)
    option = law_options().get(name)
    begins = option is not None and (option.owner == "run" or name in DERIVED)
    return {
        "label": parameter.quantity.long_name + (f", {side} ball" if side else ""),
        "symbol": parameter.quantity.symbol,
        "unit": parameter.unit,
        "units": units_of(parameter.quantity),
        "owner": parameter.owner,
        "sets": TARGETS.get(name, name),
        "limits": [asdict(limit) for limit in parameter.limits],
        "suggested": option.suggested if option is not None and begins else None,
    }


def shown_option(option: Parameter) -> dict[str, Any]:
    """Return how an option is shown and what it may be."""
    low, high = option.allowed.low, option.allowed.high
    return {
        "label": option.quantity.long_name,
        "symbol": option.quantity.symbol,
        "description": option.help,
        "unit": option.unit,
        "units": units_of(option.quantity),
        "several": option.several,
        "choices": list(option.choices),
        "switch": option.kind is bool,
        "whole": option.kind is int,
        "default": option.default,
        "usual": option.quantity.usual,
        "low": low if math.isfinite(low) else None,
        "high": high if math.isfinite(high) else None,
        "limits": [asdict(limit) for limit in option.limits],
        "for_each_ball": option.for_each_ball,
        "owner": option.owner,
        "path": option.path,
        "suggested": option.suggested,
        "is_later": option.is_later,
    }


def units_of(quantity: Quantity) -> list[dict[str, Any]]:
    """Return the units to choose from with their size in SI units, the usual one first."""
    unit = quantity.unit
    known = sorted(
        UNITS.get(unit, (unit,) if unit else ()), key=lambda each: each != quantity.shown_unit
    )
    return [{"name": each, "size": 1.0 if each == unit else _size(each, unit)} for each in known]


def _size(unit: str, si_unit: str) -> float:
    """Return how many SI units one unit is."""
    size: float = to_si("unit", f"1 {unit}", si_unit)
    return size


def _quantity(quantity: Quantity) -> dict[str, str]:
    return {
        "unit": quantity.unit,
        "symbol": quantity.symbol,
        "label": quantity.long_name,
        "shown_unit": quantity.shown_unit,
    }


def _observable(law: Any) -> dict[str, Any]:
    return {
        "title": law.__name__,
        "description": described((law.__doc__ or "").splitlines()[0]),
        "variables": {name: shown_variable(name, q) for name, q in law.variables.items()},
    }


def shown_variable(name: str, quantity: Quantity) -> dict[str, Any]:
    """Return a variable with its classes, or with the colours that it has in the report, if any.

    Those of contact words are the ones that all maps have; a page finds the others.
    """
    is_word = name == "contact_word"
    words = {"codes": list(word_classes.KNOWN), "further": word_classes.FURTHER}
    scale = next((colours for each, _, colours in SCALES if each == name), None)
    return _quantity(quantity) | {
        "units": units_of(quantity_of(name, quantity.unit)),
        "classes": list((word_classes.USUAL if is_word else CLASSES.get(name, {})).items()),
        "words": words if is_word else None,
        "log": scale is not None,
        "scale": scale or "viridis",
    }


def _scenario(path: Path) -> dict[str, Any]:
    """Return the texts of a scenario, what it sets, and what varies if it is a sweep.

    `given` are the options that its file sets, `options` those that follow from them.
    """
    scenario, tables = load_scenario(path), read_tables(path)
    return {
        "title": scenario.title,
        "question": scenario.question,
        "description": description_of(scenario),
        "figure": scenario.figure,
        "given": {
            name: _in_si(law_options()[name], value) for name, value in flat_options(tables).items()
        },
        "options": options_of(scenario),
        "sweep": scenario.to_dict().get("sweep"),
        "curves": _curves_of(path.stem),
    }


def description_of(scenario: Scenario) -> str:
    """Return the description of a scenario as pages write it, on one line."""
    return " ".join(pretty(_with_titles(scenario.description)).split())


def _with_titles(text: str) -> str:
    """Return a text in which scenarios have their titles instead of their names."""
    # Those of one word, such as toy, are words of texts too.
    names = "|".join(name for name in shipped() if not name.isalpha())
    return re.sub(rf"\b(?:{names})\b", lambda name: f"“{load_scenario(name[0]).title}”", text)


def _curves_of(name: str) -> str | None:
    """Return the path of the bifurcation curves of a scenario, None without any.

    Variants of a scenario, as ``fig05_push`` of ``fig05``, have the curves of that.
    """
    path = CURVES / f"{name.partition('_')[0]}.csv"
    return path.relative_to(STATIC).as_posix() if path.is_file() else None


def _in_si(option: Parameter, value: Any) -> Any:
    """Return a value of a scenario's file in SI units."""
    if not option.unit:
        return value
    convert = to_si_list if option.several or isinstance(value, list) else to_si
    return convert(option.name, value, option.unit)
