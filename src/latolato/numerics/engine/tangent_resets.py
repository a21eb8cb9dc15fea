"""Derivatives of what events do to balls in the plane, and their products with perturbations.

A reset changes velocities only: a string that becomes taut takes the outward velocity of its ball
(`make_tighten`), balls that meet exchange an impulse along their line of centres
(`make_collide`), and a kick turns around the pivot (`make_kick`). Each is differentiated by place
and velocity at the event itself; `tangent_delays.py` shifts perturbations there and back. A column
that belongs to a parameter also sees the change of the masses, lengths and restitutions.
"""

from __future__ import annotations

from collections.abc import Callable

from latolato.core.scalar import cosine, sine
from latolato.numerics.engine.gaps import Gaps
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.perturbations import Perturbations
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.run_record import Run


def make_tighten(
    perturbations: Perturbations, laws: Laws, count: int, part: Part = as_it_stands
) -> Callable[..., None]:
    """Make the function ``(run, i, restitution)`` for a string that becomes taut."""
    size, sensitive, columns_of = 2 * count, len(laws.changes) > 0, perturbations.columns_of

    @part
    def tighten(run: Run, i: int, restitution: float) -> None:
        """Multiply by the derivative of a string's tightening, ``v+ = v - (1 + e_s) (r v) r``.

        r is the unit vector from the pivot to the ball; its perturbation is the ball's across r,
        over the length.
        """
        if run.state.has_tangent_map == 0:
            return
        z, row, point, k = run.state.tangent_map, 4 * i, run.now[i], run.bodies[i].inverse_length
        rx, ry, back = k * point.x, k * point.y, 1.0 + restitution
        outward = rx * point.vx + ry * point.vy
        for column in range(columns_of(run)):
            x, y = k * z[row, column], k * z[row + 1, column]
            along = rx * x + ry * y
            x, y = x - along * rx, y - along * ry
            faster = rx * z[row + 2, column] + ry * z[row + 3, column]
            faster += x * point.vx + y * point.vy
            z[row + 2, column] -= back * (faster * rx + outward * x)
            z[row + 3, column] -= back * (faster * ry + outward * y)
            if sensitive and column >= size and restitution > 0.0:
                bouncier = run.changes[column - size].string_restitution * outward
                z[row + 2, column] -= bouncier * rx
                z[row + 3, column] -= bouncier * ry

    return tighten


def make_collide(
    gaps: Gaps, perturbations: Perturbations, laws: Laws, count: int, part: Part = as_it_stands
) -> Callable[..., None]:
    """Make the function ``(run, restitution)`` for balls that meet."""
    two, size, sensitive = count == 2, 2 * count, len(laws.changes) > 0
    columns_of, taut_perturbation = perturbations.columns_of, perturbations.taut_perturbation

    @part
    def mobility_of(run: Run, i: int, nx: float, ny: float) -> float:
        """Velocity along the line of centres per impulse along it [1/kg]: less on a taut string."""
        b, point, across = run.bodies[i], run.now[i], 1.0
        if run.state.is_slack[i] == 0:
            across = nx * cosine(point.angle) + ny * sine(point.angle)
        result: float = across * across / (b.inertia * b.inverse_length * b.inverse_length)
        return result

    @inlined(part)
    def heavier(run: Run, i: int, column: int) -> float:
        """By which share of it a column's parameter makes a ball's mass larger."""
        if not sensitive or column < size:
            return 0.0
        b, change = run.bodies[i], run.changes[column - size].bodies[i]
        shorter = 2.0 * change.inverse_length / b.inverse_length
        share: float = change.inertia / b.inertia + shorter
        return share

    @part
    def tangential_part(
        run: Run, i: int, column: int, nx: float, ny: float, x: float, y: float
    ) -> tuple[float, float]:
        """Component of the line of centres around the pivot, and its perturbation."""
        angle, _ = taut_perturbation(run, i, column, run.now[i])
        s, c = sine(run.now[i].angle), cosine(run.now[i].angle)
        return nx * c + ny * s, x * c + y * s + (ny * c - nx * s) * angle

    @part
    def collide(run: Run, restitution: float) -> None:
        """Multiply by the derivative of a collision.

        The impulse is ``(1 + e) c / m`` along the line of centres n, with the closing speed c and
        the sum m of both mobilities. A perturbation changes n (by the balls' places), c (by n and
        by the velocities) and m (by n and by the directions of taut strings); a ball on a taut
        string takes only the part of the impulse around the pivot. Velocities are those before the
        collision, and strings taut those that stay so.
        """
        if run.state.has_tangent_map == 0:
            return
        z, (nx, ny, distance) = run.state.tangent_map, gaps.line_of_centres(run.now)
        closing, mobility = -gaps.gap(run, run.now)[1], 0.0
        for i in range(count):
            mobility += mobility_of(run, i, nx, ny)
        back = 1.0 + restitution
        impulse = back * closing / mobility
        for column in range(columns_of(run)):
            # Perturbations of the line of centres, of the closing speed and of the mobility.
            x, y, slower, mobility_change = 0.0, 0.0, 0.0, 0.0
            if two:
                x = (z[0, column] - z[4, column]) / distance
                y = (z[1, column] - z[5, column]) / distance
                along = nx * x + ny * y
                x, y = x - along * nx, y - along * ny
            for i in range(count):
                row, sign, point, b = 4 * i, 1.0 - 2.0 * i, run.now[i], run.bodies[i]
                slower -= sign * (x * point.vx + y * point.vy)
                slower -= sign * (nx * z[row + 2, column] + ny * z[row + 3, column])
                mobility_change -= mobility_of(run, i, nx, ny) * heavier(run, i, column)
                if run.state.is_slack[i] == 0:
                    across, change = tangential_part(run, i, column, nx, ny, x, y)
                    mobility_change += (
                        2.0 * across * change / (b.inertia * b.inverse_length * b.inverse_length)
                    )
            pushed = back * (slower - closing * mobility_change / mobility) / mobility
            if sensitive and column >= size and restitution > 0.0:
                pushed += run.changes[column - size].restitution * closing / mobility
            for i in range(count):
                b, row = run.bodies[i], 4 * i
                per_mass = (1.0 - 2.0 * i) / (b.inertia * b.inverse_length * b.inverse_length)
                less = pushed - impulse * heavier(run, i, column)
                px, py = less * nx + impulse * x, less * ny + impulse * y
                if run.state.is_slack[i] == 0:
                    across, change = tangential_part(run, i, column, nx, ny, x, y)
                    angle, _ = taut_perturbation(run, i, column, run.now[i])
                    s, c = sine(run.now[i].angle), cosine(run.now[i].angle)
                    around = less * across + impulse * change
                    px = around * c - impulse * across * s * angle
                    py = around * s + impulse * across * c * angle
                z[row + 2, column] += per_mass * px
                z[row + 3, column] += per_mass * py

    return collide


def make_kick(perturbations: Perturbations, part: Part = as_it_stands) -> Callable[..., None]:
    """Make the function ``(run, i, kicked)`` for a kick of a slack ball."""
    columns_of = perturbations.columns_of

    @part
    def kick(run: Run, i: int, kicked: float) -> None:
        """Multiply by the derivative of a kick of a slack ball around the pivot [rad/s]."""
        z, row = run.state.tangent_map, 4 * i
        for column in range(columns_of(run)):
            z[row + 2, column] -= kicked * z[row + 1, column]
            z[row + 3, column] += kicked * z[row, column]

    return kick
