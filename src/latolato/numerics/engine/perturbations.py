"""Perturbations in the plane: columns of places and velocities, and what they are in angles.

Each unit perturbation of the taut state is a column of ``z = run.state.tangent_map``: rows 4 i to
4 i + 3 hold x, y, vx and vy of ball i, measured from the pivot in its frame. Where derivatives with
respect to parameters are asked for, each parameter has a further column: what it does on its own
since the first string went slack, with no perturbation before.

On a taut string a perturbation has an angle and an angular velocity. With the string's direction
``r = (sin a, -cos a)`` and ``r' = (cos a, sin a)`` a place is ``l r`` and its velocity ``l w r'``;
their derivatives lead from one description to the other, and a parameter that lengthens the string
moves its taut ball outwards as well.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from latolato.core.scalar import cosine, formula, sine
from latolato.numerics.engine.gaps import Gaps
from latolato.numerics.engine.laws import Laws
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.run_record import Point, Run


class Perturbations(NamedTuple):
    """The functions of single columns; see `make_perturbations`."""

    columns_of: Callable[..., int]
    stretch_of: Callable[..., float]
    write_taut: Callable[..., None]
    taut_perturbation: Callable[..., tuple[float, float]]
    gap_perturbation: Callable[..., float]
    write_map: Callable[..., None]


@formula
def _write_column(run: Run, i: int, column: int, x: float, y: float, vx: float, vy: float) -> None:
    """Write the perturbation of one ball into a column [m, m/s]."""
    z, row = run.state.tangent_map, 4 * i
    z[row, column], z[row + 1, column] = x, y
    z[row + 2, column], z[row + 3, column] = vx, vy


@formula
def _polar_perturbation(run: Run, i: int, column: int, point: Point) -> tuple[float, float]:
    """Perturbation of angle [rad] and angular velocity [rad/s] about the pivot, from a column.

    The derivatives of ``atan2(x, -y)`` and of ``(x vy - y vx)/r^2``.
    """
    z, row = run.state.tangent_map, 4 * i
    x, y, vx, vy = point.x, point.y, point.vx, point.vy
    dx, dy, dvx, dvy = z[row, column], z[row + 1, column], z[row + 2, column], z[row + 3, column]
    squared = max(x * x + y * y, 1e-300)
    turned = (dx * vy + x * dvy - dy * vx - y * dvx) / squared
    spin, farther = (x * vy - y * vx) / squared, 2.0 * (x * dx + y * dy) / squared
    return (x * dy - y * dx) / squared, turned - spin * farther


def make_perturbations(
    gaps: Gaps, laws: Laws, count: int, part: Part = as_it_stands
) -> Perturbations:
    """Make the functions that read and write the columns of `count` balls."""
    two, size, sensitive = count == 2, 2 * count, len(laws.changes) > 0

    @inlined(part)
    def columns_of(run: Run) -> int:
        """Number of columns."""
        return size + run.parameters if sensitive else size

    @inlined(part)
    def stretch_of(run: Run, i: int, column: int) -> float:
        """By how much a column's parameter lengthens a string [m]."""
        if not sensitive or column < size:
            return 0.0
        k = run.bodies[i].inverse_length
        longer: float = -run.changes[column - size].bodies[i].inverse_length / (k * k)
        return longer

    @part
    def write_taut(
        run: Run, i: int, column: int, point: Point, angle: float, velocity: float
    ) -> None:
        """Write a perturbation of angle and angular velocity on a taut string as one in the plane.

        The derivative of ``l (sin, -cos)`` and of its rate ``l w (cos, sin)``: a turn by the angle
        also turns the velocity, towards the pivot, and a longer string lengthens both.
        """
        length, s, c = 1.0 / run.bodies[i].inverse_length, sine(point.angle), cosine(point.angle)
        longer = stretch_of(run, i, column)
        around, inward = (
            length * velocity + longer * point.velocity,
            length * point.velocity * angle,
        )
        far = length * angle
        _write_column(
            run, i, column, far * c + longer * s, far * s - longer * c,
            around * c - inward * s, around * s + inward * c,
        )  # fmt: skip

    @part
    def taut_perturbation(run: Run, i: int, column: int, point: Point) -> tuple[float, float]:
        """Perturbation of angle [rad] and angular velocity [rad/s] on a taut string."""
        z, row = run.state.tangent_map, 4 * i
        inverse_length, s, c = run.bodies[i].inverse_length, sine(point.angle), cosine(point.angle)
        angle = inverse_length * (c * z[row, column] + s * z[row + 1, column])
        around = c * z[row + 2, column] + s * z[row + 3, column]
        velocity = inverse_length * (around - stretch_of(run, i, column) * point.velocity)
        return angle, velocity

    @part
    def gap_perturbation(run: Run, column: int) -> float:
        """Perturbation of the gap between the balls [m]."""
        z, (nx, ny, _) = run.state.tangent_map, gaps.line_of_centres(run.now)
        result: float = nx * z[0, column] + ny * z[1, column]
        if two:
            result -= nx * z[4, column] + ny * z[5, column]
        if sensitive and column >= size:
            for i in range(count):
                result -= run.changes[column - size].radius[i]
        return result

    @part
    def write_map(run: Run, points: list[Point]) -> None:
        """Write the columns as angles and angular velocities into matrix and forcing."""
        for column in range(columns_of(run)):
            for i in range(count):
                angle, velocity = _polar_perturbation(run, i, column, points[i])
                if column < size:
                    run.jacobian[2 * i, column], run.jacobian[2 * i + 1, column] = angle, velocity
                else:
                    p = column - size
                    run.forcing[2 * i, p], run.forcing[2 * i + 1, p] = angle, velocity

    return Perturbations(
        columns_of=columns_of,
        stretch_of=stretch_of,
        write_taut=write_taut,
        taut_perturbation=taut_perturbation,
        gap_perturbation=gap_perturbation,
        write_map=write_map,
    )
