"""Two balls in sticking contact: they swing as one rigid body until the contact force would pull.

On strings a ball may also meet the string of the other one.
"""

from __future__ import annotations

import math
from typing import Any

from latolato.core.scalar import cosine, formula, sine


@formula
def joint_inverse_length(
    moment_1: float, moment_2: float, inertia: float, separation: float
) -> tuple[float, float]:
    """Return coupling [1/m] and angle offset [rad] of the body made of both balls.

    With ``angle_1 = angle_2 + separation`` the two restoring torques add up to one sine:
    ``S1 sin(angle_2 + separation) + S2 sin(angle_2) = M sin(angle_2 + offset)`` and the body
    moves like a pendulum of angle ``angle_2 + offset`` and length ``inertia/M``
    (``S_i = m_i l_i`` static moments).
    """
    x = moment_1 * cosine(separation) + moment_2
    y = moment_1 * sine(separation)
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
    """Return the share of the contact in the tension of a ball in sticking contact [N].

    The contact force acts along the line of centres; with its torque on ball 1 known, its
    component along the rod is ``torque (l1 - l2 cos(separation))/(l1 l2 sin(separation))``, written
    as ``torque ((l1 - l2)/sin(separation) + l2 tan(separation/2))/(l1 l2)``: it vanishes for points
    on equal rods, whose separation is zero. Call it for each ball with its own length first.
    """
    l1, l2 = length, other_length
    slant = (l1 - l2) / math.sin(separation) if l1 != l2 else 0.0
    return torque * (slant + l2 * math.tan(0.5 * separation)) / (l1 * l2)


@formula
def runs_through(length: float, along: float, beside: float, radius: float) -> bool:
    """Return whether a taut string of this length [m] runs through a ball.

    The ball's centre, seen from the pivot, lies so far `along` the string and `beside` it [m].
    """
    return 0.0 < along < length and abs(beside) < radius


@formula
def write_pair_saltation(
    matrix: Any,
    share: float,
    restitution: float,
    before: tuple[float, float],
    after: tuple[float, float],
    pulls_before: tuple[float, float],
    pulls_after: tuple[float, float],
) -> None:
    """Write how perturbations of both angles and angular velocities change at an impact.

    ``S = R + (f+ - R f-) n/(n f-)`` (Aizerman & Gantmacher, 1958) for the state
    ``(angle_1, velocity_1, angle_2, velocity_2)``: R is the impact itself, f the rates of the
    state and n the gradient of the separation; `share` is the first ball's of the inertia.
    """
    closing = before[0] - before[1]
    # Velocities after = impact times velocities before; angular momentum is kept.
    keep_1 = share - restitution * (1.0 - share)
    take_1 = (1.0 - share) * (1.0 + restitution)
    keep_2 = 1.0 - share - restitution * share
    take_2 = share * (1.0 + restitution)
    bend_1 = pulls_after[0] - keep_1 * pulls_before[0] - take_1 * pulls_before[1]
    bend_2 = pulls_after[1] - take_2 * pulls_before[0] - keep_2 * pulls_before[1]
    for row in range(4):
        for column in range(4):
            matrix[row, column] = 0.0
    matrix[0, 0], matrix[2, 2] = 1.0, 1.0
    matrix[1, 1], matrix[1, 3] = keep_1, take_1
    matrix[3, 1], matrix[3, 3] = take_2, keep_2
    shifts = (after[0] - before[0], bend_1, after[1] - before[1], bend_2)
    for row in range(4):
        shift = shifts[row] / closing
        matrix[row, 0] += shift
        matrix[row, 2] -= shift
