"""The one error of refused input, and how a missing extra becomes one."""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from string import Formatter
from typing import Any, NamedTuple

# Returns what a user calls a parameter; with a value, what sets the parameter to that.
Naming = Callable[[str, str], str]
# Stands for a value that is not given, as None may be one.
NOT_GIVEN: Any = object()
# Where a rule names the parameter, as the input does or as its reader does.
_NAME, _READERS_NAME = "{parameter}", "{@}"
# Letters of a value in a text.
_LONGEST = 200


class NamedRule(NamedTuple):
    """A rule of a table: its name, its sentence and way out with gaps, and what stands in them.

    Pages say it in another language by its name.
    """

    name: str
    rule: str
    way_out: str
    values: Mapping[str, Any]


class Word(str):
    """A word in the gap of a sentence, which pages translate by itself."""

    __slots__ = ()


class Sentence(str):
    """The text of a rule with its gaps filled; pages say it in another language by its name.

    Parameters
    ----------
    named : NamedRule
        The rule and what stands in its gaps: numbers, texts, words and other sentences. One
        without a name only joins what stands in its gaps.
    part : {"rule", "way_out"}
        Which of its texts this is.

    Examples
    --------
    >>> text = Sentence(NamedRule("touch", "{count} balls touch", "", {"count": 2}))
    >>> text
    '2 balls touch'
    >>> in_parts(text)["values"]
    {'count': 2}
    """

    named: NamedRule
    part: str

    def __new__(cls, named: NamedRule, part: str = "rule") -> Sentence:
        """Return the text."""
        sentence = super().__new__(cls, _filled(named, part, python_name))
        sentence.named, sentence.part = named, part
        return sentence

    def __getnewargs__(self) -> Any:
        """Return what it is made of, from which copies are made."""
        return self.named, self.part


def python_name(parameter: str, value: str = "") -> str:
    """Return what Python calls a parameter, or what sets it to a word or a number.

    Examples
    --------
    >>> python_name("row_time"), python_name("damping", "0"), python_name("suspension", "rod")
    ('row_time', 'damping=0', "suspension='rod'")
    """
    if not value:
        return parameter
    return f"{parameter}={value!r}" if value.isidentifier() else f"{parameter}={value}"


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# From this power of ten on a number is written with it.
_POWER = 6


def as_read(number: str) -> str:
    """Return a number that Python wrote as people write it, with a minus sign and a power of ten.

    Examples
    --------
    >>> as_read("2.6e+02"), as_read("-0.00"), as_read("8.2e-05")[-3:], as_read("-0.5")[1:]
    ('260', '0.00', '0⁻⁵', '0.5')
    """
    digits, marked, power = number.partition("e")
    if marked and not 0 <= int(power) < _POWER:
        factor = digits[:-1] if digits in ("1", "-1") else f"{digits} \N{MULTIPLICATION SIGN} "
        text = f"{factor}10{str(int(power)).translate(_SUPERSCRIPTS)}"
    else:
        text = f"{float(number):.0f}" if marked else number
        text = text if text.strip("-0.") else text.removeprefix("-")
    return text.replace("-", "\N{MINUS SIGN}")


class _Sentences(Formatter):
    """Fills the gaps of sentences, with numbers as people write them."""

    def format_field(self, value: Any, format_spec: str) -> str:
        text: str = super().format_field(value, format_spec)
        is_number = format_spec.endswith("g") and math.isfinite(value)
        return as_read(text) if is_number else text


class _Gaps(dict[str, Any]):
    """What stands in the gaps of a sentence.

    ``{@end}`` is for the name of the parameter `end`, ``{@end=2}`` for what sets it to 2, and
    ``{@}`` for the name of the parameter at fault.
    """

    def __init__(self, values: Mapping[str, Any], name_of: Naming) -> None:
        super().__init__(values, parameter=_NAME)
        self.name_of = name_of

    def __missing__(self, gap: str) -> str:
        if not gap.startswith("@"):
            raise KeyError(gap)
        if gap == "@":
            return _READERS_NAME
        parameter, _, value = gap[1:].partition("=")
        return self.name_of(parameter, value)


