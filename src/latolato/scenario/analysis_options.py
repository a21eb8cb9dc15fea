"""Options of an analysis, made from the signature of its function and from its docstring."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES, Quantity
from latolato.scenario.options import law_options
from latolato.scenario.tables import RUN_OPTIONS
from latolato.scenario.units import to_si
from latolato.scenario.variation import read_axes

# What every analysis or fit is of; everything else that it takes is an option.
LAWS = ("system", "drive", "table")
_UNIT = re.compile(r"\s*\[(1|[a-zA-Z][\w*/^()]*)\]")
_REFERENCE = re.compile(r"As (?:in|of|for) `+(?P<name>[\w.]+)`+")


@dataclass(frozen=True)
class AnalysisOption:
    """An option of the command line that sets one parameter of an analysis.

    Attributes
    ----------
    kind : type
        bool, int, float or str, of one value.
    unit : str, optional
        The SI unit; None for that of the quantity which another option names.
    is_sequence, is_single : bool
        Whether several values are taken, and whether one alone stays a number.
    default
        Of the function; `inspect.Parameter.empty` where there is none.
    choices : tuple of str
        The words that it may be, from a `Literal`; empty if any.
    """

    name: str
    kind: type
    description: str
    unit: str | None
    is_sequence: bool
    is_single: bool
    default: Any
    choices: tuple[str, ...] = ()

    @property
    def flag(self) -> str:
        """How it is typed."""
        return "--" + self.name.replace("_", "-")

    @property
    def is_required(self) -> bool:
        """Whether the function has no default."""
        return self.default is inspect.Parameter.empty

    @property
    def is_of_run(self) -> bool:
        """Whether it is an entry of a scenario's ``[run]`` too."""
        return self.name in RUN_OPTIONS

    def value(self, given: Any, unit: str) -> Any:
        """Return what the function gets for what was typed."""
        if self.kind in (bool, str) and not self.is_sequence:
            return given
        if self.kind is str:
            return [part.strip() for part in given.split(",")]
        several = self.is_sequence and not (self.is_single and not set(",:") & set(str(given)))
        if not several:
            return given if self.kind is int else to_si(self.name, given, unit)
        known = {self.name: Quantity(unit, "", self.name)}
        values = read_axes({self.name: given}, known, Path())[self.name]
        if self.kind is not int:
            return list(values)
        if any(number != int(number) for number in values):
            raise InputError("must be whole numbers", parameter=self.name, value=given)
        return [int(number) for number in values]

    def help(self) -> str:
        """Return what is said about the option."""
        law = law_options().get(self.name)
        parts = [self.description]
        if self.choices:
            parts[0] += f": {' or '.join(self.choices)}"
        if self.unit not in (None, "", "1"):
            parts[0] += f", in {self.unit}"
        if self.is_required:
            has_law = law is not None and not self.is_sequence
            parts.append("by default the scenario's" if has_law else "needed")
        elif self.default is not None and self.kind is not bool:
            text = ", ".join(map(_shown, _listed(self.default)))
            where = "the scenario's, else " if self.is_of_run else ""
            parts.append(f"by default {where}{text}")
        return "; ".join(part for part in parts if part)


def _listed(value: Any) -> list[Any]:
    """Return a default as a list."""
    return list(value) if isinstance(value, (list, tuple)) else [value]


