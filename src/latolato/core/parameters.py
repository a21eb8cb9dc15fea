"""What is known of a parameter: command line, files, forms, axes and checks are made from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from typing import Any

from latolato.core.quantities import ANY, Quantity, Range
from latolato.core.registry import types_of


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter: what it is, what it may be, and where its value stands.

    Attributes
    ----------
    name : str
        Option, axis and attribute.
    owner : str
        Table of a scenario that holds the value: system, drive, run or noise.
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
    several : bool
        Whether it holds a list.
    for_each_ball : bool
        Whether two balls have a value each.
    choices : tuple of str
        The words that it may be; empty if any.
    default : object
        None where the value is needed, or may be left out.
    suggested : tuple of float, optional
        Interval in which sliders move [SI].
    """

    name: str
    owner: str
    path: tuple[str, ...]
    kind: type
    description: str
    quantity: Quantity
    allowed: Range = ANY
    several: bool = False
    for_each_ball: bool = False
    choices: tuple[str, ...] = ()
    default: Any = None
    suggested: tuple[float, float] | None = None

    @property
    def unit(self) -> str:
        """The SI unit, "" for what has none."""
        return self.quantity.unit

    @property
    def is_number(self) -> bool:
        """Whether it is one number, which a sweep can vary."""
        return self.unit != "" and not self.several

    @property
    def help(self) -> str:
        """What it does, with the words that it may be."""
        words = f": {' or '.join(self.choices)}" if self.choices else ""
        return self.description + words


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
            default=None if field.default is MISSING else field.default,
            suggested=about.get("suggested"),
        )