def _filled(named: NamedRule, part: str, name_of: Naming) -> str:
    """Return a text of a rule with its gaps filled."""
    values = {
        gap: called(value, name_of) if isinstance(value, Sentence) else value
        for gap, value in named.values.items()
    }
    template: str = getattr(named, part)
    return _Sentences().vformat(template, (), _Gaps(values, name_of))


def called(text: str, name_of: Naming) -> str:
    """Return a text with what a user calls the parameters that its rule names, such as ``--end``.

    Examples
    --------
    >>> text = Sentence(NamedRule("cut", "give {@end=2}", "", {}))
    >>> text, called(text, "--{} {}".format)
    ('give end=2', 'give --end 2')
    """
    return _filled(text.named, text.part, name_of) if isinstance(text, Sentence) else text


def in_parts(value: Any) -> Any:
    """Return JSON that pages say in their language.

    A sentence is ``{"name", "part", "text", "values"}`` with the gaps of its text, and a word is
    ``{"word"}``.
    """
    if isinstance(value, Sentence):
        name, values = value.named.name, in_parts(value.named.values)
        text = getattr(value.named, value.part)
        return {"name": name, "part": value.part, "text": text, "values": values}
    if isinstance(value, Word):
        return {"word": str(value)}
    if isinstance(value, Mapping):
        return {key: in_parts(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [in_parts(each) for each in value]
    return _plain(value)


def joined(parts: Iterable[str | float], between: str = " ") -> Sentence:
    """Return sentences, words and numbers as one sentence."""
    values = {f"part_{k}": part for k, part in enumerate(parts)}
    return Sentence(NamedRule("", between.join(f"{{{name}}}" for name in values), "", values))


def name_gap(parameter: str) -> Sentence:
    """Return what a user calls a parameter, for the gap of a sentence."""
    return Sentence(NamedRule("", f"{{@{parameter}}}", "", {}))


def quantity_gap(value: float, unit: str) -> Sentence:
    """Return a number with its SI unit, for the gap of a sentence; pages have units of their own.

    Examples
    --------
    >>> print(quantity_gap(0.25, "rad"))
    0.25 rad
    """
    return Sentence(NamedRule("", "{value:.6g}{unit}", "", {"value": value, "unit": f" {unit}"}))


class InputError(ValueError):
    """Input that breaks a rule; any other exception is a bug in the program.

    Its text is one line, made of its parts: ``radius must lie in [0, length), got 0.5; give less
    than 0.4``. Programs read the parts, never the text.

    Parameters
    ----------
    rule : str
        What must hold, as the rest of a sentence that begins with the parameter's name, or a
        whole sentence in which ``{parameter}`` stands for that name, or ``{@}`` for what its reader
        calls the parameter; just a sentence if no single parameter is at fault.
    parameter : str, optional
        Name of the parameter at fault.
    value : object, optional
        What was given for it.
    way_out : str, optional
        What to give or do instead.

    Attributes
    ----------
    where : str
        The file that the input is about, "" if none is; begins the text.
    is_of_file : bool
        Whether that file gives the value, and not a call or a command.
    name_of : callable
        Returns what its reader calls parameters, see `called`; by default as Python does.

    Examples
    --------
    >>> error = InputError("must lie in [0, 1]", parameter="restitution", value=2, way_out="give 1")
    >>> print(error)
    restitution must lie in [0, 1], got 2; give 1
    >>> error.parameter
    'restitution'
    >>> print(InputError("Pendulum needs '{parameter}' [m]", parameter="length"))
    Pendulum needs 'length' [m]
    """

    def __init__(
        self,
        rule: str,
        *,
        parameter: str | None = None,
        value: Any = NOT_GIVEN,
        way_out: str | None = None,
    ) -> None:
        super().__init__(rule)
        self.rule = rule
        self.parameter = parameter
        self.value: Any = None if value is NOT_GIVEN else value
        self.has_value: bool = value is not NOT_GIVEN
        self.way_out = way_out
        self.where = ""
        self.is_of_file = False
        self.name_of: Naming = python_name

    def worded(self, name: str | None) -> str:
        """Return the whole text on one line, with this name for the parameter."""
        text = called(self.rule, self.name_of)
        if self.parameter is not None:
            if _NAME not in text and _READERS_NAME not in text:
                text = f"{_NAME} {text}"
            readers = self.name_of(str(name), "")
            own = readers if self.is_of_file else str(name)
            for gap, each in (_NAME, own), (_READERS_NAME, readers):
                if each.startswith(("\u201c", "--")):  # a label has quotes, a flag needs none
                    text = text.replace(f"'{gap}'", gap)
                text = text.replace(gap, each)
        if self.has_value:
            # Arrays and numbers of numpy as Python's own.
            value = _plain(self.value)
            if isinstance(value, float):
                shown = f"{value:.9g}"
            else:
                shown = str(value) if is_quantity(value) else repr(value)
            text += f", got {shown:.{_LONGEST}}"
        if self.way_out is not None:
            text += f"; {called(self.way_out, self.name_of)}"
        if self.where:
            text = f"{self.where}: {text}"
        return " ".join(text.split())

    def parts(self) -> dict[str, Any] | None:
        """Return what the text is made of, as JSON; None where JSON cannot hold it.

        Sentences are as `in_parts` has them.
        """
        result = {"rule": in_parts(self.rule), "parameter": self.parameter}
        if self.where:
            result["where"] = self.where
        if self.has_value:
            result["value"] = _plain(self.value)
        if self.way_out is not None:
            result["way_out"] = in_parts(self.way_out)
        try:
            json.dumps(result, allow_nan=False)
        except (TypeError, ValueError):
            return None
        return result

    def add_way_out(self, text: str) -> None:
        """Say one more thing that can be done."""
        self.way_out = text if self.way_out is None else joined([self.way_out, text], "; ")

    def __str__(self) -> str:
        return self.worded(self.parameter)

    def __reduce__(self) -> tuple[Any, ...]:
        # Exceptions are rebuilt from `args` alone; one that comes from a worker keeps its parts.
        return _rebuilt, (type(self), self.args, vars(self))


def _rebuilt(kind: type[InputError], rule: tuple[str], parts: dict[str, Any]) -> InputError:
    error = kind(*rule)
    vars(error).update(parts)
    return error


def _plain(value: Any) -> Any:
    """Return a value, and those in a tuple or list, without numpy's types."""
    if type(value) in (tuple, list):
        return type(value)(map(_plain, value))
    if is_quantity(value):  # has a `tolist` that fails
        return value
    return getattr(value, "tolist", lambda: value)()


def is_quantity(value: Any) -> bool:
    """Return whether a value is a quantity of pint, which need not be imported for it."""
    return all(hasattr(type(value), name) for name in ("magnitude", "units", "to_root_units"))


@contextmanager
def reading(path: str | Path, *, gives_values: bool = False) -> Iterator[None]:
    """Name a file in errors that are raised meanwhile, unless they name another one.

    `gives_values` is whether the values that may be refused are those of the file.
    """
    try:
        yield
    except InputError as error:
        error.where = error.where or str(path)
        error.is_of_file = error.is_of_file or gives_values
        raise


def extra_command(extra: str) -> str:
    """Return the command that installs an extra; the package is on no index."""
    return f'in a clone of the repository, run: pip install ".[{extra}]"'


def import_extra(module: str, extra: str, purpose: str, *, way_out: str = "") -> Any:
    """Return a module that an extra of this package installs.

    Parameters
    ----------
    module : str
        Its name.
    extra : str
        The extra.
    purpose : str
        What needs it, as the subject of a sentence.
    way_out : str, optional
        What to do without it, beside installing the extra.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        missing = error.name or module
        if missing.partition(".")[0] == "latolato":
            raise
        either = f", or {way_out}" if way_out else ""
        raise InputError(
            f"{purpose} needs the package '{missing}'", way_out=f"{extra_command(extra)}{either}"
        ) from None
