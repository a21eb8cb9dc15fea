"""Small deviations while a string is slack, and the saltation matrices of what happens then.

With all strings taut a deviation is one of angles and angular velocities. A slack string gives its
ball two more freedoms. Each deviation that there was when the first string went slack is then
followed as one of places and velocities in the plane, one column each: its image. Once all strings
are taut again the image is one of angles and angular velocities, and the matrix from the one to the
other is shown to the observables.

An event that comes dt later changes a deviation by ``z+ = D z- + (D f- - f+) dt``: f are the
velocities and accelerations before and after it, D is what it does to a deviation at the event
itself (Aizerman & Gantmacher 1958).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.core.scalar import cosine, formula, sine
from latolato.numerics.engine.apart import THERE, Apart
from latolato.numerics.engine.compiling import Part, as_it_stands
from latolato.numerics.engine.fall import Fall, place_taut
from latolato.numerics.engine.look import Look
from latolato.numerics.engine.record import IMAGE_DELAY, KICK, REACH
from latolato.numerics.engine.swing import ANY_LENGTH, Swing
from latolato.numerics.watch import Eyes
from latolato.physics.damping import drift, drift_slopes


class Image(NamedTuple):
    """The functions of the image; see `make_image`. They do nothing where nobody looks at it."""

    begin: Callable[..., None]
    step: Callable[..., None]
    meet: Callable[..., None]
    reach: Callable[..., None]
    tighten: Callable[..., None]
    strike: Callable[..., None]
    leave: Callable[..., None]
    throw: Callable[..., None]
    spoil: Callable[..., None]
    finish: Callable[..., None]


@formula
def _place(run: Any, i: int, column: int, x: float, y: float, vx: float, vy: float) -> None:
    """Write what deviates of one ball, in one column."""
    image, row = run.state.image, 4 * i
    image[row, column], image[row + 1, column] = x, y
    image[row + 2, column], image[row + 3, column] = vx, vy


@formula
def _embed(run: Any, i: int, column: int, point: Any, angle: float, velocity: float) -> None:
    """Write the image of a deviation of angle and angular velocity on a taut string."""
    length, s, c = 1.0 / run.bodies[i].coupling, sine(point.angle), cosine(point.angle)
    around, inward = length * velocity, length * point.velocity * angle
    far = length * angle
    _place(run, i, column, far * c, far * s, around * c - inward * s, around * s + inward * c)


@formula
def _turned(run: Any, i: int, column: int, point: Any) -> tuple[float, float]:
    """Return the deviation of angle and angular velocity of an image on a taut string."""
    image, row = run.state.image, 4 * i
    coupling, s, c = run.bodies[i].coupling, sine(point.angle), cosine(point.angle)
    angle = coupling * (c * image[row, column] + s * image[row + 1, column])
    velocity = coupling * (c * image[row + 2, column] + s * image[row + 3, column])
    return angle, velocity


def make_image(
    swing: Swing, fall: Fall, apart: Apart, look: Look, count: int, part: Part = as_it_stands
) -> Image:
    """Return the functions of the image of `count` balls."""
    two, size, pull = count == 2, 2 * count, fall.pull

    @part
    def closer(run: Any, column: int) -> float:
        """Return by how much the gap between balls deviates [m]."""
        image, (nx, ny, _) = run.state.image, apart.line(run.now)
        result: float = nx * image[0, column] + ny * image[1, column]
        if two:
            result -= nx * image[4, column] + ny * image[5, column]
        return result

    @part
    def begin(run: Any) -> None:
        """Begin with a deviation of each angle and angular velocity, where all strings are taut.

        A string that a hit would make push lets go at once. Its ball falls from the hit on then,
        not only from now, which a deviation delays.
        """
        state = run.state
        is_slack = state.is_slack[0] != 0 or state.is_slack[count - 1] != 0
        if is_slack or state.has_image != 0 or not look.sees_matrices(run):
            return
        state.has_image, state.image_start = 1, run.t
        for column in range(size):
            for i in range(count):
                angle = 1.0 if column == 2 * i else 0.0
                velocity = 1.0 if column == 2 * i + 1 else 0.0
                _embed(run, i, column, run.now[i], angle, velocity)
                state.image[IMAGE_DELAY + i, column] = 0.0
        for i in range(count):
            place_taut(run.now[i], 1.0 / run.bodies[i].coupling)
        _, rate = apart.gap(run, run.now)
        if state.touch == 0.0 or rate <= 0.0:
            return
        for column in range(size):
            delay = -closer(run, column) / rate
            for i in range(count):
                point, length = run.now[i], 1.0 / run.bodies[i].coupling
                pushed = length * min(swing.tension(run, i, point), 0.0) * delay
                state.image[4 * i + 2, column] -= pushed * sine(point.angle)
                state.image[4 * i + 3, column] += pushed * cosine(point.angle)

    @part
    def fall_along(run: Any, i: int) -> None:
        """Follow the image of a falling ball; what pulls at it is the same everywhere."""
        image, row, b, table = run.state.image, 4 * i, run.bodies[i], ANY_LENGTH + i
        vx, vy, gravity = run.now[i].vx, run.now[i].vy, run.settings.gravity
        ax, ay = run.now[i].across, run.now[i].pivot_acceleration
        wx, wy, quadratic = run.now[i].wind_x, run.now[i].wind_y, b.quadratic * b.coupling
        for k in range(run.stages):
            h, reach = run.tables[table, KICK, k], run.tables[table, REACH, k]
            vx -= h * (ax + b.rate * wx)
            vy -= h * (gravity + ay + b.rate * wy)
            speed = math.hypot(vx, vy)
            # Along the velocity, and beside it.
            far, kept = drift_slopes(speed, 1.0, reach, b.rate, quadratic)
            far_beside, kept_beside, ux, uy = far, kept, 0.0, 0.0
            if speed > 0.0:
                travelled, slower = drift(speed, 1.0, reach, b.rate, quadratic)
                far_beside, kept_beside = travelled / speed, slower / speed
                ux, uy = vx / speed, vy / speed
            for column in range(size):
                x, y = image[row + 2, column], image[row + 3, column]
                along = ux * x + uy * y
                farther, faster = (far - far_beside) * along, (kept - kept_beside) * along
                image[row, column] += far_beside * x + farther * ux
                image[row + 1, column] += far_beside * y + farther * uy
                image[row + 2, column] = kept_beside * x + faster * ux
                image[row + 3, column] = kept_beside * y + faster * uy
            vx *= kept_beside
            vy *= kept_beside
            swing.shake(run, run.t + run.nodes[k] * run.length, run.inside[i])
            ax, ay = run.inside[i].across, run.inside[i].pivot_acceleration
            wx, wy = run.inside[i].wind_x, run.inside[i].wind_y

    @part
    def step(run: Any) -> None:
        """Follow the image through the step that is planned."""
        if run.state.has_image == 0:
            return
        for i in range(count):
            swing.prepare(run, i, ANY_LENGTH + i, run.length)
            if run.state.is_slack[i] != 0:
                fall_along(run, i)
                continue
            m11, m12, m21, m22 = swing.tangent(run, i, ANY_LENGTH + i, run.now[i])
            for column in range(size):
                angle, velocity = _turned(run, i, column, run.now[i])
                later, faster = m11 * angle + m12 * velocity, m21 * angle + m22 * velocity
                _embed(run, i, column, run.end[i], later, faster)

    @part
    def move(run: Any, sign: float) -> None:
        """Move all deviations to the event, or back from it, by their delays."""
        image = run.state.image
        for i in range(count):
            row, point, (ax, ay) = 4 * i, run.now[i], pull(run, i, run.now[i])
            for column in range(size):
                delay = sign * image[IMAGE_DELAY + i, column]
                image[row, column] += point.vx * delay
                image[row + 1, column] += point.vy * delay
                image[row + 2, column] += ax * delay
                image[row + 3, column] += ay * delay

    @part
    def meet(run: Any) -> None:
        """Find by how much deviations delay it that balls meet, and what they are there."""
        begin(run)
        _, rate = apart.gap(run, run.now)
        if run.state.has_image == 0 or rate >= 0.0:
            return
        for column in range(size):
            delay = -closer(run, column) / rate
            for i in range(count):
                run.state.image[IMAGE_DELAY + i, column] = delay
        move(run, 1.0)

    @part
    def reach(run: Any) -> None:
        """Find the same where strings reach their lengths; others do not wait for a ball there."""
        if run.state.has_image == 0:
            return
        image = run.state.image
        for i in range(count):
            row, point, b = 4 * i, run.now[i], run.bodies[i]
            spare, rate = apart.spare(run, i, point)
            if run.state.is_slack[i] != 0 and spare * b.coupling <= THERE and rate < 0.0:
                for column in range(size):
                    longer = point.x * image[row, column] + point.y * image[row + 1, column]
                    image[IMAGE_DELAY + i, column] = longer * b.coupling / rate
        move(run, 1.0)

    @part
    def leave(run: Any) -> None:
        """Return from the event."""
        if run.state.has_image == 0:
            return
        move(run, -1.0)
        for column in range(size):
            for i in range(count):
                run.state.image[IMAGE_DELAY + i, column] = 0.0

    @part
    def tighten(run: Any, i: int, restitution: float) -> None:
        """Let the string of a ball throw it back, or hold it: ``v+ = v - (1 + e_s) (r v) r``."""
        if run.state.has_image == 0:
            return
        image, row, point, k = run.state.image, 4 * i, run.now[i], run.bodies[i].coupling
        rx, ry, back = k * point.x, k * point.y, 1.0 + restitution
        outward = rx * point.vx + ry * point.vy
        for column in range(size):
            x, y = k * image[row, column], k * image[row + 1, column]
            along = rx * x + ry * y
            x, y = x - along * rx, y - along * ry
            faster = rx * image[row + 2, column] + ry * image[row + 3, column]
            faster += x * point.vx + y * point.vy
            image[row + 2, column] -= back * (faster * rx + outward * x)
            image[row + 3, column] -= back * (faster * ry + outward * y)

    @part
    def share(run: Any, i: int, nx: float, ny: float) -> float:
        """Return how much faster a ball becomes by a push along the line of centres [1/kg]."""
        b, point, across = run.bodies[i], run.now[i], 1.0
        if run.state.is_slack[i] == 0:
            across = nx * cosine(point.angle) + ny * sine(point.angle)
        result: float = across * across / (b.inertia * b.coupling * b.coupling)
        return result

    @part
    def beside(
        run: Any, i: int, column: int, nx: float, ny: float, x: float, y: float
    ) -> tuple[float, float]:
        """Return the part of the line of centres around the pivot, and how it deviates."""
        angle, _ = _turned(run, i, column, run.now[i])
        s, c = sine(run.now[i].angle), cosine(run.now[i].angle)
        return nx * c + ny * s, x * c + y * s + (ny * c - nx * s) * angle

    @part
    def strike(run: Any, restitution: float) -> None:
        """Let balls collide; velocities are those before, strings those that stay taut."""
        if run.state.has_image == 0:
            return
        image, (nx, ny, distance) = run.state.image, apart.line(run.now)
        closing, yields = -apart.gap(run, run.now)[1], 0.0
        for i in range(count):
            yields += share(run, i, nx, ny)
        back = 1.0 + restitution
        impulse = back * closing / yields
        for column in range(size):
            # How the line of centres, the closing speed and what yields deviate.
            x, y, slower, yielding = 0.0, 0.0, 0.0, 0.0
            if two:
                x = (image[0, column] - image[4, column]) / distance
                y = (image[1, column] - image[5, column]) / distance
                along = nx * x + ny * y
                x, y = x - along * nx, y - along * ny
            for i in range(count):
                row, sign, point, b = 4 * i, 1.0 - 2.0 * i, run.now[i], run.bodies[i]
                slower -= sign * (x * point.vx + y * point.vy)
                slower -= sign * (nx * image[row + 2, column] + ny * image[row + 3, column])
                if run.state.is_slack[i] == 0:
                    across, deviates = beside(run, i, column, nx, ny, x, y)
                    yielding += 2.0 * across * deviates / (b.inertia * b.coupling * b.coupling)
            pushed = back * (slower - closing * yielding / yields) / yields
            for i in range(count):
                b, row = run.bodies[i], 4 * i
                per_mass = (1.0 - 2.0 * i) / (b.inertia * b.coupling * b.coupling)
                px, py = pushed * nx + impulse * x, pushed * ny + impulse * y
                if run.state.is_slack[i] == 0:
                    across, deviates = beside(run, i, column, nx, ny, x, y)
                    angle, _ = _turned(run, i, column, run.now[i])
                    s, c = sine(run.now[i].angle), cosine(run.now[i].angle)
                    around = pushed * across + impulse * deviates
                    px = around * c - impulse * across * s * angle
                    py = around * s + impulse * across * c * angle
                image[row + 2, column] += per_mass * px
                image[row + 3, column] += per_mass * py

    @part
    def throw(run: Any, i: int, thrown: float) -> None:
        """Throw a slack ball around the pivot [rad/s]."""
        image, row = run.state.image, 4 * i
        for column in range(size):
            image[row + 2, column] -= thrown * image[row + 1, column]
            image[row + 3, column] += thrown * image[row, column]

    @part
    def spoil(run: Any) -> None:
        """Note that small deviations do not stay small here, or not alike on both sides."""
        for column in range(size):
            run.state.image[0, column] = math.nan

    @part
    def finish(run: Any, eyes: Eyes) -> None:
        """Show the matrix, now that all strings are taut.

        What the laws of motion give its determinant is not known beforehand: NaN.
        """
        if run.state.has_image == 0:
            return
        run.state.has_image = 0
        for column in range(size):
            for i in range(count):
                angle, velocity = _turned(run, i, column, run.now[i])
                run.jacobian[2 * i, column], run.jacobian[2 * i + 1, column] = angle, velocity
        look.matrix(run, eyes, size, run.t - run.state.image_start, math.nan)

    return Image(begin, step, meet, reach, tighten, strike, leave, throw, spoil, finish)
