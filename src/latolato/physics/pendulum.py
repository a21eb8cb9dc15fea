"""The systems: one pendulum, its linearisation, the mirror-symmetric pair, and two free balls.

Every ball on a rod or a taut string obeys (Paper eq10, with the drags of
`latolato.physics.damping`)

    angle'' = -(gravity + pivot_acceleration(t)) / length * sin(angle) - drag(angle')

above a pivot that moves up and down. On a slack string it falls
(`latolato.numerics.engine.slack_step`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property, partial
from typing import Any, ClassVar

from latolato.core.errors import InputError
from latolato.core.quantities import (
    NON_NEGATIVE,
    POSITIVE,
    UNIT_INTERVAL,
    choice_field,
    quantity_field,
)
from latolato.core.registry import Registry, check_fields, checked_number, named
from latolato.core.rules import broken_rule
from latolato.core.scalar import cosine, formula, sine
from latolato.physics import contacts

GRAVITY = 9.8  # m/s^2, the paper's value (not 9.81)

# Fields that several systems have. The paper's balls hang on rods, in air that moves with the
# pivot; air at rest in the room is "lab".
_suspension_field = partial(
    choice_field,
    ("rod", "string"),
    default="rod",
    description="what each ball hangs on",
    is_later=True,
)
_string_restitution_field = partial(
    quantity_field,
    "string_restitution",
    UNIT_INTERVAL,
    default=0.0,
    suggested=(0.0, 1.0),
    is_later=True,
)
_drag_frame_field = partial(
    choice_field,
    ("pivot", "lab"),
    default="pivot",
    description="where the air is at rest",
    is_later=True,
)

systems: Registry[type] = Registry("system")


@formula
def swung(gravity: float, inverse_length: float, restored: float) -> float:
    """Return the angular acceleration ``-gravity/length restored`` without drag [rad/s^2].

    The equation of motion of every ball: `gravity` is that of the pivot's frame, ``g + y0''``
    [m/s^2], or the drive's part of it, and `restored` the restoring factor of the angle.
    """
    return -gravity * inverse_length * restored


@formula
def restoring_sine(angle: float) -> float:
    """Return sin(angle), the restoring factor of the pendulum (Paper eq10)."""
    return sine(angle)


@formula
def potential_sine(angle: float) -> float:
    """Return 1 - cos(angle) without loss of digits near zero."""
    half = sine(0.5 * angle)
    return 2.0 * half * half


@formula
def restoring_linear(angle: float) -> float:
    """Return the angle itself, the restoring factor of the Mathieu equation (Paper eq14)."""
    return angle


@formula
def potential_linear(angle: float) -> float:
    """Return angle^2 / 2, the potential that belongs to `restoring_linear`."""
    return 0.5 * angle * angle


@formula
def slope_sine(angle: float) -> float:
    """Return cos(angle), the slope of `restoring_sine`."""
    return cosine(angle)


@formula
def slope_linear(angle: float) -> float:
    """Return 1, the slope of `restoring_linear`."""
    return 1.0


# The slope of each restoring factor, for what is linear in perturbations.
SLOPES: dict[Any, Any] = {restoring_sine: slope_sine, restoring_linear: slope_linear}


@named
@dataclass(frozen=True, kw_only=True)
class Ball:
    """One ball on its rod or string: ``Ball(length=, mass=, damping=, radius=)``."""

    length: float = quantity_field("length", POSITIVE, suggested=(0.05, 2.0))
    mass: float = quantity_field("mass", POSITIVE, suggested=(0.01, 2.0))
    damping: float = quantity_field("damping", NON_NEGATIVE, default=0.0, suggested=(0.0, 0.1))
    quadratic_damping: float = quantity_field(
        "quadratic_damping", NON_NEGATIVE, default=0.0, suggested=(0.0, 0.1)
    )
    coulomb_damping: float = quantity_field(
        "coulomb_damping", NON_NEGATIVE, default=0.0, suggested=(0.0, 0.05)
    )
    radius: float = quantity_field("radius", NON_NEGATIVE, default=0.0, suggested=(0.0, 0.2))

    def __post_init__(self) -> None:
        check_fields(self)
        contacts.check_radius(self.radius, self.length)


@dataclass(frozen=True, kw_only=True)
class System:
    """What every system has: gravity, the restoring law and the balls it is made of.

    A subclass declares its fields, `balls` (right ball first) and, if balls meet,
    `separation_low` and `separation_high`. `suspension`, `string_restitution` and `drag_frame` are
    fields of those that can hang on strings.
    """

    restoring: ClassVar[Any] = staticmethod(restoring_sine)
    potential: ClassVar[Any] = staticmethod(potential_sine)
    # How many angles the state has, and whether walls or a second ball can be met.
    angles: ClassVar[int] = 1
    has_contacts: ClassVar[bool] = False

    suspension = "rod"
    drag_frame = "pivot"

    @property
    def string_restitution(self) -> float:
        """Restitution of a string that becomes taut."""
        return 0.0

    gravity: float = quantity_field("gravity", POSITIVE, default=GRAVITY, suggested=(1.6, 25.0))

    def __post_init__(self) -> None:
        check_fields(self)
        if self.suspension == "rod" and self.string_restitution > 0.0:
            raise broken_rule(
                "rigid_rod", parameter="string_restitution", value=self.string_restitution
            )
        if self.drag_frame == "lab" and any(ball.quadratic_damping > 0.0 for ball in self.balls):
            raise broken_rule("lab_drag", parameter="drag_frame", value=self.drag_frame)

    @cached_property
    def balls(self) -> tuple[Ball, ...]:
        """The balls whose angles are the state, right ball first."""
        shared = {f.name: getattr(self, f.name) for f in fields(Ball) if hasattr(self, f.name)}
        return (Ball(**shared),)

    @property
    def is_linear(self) -> bool:
        """Whether the restoring torque is proportional to the angle."""
        return self.restoring is restoring_linear

    @property
    def natural_frequency(self) -> float:
        """Angular frequency of small free swings of the right ball [rad/s]."""
        return math.sqrt(self.gravity / self.balls[0].length)


@dataclass(frozen=True, kw_only=True)
class OneBall(System):
    """A system with one angle and the parameters of one ball."""

    length: float = quantity_field("length", POSITIVE, suggested=(0.05, 2.0))
    mass: float = quantity_field("mass", POSITIVE, suggested=(0.01, 2.0))
    damping: float = quantity_field("damping", NON_NEGATIVE, default=0.0, suggested=(0.0, 0.1))
    quadratic_damping: float = quantity_field(
        "quadratic_damping", NON_NEGATIVE, default=0.0, suggested=(0.0, 0.1)
    )
    coulomb_damping: float = quantity_field(
        "coulomb_damping", NON_NEGATIVE, default=0.0, suggested=(0.0, 0.05)
    )


@systems.register("pendulum")
@dataclass(frozen=True, kw_only=True)
class Pendulum(OneBall):
    """One pendulum on a driven pivot, without walls (Paper eq10)."""

    suspension: str = _suspension_field()
    string_restitution: float = _string_restitution_field()
    drag_frame: str = _drag_frame_field()


@systems.register("mathieu")
@dataclass(frozen=True, kw_only=True)
class Mathieu(OneBall):
    """The linearised pendulum, a damped Mathieu equation (Paper eq14)."""

    restoring: ClassVar[Any] = staticmethod(restoring_linear)
    potential: ClassVar[Any] = staticmethod(potential_linear)


@systems.register("latolato")
@dataclass(frozen=True, kw_only=True)
class LatoLato(OneBall):
    """The mirror-symmetric colliding pair: one angle between two walls (Paper eq10 and eq11).

    The angle is the right ball's; the left one is its negative. Energies, works and losses are
    *per ball*: the pair has twice that.
    """

    has_contacts: ClassVar[bool] = True

    radius: float = quantity_field("radius", NON_NEGATIVE, suggested=(0.0, 0.2))
    restitution: float = quantity_field(
        "restitution", UNIT_INTERVAL, default=1.0, suggested=(0.0, 1.0)
    )
    suspension: str = _suspension_field()
    string_restitution: float = _string_restitution_field()
    drag_frame: str = _drag_frame_field()

    def __post_init__(self) -> None:
        super().__post_init__()
        contacts.check_radius(self.radius, self.length)

    @property
    def contact_angle_low(self) -> float:
        """Angle at which the balls touch at the bottom [rad], asin(radius/length)."""
        return contacts.half_width(self.length, self.radius)

    @property
    def contact_angle_high(self) -> float:
        """Angle at which the balls touch at the top [rad]."""
        return math.pi - self.contact_angle_low


@systems.register("ballpair")
@dataclass(frozen=True, kw_only=True)
class BallPair(System):
    """Two balls on one pivot, each with its own angle, that collide (Paper eq11 in full).

    ``right`` and ``left`` may differ in every parameter, but both hang on rods or both on strings.
    Energies are per ball, works and losses are sums over both.
    """

    angles: ClassVar[int] = 2
    has_contacts: ClassVar[bool] = True

    right: Ball
    left: Ball
    restitution: float = quantity_field(
        "restitution", UNIT_INTERVAL, default=1.0, suggested=(0.0, 1.0)
    )
    suspension: str = _suspension_field()
    string_restitution: float = _string_restitution_field()
    drag_frame: str = _drag_frame_field()

    def __post_init__(self) -> None:
        for name in ("right", "left"):
            if not isinstance(getattr(self, name), Ball):
                raise InputError("must be a Ball", parameter=name, value=getattr(self, name))
        super().__post_init__()
        contacts.contact_separation(self.right, self.left)  # refuses what cannot be described

    @property
    def balls(self) -> tuple[Ball, ...]:
        """The right and the left ball."""
        return (self.right, self.left)

    @property
    def contact_separation(self) -> float:
        """Angle between the balls, on rods or taut strings, at bottom contact [rad].

        Top contact is at 2 pi minus it.
        """
        return contacts.contact_separation(self.right, self.left)


def equivalent_pendulum(
    length: float, mass: float, rod_mass: float = 0.0, radius: float = 0.0
) -> tuple[float, float]:
    """Return length [m] and mass [kg] of the point pendulum equivalent to a rod with a solid ball.

    A uniform rod reaches from the pivot to the ball's centre. The equivalent pendulum has the
    same moment of inertia about the pivot and the same static moment:
    ``l_eq = I/S``, ``m_eq = S^2/I`` with ``I = m l^2 + 2/5 m r^2 + m_rod l^2/3`` and
    ``S = m l + m_rod l/2``.

    Parameters
    ----------
    length : float
        Pivot to the centre of the ball [m].
    mass : float
        Mass of the ball [kg].
    rod_mass : float
        Mass of the rod [kg].
    radius : float
        Radius of the solid ball [m].

    Examples
    --------
    A rod of a tenth of the ball's mass shortens the pendulum by 1.6 percent, which raises the
    natural frequency by 0.80 percent (a tenth of the total mass: 0.89 percent):

    >>> length, mass = equivalent_pendulum(1.0, 1.0, rod_mass=0.1)
    >>> round(length, 6)
    0.984127
    """
    ball = Ball(length=length, mass=mass, radius=radius)
    rod = checked_number("rod_mass", rod_mass, NON_NEGATIVE, "kg")
    l, m, r = ball.length, ball.mass, ball.radius
    inertia = m * l * l + 0.4 * m * r * r + rod * l * l / 3.0
    moment = m * l + 0.5 * rod * l
    return inertia / moment, moment * moment / inertia
