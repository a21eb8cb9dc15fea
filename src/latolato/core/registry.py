"""Named collections of laws, and the checks that every law shares.

A law enters its registry by a decorator in the file that defines it; options of the command line,
scenario files, forms and tables are generated from the registries.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import lru_cache, wraps
from itertools import pairwise
from typing import Any, Generic, TypeVar, cast, get_type_hints

from latolato.core.errors import InputError, Word, is_quantity
from latolato.core.quantities import ANY, COUNT, Range, in_brackets
from latolato.core.rules import broken_rule, sentence

Entry = TypeVar("Entry")
Given = TypeVar("Given")
Law = TypeVar("Law")
Number = TypeVar("Number", bound=float)


# Of the longer name's letters, the part that a typo leaves: two slips in five letters are guessed.
_LIKENESS = 0.55
# Shorter parts of a name occur in too many others.
_SHORTEST_PART = 3
# Kinds of NumPy's types that hold real numbers, or any objects, each of which is checked.
_REAL = "fiuO"


def suggest(name: object, known: list[str]) -> str:
    """Return a closing clause such as ``did you mean 'length'?``, or a list of what is known.

    Suggested is the only known name that begins with `name`, capitals and dashes aside; else the
    one that the fewest slips of the pen lead from, if they are few for its length; else those that
    `name` is a part of.

    Examples
    --------
    >>> suggest("latlato", ["pendulum", "latolato"])
    "did you mean 'latolato'?"
    >>> suggest("drive_amp", ["drive_amplitude", "drive_phase"])
    "did you mean 'drive_amplitude'?"
    >>> suggest("phase", ["drive_amplitude", "drive_phase"])
    "did you mean 'drive_phase'?"
    >>> suggest("drive_times", ["times", "drive_phase"])
    "did you mean 'times'?"
    >>> suggest("mass", ["right_mass", "left_mass", "restitution"])
    'known are right_mass, left_mass'
    >>> suggest("friction", ["duration", "restitution"])
    'known are duration, restitution'
    """
    _, _, within = str(name).partition("_")  # options name the law too, its parameters do not
    if within in known:
        return _meant(within)
    typed = _plain(str(name))
    is_long = len(typed) >= _SHORTEST_PART
    longer = [each for each in known if _plain(each).startswith(typed)]
    if len(longer) == 1 and is_long:
        return _meant(longer[0])
    likeness = {each: _likeness(typed, _plain(each)) for each in known}
    nearest = max(known, key=likeness.__getitem__, default="")
    if known and likeness[nearest] >= _LIKENESS:
        return _meant(nearest)
    holders = [each for each in known if typed in _plain(each)]
    if len(holders) == 1 and is_long:
        return _meant(holders[0])
    return sentence("known", names=", ".join(holders if holders and is_long else known))


def _meant(name: str) -> str:
    """Return the clause that suggests a name."""
    return sentence("meant", name=name)


def _plain(name: str) -> str:
    """Return a name as it is compared: options have dashes where fields have underscores."""
    return name.lower().replace("-", "_")


def _likeness(name: str, other: str) -> float:
    """Return 1 - (slips that turn one name into the other)/(letters of the longer one).

    A slip drops, adds or changes a letter or swaps two neighbours (optimal string alignment;
    Damerau, 1964).
    """
    shorter, longer = sorted((len(name), len(other)))
    if shorter < _LIKENESS * longer or longer == 0:  # at least so many letters must be added
        return 0.0
    before: list[int] = []
    row = list(range(len(other) + 1))
    for i, letter in enumerate(name):
        before, last, row = row, before, [i + 1]
        for j, theirs in enumerate(other):
            slips = min(before[j + 1] + 1, row[j] + 1, before[j] + (letter != theirs))
            if i and j and letter == other[j - 1] and name[i - 1] == theirs:
                slips = min(slips, last[j - 1] + 1)
            row.append(slips)
    return 1.0 - row[-1] / longer


def types_of(law: type) -> dict[str, Any]:
    """Return the types of a law's fields by name; looked up once, as forms ask at every change."""
    return _TYPES(law)


_TYPES: Callable[[Any], dict[str, Any]] = lru_cache(maxsize=256)(get_type_hints)


