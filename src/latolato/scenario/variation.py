"""What a sweep varies and gathers, as people write it: axes, observables, values that fix axes.

Texts and tables of ``[sweep]`` and of the command line become the arguments of `latolato.sweep`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.core.quantities import ANY, QUANTITIES, Quantity
from latolato.core.registry import checked_number, describe, suggest
from latolato.physics.drives import drives
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import systems
from latolato.scenario.units import to_si, to_si_list
from latolato.simulation.vary import DERIVED, TARGETS, parameters_of
from latolato.sweeps.axes import unknown_parameter

if TYPE_CHECKING:
    from latolato.sweeps.plan import Plan

# More values than this along one axis are a slip of the pen.
MOST_VALUES = 10_000_000
_RANGE = ("low", "high", "count", "spacing")
_SIDES = ("_right", "_left")
_COUNT = re.compile(r"(?P<count>[-+]?\d+)\s*(?P<log>log\b)?\s*(?P<unit>(?!e[-+]?\d|\.).*)")
_WITH_PARAMETERS = re.compile(r"(?P<kind>\w+)\s*\((?P<parameters>.*)\)")

Values = tuple[float, ...]


def known_quantities(system: Any, drive: Any) -> dict[str, Quantity]:
    """Return the parameters that axes can vary for a system and a drive of these kinds, by name.

    An unknown kind stands for all of its registry, and a static or missing drive for a harmonic
    one, which a sweep makes of it.
    """
    kind = "harmonic" if drive in (None, "fixed_pivot") else drive
    moving = [systems[system]] if system in systems else list(systems.values())
    driving = [drives[kind]] if kind in drives else list(drives.values())
    result: dict[str, Quantity] = {}
    for law in moving:
        for each in driving:
            known = parameters_of(law, each, VelocityKicks)
            result |= {name: p.quantity for name, p in known.items()}
    return result


def read_axes(axes: Any, known: Mapping[str, Quantity], folder: Path) -> dict[str, Any]:
    """Return axes with SI numbers: names with tuples, or with parameters that vary together.

    Parameters
    ----------
    axes : mapping
        Values are a text ``"low : high : count"`` with units, also ``"low : high : count log"``, a
        table ``{low, high, count, spacing}``, a list, the name of a file that holds numbers, or,
        for parameters that vary together, a table of these by name.
    known : mapping
        What `known_quantities` returned.
    folder : Path
        Where names of files begin.

    Raises
    ------
    InputError
        For unknown names, with the closest known one, and for wrong units, counts and ends.
    """
    if not isinstance(axes, Mapping):
        raise InputError("must be a table of names and values", parameter="axes", value=axes)
    result: dict[str, Any] = {}
    for name, value in axes.items():
        if isinstance(value, Mapping) and not (set(_RANGE) & value.keys() or name in known):
            result[name] = {p: _read_values(p, v, known, folder) for p, v in value.items()}
        else:
            result[name] = _read_values(name, value, known, folder)
    return result


def _read_values(name: str, value: Any, known: Mapping[str, Quantity], folder: Path) -> Values:
    """Return the values of one parameter."""
    if name not in known:
        raise unknown_parameter(name, known)
    unit = known[name].unit
    values = _listed(name, value, unit, folder)
    if isinstance(values, str) or not isinstance(values, Sequence):
        raise InputError(
            f"axis {{parameter}} must hold numbers in {unit}", parameter=name, value=value
        )
    if not values:
        raise InputError("axis {parameter} needs at least one value", parameter=name)
    return tuple(values)


def _listed(name: str, value: Any, unit: str, folder: Path) -> Any:
    """Return the values that a text, a table or a list stands for."""
    if isinstance(value, Mapping):
        return _from_table(name, value, unit)
    if isinstance(value, str):
        parts = [part.strip() for part in value.split(":")]
        if len(parts) == 3 and not (folder / value).is_file():
            return _from_text(name, parts, unit)
        if len(parts) == 2 and re.match(r"[-+.\d]", parts[0]):
            raise InputError(
                "axis {parameter} must be low : high : count or a list of values",
                parameter=name,
                value=value,
            )
    return to_si_list(name, value.tolist() if hasattr(value, "tolist") else value, unit, folder)


def _from_text(name: str, parts: Sequence[str], unit: str) -> Values:
    """Return the values that ``"low : high : count log unit"`` stands for."""
    match = _COUNT.fullmatch(parts[2])
    if match is None:
        raise InputError(
            "needs a whole number of values after its ends",
            parameter=name,
            value=parts[2],
            way_out=f"for example 0 : 1 : 11{'' if unit in ('', '1') else f' {unit}'}",
        )
    ends = parts[:2]
    if match["unit"]:
        ends = [f"{end} {match['unit']}" for end in ends]
    low, high = to_si_list(name, ", ".join(ends), unit)
    return _spread(name, low, high, int(match["count"]), match["log"] is not None, unit)


def _from_table(name: str, table: Mapping[str, Any], unit: str) -> Values:
    """Return the values that ``{low, high, count, spacing}`` stands for."""
    for key in table:
        if key not in _RANGE:
            raise InputError(
                f"unknown entry '{key}' of axis {{parameter}}: {suggest(key, list(_RANGE))}",
                parameter=name,
            )
    for key in _RANGE[:3]:
        if key not in table:
            raise InputError(
                f"axis {{parameter}} needs '{key}' beside {', '.join(table)}", parameter=name
            )
    count, spacing = table["count"], table.get("spacing", "linear")
    if isinstance(count, bool) or not isinstance(count, int):
        raise InputError(
            "count of axis {parameter} must be a whole number", parameter=name, value=count
        )
    if spacing not in ("linear", "log"):
        raise InputError(
            "spacing of axis {parameter} must be 'linear' or 'log'", parameter=name, value=spacing
        )
    low, high = (to_si(name, table[key], unit) for key in ("low", "high"))
    return _spread(name, low, high, count, spacing == "log", unit)


def _spread(name: str, low: Any, high: Any, count: int, is_log: bool, unit: str) -> Values:
    """Return `count` values from `low` to `high`, both included."""
    import numpy as np

    low, high = (checked_number(name, end, ANY, unit) for end in (low, high))
    if count < 0 or count > MOST_VALUES:
        raise InputError(
            f"axis {{parameter}} must have 1 to {MOST_VALUES} values", parameter=name, value=count
        )
    if count == 1 and low != high:
        raise InputError(
            f"axis {{parameter}} needs at least 2 values to go from {low:g} to {high:g}",
            parameter=name,
        )
    if is_log and not (low > 0.0 and high > 0.0):
        raise InputError(
            "axis {parameter} with log spacing must lie above 0", parameter=name, value=[low, high]
        )
    make = np.geomspace if is_log else np.linspace
    return tuple(make(low, high, count).tolist())


def parse_axis(text: str) -> tuple[str, Any]:
    """Return the name and the values of an axis given on the command line, as texts.

    Examples
    --------
    >>> parse_axis("drive-amplitude = 0 : 0.5 : 400 m")
    ('drive_amplitude', '0 : 0.5 : 400 m')
    >>> parse_axis("case: length = 0.2 m, 0.3 m; radius = 2 cm, 3 cm")
    ('case', {'length': '0.2 m, 0.3 m', 'radius': '2 cm, 3 cm'})
    """
    head, equals, rest = text.partition("=")
    together, colon, first = head.partition(":")
    if not equals or not head.strip():
        raise InputError(
            "an axis must be NAME=VALUES",
            value=text,
            way_out='for example "drive_amplitude = 0 : 0.5 : 400 m"',
        )
    if not colon:
        return _name(head), rest.strip()
    columns: dict[str, str] = {}
    for column in f"{first}={rest}".split(";"):
        parameter, equals, values = column.partition("=")
        if not equals or not parameter.strip():
            raise InputError(
                f"parameters along axis {_name(together)} must be NAME=VALUES with ; between",
                value=column.strip(),
            )
        columns[_name(parameter)] = values.strip()
    return _name(together), columns


def parse_axes(texts: Sequence[str]) -> dict[str, Any]:
    """Return the axes of the command line, each given once."""
    result: dict[str, Any] = {}
    for text in texts:
        name, values = parse_axis(text)
        if name in result:
            raise InputError("axis {parameter} must be given once", parameter=name)
        result[name] = values
    return result


def parse_observable(text: str) -> Any:
    """Return an observable of the command line: its name, or a table with its parameters.

    Examples
    --------
    >>> parse_observable("crossings(crossing_angle = 90 deg, unwrapped = true)")
    {'kind': 'crossings', 'crossing_angle': '90 deg', 'unwrapped': True}
    """
    match = _WITH_PARAMETERS.fullmatch(text.strip())
    if match is None:
        return _name(text)
    table: dict[str, Any] = {"kind": match["kind"]}
    for part in match["parameters"].split(",") if match["parameters"].strip() else ():
        name, equals, value = (each.strip() for each in part.partition("="))
        if not equals:
            raise InputError(f"parameters of {match['kind']} must be NAME=VALUE", value=name)
        words: dict[str, Any] = {"true": True, "false": False}
        table[_name(name)] = int(value) if value.isdigit() else words.get(value.lower(), value)
    return table


def _name(text: str) -> str:
    """Return a name as fields are called."""
    return text.strip().replace("-", "_")


def merged_axes(
    axes: Mapping[str, Any], new: Mapping[str, Any], changes: Mapping[str, Mapping[str, Any]]
) -> dict[str, Any]:
    """Return a scenario's axes with those of options put in, and without what options fix.

    A new axis takes the place of the one that sets the same thing, a given value that of the axis.

    Raises
    ------
    InputError
        If an option fixes what a new axis varies, or one of several parameters along an axis.
    """
    fixed = {TARGETS.get(name, name): name for name in _changed(changes)}
    for name in _parameters(new):
        if TARGETS.get(name, name) in fixed:
            raise InputError(
                f"{{parameter}} is given as a value and varied along axis {name}",
                parameter=fixed[TARGETS.get(name, name)],
                way_out="drop one",
            )
    varied = {TARGETS.get(name, name) for name in _parameters(new)}
    kept: dict[str, Any] = {}
    for name, values in axes.items():
        targets = {TARGETS.get(p, p) for p in _parameters({name: values})}
        taken = targets & (varied | fixed.keys())
        if name in new or not taken:
            kept[name] = new.get(name, values)
        elif len(targets) > 1:
            raise InputError(
                f"varies together with others along axis {name} of the scenario",
                parameter=taken.pop(),
                way_out=f"give a new axis {name} instead",
            )
    return {**kept, **new}


def _parameters(axes: Mapping[str, Any]) -> list[str]:
    """Return the names of the parameters that axes vary."""
    result: list[str] = []
    for name, values in axes.items():
        is_zip = isinstance(values, Mapping) and not set(_RANGE) & values.keys()
        result += list(values) if is_zip else [name]
    return result


def _changed(changes: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return the names of the parameters that options set, those of balls with their side."""
    result = []
    for part in ("system", "drive", "run"):
        for name, value in changes.get(part, {}).items():
            nested = isinstance(value, Mapping)
            result += [f"{name}_{inner}" for inner in value] if nested else [name]
    result += changes.get("noise", {})
    return result + [name + side for name in result for side in _SIDES if name in QUANTITIES]


