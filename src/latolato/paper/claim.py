"""Claims of the paper, judged by code: words, computed numbers, stated limits, a verdict.

A `Statement` holds what is known before anything is computed: the paper's words and the limits
that numbers must keep for them to be true. They all stand in ``claims.toml``. `Statement.judge`
turns numbers into a `Claim`. `Evidence` computes and draws what the numbers come from.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from latolato.core.registry import suggest
from latolato.figures.style import unit_after

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Numbers = Mapping[str, float]
_LINE_END = re.compile(r"\s*\n\s*")
_TYPES: dict[str, Any] = {"str": str, "float": (float, int), "bool": bool}


class Verdict(Enum):
    """What became of a claim."""

    REPRODUCED = "reproduced"
    ASSUMED = "reproduced with an assumption"
    NOT_AS_PRINTED = "not as printed"
    METHOD_CHECK = "method check, not testable from the paper"


@dataclass(frozen=True)
class Limit:
    """A closed interval that a computed number must lie in.

    Parameters
    ----------
    number : str
        Name among the computed numbers.
    meaning : str
        What the number is, in words.
    low, high : float
        The interval; an infinite end is no limit, but one end at least is finite.
    unit : str
        SI unit of the number and of the ends.
    """

    number: str
    meaning: str
    low: float = -math.inf
    high: float = math.inf
    unit: str = "1"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) or math.isfinite(self.high)) or self.low > self.high:
            raise ValueError(
                f"the limit on '{self.number}' needs a low or a high end, in this order; "
                f"got {self.low} to {self.high}"
            )

    def holds(self, numbers: Numbers) -> bool:
        """Return whether the number lies in the interval; NaN never does."""
        return self.low <= numbers[self.number] <= self.high

    @property
    def demand(self) -> str:
        """The interval in words, e.g. ``at most 0.01``."""
        if self.low == -math.inf:
            text = f"at most {_text(self.high)}"
        elif self.high == math.inf:
            text = f"at least {_text(self.low)}"
        else:
            text = f"{_text(self.low)} to {_text(self.high)}"
        return unit_after(text, self.unit)

    def report(self, numbers: Numbers) -> str:
        """Return the number beside its limit, e.g. ``difference: 0.00403 (at most 0.01)``."""
        number = unit_after(_text(numbers[self.number]), self.unit)
        return f"{self.meaning}: {number} ({self.demand})"


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A judged statement, ready to be shown.

    Attributes
    ----------
    name, where, words : str
        Identifier, place in the paper, short quotation.
    finding : str
        What was computed, in a sentence with numbers.
    criteria : tuple of (str, bool)
        Each number beside its limit, and whether it kept it.
    assumption : str
        What had to be assumed; empty for none.
    verdict : Verdict
        By the numbers and limits alone, unless it is a method check.
    why : str
        One or two sentences of explanation.
    numbers : dict of str to float
        The computed numbers in SI units.
    """

    name: str
    where: str
    words: str
    finding: str
    criteria: tuple[tuple[str, bool], ...]
    assumption: str
    verdict: Verdict
    why: str
    numbers: Numbers


