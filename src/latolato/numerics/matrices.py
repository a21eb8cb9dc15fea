"""Matrices of perturbations of the whole state: angle and angular velocity of each ball."""

from __future__ import annotations

from latolato.core.scalar import formula
from latolato.numerics.records import Floats

Matrix = tuple[float, float, float, float]
UNCHANGED: Matrix = (1.0, 0.0, 0.0, 1.0)


@formula
def write_matrix(jacobian: Floats, ball: int, matrix: Matrix) -> None:
    """Write the block of one ball, row by row, into the matrix of the whole state."""
    at = 2 * ball
    jacobian[at, at], jacobian[at, at + 1] = matrix[0], matrix[1]
    jacobian[at + 1, at], jacobian[at + 1, at + 1] = matrix[2], matrix[3]


@formula
def write_joint_matrix(jacobian: Floats, share: float, matrix: Matrix) -> None:
    """Write the matrix of two balls that move as one; `share` is the first one's of the inertia.

    Perturbations that part them are lost; the common one is the mean that impacts keep.
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
def clear_matrix(jacobian: Floats, size: int) -> None:
    """Write zeros."""
    for row in range(size):
        for column in range(size):
            jacobian[row, column] = 0.0
