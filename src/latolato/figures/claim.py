"""Claims of the paper, judged by code: words, computed numbers, stated limits, a verdict.

A `Statement` holds what is known before anything is computed: the paper's words and the limits
that numbers must keep for them to be true. `Statement.judge` turns numbers into a `Claim`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from latolato.figures.style import pretty_unit

Numbers = Mapping[str, float]


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
        The interval; an infinite end is no limit.
    unit : str
        SI unit of the number and of the ends.
    """

    number: str
    meaning: str
    low: float = -math.inf
    high: float = math.inf
    unit: str = "1"

    def holds(self, numbers: Numbers) -> bool:
        """Return whether the number lies in the interval; NaN never does."""
        return self.low <= numbers[self.number] <= self.high

    @property
    def demand(self) -> str:
        """The interval in words, e.g. ``at most 0.01``."""
        unit = "" if self.unit == "1" else f" {pretty_unit(self.unit)}"
        if self.low == -math.inf:
            return f"at most {_text(self.high)}{unit}"
        if self.high == math.inf:
            return f"at least {_text(self.low)}{unit}"
        return f"{_text(self.low)} to {_text(self.high)}{unit}"

    def report(self, numbers: Numbers) -> str:
        """Return the number beside its limit, e.g. ``difference: 0.00403 (at most 0.01)``."""
        unit = "" if self.unit == "1" else f" {pretty_unit(self.unit)}"
        return f"{self.meaning}: {_text(numbers[self.number])}{unit} ({self.demand})"


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
            finding=self.finding.format(**numbers),
            criteria=tuple((limit.report(numbers), limit.holds(numbers)) for limit in self.limits),
            assumption=self.assumption
            if verdict in (Verdict.ASSUMED, Verdict.METHOD_CHECK)
            else "",
            verdict=verdict,
            why=self.why.format(**numbers),
            numbers=dict(numbers),
        )


def _text(value: float) -> str:
    """Return a number with up to five significant digits."""
    if not math.isfinite(value):
        return str(value)
    return f"{value:.5g}"
