"""Force along the rod: positive pulls the ball; at negative values a string would go slack."""

from __future__ import annotations

from latolato.core.scalar import cosine, formula


@formula
def tension(
    angle: float,
    angular_velocity: float,
    pivot_acceleration: float,
    mass: float,
    length: float,
    gravity: float,
) -> float:
    """Return m l w^2 + m (g + y0'') cos(angle) [N], the tension away from contact."""
    return mass * (
        length * angular_velocity * angular_velocity
        + (gravity + pivot_acceleration) * cosine(angle)
    )


@formula
def wall_tension(angle: float, pivot_acceleration: float, mass: float, gravity: float) -> float:
    """Return m (g + y0'')/cos(angle) [N], the tension of a ball that rests on the other one."""
    return mass * (gravity + pivot_acceleration) / cosine(angle)
