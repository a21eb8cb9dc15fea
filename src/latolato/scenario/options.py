"""Options that set the entries of a scenario, made from the registries: one for each parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from latolato.core.parameters import Parameter, law_parameters
from latolato.core.quantities import NON_NEGATIVE, QUANTITIES, Quantity
from latolato.physics.drives import drives
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import systems
from latolato.scenario.tables import RATIOS, RUN_OPTIONS, run_options
from latolato.scenario.units import to_si_list

# Only the command of a single run takes it: neither pages nor sweeps show derivatives.
SENSITIVITY = RUN_OPTIONS["sensitivity_to"]


@lru_cache(maxsize=1)
def law_options() -> dict[str, Parameter]:
    """Return the parameters that set system, drive, run and noise, by the name of their option."""
    result: dict[str, Parameter] = {}
    for owner, registry in (("system", systems), ("drive", drives)):
        kind = f"one of {', '.join(registry)}"
        result[owner] = Parameter(
            name=owner, owner=owner, path=("kind",), kind=str, description=kind,
            quantity=Quantity("", "", owner),
        )  # fmt: skip
    for owner, registry in (("system", systems), ("drive", drives)):
        for law in registry.values():
            for parameter in law_parameters(law, owner):
                # A drive's `times` are not the instants of the samples.
                is_taken = parameter.name in RUN_OPTIONS
                name = f"{owner}_{parameter.name}" if is_taken else parameter.name
                result.setdefault(name, replace(parameter, name=name))
    for ratio, plain in RATIOS.items():
        result[ratio] = replace(
            result[plain],
            name=ratio,
            path=(ratio,),
            description=f"instead of {plain.replace('_', '-')}, in natural frequencies",
            quantity=QUANTITIES.get(ratio) or Quantity("1", "", ratio.replace("_", " ")),
            allowed=NON_NEGATIVE,
            default=None,
            suggested=(0.0, 5.0),
        )
    of_noise = {p.name: p for p in law_parameters(VelocityKicks, "noise")}
    of_run = {name: option for name, option in run_options().items() if name != SENSITIVITY.name}
    return result | of_run | of_noise


def flat_options(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return every option that the tables of a scenario set, in SI units."""
    result = {}
    for name, option in law_options().items():
        place: Any = tables
        for part in (option.owner, *option.path):
            place = place.get(part) if isinstance(place, Mapping) else None
        if place is not None:
            result[name] = place
    return result


def table_value(parameter: Parameter, value: Any) -> Any:
    """Return the entries for a scenario's table; paths are relative to the working directory."""
    if not parameter.several or parameter.kind is str:
        return value
    return to_si_list(parameter.name, value, parameter.unit)


def changes(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the tables of a scenario's changes that options ask for, those not given left out."""
    result: dict[str, dict[str, Any]] = {}
    for name, option in (law_options() | {SENSITIVITY.name: SENSITIVITY}).items():
        if values.get(name) is None:
            continue
        *inner, key = option.path
        place = result.setdefault(option.owner, {})
        for part in inner:
            place = place.setdefault(part, {})
        place[key] = table_value(option, values[name])
    return result
