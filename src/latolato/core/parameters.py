"""What is known of a parameter: command line, files, forms, axes and checks are made from it."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from html import escape
from types import SimpleNamespace, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from latolato.core.quantities import ANY, COUNT, QUANTITIES, Limit, Quantity, Range
from latolato.core.registry import (
    checked_array,
    checked_choice,
    checked_count,
    checked_number,
    types_of,
)


def flag_of(name: str, value: str = "") -> str:
    """Return the flag of a parameter, with a value if one is given.

    Examples
    --------
    >>> flag_of("row_time"), flag_of("drag_frame", "lab")
    ('--row-time', '--drag-frame lab')
    """
    return f"--{name.replace('_', '-')} {value}".rstrip()


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter: what it is, what it may be, and where its value stands.

    Attributes
    ----------
    name : str
        Option, axis and attribute.
    owner : str
        Table of a scenario that holds the value: system, drive, run, noise or sweep; "" for none.
    path : tuple of str
        Where the value stands below the owner.
    kind : type
        Of one value: float, int, bool or str.
    description : str
        What it does, without its unit.
    quantity : Quantity
        Unit, symbol and long name; the unit is "" for a word, a switch or a plain count.
    allowed : Range
        Where the value may lie [SI].
    several, or_one : bool
        Whether it holds a list, and whether one value alone may stand for it.
    for_each_ball : bool
        Whether two balls have a value each.
    unit_of : str
        The parameter that names the quantity whose unit this one has, "" if the unit is its own.
    choices : tuple of str
        The words that it may be; empty if any.
    is_required : bool
        Whether there is no default.
    default : object
        None where the value is needed, or may be left out.
    suggested : tuple of float, optional
        Interval in which sliders move [SI].
    is_later : bool
        Whether descriptions leave it out at its default; see `quantities.quantity_field`.
    """

    name: str
    kind: type
    description: str
    quantity: Quantity
    owner: str = ""
    path: tuple[str, ...] = ()
    allowed: Range = ANY
    several: bool = False
    or_one: bool = False
    for_each_ball: bool = False
    unit_of: str = ""
    choices: tuple[str, ...] = ()
    is_required: bool = False
    default: Any = None
    suggested: tuple[float, float] | None = None
    is_later: bool = False

    @property
    def unit(self) -> str:
        """The SI unit, "" for what has none."""
        return self.quantity.unit

    @property
    def is_number(self) -> bool:
        """Whether it is one number, which a sweep can vary."""
        return self.unit != "" and not self.several

    @property
    def flag(self) -> str:
        """How the option is typed."""
        return flag_of(self.name)

    @property
    def help(self) -> str:
        """What it does, with the words that it may be."""
        words = f"; one of {', '.join(self.choices)}" if self.choices else ""
        return self.description + words

    @property
    def limits(self) -> tuple[Limit, ...]:
        """What the number must keep, with the words of a refusal."""
        return self.allowed.limits(self.unit or "1") if self.kind in (float, int) else ()

    @property
    def can_be_checked(self) -> bool:
        """Whether it is described what a value may be: numbers, or one of some words."""
        return bool(self.choices) or (self.kind in (float, int) and not self.for_each_ball)

    def checked(self, value: Any) -> Any:
        """Return a number as a float or an int, or a word, or raise an `InputError`."""
        if self.choices:
            return checked_choice(self.name, value, self.choices)
        if self.kind is int:
            return checked_count(self.name, value, self.allowed)
        return checked_number(self.name, value, self.allowed, self.unit)

    def checked_row(self, values: Any) -> tuple[float, ...]:
        """Return the numbers of an axis as floats, or raise an `InputError`."""
        numbers = tuple(checked_array(self.name, values, self.allowed, unit=self.unit))
        if self.kind is int:
            for number in numbers:
                checked_count(self.name, number, self.allowed)
        return numbers


def law_parameters(law: Any, owner: str) -> Iterator[Parameter]:
    """Yield the parameters of a law (class or instance), and of the laws that it is made of.

    Examples
    --------
    >>> from latolato.physics.pendulum import BallPair
    >>> [p.name for p in law_parameters(BallPair, "system")][:3]
    ['gravity', 'right_length', 'right_mass']
    """
    kinds = types_of(law if isinstance(law, type) else type(law))
    for field in fields(law):
        if not field.init:
            continue
        kind = kinds[field.name]
        if is_dataclass(kind):
            for part in law_parameters(kind, owner):
                yield replace(
                    part,
                    name=f"{field.name}_{part.name}",
                    path=(field.name, *part.path),
                    description=f"{part.description}, {field.name} ball",
                )
            continue
        about = field.metadata
        words = field.name.replace("_", " ")
        quantity = about.get("quantity", Quantity("1" if kind is float else "", "", words))
        plain = kind if kind in (bool, int) else float if quantity.unit else str
        yield Parameter(
            name=field.name,
            owner=owner,
            path=(field.name,),
            kind=plain,
            description=about.get("description", words),
            quantity=quantity,
            allowed=about.get("range") or ANY,
            several=bool(about.get("array")),
            choices=tuple(about.get("choices", ())),
            is_required=field.default is MISSING,
            default=None if field.default is MISSING else field.default,
            suggested=about.get("suggested"),
            is_later=bool(about.get("is_later")),
        )


