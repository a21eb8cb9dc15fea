"""How a step changes small deviations: the exact tangent of the splitting method.

A kick adds ``h a'(angle)`` times the angle's deviation to the velocity's, a drift is linear in the
velocity; so the matrix belongs to the very step that the trajectory takes, not to an approximation
of the flow. Events (impact, capture, turning under friction) have matrices of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from latolato.numerics.engine.swing import KICK, OFFSET, REACH
from latolato.numerics.flight import Law, Part, Point
from latolato.physics.damping import drift, drift_slopes
from latolato.physics.pendulum import SLOPES
from latolato.scalar import formula

Matrix = tuple[float, float, float, float]
UNCHANGED: Matrix = (1.0, 0.0, 0.0, 1.0)


@formula
def write_matrix(jacobian: Any, ball: int, matrix: Matrix) -> None:
    """Write the block of one ball, row by row, into the matrix of the whole state."""
    at = 2 * ball
    jacobian[at, at], jacobian[at, at + 1] = matrix[0], matrix[1]
    jacobian[at + 1, at], jacobian[at + 1, at + 1] = matrix[2], matrix[3]


@formula
def write_joint_matrix(jacobian: Any, share: float, matrix: Matrix) -> None:
    """Write the matrix of two balls that move as one; `share` is the first one's of the inertia.

    Deviations from moving as one are lost; the common one is the mean that impacts keep.
    """
    for ball in range(2):
        for other in range(2):
            weight = share if other == 0 else 1.0 - share
            row, column = 2 * ball, 2 * other
            jacobian[row, column] = weight * matrix[0]
            jacobian[row, column + 1] = weight * matrix[1]
            jacobian[row + 1, column] = weight * matrix[2]
            jacobian[row + 1, column + 1] = weight * matrix[3]


@formula
def clear_matrix(jacobian: Any, size: int) -> None:
    """Write zeros."""
    for row in range(size):
        for column in range(size):
            jacobian[row, column] = 0.0


def make_tangent(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    compile_part: Part | None = None,
) -> Callable[..., Matrix]:
    """Return the function that gives the matrix of `flight.advance`, row by row."""
    part: Part = compile_part or (lambda function: function)
    slope = SLOPES[restoring]

    @part
    def tangent(point: Point, sign: float, table: Any, law: Law) -> Matrix:
        """Return the matrix of a prepared step."""
        gravity, body, p = law
        t, angle, velocity, a, _, lift = point
        stages = table.shape[1] - 1
        coulomb = body.coulomb * sign
        stiffness = -(gravity + lift) * body.coupling * slope(angle)
        # The columns of the matrix: what starts as a unit of angle, and of velocity.
        x1, v1, x2, v2 = 1.0, 0.0, 0.0, 1.0
        for i in range(stages):
            h = table[KICK, i]
            velocity += h * a
            v1 += h * stiffness * x1
            v2 += h * stiffness * x2
            reach = table[REACH, i]
            far, kept = drift_slopes(velocity, sign, reach, body.rate, body.quadratic)
            x1 += far * v1
            x2 += far * v2
            v1 *= kept
            v2 *= kept
            travelled, velocity = drift(velocity, sign, reach, body.rate, body.quadratic)
            angle += travelled
            lift = acceleration(t + table[OFFSET, i], p)
            pull = (gravity + lift) * body.coupling
            a = -pull * restoring(angle) - coulomb
            stiffness = -pull * slope(angle)
        h = table[KICK, stages]
        return x1, x2, v1 + h * stiffness * x1, v2 + h * stiffness * x2

    return tangent
