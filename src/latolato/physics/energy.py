"""Energies and powers of one ball, in the frame of the pivot and in the laboratory.

In the pivot frame ``E = m l^2 w^2/2 + m g l V(angle)`` (V = 1 - cos, zero when hanging) and
between impacts ``dE/dt = drive_power - damping_power`` with ``drive_power = -m y0'' l w R(angle)``
(R = sin; the paper's definition, with the sign that closes the ledger). In the laboratory
``E_L = m |v|^2/2 + m g y`` changes by the work of the rod, and jumps at impacts of the moving pair.
"""

from __future__ import annotations

from latolato.core.scalar import cosine, formula, sine


@formula
def kinetic_energy(angular_velocity: float, mass: float, length: float) -> float:
    """Return m l^2 w^2/2 [J] (Paper eq1)."""
    speed = length * angular_velocity
    return 0.5 * mass * speed * speed


@formula
def potential_energy(potential: float, mass: float, length: float, gravity: float) -> float:
    """Return m g l V [J], zero in the hanging position."""
    # Paper: eq2 puts zero at the pivot, but its Fig. 6 (E envelopes U) needs it at the bottom.
    return mass * gravity * length * potential


@formula
def drive_power(
    angular_velocity: float,
    restoring: float,
    pivot_acceleration: float,
    mass: float,
    length: float,
) -> float:
    """Return -m y0'' l w R(angle) [W], the power of the inertial force in the pivot frame."""
    return -mass * pivot_acceleration * length * angular_velocity * restoring


@formula
def lab_energy(
    angle: float,
    angular_velocity: float,
    pivot_height: float,
    pivot_velocity: float,
    mass: float,
    length: float,
    gravity: float,
) -> float:
    """Return m |v|^2/2 + m g y [J] in the laboratory, zero height at the mean pivot."""
    l = length
    vx = l * angular_velocity * cosine(angle)
    vy = pivot_velocity + l * angular_velocity * sine(angle)
    y = pivot_height - l * cosine(angle)
    return mass * (0.5 * (vx * vx + vy * vy) + gravity * y)


@formula
def rod_power(angle: float, drag_force: float, tension: float, pivot_velocity: float) -> float:
    """Return F_y y0' [W], the power of pivot and rod on the ball in the laboratory.

    ``F_y = T cos(angle) - f sin(angle)`` with T the tension and f the tangential drag force
    (C w for linear drag).
    """
    return (tension * cosine(angle) - drag_force * sine(angle)) * pivot_velocity
