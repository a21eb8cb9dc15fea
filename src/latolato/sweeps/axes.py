"""What can be varied, and the axes of a sweep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.quantities import ANY, NON_NEGATIVE, QUANTITIES, Quantity, Range
from latolato.core.registry import checked_number, number_fields, suggest, types_of
from latolato.physics.drives import Drive
from latolato.physics.noise import KEY, LARGEST_STREAM, VelocityKicks
from latolato.physics.pendulum import LatoLato, System

# Parameters that stand for another one, which is set from them.
DERIVED = {
    "frequency_ratio": "drive_frequency",
    "amplitude_ratio": "drive_amplitude",
    "drive_acceleration_ratio": "drive_amplitude",
}


@dataclass(frozen=True)
class Parameter:
    """One thing that can be varied: what it is, where it may lie, and whom it belongs to."""

    quantity: Quantity
    allowed: Range
    owner: str  # system, drive, noise or run
    path: tuple[str, ...]  # where its value stands below the owner
    whole: bool = False  # only whole numbers


@dataclass(frozen=True)
class Axis:
    """One dimension of a sweep: parameters that vary together along it.

    Attributes
    ----------
    values : tuple of tuple
        For each parameter, its values along the dimension.
    """

    name: str
    parameters: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]

    def __len__(self) -> int:
        return len(self.values[0])


def parameters_of(
    system: System, drive: Drive, noise: VelocityKicks | None = None
) -> dict[str, Parameter]:
    """Return everything that a sweep of this system, drive and noise can vary, by name."""
    found: dict[str, Parameter] = {}
    hints = types_of(type(system))
    for field in fields(system):
        if is_dataclass(hints[field.name]):
            for inner in number_fields(hints[field.name]):
                path = (field.name, inner.name)
                found["_".join(path)] = _of_field(inner, "system", path)
    for owner, law in (("system", system), ("drive", drive)):
        for field in number_fields(law):
            found[field.name] = _of_field(field, owner, (field.name,))
    for derived, target in DERIVED.items():
        if target in found:
            found[derived] = Parameter(QUANTITIES[derived], NON_NEGATIVE, "drive", (target,))
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    for name in ("initial_angle", "initial_angular_velocity"):
        for side in sides:
            found[name + side] = Parameter(QUANTITIES[name], ANY, "run", (name + side,))
    if isinstance(system, LatoLato):
        offset = QUANTITIES["initial_offset"]
        found["initial_offset"] = Parameter(offset, NON_NEGATIVE, "run", ("initial_offset",))
    if noise is not None:
        for field in number_fields(noise):
            parameter = _of_field(field, "noise", (field.name,))
            if field.name in KEY:
                # Floats hold every whole number up to here, also of seeds.
                parameter = replace(parameter, allowed=Range(0, LARGEST_STREAM), whole=True)
            found[field.name] = parameter
    return found


def _of_field(field: Any, owner: str, path: tuple[str, ...]) -> Parameter:
    """Return the parameter that a law's field is."""
    return Parameter(field.metadata["quantity"], field.metadata["range"], owner, path)


def checked_axes(axes: Any, known: Mapping[str, Parameter]) -> tuple[Axis, ...]:
    """Return the axes of a sweep, checked.

    Parameters
    ----------
    axes : mapping
        A parameter's name with its values, or the name of a dimension with a mapping of
        parameters that vary together along it to their values.

    Raises
    ------
    InputError
        For unknown names, with the closest known one, and for values that are empty, repeated,
        not finite or out of range.
    """
    if not isinstance(axes, Mapping):
        raise InputError("must map names of parameters to values", parameter="axes", value=axes)
    if not axes:
        raise InputError("must name at least one parameter to vary", parameter="axes")
    found = []
    for name, values in axes.items():
        together = values if isinstance(values, Mapping) else {name: values}
        if not together:
            raise InputError(f"axis {name} must name at least one parameter to vary")
        if isinstance(values, Mapping) and name in known and name not in together:
            raise InputError(
                f"axis {name} sets several parameters, so it needs a name that is no parameter"
            )
        columns = {p: _checked_values(p, v, known) for p, v in together.items()}
        lengths = {p: len(v) for p, v in columns.items()}
        if len(set(lengths.values())) > 1:
            counts = ", ".join(f"{p} {n}" for p, n in lengths.items())
            raise InputError(f"parameters along axis {name} must be equally many, got {counts}")
        points = list(zip(*columns.values(), strict=True))
        if len(set(points)) < len(points):
            repeated = next(p for i, p in enumerate(points) if p in points[:i])
            shown = ", ".join(f"{value:g}" for value in repeated)
            raise InputError(f"axis {name} must not repeat a value, got {shown} twice; remove one")
        found.append(Axis(str(name), tuple(columns), tuple(columns.values())))
    _check_conflicts(found)
    return tuple(found)


def _checked_values(name: str, values: Any, known: Mapping[str, Parameter]) -> tuple[float, ...]:
    """Return the values of one parameter along an axis."""
    if name not in known:
        raise InputError(f"unknown parameter '{name}' in axes: {suggest(name, list(known))}")
    parameter = known[name]
    unit = parameter.quantity.unit
    single = isinstance(values, np.ndarray) and values.ndim == 0
    if isinstance(values, (str, bytes)) or single or not isinstance(values, Iterable):
        raise InputError(f"axis {name} must hold numbers in {unit}, got {values!r}")
    values = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if not values:
        raise InputError(f"axis {name} has no values: a sweep needs at least one point")
    if isinstance(values[0], list):
        raise InputError(f"axis {name} must be one-dimensional, got shape {np.shape(values)}")
    numbers = tuple(checked_number(name, value, parameter.allowed, unit) for value in values)
    for number in numbers:
        if parameter.whole and not number.is_integer():
            raise InputError(f"must be a whole number, got {number:g}", parameter=name)
    return numbers


def _check_conflicts(axes: list[Axis]) -> None:
    """Raise InputError if two axes set the same thing or bear the same name."""
    setters: dict[str, str] = {}
    alternatives = {**DERIVED, "initial_offset": "initial_angle"}
    for axis in axes:
        for name in axis.parameters:
            target = alternatives.get(name, name)
            if target in setters:
                raise InputError(f"axes {setters[target]} and {name} both set {target}: drop one")
            setters[target] = name
    names = [axis.name for axis in axes]
    for name in names:
        if not name.isidentifier():
            raise InputError(
                f"axis name '{name}' must be of letters, digits and underscores: choose another"
            )
        if names.count(name) > 1 or name in ("direction", "ball", "sample", "status"):
            raise InputError(f"axis name '{name}' is taken: choose another")
