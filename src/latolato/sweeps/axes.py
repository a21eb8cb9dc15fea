"""The axes of a sweep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from latolato.core.errors import InputError
from latolato.core.parameters import Parameter, law_parameters
from latolato.core.registry import suggest
from latolato.physics.drives import drives
from latolato.physics.pendulum import systems
from latolato.simulation.vary import TARGETS


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


def unknown_parameter(name: str, known: Iterable[str]) -> InputError:
    """Return the error of an axis that varies none of the `known` parameters."""
    choices = {
        parameter.name: parameter.choices
        for law in (*systems.values(), *drives.values())
        for parameter in law_parameters(law, "")
    }
    if not choices.get(name):
        return InputError(f"unknown parameter '{name}' in axes: {suggest(name, list(known))}")
    words = " or ".join(map(repr, choices[name]))
    return InputError(
        f"{{parameter}} is {words}, but an axis varies numbers only",
        parameter=name,
        way_out="run one sweep for each",
    )


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
    result = []
    for name, values in axes.items():
        together = values if isinstance(values, Mapping) else {name: values}
        if not together:
            raise InputError(f"axis {name} must name at least one parameter to vary")
        if isinstance(values, Mapping) and name in known and name not in together:
            raise InputError(
                f"axis {name} sets several parameters, so it needs a name that is not a parameter"
            )
        columns = {p: _checked_values(p, v, known) for p, v in together.items()}
        lengths = {p: len(v) for p, v in columns.items()}
        if len(set(lengths.values())) > 1:
            counts = ", ".join(f"{p} {n}" for p, n in lengths.items())
            raise InputError(f"parameters along axis {name} must be equally many, got {counts}")
        points = list(zip(*columns.values(), strict=True))
        if len(set(points)) < len(points):
            repeated = next(p for i, p in enumerate(points) if p in points[:i])
            text = ", ".join(f"{value:g}" for value in repeated)
            raise InputError(
                f"must not repeat a value, got {text} twice",
                parameter=name,
                way_out="remove one",
            )
        result.append(Axis(str(name), tuple(columns), tuple(columns.values())))
    _check_conflicts(result)
    return tuple(result)


def _checked_values(name: str, values: Any, known: Mapping[str, Parameter]) -> tuple[float, ...]:
    """Return the values of one parameter along an axis."""
    if name not in known:
        raise unknown_parameter(name, known)
    return known[name].checked_row(values)


def _check_conflicts(axes: list[Axis]) -> None:
    """Raise InputError if two axes set the same thing or bear the same name."""
    setters: dict[str, str] = {}
    for axis in axes:
        for name in axis.parameters:
            target = TARGETS.get(name, name)
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


def names_in(axes: Any) -> set[str]:
    """Return the names of the parameters that axes vary, before they are checked."""
    varied: set[str] = set()
    if isinstance(axes, Mapping):
        for name, values in axes.items():
            varied |= set(values) if isinstance(values, Mapping) else {name}
    return varied


def is_replaced(name: str, system: Any, varied: set[str]) -> bool:
    """Return whether axes give all numbers of a start that this argument gives."""
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    return {name + side for side in sides} <= varied
