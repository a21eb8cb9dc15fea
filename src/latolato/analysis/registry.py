"""The analyses by name, and the labels that all their datasets carry."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from functools import cache, wraps
from inspect import signature
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.analysis.rules import said
from latolato.core.errors import Sentence, is_quantity, joined
from latolato.core.parameters import Parameter, function_parameters
from latolato.core.quantities import QUANTITIES, Quantity
from latolato.core.registry import Given, Registry, checked_array, describe, flattened
from latolato.core.versions import version_of
from latolato.physics.drives import Drive, Harmonic, drives
from latolato.physics.pendulum import System, systems
from latolato.simulation.parameters import RUN_PARAMETERS
from latolato.simulation.record import BALL, BALLS
from latolato.simulation.start import checked_drive, checked_system

if TYPE_CHECKING:
    import xarray as xr


class Analyses(Registry[Callable[..., Any]]):
    """Functions of a system, and of a drive where they take one, that return labelled datasets.

    Their arguments are checked before they begin. Numbers become floats or whole numbers within
    the `Range` of their annotation, values along an axis arrays; words must be among their choices.
    The result records them as attributes.
    """

    def __init__(self, kind: str) -> None:
        super().__init__(kind)
        self._checks: dict[str, tuple[Callable[..., Any], ...]] = {}

    def register(self, name: str, *checks: Callable[..., Any]) -> Callable[[Given], Given]:
        """Return a decorator that adds a function under `name`, and returns the checked one.

        `checks` raise InputError for systems and drives that it cannot treat. Their parameters are
        named as those of the function.
        """
        self._checks[name] = checks
        add = super().register(name)
        return lambda function: add(_checked_and_recorded(name, function))

    def check(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Raise InputError for a system or a drive that an analysis cannot treat."""
        for check in self._checks[name]:
            known = signature(check).parameters
            check(**{each: value for each, value in arguments.items() if each in known})


def _checked_and_recorded(name: str, function: Any) -> Any:
    """Return a function that passes checked arguments on, and records them in the result.

    None stays where it is the default.
    """
    called = signature(function)

    @cache  # not before the function's module is complete
    def known() -> dict[str, Parameter]:
        own = function_parameters(function, without=("system", "drive"))
        both = {name: RUN_PARAMETERS.get(name, each) for name, each in own.items()}
        return {name: each for name, each in both.items() if each.can_be_checked}

    @wraps(function)
    def checked(*args: Any, **options: Any) -> Any:
        try:
            bound = called.bind(*args, **options)
        except TypeError as error:
            raise TypeError(f"{function.__name__}: {error}") from None
        bound.apply_defaults()
        for own, parameter in known().items():
            value = bound.arguments[own]
            if parameter.unit_of and parameter.several:
                continue
            if parameter.unit_of and is_quantity(value):
                system, drive = bound.arguments["system"], bound.arguments["drive"]
                quantity = quantity_named(bound.arguments[parameter.unit_of], system, drive)
                parameter = replace(parameter, quantity=quantity)
            if value is not None or called.parameters[own].default is not None:
                bound.arguments[own] = _checked(parameter, value)
        analyses.check(name, bound.arguments)
        return recorded(name, function(*bound.args, **bound.kwargs), bound.arguments)

    return checked


def quantity_named(name: str, system: System, drive: Drive | None) -> Quantity:
    """Return the quantity of a parameter of a system or a drive, a plain number if unknown."""
    from latolato.simulation.vary import parameters_of

    drive = drive or Harmonic(drive_amplitude=0.0, drive_frequency=1.0)
    parameters = parameters_of(checked_system(system), checked_drive(drive))
    known = {each.name: each.quantity for each in parameters.values()}
    return (QUANTITIES | known).get(name, Quantity("1", "", str(name)))


def _checked(parameter: Parameter, value: Any) -> Any:
    """Return a checked argument; one number is an axis of one value."""
    if not parameter.several:
        return parameter.checked(value)
    if not isinstance(value, (list, tuple)) and not np.ndim(value):
        return np.array([parameter.checked(value)])
    return np.array(checked_array(parameter.name, value, parameter.allowed, unit=parameter.unit))