def _shown(value: Any) -> str:
    """Return one value as it would be typed."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def options_of(function: Callable[..., Any]) -> dict[str, AnalysisOption]:
    """Return the options of an analysis by name.

    Optional parameters of a kind that cannot be typed, such as a mapping, are left out.

    Raises
    ------
    TypeError
        If a needed parameter has such a kind.
    """
    texts = parameter_texts(inspect.getdoc(function) or "")
    result = {}
    for name, parameter in inspect.signature(function).parameters.items():
        if name in LAWS:
            continue
        hint = _hint(parameter.annotation, function)
        choices = get_args(hint) if get_origin(hint) is Literal else ()
        kinds = (str, None) if choices else _kinds(hint)
        if kinds is None:
            if parameter.default is parameter.empty:
                raise TypeError(f"{function.__name__} needs '{name}', which cannot be typed")
            continue
        single, several = kinds
        text, unit = _about(name, texts)
        result[name] = AnalysisOption(
            name=name,
            kind=several or single or str,
            description=text,
            unit=unit if (several or single) is float else "1",
            is_sequence=several is not None,
            is_single=single is not None,
            default=parameter.default,
            choices=choices,
        )
    return result


def _hint(annotation: Any, function: Any) -> Any:
    """Return the type that an annotation of a function names, None for one that is not known."""
    holder = SimpleNamespace(__annotations__={"it": annotation})
    scope = {"Sequence": Sequence, "Mapping": Mapping, "Callable": Callable, "Any": Any}
    try:
        return get_type_hints(holder, function.__globals__, scope)["it"]
    except NameError:
        return None


def _kinds(hint: Any) -> tuple[type | None, type | None] | None:
    """Return the kinds of one value and of each of several, None for a kind that is not known."""
    if hint is None:
        return None
    parts = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    single: type | None = None
    several: type | None = None
    for part in parts:
        if part is type(None):
            continue
        if _is_sequence(part):
            several = get_args(part)[0]
            if several not in (int, float, str):
                return None
        elif part in (bool, int, float, str):
            single = float if float in (part, single) else part
        else:
            return None
    return single, several


def _is_sequence(hint: Any) -> bool:
    """Return whether a type holds several values of one kind."""
    origin = get_origin(hint)
    return isinstance(origin, type) and issubclass(origin, Sequence) and bool(get_args(hint))


def _about(name: str, texts: Mapping[str, str]) -> tuple[str, str | None]:
    """Return what an option does, and its unit."""
    text = _followed(name, texts)
    units = _UNIT.findall(text)
    quantity = QUANTITIES.get(name) or QUANTITIES.get(name.removesuffix("s"))
    if quantity is not None:
        unit: str | None = quantity.unit
    elif units:
        unit = units[0]
    else:
        unit = None if re.search(r"\bunit\b", text) else "1"
    if name in RUN_OPTIONS:
        return RUN_OPTIONS[name].description, unit
    said = plain_text(_UNIT.sub("", text)).rstrip(".")
    if said[1:2].islower() or said[1:2] == " ":
        said = said[0].lower() + said[1:]
    return said or name.replace("_", " "), unit


def _followed(name: str, texts: Mapping[str, str]) -> str:
    """Return the text on a parameter, that of another analysis where it refers to one."""
    from latolato.analysis import analyses

    text = texts.get(name, "")
    for _ in analyses:
        reference = _REFERENCE.match(text)
        if reference is None:
            return text
        other = reference["name"].rpartition(".")[2]
        if other not in analyses:
            break
        text = parameter_texts(inspect.getdoc(analyses[other]) or "").get(name, "")
    return ""


def parameter_texts(docstring: str) -> dict[str, str]:
    r"""Return what the section Parameters of a numpydoc docstring says, by name.

    Examples
    --------
    >>> parameter_texts("Return.\n\nParameters\n----------\nlow, high : float\n    Ends [m].")
    {'low': 'Ends [m].', 'high': 'Ends [m].'}
    """
    lines = docstring.splitlines()
    result: dict[str, str] = {}
    names: list[str] = []
    is_inside = False
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if re.fullmatch(r"-{3,}", below.strip()) and line and not line[0].isspace():
            is_inside = line.strip() == "Parameters"
        elif not is_inside or re.fullmatch(r"-{3,}", line.strip()):
            continue
        elif line and not line[0].isspace():
            names = [name.strip() for name in line.partition(" : ")[0].split(",")]
            result |= dict.fromkeys(names, "")
        elif line.strip():
            result |= {name: f"{result[name]} {line.strip()}".strip() for name in names}
    return result


def summary_of(function: Callable[..., Any]) -> str:
    """Return the first line of a docstring as a list of commands shows it."""
    first = plain_text((inspect.getdoc(function) or "").partition("\n")[0].removeprefix("Return "))
    return first[:1].upper() + first[1:]


def plain_text(text: str) -> str:
    """Return a docstring's text without its marks; brackets would be taken for a style."""
    without = re.sub(r"\s*\[1\]", "", text).replace("`", "")
    return " ".join(re.sub(r"\[([a-zA-Z][^\]]*|1/[^\]]*)\]", r"(\1)", without).split())
