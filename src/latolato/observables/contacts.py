"""Counts of contacts, speeds of impacts, and the share of time at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import Quantity
from latolato.core.scalar import formula
from latolato.observables.base import Observable, Outcome, Step, observables
from latolato.physics.contacts import BOTTOM, TOP


@formula
def _is_impact(kind: int) -> bool:
    """Return whether a row of the contact table is an impact."""
    return kind in (BOTTOM, TOP)


@formula
def _bottom(
    acc: Any, i: int, n: int, t: float, kind: int, before: float, after: float, closing: float
) -> None:
    """Count a bottom contact."""
    acc[i] += 1.0 if kind == BOTTOM else 0.0


@formula
def _top(
    acc: Any, i: int, n: int, t: float, kind: int, before: float, after: float, closing: float
) -> None:
    """Count a top contact."""
    acc[i] += 1.0 if kind == TOP else 0.0


@formula
def _speeds(
    acc: Any, i: int, n: int, t: float, kind: int, before: float, after: float, closing: float
) -> None:
    """Gather count, mean and squared deviations (Welford), and the largest closing speed."""
    if _is_impact(kind):
        acc[i] += 1.0
        change = closing - acc[i + n]
        acc[i + n] += change / acc[i]
        acc[i + 2 * n] += change * (closing - acc[i + n])
        acc[i + 3 * n] = max(acc[i + 3 * n], closing)


@formula
def _forget(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient."""
    acc[i] = 0.0


@formula
def _forget_speeds(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient."""
    for m in range(4):
        acc[i + m * n] = 0.0


@formula
def _rest(acc: Any, i: int, n: int, s: Step) -> None:
    """Add a time at rest."""
    acc[i] += s.held * (s.t1 - s.t0)


@observables.register("bottom_contacts")
@dataclass(frozen=True, kw_only=True)
class BottomContacts(Observable):
    """Number of impacts at the bottom after the transient."""

    variables: ClassVar[Any] = {
        "bottom_contacts": Quantity("1", r"N_{bottom}", "impacts at the bottom")
    }
    contact: ClassVar[Any] = staticmethod(_bottom)
    restart: ClassVar[Any] = staticmethod(_forget)


@observables.register("top_contacts")
@dataclass(frozen=True, kw_only=True)
class TopContacts(Observable):
    """Number of impacts at the top after the transient."""

    variables: ClassVar[Any] = {"top_contacts": Quantity("1", r"N_{top}", "impacts at the top")}
    contact: ClassVar[Any] = staticmethod(_top)
    restart: ClassVar[Any] = staticmethod(_forget)


@formula
def _finish_speeds(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write mean, standard deviation and largest; NaN without impacts."""
    count, mean, squares, largest = acc[i], acc[i + n], acc[i + 2 * n], acc[i + 3 * n]
    none = count == 0.0
    acc[i] = math.nan if none else mean
    acc[i + n] = math.nan if none else math.sqrt(squares / max(count, 1.0))
    acc[i + 2 * n] = math.nan if none else largest


@formula
def _finish_rest(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Turn the time at rest into a share."""
    acc[i] /= end.observed_time


@observables.register("impact_speed")
@dataclass(frozen=True, kw_only=True)
class ImpactSpeed(Observable):
    """Mean, standard deviation and largest of the impact speeds after the transient.

    The speed is the ball's angular speed before impact; for a `BallPair` the relative one. NaN
    where there was no impact.
    """

    variables: ClassVar[Any] = {
        "mean_impact_speed": Quantity("rad/s", r"\langle v\rangle", "mean impact speed"),
        "impact_speed_deviation": Quantity(
            "rad/s", r"\sigma_v", "standard deviation of the impact speed"
        ),
        "largest_impact_speed": Quantity("rad/s", r"v_{max}", "largest impact speed"),
    }
    contact: ClassVar[Any] = staticmethod(_speeds)
    restart: ClassVar[Any] = staticmethod(_forget_speeds)
    finish: ClassVar[Any] = staticmethod(_finish_speeds)

    @property
    def memory(self) -> int:
        """Count, mean, squared deviations and largest."""
        return 4


@observables.register("rest_fraction")
@dataclass(frozen=True, kw_only=True)
class RestFraction(Observable):
    """Share of the time after the transient in sticking contact, or held by Coulomb friction.

    The balls of a `BallPair` may swing together in sticking contact; that time counts too.
    """

    variables: ClassVar[Any] = {"rest_fraction": Quantity("1", "", "share of time at rest")}
    step: ClassVar[Any] = staticmethod(_rest)
    restart: ClassVar[Any] = staticmethod(_forget)
    finish: ClassVar[Any] = staticmethod(_finish_rest)
