"""How a run begins: system, drive, contact law, walls, start and kicks, checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.quantities import ANY, NON_NEGATIVE, QUANTITIES
from latolato.core.registry import checked_number
from latolato.numerics.integrate import Floats, Start
from latolato.numerics.prepare import ON_WALL
from latolato.physics.contacts import ContactLaw, ExactContact, PassThrough, contact_laws
from latolato.physics.drives import Drive, FixedPivot, PeriodicDrive, drives
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import BallPair, LatoLato, System, systems

DEFAULT_REST_SPEED = 1e-7  # rad/s
# More velocity kicks than this would fill the memory.
MOST_KICKS = 20_000_000


def checked_system(system: Any) -> System:
    """Return a system, or raise with what is known."""
    if not isinstance(system, System):
        raise InputError(f"must be one of {', '.join(systems)}", parameter="system", value=system)
    return system


def checked_drive(drive: Drive | None) -> Drive:
    """Return a drive, a pivot at rest for None."""
    if drive is None:
        return FixedPivot()
    if not isinstance(drive, Drive):
        raise InputError(
            f"must be None or one of {', '.join(drives)}", parameter="drive", value=drive
        )
    return drive


def checked_periodic_drive(drive: Drive | None) -> PeriodicDrive:
    """Return a drive that repeats itself."""
    checked_drive(drive)
    if not isinstance(drive, PeriodicDrive):
        name = "none" if drive is None else drives.name_of(drive)
        raise InputError(
            "must repeat itself with a single period",
            parameter="drive",
            value=name,
            way_out="give one such as Harmonic",
        )
    return drive


def checked_contact(contact: Any, system: System) -> ContactLaw:
    """Return the contact law; systems that never meet a wall have none."""
    if contact is None:
        return PassThrough()
    law = contact_laws[contact]() if isinstance(contact, str) else contact
    if not isinstance(law, ContactLaw):
        raise InputError(
            f"must be one of {', '.join(contact_laws)}", parameter="contact", value=contact
        )
    if not system.has_contacts:
        if not isinstance(law, (ExactContact, PassThrough)):
            raise InputError(
                f"{{parameter}} '{contact_laws.name_of(law)}' is for balls that meet, and a "
                f"{type(system).__name__} has none",
                parameter="contact",
                way_out="leave it out",
            )
        return PassThrough()
    law.check_system(system)
    return law


def walls_of(system: System, law: ContactLaw) -> tuple[float, float]:
    """Return the contact angles of one ball or the contact separations of two [rad]."""
    if not law.meets:
        return -math.inf, math.inf
    if isinstance(system, BallPair):
        return system.contact_separation, 2.0 * math.pi - system.contact_separation
    assert isinstance(system, LatoLato)
    return system.contact_angle_low, system.contact_angle_high


def between_walls(angles: Sequence[float] | Floats, walls: tuple[float, float]) -> Floats:
    """Return the angles of one or two balls, moved to the nearest wall if they lie beyond it."""
    low, high = walls
    if len(angles) == 1:
        return np.array([min(max(angles[0], low), high)])
    gap = angles[0] - angles[1]
    shift = 0.5 * (min(max(gap, low), high) - gap)
    return np.array([angles[0] + shift, angles[1] - shift])


def checked_numbers(name: str, value: Any, count: int) -> tuple[float, ...]:
    """Return one or two checked numbers of a start."""
    unit = QUANTITIES[name].unit
    if count == 1:
        if isinstance(value, (list, tuple, np.ndarray)) and np.ndim(value) > 0:
            raise InputError(
                f"must be one number in {unit} for one angle", parameter=name, value=value
            )
        return (checked_number(name, value, ANY, unit),)
    if np.isscalar(value) and value == 0.0 and not isinstance(value, str):
        value = (0.0, 0.0)
    if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != 2:
        raise InputError(
            "of a BallPair must be two numbers (right, left)", parameter=name, value=value
        )
    return tuple(checked_number(f"{name}[{i}]", v, ANY, unit) for i, v in enumerate(value))


def checked_offset(system: System, angle: Any, offset: Any) -> float:
    """Return an offset that replaces an angle [rad]."""
    if not isinstance(system, LatoLato):
        raise InputError(
            "counts from the low contact angle of a LatoLato",
            parameter="initial_offset",
            way_out="use initial_angle for other systems",
        )
    if angle is not None:
        raise InputError(
            "give only one of {parameter} and initial_offset", parameter="initial_angle"
        )
    return checked_number("initial_offset", offset, NON_NEGATIVE, "rad")


def checked_start(
    system: System, walls: tuple[float, float], angle: Any, velocity: Any, offset: Any
) -> Start:
    """Return the start, moved onto a wall that it is within 1e-12 rad of."""
    low, high = walls
    if angle is None and offset is None:
        raise InputError(
            "is needed [rad] (for a LatoLato initial_offset may stand instead)",
            parameter="initial_angle",
        )
    if offset is not None:
        above = checked_offset(system, angle, offset)
        assert isinstance(system, LatoLato)
        angle = system.contact_angle_low + above
    velocities = checked_numbers("initial_angular_velocity", velocity, system.angles)
    if system.angles == 1:
        (value,) = checked_numbers("initial_angle", angle, 1)
        what, gap = "{parameter}", value
    else:
        if np.isscalar(angle):
            raise InputError(
                "of a BallPair must be two numbers (right, left)",
                parameter="initial_angle",
                value=angle,
            )
        right, left = checked_numbers("initial_angle", angle, 2)
        what, gap = "the separation {parameter}[0] - {parameter}[1]", right - left
    if not low - ON_WALL <= gap <= high + ON_WALL:
        raise InputError(
            f"{what} must lie between the contact angles [{low:.9g}, {high:.9g}] rad",
            parameter="initial_angle",
            value=float(gap),
            way_out="give one at which the balls do not overlap",
        )
    shift = 0.0
    if abs(gap - low) <= ON_WALL:
        shift = low - gap
    elif abs(gap - high) <= ON_WALL:
        shift = high - gap
    if system.angles == 1:
        on_wall = low if abs(gap - low) <= ON_WALL else high
        return Start((on_wall if abs(gap - on_wall) <= ON_WALL else gap,), velocities)
    return Start((right + shift, left), velocities)


def kicks_of(
    noise: VelocityKicks | None, system: System, end: float
) -> tuple[Floats | None, Floats | None]:
    """Return instants and sizes of the velocity kicks; equal for equal seed and stream."""
    if noise is None:
        return None, None
    if not isinstance(noise, VelocityKicks):
        raise InputError("must be VelocityKicks or None", parameter="noise", value=noise)
    spacing = noise.spacing(system)
    if end / spacing > MOST_KICKS:
        raise InputError(
            f"{end / spacing:.3g} velocity kicks exceed the limit of {MOST_KICKS}; "
            "make interval longer"
        )
    count = int(end / spacing)
    instants: Floats = spacing * np.arange(1, count + 1, dtype=np.float64)
    generator = np.random.Generator(
        np.random.Philox(key=np.array([noise.noise_seed, noise.noise_stream], dtype=np.uint64))
    )
    normal = generator.standard_normal((count, system.angles)).T
    return instants, np.ascontiguousarray(normal * noise.noise_strength * math.sqrt(spacing))
