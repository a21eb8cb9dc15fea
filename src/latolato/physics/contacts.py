"""Contact of the two balls: geometry, impact with restitution, and the available contact laws."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import POSITIVE, quantity_field
from latolato.core.registry import Registry, check_fields
from latolato.core.rules import broken_rule
from latolato.core.scalar import formula
from latolato.physics import problems

contact_laws: Registry[type] = Registry("contact law")

# Row kinds of the contact table.
BOTTOM, TOP, REST, RELEASE, SLACK, TAUT = range(6)
CONTACT_KINDS = ("bottom", "top", "rest", "release", "slack", "taut")


class ContactLaw:
    """Base of contact laws: what happens where balls meet.

    Attributes
    ----------
    motion : str
        Which of `latolato.numerics.trajectory.MOTIONS` carries the balls.
    meets : bool
        Whether the balls meet at all.
    numbers : tuple of two floats
        What that motion reads as ``run.settings.law``.
    fixed_step : float or None
        The step [s] of a law whose result depends on it; perturbations have no meaning then.
    fastest_rate : float
        The fastest angular rate of what the law adds to the motion [rad/s]; steps resolve it.
    stores_energy : bool
        Whether balls in contact hold energy that samples do not show, as a spring does.
    """

    motion: ClassVar[str] = "exact"
    meets: ClassVar[bool] = True
    stores_energy: ClassVar[bool] = False

    @property
    def numbers(self) -> tuple[float, float]:
        """Two zeros by default."""
        return 0.0, 0.0

    @property
    def fixed_step(self) -> float | None:
        """None by default."""
        return None

    @property
    def fastest_rate(self) -> float:
        """Zero by default."""
        return 0.0

    def check_system(self, system: Any) -> None:
        """Raise InputError if the law does not suit a system; by default it suits all."""


@contact_laws.register("exact")
@dataclass(frozen=True)
class ExactContact(ContactLaw):
    """Impact with restitution, resting contact and lift-off, located on the solution itself."""


@contact_laws.register("clamp")
@dataclass(frozen=True)
class ClampContact(ContactLaw):
    """The fixed-step artefact that the paper's pictures probably contain.

    Classical Runge-Kutta steps of `clamp_step` seconds; a ball found beyond a wall is put back on
    it with its velocity reflected. The result depends on the step and breaks the energy ledger:
    use it to reproduce such pictures, never to study the toy.
    """

    motion: ClassVar[str] = "clamp"

    clamp_step: float = quantity_field("clamp_step", POSITIVE, default=1e-3, suggested=(1e-4, 1e-2))

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def fixed_step(self) -> float:
        """The step [s]."""
        return self.clamp_step

    def check_system(self, system: Any) -> None:
        """Raise InputError for two balls that move independently."""
        if system.angles == 2:
            raise broken_rule("clamped_toy", parameter="contact")


@contact_laws.register("none")
@dataclass(frozen=True)
class PassThrough(ContactLaw):
    """The balls pass through each other."""

    meets: ClassVar[bool] = False


def check_radius(radius: float, length: float) -> None:
    """Raise InputError unless 0 <= radius < length."""
    if not 0.0 <= radius < length:
        raise problems.refusal(problems.RADIUS, (radius, length))


# Lengths that differ by the sum of the radii but for rounding; a share of their sum.
_ROUNDING = 1e-15


@formula
def half_width(length: float, radius: float) -> float:
    """Return half the angle that a ball fills as seen from the pivot [rad].

    Two equal balls side by side touch where this is the angle of each.
    """
    return math.asin(radius / length)


@formula
def _is_hit(length: float, radius: float, other_length: float, separation: float) -> bool:
    """Return whether the other ball's rod or string hits this ball before the balls meet.

    A line from the pivot touches the ball at ``sqrt(l^2 - r^2)``; a shorter rod or string ends
    before it, in its own ball, which touches first.
    """
    tangent = math.sqrt((length - radius) * (length + radius))
    # Equal balls have a half width of separation/2: only truly unequal ones can be hit.
    return bool(other_length >= tangent and half_width(length, radius) > separation)


@formula
def meeting(l1: float, l2: float, r1: float, r2: float) -> tuple[float, float, int]:
    """Return the angle between balls that touch at the bottom [rad], and what is wrong.

    Arguments are the lengths and radii of the right and the left ball. See `contact_separation`.
    The second number is the half width [rad] of a ball that a rod or string hits.
    """
    reach = r1 + r2
    if l1 != l2 and reach - abs(l1 - l2) <= _ROUNDING * (l1 + l2):
        return 0.0, 0.0, problems.NEVER_MEET
    sine = math.sqrt((reach * reach - (l1 - l2) ** 2) / (4.0 * l1 * l2))
    if not sine < 1.0:
        return 0.0, 0.0, problems.TOO_LARGE
    separation = 2.0 * math.asin(sine)
    if _is_hit(l1, r1, l2, separation):
        return separation, half_width(l1, r1), problems.LEFT_ROD_HITS
    if _is_hit(l2, r2, l1, separation):
        return separation, half_width(l2, r2), problems.RIGHT_ROD_HITS
    return separation, 0.0, problems.FINE


def contact_separation(right: Any, left: Any) -> float:
    """Return the angle between the balls, on rods or taut strings, at bottom contact [rad].

    ``Theta = arccos[(l1^2 + l2^2 - (r1 + r2)^2) / (2 l1 l2)]``, evaluated as
    ``2 asin(sqrt(((r1 + r2)^2 - (l1 - l2)^2) / (4 l1 l2)))`` to keep all digits.

    Raises
    ------
    InputError
        If the balls can never meet, or a rod or string would hit the other ball first: a rod
        or string at least ``sqrt(l^2 - r^2)`` long touches the other ball at the separation
        ``asin(r/l)``.
    """
    shape = right.length, left.length, right.radius, left.radius
    separation, width, problem = meeting(*shape)
    if problem != problems.FINE:
        raise problems.refusal(problem, (*shape, width, separation))
    return separation


@formula
def wall_impact(velocity: float, restitution: float) -> float:
    """Return the angular velocity after an impact on a wall (one of two mirrored balls)."""
    return -restitution * velocity


@formula
def pair_impact(
    velocity_1: float, velocity_2: float, inertia_1: float, inertia_2: float, restitution: float
) -> tuple[float, float]:
    """Return both angular velocities after an impact (Paper eq11, for any lengths).

    Angular momentum about the pivot is conserved for every restitution: with
    ``P = (I1 w1 + I2 w2)/(I1 + I2)`` and ``D = w1 - w2``,
    ``w1 -> P - e I2 D/(I1 + I2)`` and ``w2 -> P + e I1 D/(I1 + I2)``.
    """
    total = inertia_1 + inertia_2
    mean = (inertia_1 * velocity_1 + inertia_2 * velocity_2) / total
    rebound = restitution * (velocity_1 - velocity_2) / total
    return mean - inertia_2 * rebound, mean + inertia_1 * rebound


@formula
def wall_saltation(
    before: float, after: float, pull_before: float, pull_after: float
) -> tuple[float, float, float, float]:
    """Return how perturbations of angle and velocity change at an impact, row by row.

    Aizerman & Gantmacher (1958): later impacts of neighbours give ``[[-e, 0], [(a+ + e a-)/v-,
    -e]]`` with ``e = -after/before`` and the accelerations a- and a+ just before and after.
    """
    reversal = after / before
    return reversal, 0.0, (pull_after - reversal * pull_before) / before, reversal
