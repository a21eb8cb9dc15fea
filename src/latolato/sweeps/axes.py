"""What can be varied, and the axes of a sweep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from latolato.core.errors import InputError
from latolato.core.parameters import Parameter, law_parameters
from latolato.core.quantities import NON_NEGATIVE, QUANTITIES
from latolato.core.registry import suggest
from latolato.physics.drives import drives
from latolato.physics.noise import KEY, STREAMS
from latolato.physics.pendulum import systems
from latolato.simulation.parameters import RUN_PARAMETERS

# Parameters that stand for another one, which is set from them.
DERIVED = {
    "frequency_ratio": "drive_frequency",
    "amplitude_ratio": "drive_amplitude",
    "drive_acceleration_ratio": "drive_amplitude",
}
# Parameters that set the same thing.
TARGETS = {**DERIVED, "initial_offset": "initial_angle"}


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


def parameters_of(system: Any, drive: Any, noise: Any = None) -> dict[str, Parameter]:
    """Return everything that a sweep can vary, by name.

    Parameters
    ----------
    system : System, or its class
    drive : Drive, or its class
    noise : VelocityKicks, or its class, optional
    """
    laws = {"system": system, "drive": drive} | ({"noise": noise} if noise is not None else {})
    result = {
        parameter.name: parameter
        for owner, law in laws.items()
        for parameter in law_parameters(law, owner)
        if parameter.is_number
    }
    for name, target in DERIVED.items():
        if target in result:
            result[name] = replace(
                result[target], name=name, kind=float, quantity=QUANTITIES[name],
                allowed=NON_NEGATIVE,
            )  # fmt: skip
    if "drive_frequency" not in result:  # stages have several accelerations
        result.pop("drive_acceleration_ratio", None)
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    starts = ["initial_angle", "initial_angular_velocity"]
    if "suspension" in system.__dataclass_fields__:
        starts.append("initial_distance")
    for name in starts:
        result |= {name + side: replace(RUN_PARAMETERS[name], name=name + side) for side in sides}
    if system.has_contacts and system.angles == 1:
        result["initial_offset"] = RUN_PARAMETERS["initial_offset"]
    for name in result.keys() & set(KEY):
        # Floats hold every whole number up to here, also of seeds.
        result[name] = replace(result[name], allowed=STREAMS)
    return result


def replaced(law: Any, values: Mapping[tuple[str, ...], Any]) -> Any:
    """Return a law with other values where these paths lead: to its own fields or its parts'."""
    changed: dict[str, Any] = {}
    for (name, *inner), value in values.items():
        if inner:
            changed.setdefault(name, {})[inner[0]] = value
        else:
            changed[name] = value
    parts = {n: replace(getattr(law, n), **v) for n, v in changed.items() if isinstance(v, dict)}
    return replace(law, **changed | parts) if changed else law


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
            raise InputError(f"axis {name} must not repeat a value, got {text} twice; remove one")
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