analyses = Analyses("analysis")


def warn(rule: str, /, **values: Any) -> None:
    """Warn the caller of an analysis, by a rule, that it has no answer, or a doubtful one."""
    text = said(rule, **values)
    warnings.warn(text, RuntimeWarning, stacklevel=4)  # past the analysis and its checks


_NOTES: ContextVar[list[Sentence] | None] = ContextVar("notes", default=None)


def note(*sentences: Sentence | None) -> str | None:
    """Return the message of a result, made of those that it needs, as text that files can hold."""
    needed = [each for each in sentences if each]
    if not needed:
        return None
    sentence = needed[0] if len(needed) == 1 else joined(needed, "; ")
    notes = _NOTES.get()
    if notes is not None:
        notes.append(sentence)
    return str(sentence)


@contextmanager
def noting() -> Iterator[list[Sentence]]:
    """Collect the messages of results with their parts, which pages translate."""
    notes: list[Sentence] = []
    token = _NOTES.set(notes)
    try:
        yield notes
    finally:
        _NOTES.reset(token)


# What several analyses name.
COMMON = {
    "status": Quantity("1", "", "status"),
    "ball": BALL,
    "multipliers": Quantity("1", r"\mu", "Floquet multipliers"),
    "impacts": Quantity("1", "n", "impacts in one period of the orbit"),
    "guess_distance": Quantity("rad", r"\Delta\theta_g", "distance of the orbit from the guess"),
}
# What a file can hold as an attribute.
_STORABLE = (int, float, str, tuple, list, np.generic, np.ndarray)


def labelled(
    variables: Mapping[str, Any],
    *,
    system: System | None = None,
    drive: Drive | None = None,
    coordinates: Mapping[str, Any] | None = None,
    quantities: Mapping[str, Quantity] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Return the dataset of an analysis with units, names and symbols.

    The arguments of the analysis become attributes when it returns (`recorded`).

    Parameters
    ----------
    variables : mapping
        Scalars, or ``(dims, values)``. Where one is over ``ball``, this coordinate is added.
    system, drive
        What the analysis was of: kind and parameters become attributes.
    coordinates : mapping
        Values along dimensions of the same names.
    quantities : mapping of str to Quantity
        Of names that neither `quantities.QUANTITIES` nor `COMMON` knows; each needs one.
    settings : mapping
        Further attributes, such as the value taken for an argument that was None; None is left out.
    """
    import xarray as xr

    known = {**QUANTITIES, **COMMON, **(quantities or {})}
    coordinates = {each: ((each,), values) for each, values in (coordinates or {}).items()}
    if any("ball" in value[0] for value in variables.values() if isinstance(value, tuple)):
        coordinates |= {"ball": (("ball",), list(BALLS))}
    attributes: dict[str, Any] = {}
    for registry, law in ((systems, system), (drives, drive)):
        if law is not None:
            attributes |= {registry.kind: registry.name_of(law), **flattened(describe(law))}

    def entry(key: str, value: Any) -> Any:
        dims, values = value if isinstance(value, tuple) else ((), value)
        return dims, values, known[key].attributes

    return xr.Dataset(
        {key: entry(key, value) for key, value in variables.items()},
        coords={key: entry(key, value) for key, value in coordinates.items()},
        attrs=attributes | flattened(settings or {}),
    )


def recorded(name: str, result: xr.Dataset, arguments: Mapping[str, Any]) -> xr.Dataset:
    """Return the result of an analysis with its name, versions and arguments as attributes.

    Attributes that the result has already remain; arguments that are variables, and laws, which
    `labelled` describes, are left out.
    """
    left_out = {"system", "drive", *map(str, result.variables)}
    own = {key: value for key, value in arguments.items() if key not in left_out}
    about = {
        "title": f"latolato analysis {name}",
        "analysis": name,
        "latolato_version": version_of(),
        "numpy_version": np.__version__,
        **flattened({key: value for key, value in own.items() if isinstance(value, _STORABLE)}),
    }
    return result.assign_attrs({**about, **result.attrs})
