"""Two balls in lasting contact: they swing as one rigid body until the contact force would pull."""

from __future__ import annotations

import math

from latolato.scalar import formula


@formula
def joint_coupling(
    moment_1: float, moment_2: float, inertia: float, separation: float
) -> tuple[float, float]:
    """Return coupling [1/m] and angle offset [rad] of the body made of both balls.

    With ``angle_1 = angle_2 + separation`` the two restoring torques add up to one sine:
    ``S1 sin(angle_2 + separation) + S2 sin(angle_2) = M sin(angle_2 + offset)`` and the body
    moves like a pendulum of angle ``angle_2 + offset`` and length ``inertia/M``
    (``S_i = m_i l_i`` static moments).
    """
    x = moment_1 * math.cos(separation) + moment_2
    y = moment_1 * math.sin(separation)
    return math.hypot(x, y) / inertia, math.atan2(y, x)


@formula
def contact_torque(
    acceleration_1: float, acceleration_2: float, inertia_1: float, inertia_2: float
) -> float:
    """Return the torque N m by which the contact pushes ball 1 at the bottom (at the top: minus).

    ``N = (I1 tau2 - I2 tau1)/(I1 + I2)`` with the free torques ``tau = I acceleration``: what
    both need to share one angular acceleration.
    """
    reduced = inertia_1 * inertia_2 / (inertia_1 + inertia_2)
    return reduced * (acceleration_2 - acceleration_1)


@formula
def radial_push(torque: float, length: float, other_length: float, separation: float) -> float:
    """Return what the contact adds to the tension of a ball in lasting contact [N].

    The contact force acts along the line of centres; with its torque on ball 1 known, its
    component along the rod is ``torque (l1 - l2 cos(separation))/(l1 l2 sin(separation))``.
    Both balls are met with the same torque and separation, each with its own length first.
    """
    l1, l2 = length, other_length
    return torque * (l1 - l2 * math.cos(separation)) / (l1 * l2 * math.sin(separation))