@dataclass(frozen=True, kw_only=True)
class Statement:
    """What the paper says and when it counts as true.

    Attributes
    ----------
    printed : tuple of Limit
        True as printed if all hold. Empty: nothing can be computed without an assumption.
    assumed : tuple of Limit
        Otherwise true under `assumption` if all of these hold. Empty: no assumption helps.
    is_method_check : bool
        The claim needs data that the paper does not print; the assumed limits test only the method
        by which such data would be judged.
    finding, why : str
        Templates that computed numbers are written into by ``str.format``.
    """

    name: str
    where: str
    words: str
    finding: str
    why: str
    printed: tuple[Limit, ...] = ()
    assumed: tuple[Limit, ...] = ()
    assumption: str = ""
    is_method_check: bool = False

    def __post_init__(self) -> None:
        if not self.printed and not self.assumed:
            raise ValueError(f"statement '{self.name}' needs at least one limit")
        if bool(self.assumed) != bool(self.assumption):
            raise ValueError(
                f"statement '{self.name}' must have both assumed limits and an assumption, or none"
            )
        if self.is_method_check and self.printed:
            raise ValueError(f"statement '{self.name}' is a method check: no limit can be printed")

    @property
    def limits(self) -> tuple[Limit, ...]:
        """All limits, those of the printed claim first."""
        return self.printed + self.assumed

    def verdict(self, numbers: Numbers) -> Verdict:
        """Return the verdict on computed numbers."""
        if self.is_method_check:
            return Verdict.METHOD_CHECK
        if self.printed and all(limit.holds(numbers) for limit in self.printed):
            return Verdict.REPRODUCED
        if self.assumed and all(limit.holds(numbers) for limit in self.assumed):
            return Verdict.ASSUMED
        return Verdict.NOT_AS_PRINTED

    def judge(self, numbers: Numbers) -> Claim:
        """Return the claim with its verdict.

        Raises
        ------
        KeyError
            If a number that a limit or a template names was not computed.
        """
        verdict = self.verdict(numbers)
        return Claim(
            name=self.name,
            where=self.where,
            words=self.words,
            finding=filled(self.finding, numbers),
            criteria=tuple((limit.report(numbers), limit.holds(numbers)) for limit in self.limits),
            assumption=self.assumption
            if verdict in (Verdict.ASSUMED, Verdict.METHOD_CHECK)
            else "",
            verdict=verdict,
            why=filled(self.why, numbers),
            numbers=dict(numbers),
        )


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """A figure, or a set of runs without one, and the claims that it decides.

    Attributes
    ----------
    title : str
        What it is about.
    data : callable
        ``data(quick=False)`` computes everything that is drawn and judged. With `needs_video` it
        also takes ``full``, to film all that it can.
    numbers : callable
        Returns the numbers that the statements name, in SI units, from the dataset.
    statements : tuple of Statement
        The claims that the numbers decide.
    caption : str
        Of the figure; empty without one.
    draw : callable, optional
        Returns the figure drawn from the dataset.
    needs_video : bool
        It goes through a video, which needs the extra `video`.
    """

    title: str
    data: Callable[..., xr.Dataset]
    numbers: Callable[[xr.Dataset], Numbers]
    statements: tuple[Statement, ...] = ()
    caption: str = ""
    draw: Callable[[xr.Dataset], Figure] | None = None
    needs_video: bool = False

    def judge(self, dataset: xr.Dataset) -> list[Claim]:
        """Return the claims that a dataset decides."""
        numbers = self.numbers(dataset)
        return [statement.judge(numbers) for statement in self.statements]


def read_statements(path: Path) -> dict[str, tuple[Statement, ...]]:
    """Return the statements of a file of claims, by figure.

    Raises
    ------
    ValueError
        If a claim or a limit has a key that is not known, or lacks one.
    """
    figures = tomllib.loads(path.read_text(encoding="utf-8"))
    return {
        figure: tuple(_statement(name, f"{figure}.{name}", table) for name, table in claims.items())
        for figure, claims in figures.items()
    }


def _statement(name: str, place: str, table: Mapping[str, Any]) -> Statement:
    """Return the statement of a table, whose place in the file is named in errors."""
    limits = {
        kind: tuple(
            _checked(Limit, f"{place}.{kind}.{number}", {**entries, "number": number})
            for number, entries in table.get(kind, {}).items()
        )
        for kind in ("printed", "assumed")
    }
    return _checked(Statement, place, {**table, **limits, "name": name})


_Made = TypeVar("_Made", Limit, Statement)


def _checked(kind: type[_Made], place: str, entries: Mapping[str, Any]) -> _Made:
    """Return a limit or a statement made from entries of the file; lines of a text are joined."""
    known = {field.name: field for field in fields(kind)}
    values: dict[str, Any] = {}
    for key, value in entries.items():
        if key not in known:
            raise ValueError(f"claim {place} has no key '{key}': {suggest(key, list(known))}")
        if not isinstance(value, _TYPES.get(str(known[key].type), object)):
            raise ValueError(f"claim {place}: {key} must be a {known[key].type}, got {value!r}")
        values[key] = _LINE_END.sub(" ", value).strip() if isinstance(value, str) else value
    for key, field in known.items():
        if field.default is MISSING and key not in values:
            raise ValueError(f"claim {place} lacks the key '{key}'")
    return kind(**values)


def filled(template: str, numbers: Numbers) -> str:
    """Return a template with its numbers; a percent sign follows a space."""
    return re.sub(r"(?<=\d)%", " %", template.format(**numbers))


def _text(value: float) -> str:
    """Return a number with up to five significant digits."""
    if not math.isfinite(value):
        return str(value)
    return f"{value:.5g}"