def parameter_table(law: Any) -> str:
    """Return a law's parameters as a table in HTML: meaning, symbol, name, value and unit.

    Examples
    --------
    >>> from latolato.physics.pendulum import Pendulum
    >>> table = parameter_table(Pendulum(length=0.363, mass=0.108))
    >>> "<td>$l$</td><td><code>length</code></td><td>0.363 m</td>" in table
    True
    """
    rows = []
    for parameter in law_parameters(law, ""):
        value = law
        for name in parameter.path:
            value = getattr(value, name)
        symbol = f"${parameter.quantity.symbol}$" if parameter.quantity.symbol else ""
        cells = (symbol, f"<code>{parameter.name}</code>", escape(_shown(parameter, value)))
        rows.append(
            f"<tr><th>{escape(parameter.description)}</th><td>{'</td><td>'.join(cells)}</td></tr>"
        )
    return f"<table><caption>{type(law).__name__}</caption>{''.join(rows)}</table>"


def _shown(parameter: Parameter, value: Any) -> str:
    """Return a value with its unit, of several how many there are."""
    if value is None:
        return "none"
    unit = "" if parameter.unit in ("", "1") else f" {parameter.unit}"
    if parameter.several:
        return f"{len(value)} values{unit and ' in'}{unit}"
    return f"{value:.9g}{unit}" if isinstance(value, float) else f"{value}{unit}"


@dataclass(frozen=True)
class UnitOf:
    """Mark of a number in the unit of the quantity that another parameter names.

    Of several numbers each has the unit of its own name there; the function checks them itself.
    """

    parameter: str


def function_parameters(
    function: Callable[..., Any], without: Container[str] = ()
) -> dict[str, Parameter]:
    """Return the parameters of a function that can be typed, by name.

    Kind and choices come from the annotations, the description from the docstring. The unit is that
    of the quantity of this name, else the one of the annotation, as in ``Annotated[float, "rad"]``.
    A `Range` there says where a number may lie: by default anywhere, or from 1 on if it is a count.

    Raises
    ------
    TypeError
        If a needed parameter has a kind that cannot be typed, such as a mapping.
    """
    texts = parameter_texts(inspect.getdoc(function) or "")
    result = {}
    for name, parameter in inspect.signature(function).parameters.items():
        if name in without:
            continue
        hint = _hint(parameter.annotation, function)
        marks: dict[type, Any] = {type(mark): mark for mark in getattr(hint, "__metadata__", ())}
        if get_origin(hint) is Annotated:
            hint = get_args(hint)[0]
        kinds = [kind for kind in get_args(hint) if kind is not type(None)]
        if get_origin(hint) in (Union, UnionType) and len(kinds) == 1:
            hint = kinds[0]
        choices = get_args(hint) if get_origin(hint) is Literal else ()
        is_needed = parameter.default is parameter.empty
        single, several = (str, None) if choices else _kinds(hint)
        kind = several or single
        if kind is None:
            if is_needed:
                raise TypeError(f"{function.__name__} needs '{name}', which cannot be typed")
            continue
        words = name.replace("_", " ")
        known = QUANTITIES.get(name) or QUANTITIES.get(name.removesuffix("s"))
        unit = marks.get(str) or ("" if kind in (bool, str) else "1")
        if known is None or kind is not float or str in marks:
            known = Quantity(unit, "", words)
        text = texts.get(name, "").replace(f" [{known.unit}]", "")
        result[name] = Parameter(
            name=name,
            kind=kind,
            description=text or words,
            quantity=known,
            allowed=marks.get(Range, COUNT if kind is int else ANY),
            several=several is not None,
            or_one=several is not None and single is not None,
            unit_of=marks.get(UnitOf, UnitOf("")).parameter,
            choices=choices,
            is_required=is_needed,
            default=None if is_needed else parameter.default,
        )
    return result


def _hint(annotation: Any, function: Any) -> Any:
    """Return the type that an annotation of a function names, None for one that is not known."""
    holder = SimpleNamespace(__annotations__={"it": annotation})
    scope = {"Sequence": Sequence, "Mapping": Mapping, "Callable": Callable, "Any": Any}
    try:
        known = vars(sys.modules[inspect.unwrap(function).__module__])
        return get_type_hints(holder, known, scope, include_extras=True)["it"]
    except NameError:
        return None


def _kinds(hint: Any) -> tuple[type | None, type | None]:
    """Return the kinds of one value and of each of several, None for a kind that is not known."""
    single: type | None = None
    several: type | None = None
    for part in get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,):
        origin = get_origin(part)
        if part in (bool, int, float, str):
            single = float if float in (part, single) else part
        elif isinstance(origin, type) and issubclass(origin, Sequence):
            several = next((kind for kind in get_args(part) if kind in (int, float, str)), None)
        elif part is not type(None):
            return None, None
    return single, several


def parameter_texts(docstring: str) -> dict[str, str]:
    r"""Return the entries of the section Parameters of a numpydoc docstring, by name.

    Examples
    --------
    >>> parameter_texts("Return.\n\nParameters\n----------\nlow, high : float\n    Ends [m].")
    {'low': 'Ends [m].', 'high': 'Ends [m].'}
    """
    result: dict[str, str] = {}
    names: list[str] = []
    for line in docstring.partition("\nParameters\n----------\n")[2].splitlines():
        if line.startswith("---"):  # below the title of the next section
            del result[names[0]]
            break
        if line[:1].strip():
            names = [name.strip() for name in line.partition(" : ")[0].split(",")]
            result |= dict.fromkeys(names, "")
        else:
            result |= {name: f"{result[name]} {line.strip()}".strip() for name in names}
    return result