class Registry(Mapping[str, Entry], Generic[Entry]):
    """Entries by name, in the order in which they were added."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._entries: dict[str, Entry] = {}

    def register(self, name: str) -> Callable[[Given], Given]:
        """Return a decorator that adds an entry under `name`, and keeps its own type."""

        def add(entry: Given) -> Given:
            if name in self._entries:
                raise ValueError(f"{self.kind} '{name}' is registered twice")
            self._entries[name] = cast(Entry, entry)
            return named(entry) if isinstance(entry, type) and is_dataclass(entry) else entry

        return add

    def __getitem__(self, name: str) -> Entry:
        if name not in self:
            hint = suggest(str(name), list(self._entries))
            raise broken_rule("unknown", {"kind": Word(self.kind), "name": name, "hint": hint})
        return self._entries[name]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def name_of(self, entry: Any) -> str:
        """Return the name under which `entry` (or the class of an instance) stands."""
        for name, known in self._entries.items():
            if known is entry or known is type(entry):
                return name
        raise InputError(f"{entry!r} is not a registered {self.kind}")

    def described(self, law: Any) -> dict[str, Any]:
        """Return the name of a law as its kind, and its fields as `describe` gives them."""
        return {"kind": self.name_of(law), **describe(law)}


def in_unit(name: str, value: Any, unit: str) -> Any:
    """Return a value as numbers in an SI unit.

    A quantity of pint, which is known by its methods, is converted and returned as its number or
    array; an xarray variable, a column of pandas and the like as their NumPy array. Anything else
    is returned as it is.

    Raises
    ------
    InputError
        If the unit of `value` does not convert to `unit`.

    Notes
    -----
    To pint an angle has no dimension, so it would take 1 Hz for 1 rad/s. Here a hertz is one turn
    per second, and the powers of the radian must agree. Only for an angle itself may the radian be
    missing, as in the ratio of an arc and its radius, and for a rate in Hz, such as that of frames.
    """
    if hasattr(value, "to_numpy") and is_quantity(getattr(value, "data", None)):
        value = value.data  # of an xarray variable, whose `to_numpy` would drop the unit
    if is_quantity(value):
        try:
            wanted = type(value)(1.0, "" if unit == "1" else unit)
            given, needed = (
                dict(value.to_root_units().unit_items()),
                dict(wanted.to_root_units().unit_items()),
            )
            turns, asked = (
                sum(power for each, power in units.unit_items() if each.endswith("hertz"))
                for units in (value, wanted)
            )
            angle = given.pop("radian", 0) + turns
            is_bare = angle == 0 and ((not given and unit == "rad") or unit == "Hz")
            if angle == needed.pop("radian", 0) + asked or is_bare:
                number = value.to(wanted.units).magnitude
                return number if is_bare or turns == asked else number * math.tau ** (turns - asked)
        # Those of pint: of another dimension, of an offset unit, of a unit that it does not know.
        except (ArithmeticError, AttributeError, TypeError, ValueError):
            pass
        way_out = "give it in rad/s or Hz" if unit == "rad/s" else None
        raise no_quantity(name, value, unit, way_out)
    stated = getattr(value, "attrs", {}).get("units", unit)
    if isinstance(stated, str) and stated not in (unit, ""):
        raise InputError(
            f"must be in {unit}, but its attribute units is '{stated}'",
            parameter=name,
            way_out="convert the values and correct the attribute",
        )
    return value.to_numpy() if hasattr(value, "to_numpy") else value


def no_quantity(name: str, value: Any, unit: str, way_out: str | None) -> InputError:
    """Return the error of a quantity whose unit does not convert."""
    rule = "plain_number" if unit == "1" else "quantity_of_unit"
    return broken_rule(rule, {"unit": unit}, parameter=name, value=value, way_out=way_out)


def checked_number(name: str, value: Any, allowed: Range, unit: str) -> float:
    """Return `value` as a float in its unit, or raise with the value, the rule and a way out.

    Raises
    ------
    InputError
        If `value` is no real number, NaN, infinite, outside `allowed` or of a size that cannot be
        computed with, or if it has a unit that does not convert.
    """
    rule, gaps = "number" if unit == "1" else "number_in_unit", {"unit": unit}
    if type(value) is not float:  # as most are
        value = in_unit(name, value, unit)
        dtype = getattr(getattr(value, "dtype", None), "kind", "f")
        if dtype not in _REAL or isinstance(value, (str, bytes, bytearray, bool)) or value is None:
            raise broken_rule(rule, gaps, parameter=name, value=value, way_out=_way_out(value))
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise broken_rule(
            rule, gaps, parameter=name, value=value, way_out=_way_out(value)
        ) from None
    except OverflowError:
        kind = sentence(rule, **gaps)
        raise InputError(f"{kind}, got an integer too large for a float", parameter=name) from None
    if not math.isfinite(number):
        raise broken_rule(rule, gaps, parameter=name, value=number)
    return _within(name, number, allowed, unit)


def _way_out(value: Any) -> str | None:
    """Return the way from a value that is no number to the number that was meant."""
    if isinstance(value, str) and value[:1].isdigit():
        return "give a plain number, or a quantity of pint; texts with units are for files"
    if hasattr(value, "total_seconds"):  # of the standard library and of pandas
        return "give its total_seconds()"
    if getattr(getattr(value, "dtype", None), "kind", "") == "m":
        return "divide it by np.timedelta64(1, 's')"
    return None


def checked_array(
    name: str, values: Any, allowed: Range = ANY, at_least: int = 1, *, unit: str
) -> array[float]:
    """Return several numbers as floats in their unit; each is checked as `checked_number` does.

    Parameters
    ----------
    values : iterable
        A list, a range, a one-dimensional array, a quantity of pint.
    at_least : int
        How many numbers are needed.

    Raises
    ------
    InputError
        If `values` is no row of numbers or is too short, or for the first number that is refused,
        which is named ``name[i]``.
    """
    values = in_unit(name, values, unit)
    shape, dtype = getattr(values, "shape", None), getattr(values, "dtype", None)
    rule, gaps = "numbers" if unit == "1" else "numbers_in_unit", {"unit": unit}
    no_row = isinstance(values, (str, bytes, bytearray, Mapping, Set)) or shape == ()
    if no_row or not hasattr(values, "__iter__"):
        raise broken_rule(rule, gaps, parameter=name, value=values)
    if shape is not None and len(shape) != 1:
        raise InputError(f"must be one-dimensional, got shape {tuple(shape)}", parameter=name)
    kind = getattr(dtype, "kind", "O")
    if kind not in _REAL:
        raise InputError(
            f"{sentence(rule, **gaps)}, got values of type {dtype}",
            parameter=name,
            way_out="divide them by np.timedelta64(1, 's')" if (kind, unit) == ("m", "s") else None,
        )
    if kind != "O":
        values = values.astype("f8").tolist()  # what a mask hides becomes None
    numbers = list(values)
    if len(numbers) < at_least:
        noun = "values" if at_least > 1 else "value"
        raise broken_rule(
            "list_length",
            {"least": at_least, "values": noun, "count": len(numbers)},
            parameter=name,
        )
    if set(map(type, numbers)) == {float} and all(map(math.isfinite, numbers)):
        ends = min(numbers), max(numbers)
        if all(limit.holds(end) for limit in allowed.limits(unit) for end in ends):
            return array("d", numbers)
    return array(
        "d", (checked_number(f"{name}[{i}]", each, allowed, unit) for i, each in enumerate(numbers))
    )


def check_increasing(name: str, values: Sequence[float]) -> None:
    """Raise InputError unless each value is larger than the one before."""
    for i, (a, b) in enumerate(pairwise(values)):
        if not b > a:
            place = {"after": b, "before": a, "place": i + 1}
            raise broken_rule("increasing", place, parameter=name)


def checked_count(name: str, value: Any, allowed: Range = COUNT) -> int:
    """Return a whole number, by default of at least 1 and such that a file can hold it.

    Raises
    ------
    InputError
        If `value` is none, or outside `allowed`.
    """
    try:
        is_whole = not isinstance(value, bool) and value == int(value)
    except (TypeError, ValueError, OverflowError):
        is_whole = False
    if not is_whole:
        raise broken_rule("whole_number", parameter=name, value=value)
    return _within(name, int(value), allowed, "1")


def checked_choice(name: str, value: Any, choices: Sequence[str]) -> str:
    """Return one of the words that a parameter may be.

    Raises
    ------
    InputError
        For any other.
    """
    if value not in choices:
        *others, last = map(repr, choices)
        guess = suggest(str(value), list(choices))
        raise broken_rule(
            "choice",
            {"words": ", ".join(others), "last": last},
            parameter=name,
            value=value,
            way_out=guess if guess.startswith("did") else None,
        )
    return str(value)


def _within(name: str, number: Number, allowed: Range, unit: str) -> Number:
    """Return a number, or raise with the first limit that it does not keep."""
    for limit in allowed.limits(unit):
        if not limit.holds(number):
            raise broken_rule(limit.rule, limit.values, parameter=name, value=number)
    return number


def number_fields(law: Any) -> list[Field[Any]]:
    """Return the fields of a law (class or instance) that hold one number."""
    return [f for f in fields(law) if "quantity" in f.metadata and not f.metadata.get("array")]


def check_fields(law: Any) -> None:
    """Check a frozen law: its words, and its numbers, which are stored as a float or an int.

    None stays where it is the default of a number.
    """
    kinds = types_of(type(law))
    for field in fields(law):
        if kinds[field.name] is str and field.metadata.get("choices"):
            checked_choice(field.name, getattr(law, field.name), field.metadata["choices"])
    for field in number_fields(law):
        value, allowed = getattr(law, field.name), field.metadata["range"]
        if value is None and field.default is None:
            continue
        if kinds[field.name] is int:
            number: float = checked_count(field.name, value, allowed)
        else:
            unit = field.metadata["quantity"].unit
            number = checked_number(field.name, value, allowed, unit)
        object.__setattr__(law, field.name, number)


def describe(law: Any) -> dict[str, Any]:
    """Return a law's parameters as plain values, nested laws as nested dictionaries.

    Values that equal their default are kept too: a file must not depend on later defaults. Only
    those of fields that are later than the files stay out, so that a description, and the hash of
    a plan, is what it was before the field.
    """
    result: dict[str, Any] = {}
    for f in fields(law):
        if not f.init:
            continue
        value = getattr(law, f.name)
        if f.metadata.get("is_later") and value == f.default:
            continue
        if hasattr(value, "__dataclass_fields__"):
            value = describe(value)
        elif isinstance(value, tuple):
            value = list(value)
        result[f.name] = value
    return result


def flattened(described: Mapping[str, Any]) -> dict[str, Any]:
    """Return a description as attributes, nested laws with their name in front.

    Examples
    --------
    >>> flattened({"kind": "ballpair", "right": {"mass": 0.1}, "gravity": 9.8, "noise": None})
    {'right_mass': 0.1, 'gravity': 9.8}
    """
    result: dict[str, Any] = {}
    for name, value in described.items():
        if isinstance(value, Mapping):
            result |= {f"{name}_{inner}": number for inner, number in value.items()}
        elif name != "kind" and value is not None:
            result[name] = int(value) if isinstance(value, bool) else value
    return result


def first_difference(
    names: Iterable[str], one: Mapping[str, Any], other: Mapping[str, Any]
) -> str | None:
    """Return the first name whose values differ by more than rounding, or None.

    Examples
    --------
    >>> first_difference(["mass", "radius"], {"mass": 0.1, "radius": 0.0}, {"mass": 0.1})
    'radius'
    """

    def are_close(a: Any, b: Any) -> bool:
        both = isinstance(a, (int, float)) and isinstance(b, (int, float))
        return a == b or (both and math.isclose(a, b, rel_tol=1e-9))

    return next((name for name in names if not are_close(one.get(name), other.get(name))), None)


def named(law: Law) -> Law:
    """Make a dataclass refuse unknown and missing parameters by name; return it.

    A notebook shows it as a table of its parameters.
    """
    kind: Any = law
    plain = kind.__init__

    @wraps(plain)
    def checked(self: Any, *positional: Any, **parameters: Any) -> None:
        if positional:
            example = next((f"{f.name}=..." for f in fields(kind) if f.init), "none")
            raise InputError(f"{kind.__name__} takes its parameters by name ({example})")
        _check_names(kind, parameters)
        plain(self, **parameters)

    kind.__init__ = checked
    kind._repr_html_ = _shown_in_notebooks
    return law


def _shown_in_notebooks(law: Any) -> str:
    """Return the parameters of a law as HTML."""
    from latolato.core.parameters import parameter_table  # made from this module

    return parameter_table(law)


def _check_names(kind: Any, parameters: Mapping[str, Any]) -> None:
    """Raise for an unknown name, with the closest known one, and for a missing one."""
    known = {f.name: f for f in fields(kind) if f.init}
    for name in parameters:
        if name not in known:
            raise InputError(
                f"unknown parameter '{{parameter}}' of {kind.__name__}: "
                f"{suggest(name, list(known))}",
                parameter=name,
            )
    missing = [
        name
        for name, f in known.items()
        if name not in parameters and f.default is MISSING and f.default_factory is MISSING
    ]
    if missing:
        name = missing[0]
        quantity = known[name].metadata.get("quantity")
        unit = in_brackets(quantity.unit) if quantity else ""
        raise broken_rule("needed", {"law": Word(kind.__name__), "unit": unit}, parameter=name)


def rebuild(kind: type, described: Mapping[str, Any]) -> Any:
    """Return the law of this kind that `describe` described.

    Raises
    ------
    InputError
        For unknown and missing parameters.
    """
    hints = types_of(kind)
    parameters = {
        name: rebuild(hints[name], value)
        if isinstance(value, Mapping) and is_dataclass(hints.get(name))
        else tuple(value)
        if isinstance(value, list)
        else value
        for name, value in described.items()
    }
    return kind(**parameters)
