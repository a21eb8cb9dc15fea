"""Where a system hangs at rest, and starts as sweeps want them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from latolato.numerics.integrate import Start
from latolato.physics.pendulum import BallPair, LatoLato, System
from latolato.simulation.start import checked_contact, checked_start


def hanging_angles(system: System) -> tuple[float, ...]:
    """Return the angles of a system that hangs at rest, balls in contact [rad].

    A `LatoLato` lies on its low wall; the two balls of a `BallPair` balance their torques
    ``m_1 g l_1 sin(angle_1) + m_2 g l_2 sin(angle_2) = 0`` at the contact separation.

    Examples
    --------
    >>> import latolato as ll
    >>> ball = ll.Ball(length=1.0, mass=0.8, radius=0.1)
    >>> [f"{angle:.4f}" for angle in hanging_angles(ll.BallPair(right=ball, left=ball))]
    ['0.1002', '-0.1002']
    """
    if isinstance(system, LatoLato):
        return (system.contact_angle_low,)
    if isinstance(system, BallPair):
        gap = system.contact_separation
        right, left = (ball.mass * ball.length for ball in system.balls)
        angle = math.atan2(left * math.sin(gap), right + left * math.cos(gap))
        return (angle, angle - gap)
    return (0.0,)


def single_start(
    system: System, angle: Any, velocity: Any, offset: Any, contact: Any = "exact"
) -> Start:
    """Return the checked start of one motion."""
    return checked_start(system, checked_contact(contact, system), angle, velocity, offset)


def start_columns(system: System, angles: Any, velocities: Any) -> dict[str, Any]:
    """Return starts as parameters along an axis of `latolato.sweep`.

    Parameters
    ----------
    angles, velocities : sequence of array_like, shape (ball, start)
    """
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    pairs = {"initial_angle": angles, "initial_angular_velocity": velocities}
    return {
        name + side: np.atleast_1d(values)
        for name, balls in pairs.items()
        for side, values in zip(sides, balls, strict=True)
    }


def start_options(
    system: System,
    initial_angle: float | Sequence[float] | None,
    initial_angular_velocity: float | Sequence[float],
    initial_offset: float | None,
    beside: float = 0.0,
) -> dict[str, Any]:
    """Return the start for `latolato.sweep`, by default `beside` where the system hangs [rad]."""
    result: dict[str, Any] = {"initial_angular_velocity": initial_angular_velocity}
    if initial_angle is None and initial_offset is None:
        if isinstance(system, LatoLato):
            return result | {"initial_offset": beside}
        right, *left = hanging_angles(system)
        both = (right + beside, *(angle - beside for angle in left))
        return result | {"initial_angle": both if left else both[0]}
    return result | {"initial_angle": initial_angle, "initial_offset": initial_offset}
