"""Strings: how long they are slack, and how hard they pull taut."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import QUANTITIES
from latolato.core.scalar import formula
from latolato.observables.base import Observable, Outcome, observables


@formula
def _finish_fraction(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the share of the observed time in which the string was slack."""
    acc[i] = end.slack_time / end.observed_time


@formula
def _finish_first(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write when the string was first slack."""
    acc[i] = end.first_slack


@formula
def _finish_impulse(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the largest impulse."""
    acc[i] = end.string_impulse


@formula
def _finish_loss(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the energy lost."""
    acc[i] = end.retension_loss


@observables.register("slack_fraction")
@dataclass(frozen=True, kw_only=True)
class SlackFraction(Observable):
    """Share of the time after the transient in which a ball's string is slack."""

    variables: ClassVar[Any] = {"slack_fraction": QUANTITIES["slack_fraction"]}
    of_strings: ClassVar[bool] = True
    finish: ClassVar[Any] = staticmethod(_finish_fraction)


@observables.register("first_slack")
@dataclass(frozen=True, kw_only=True)
class FirstSlack(Observable):
    """First time after the transient at which a ball's string is slack; NaN if it never is."""

    variables: ClassVar[Any] = {"first_slack": QUANTITIES["first_slack"]}
    of_strings: ClassVar[bool] = True
    finish: ClassVar[Any] = staticmethod(_finish_first)


@observables.register("largest_string_impulse")
@dataclass(frozen=True, kw_only=True)
class LargestStringImpulse(Observable):
    """Largest impulse with which a string pulls when it tightens or its ball is hit."""

    variables: ClassVar[Any] = {"largest_string_impulse": QUANTITIES["largest_string_impulse"]}
    of_strings: ClassVar[bool] = True
    is_joint: ClassVar[bool] = True
    finish: ClassVar[Any] = staticmethod(_finish_impulse)


@observables.register("retension_loss")
@dataclass(frozen=True, kw_only=True)
class RetensionLoss(Observable):
    """Energy lost after the transient when strings become taut; for a pair, of both balls."""

    variables: ClassVar[Any] = {"retension_loss": QUANTITIES["retension_loss"]}
    of_strings: ClassVar[bool] = True
    is_joint: ClassVar[bool] = True
    finish: ClassVar[Any] = staticmethod(_finish_loss)
