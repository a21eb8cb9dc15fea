"""The lines of Python and of the command line that compute a map again."""

from __future__ import annotations

import shlex
from dataclasses import MISSING, fields
from typing import Any

from latolato.app.given import options_of
from latolato.app.lines import constructor, literal
from latolato.app.map_choices import Span
from latolato.app.map_request import Map
from latolato.observables import Observable, observables
from latolato.sweeps.axes import TARGETS

# Arguments of `latolato.sweep` that a scenario's run may have.
_OF_RUN = (
    "initial_angle",
    "initial_angular_velocity",
    "initial_offset",
    "contact",
    "rest_speed",
    "contact_limit",
    "noise",
)


def sweep_lines(shown: Map) -> str:
    """Return a Python program that computes a map."""
    scenario = shown.scenario
    lines = ["import numpy as np", "import latolato as ll", ""]
    lines.append(f"system = {constructor(scenario.system)}")
    arguments = ["system"]
    if scenario.drive.moves:
        lines.append(f"drive = {constructor(scenario.drive)}")
        arguments.append("drive")
    lines += ["grid = ll.sweep(", f"    {', '.join(arguments)},", "    axes={"]
    for span, count in _spans(shown):
        make = "geomspace" if span.log else "linspace"
        lines.append(f'        "{span.name}": np.{make}({span.low!r}, {span.high!r}, {count}),')
    lines += ["    },", f"    observables=[{', '.join(map(_observable, shown.watched))}],"]
    for name in _OF_RUN:
        value = scenario.run.get(name)
        if value is not None and name not in _replaced(shown):
            is_law = hasattr(value, "__dataclass_fields__")
            lines.append(f"    {name}={constructor(value) if is_law else literal(value)},")
    for name, value in _numbers(shown).items():
        lines.append(f"    {name}={value!r},")
    return "\n".join([*lines, ")"])


def sweep_command(shown: Map) -> str:
    """Return the command that computes a map, quoted for a shell."""
    words = ["latolato", "sweep"]
    laws = (shown.scenario.system, shown.scenario.drive)
    defaults = {f.name: f.default for law in laws for f in fields(law)}
    units = {axis["name"]: axis["unit"] for axis in shown.choices["axes"]}
    skipped = {*_replaced(shown), "duration", "tolerance", "times", "frame", "samples"}
    for name, value in options_of(shown.scenario).items():
        if name in skipped or defaults.get(name, MISSING) == value:
            continue
        words.append("--" + name.replace("_", "-"))
        if not isinstance(value, bool):
            several = isinstance(value, (list, tuple))
            words.append(", ".join(f"{v:.17g}" for v in value) if several else str(value))
    for name, number in _numbers(shown).items():
        words += ["--" + name.replace("_", "-"), repr(number)]
    for span, count in _spans(shown):
        unit = " log" if span.log else ""
        unit += "" if units[span.name] == "1" else f" {units[span.name]}"
        words += ["--axis", f"{span.name} = {span.low!r} : {span.high!r} : {count}{unit}"]
    for each in shown.watched:
        words += ["--observable", _in_words(each)]
    return shlex.join(words)


def _spans(shown: Map) -> list[tuple[Span, int]]:
    """Return both axes with their numbers of points, the one upwards first."""
    return [(shown.y, shown.request.height), (shown.x, shown.request.width)]


def _replaced(shown: Map) -> set[str]:
    """Return the names of the parameters that the axes set."""
    targets = {TARGETS.get(span.name, span.name) for span, _ in _spans(shown)}
    return targets | {"initial_offset"} if "initial_angle" in targets else targets


def _numbers(shown: Map) -> dict[str, float]:
    """Return duration, transient and tolerance."""
    result = {"duration": shown.duration, "tolerance": shown.request.tolerance}
    arguments = shown.varied()
    for name in ("transient", "transient_periods"):
        if arguments.get(name):
            result[name] = float(arguments[name])
    return result


def _changed(observable: Observable) -> dict[str, Any]:
    """Return the parameters of an observable that are not the usual ones."""
    return {
        f.name: getattr(observable, f.name)
        for f in fields(observable)
        if getattr(observable, f.name) != f.default
    }


def _observable(given: str | Observable) -> str:
    """Return an observable as Python writes it."""
    if isinstance(given, str) or not _changed(given):
        return repr(given if isinstance(given, str) else observables.name_of(given))
    inside = ", ".join(f"{name}={literal(value)}" for name, value in _changed(given).items())
    return f"ll.observables.{type(given).__name__}({inside})"


def _in_words(given: str | Observable) -> str:
    """Return an observable as the command line takes it."""
    if isinstance(given, str) or not _changed(given):
        return given if isinstance(given, str) else observables.name_of(given)
    parameters = []
    for name, value in _changed(given).items():
        shown = str(value).lower() if isinstance(value, bool) else str(value)
        parameters.append(f"{name} = {shown}")
    return f"{observables.name_of(given)}({', '.join(parameters)})"
