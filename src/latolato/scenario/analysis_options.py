"""Options of an analysis, a fit or a measurement, made from its function."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from latolato.core.errors import InputError
from latolato.core.parameters import Parameter, function_parameters
from latolato.core.quantities import Quantity
from latolato.scenario.tables import RUN_OPTIONS
from latolato.scenario.units import to_si
from latolato.scenario.variation import read_axes

# What every analysis or fit is of; everything else that it takes is an option.
LAWS = ("system", "drive", "table")


def options_of(
    function: Callable[..., Any], without: Collection[str] = LAWS
) -> dict[str, Parameter]:
    """Return the options of a function by name; the owner `run` marks those of runs."""
    result = {}
    for name, parameter in function_parameters(function, without).items():
        text = plain_text(parameter.description).rstrip(".")
        if text[1:2].islower() or text[1:2] == " ":
            text = text[0].lower() + text[1:]
        result[name] = replace(parameter, description=text)
        if name in RUN_OPTIONS:
            about = RUN_OPTIONS[name].description
            result[name] = replace(parameter, owner="run", description=about)
    return result


def arguments_of(options: Mapping[str, Parameter], values: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of a function for the options that are given, in SI units."""
    return {
        name: read_value(option, values[name])
        for name, option in options.items()
        if values.get(name) is not None
    }


def read_value(option: Parameter, value: Any, unit: str | None = None) -> Any:
    """Return the argument for the text of an option; a number without a unit is in its own."""
    unit = unit or option.unit
    if option.kind in (bool, str):
        if not option.several:
            return value
        texts = value if isinstance(value, list) else [value]  # the option's, given several times
        return [part.strip() for text in texts for part in text.split(",")]
    if not option.several or (option.or_one and not set(",:") & set(str(value))):
        if option.kind is int and isinstance(value, str):
            return _whole(option.name, value)
        return to_si(option.name, value, unit)
    known = {option.name: Quantity(unit, "", option.name)}
    values = read_axes({option.name: value}, known, Path())[option.name]
    if option.kind is not int:
        return list(values)
    if any(number != int(number) for number in values):
        raise InputError("must be whole numbers", parameter=option.name, value=value)
    return [int(number) for number in values]


def _whole(name: str, text: str) -> int:
    """Return the whole number that a text is, which may be written as 2e7."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not number.is_integer():
        raise InputError("must be a whole number", parameter=name, value=text)
    return int(number)


def summary_of(function: Callable[..., Any]) -> str:
    """Return the first line of a docstring as a list of commands shows it."""
    first = plain_text((inspect.getdoc(function) or "").partition("\n")[0].removeprefix("Return "))
    return first[:1].upper() + first[1:]


def plain_text(text: str) -> str:
    """Return a docstring's text without its marks; brackets would be taken for a style."""
    without = re.sub(r"\s*\[1\]", "", text).replace("`", "")
    return " ".join(re.sub(r"\[([a-zA-Z][^\]]*|1/[^\]]*)\]", r"(\1)", without).split())