def with_placeholders(
    tables: Mapping[str, Any], axes: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """Return the tables of system and drive, with a first value for what varies and is not given.

    Laws need a value for every parameter, though each point of a sweep has its own.
    """
    system: dict[str, Any] = dict(tables["system"])
    drive = dict(tables["drive"]) if "drive" in tables else None
    columns: dict[str, Any] = {}
    for name, values in axes.items():
        columns |= values if isinstance(values, Mapping) else {name: values}
    kind = systems[system["kind"]] if system.get("kind") in systems else None
    own = {f.name for f in fields(kind)} if kind is not None else set()
    for name, values in columns.items():
        first = values[0]
        side, _, inner = name.partition("_")
        if name in own:
            system.setdefault(name, first)
        elif side in own and isinstance(system.get(side, {}), Mapping):
            system[side] = {inner: first, **system.get(side, {})}
        elif drive is not None and drive.get("kind", "fixed_pivot") != "fixed_pivot":
            law: Any = drives.get(drive["kind"])
            target = DERIVED.get(name, name)
            ratio = next((d for d, t in DERIVED.items() if t == target and d in drive), None)
            if law is not None and target in {f.name for f in fields(law)} and ratio is None:
                drive.setdefault(target, first if target == name else 0.0)
    return system, drive


def tables_of_plan(plan: Plan) -> dict[str, Any]:
    """Return the tables of a scenario that make this plan again, chunks apart."""
    described = plan.describe()
    start = described["start"]
    run = {k: described[k] for k in ("duration", "tolerance", "rest_speed", "contact_limit")}
    run |= {"contact" if k == "kind" else k: v for k, v in described["contact"].items()}
    if plan.system.angles == 1:
        run |= start
    else:
        for name in ("initial_angle", "initial_angular_velocity"):
            run[name] = [start.get(name + side, 0.0) for side in _SIDES]
        sides = dict(zip(_SIDES, plan.system.balls, strict=True))
        if any(f"initial_distance{side}" in start for side in sides):
            run["initial_distance"] = [
                start.get(f"initial_distance{side}", ball.length) for side, ball in sides.items()
            ]
    sweep: dict[str, Any] = {
        "axes": {
            axis.name: axis.values[0]
            if axis.parameters == (axis.name,)
            else dict(zip(axis.parameters, axis.values, strict=True))
            for axis in plan.axes
        },
        "observables": described["observables"],
        "transient": plan.transient,
        "transient_periods": plan.transient_periods,
    }
    if plan.continuation:
        sweep |= {"continuation": plan.continuation, "direction": plan.direction}
    tables = {"system": described["system"], "drive": described["drive"], "run": run}
    if plan.noise is not None:
        tables["noise"] = describe(plan.noise)
    return {**tables, "sweep": sweep}
