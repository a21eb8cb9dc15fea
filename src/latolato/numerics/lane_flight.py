"""What all lanes do together: a full step, and reporting it to an observable.

Loops run over all lanes without branches, so that they become vector instructions.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from latolato.core.scalar import formula
from latolato.numerics import lane_rows as r
from latolato.numerics.engine.laws import Formula, restoring_laws
from latolato.numerics.matrices import write_matrix
from latolato.numerics.parts import Part
from latolato.numerics.pointers import ANY_SIZE, array_at
from latolato.numerics.records import Floats
from latolato.numerics.run_record import MATRIX_SHAPE
from latolato.observables import Step
from latolato.observables.hermite import turning_angle
from latolato.physics.pendulum import SLOPES

# Lanes are listed in groups of so many: most groups have none to list.
_GROUP = 8


@formula
def width_of(w: Floats) -> int:
    """Return how many lanes are in use; the compiler sees that they are whole blocks."""
    return r.BLOCK * int(w[r.BLOCKS * r.LANES])


def make_lane_step(
    restoring: Formula, part: Part, *, damped: bool, walled: bool, works: bool, tangents: bool
) -> Callable[..., float]:
    """Return the kernel that takes a step in every lane, undone where it must not be taken."""
    copied, slope = 7 if works else 5, SLOPES[restoring]
    first, second = r.ANGLE_OF_ANGLE, r.ANGLE_OF_VELOCITY
    numbers_at = array_at()

    @part
    def advance(w: Floats, table: Floats, kicks: Floats, stages: int) -> None:
        """Take a full step in every lane, keeping what was before."""
        L, width = r.LANES, width_of(w)
        for row in range(copied):
            for j in range(width):
                w[(row + r.COPY) * L + j] = w[row * L + j]
        if tangents:
            for j in range(width):
                w[first * L + j] = w[(second + 1) * L + j] = 1.0
                w[(first + 1) * L + j] = w[second * L + j] = 0.0
        for i in range(stages):
            b, at = kicks[i], i * r.TABLE_ROWS * L
            for j in range(width):
                cos, sin = table[at + r.COS * L + j], table[at + r.SIN * L + j]
                reach, left = table[at + r.DRIFT_TIME * L + j], table[at + r.LEFT * L + j]
                driven = w[r.C * L + j] * cos - w[r.D * L + j] * sin
                v, s = w[r.V * L + j], w[r.S * L + j]
                change = b * (w[r.G * L + j] + driven) * s
                if works:
                    w[r.WORK * L + j] += b * driven * s * (v + 0.5 * change)
                if tangents:
                    gradient = b * (w[r.G * L + j] + driven) * slope(w[r.X * L + j])
                    kept = left if damped else 1.0
                    v1 = w[(first + 1) * L + j] + gradient * w[first * L + j]
                    v2 = w[(second + 1) * L + j] + gradient * w[second * L + j]
                    w[first * L + j] += v1 * reach
                    w[second * L + j] += v2 * reach
                    w[(first + 1) * L + j] = v1 * kept
                    w[(second + 1) * L + j] = v2 * kept
                v += change
                x = w[r.X * L + j] + v * reach
                w[r.X * L + j] = x
                w[r.S * L + j] = restoring(x)
                if damped:
                    slower = v * left
                    if works:
                        w[r.LOSS * L + j] += 0.5 * (v - slower) * (v + slower)
                    v = slower
                w[r.V * L + j] = v
        b, at = kicks[stages], stages * r.TABLE_ROWS * L
        for j in range(width):
            cos, sin = table[at + r.COS * L + j], table[at + r.SIN * L + j]
            driven = w[r.C * L + j] * cos - w[r.D * L + j] * sin
            w[r.D * L + j] = w[r.D * L + j] * cos + w[r.C * L + j] * sin
            w[r.C * L + j] = driven
            v, s = w[r.V * L + j], w[r.S * L + j]
            change = b * (w[r.G * L + j] + driven) * s
            if works:
                w[r.WORK * L + j] += b * driven * s * (v + 0.5 * change)
            w[r.V * L + j] = v + change
            if tangents:
                gradient = b * (w[r.G * L + j] + driven) * slope(w[r.X * L + j])
                w[(first + 1) * L + j] += gradient * w[first * L + j]
                w[(second + 1) * L + j] += gradient * w[second * L + j]

    @part
    def judge(w: Floats) -> float:
        """Find the lanes whose full step must not be taken, and return how many they are.

        That is at a halt, where the end lies beyond a wall, and beside a wall where the force
        changes sign or where the ball turns round and may have been beyond in between.
        """
        L, width = r.LANES, width_of(w)
        for j in range(width):
            stays = 1.0 if w[r.N * L + j] >= w[r.HALT * L + j] else 0.0
            if walled:
                x, x0 = w[r.X * L + j], w[r.X0 * L + j]
                v, v0 = w[r.V * L + j], w[r.V0 * L + j]
                g = w[r.G * L + j]
                a = (g + w[r.C * L + j]) * w[r.S * L + j]
                a0 = (g + w[r.C0 * L + j]) * w[r.S0 * L + j]
                below = min(x, x0) - w[r.LOW * L + j]
                above = w[r.HIGH * L + j] - max(x, x0)
                beyond = (x <= w[r.LOW * L + j]) | (x >= w[r.HIGH * L + j])
                # Only a velocity that the forces can undo within the step may turn twice.
                slow = min(abs(v), abs(v0)) < max(abs(a), abs(a0))
                near = min(below, above) < abs(v) + abs(v0)
                bends = (a * a0 < 0.0) & slow & near
                dips = (v0 < 0.0) & (v > 0.0) & (below <= max(-v0, v))
                rises = (v0 > 0.0) & (v < 0.0) & (above <= max(v0, -v))
                stays = 1.0 if beyond | bends | dips | rises else stays
            w[r.TAKEN * L + j] = 1.0 - stays
        # A sum in the loop above would keep it from becoming vector instructions.
        count = 0.0
        for j in range(width):
            count += 1.0 - w[r.TAKEN * L + j]
        return count

    @part
    def put_back(w: Floats) -> None:
        """Note the ends of steps that are not taken, and put these lanes back to their start."""
        L, width = r.LANES, width_of(w)
        for j in range(width):
            per_h = w[r.PER_H * L + j]
            w[r.X1 * L + j], w[r.V1 * L + j] = w[r.X * L + j], w[r.V * L + j] * per_h
            a = (w[r.G * L + j] + w[r.C * L + j]) * w[r.S * L + j]
            w[r.A1 * L + j] = a * per_h * per_h
        for row in range(copied):
            for j in range(width):
                now, before = w[row * L + j], w[(row + r.COPY) * L + j]
                w[row * L + j] = now if w[r.TAKEN * L + j] > 0.0 else before

    def take_step(workspace: int, table: int, kicks: int, stages: int) -> float:
        w = numbers_at(workspace, r.ROWS * r.LANES)
        weights, rows = numbers_at(kicks, stages + 1), (stages + 1) * r.TABLE_ROWS * r.LANES
        advance(w, numbers_at(table, rows), weights, stages)
        waiting: float = judge(w)
        if waiting > 0.0:
            put_back(w)
        return waiting

    return take_step


def make_shared_values(
    restoring: Formula, potential_of: Formula, part: Part, *, energy: bool, turn: bool
) -> Callable[..., None]:
    """Return the kernel that computes, for every lane, the values that observables share.

    Few lanes turn round in a step. These are listed and seen to one by one.
    """
    potential = restoring_laws(restoring, potential_of, part).potential
    numbers_at = array_at()

    @part
    def list_chosen(w: Floats) -> int:
        """List the lanes that are chosen, and return how many they are."""
        L, count = r.LANES, 0
        for first in range(0, width_of(w), _GROUP):
            some = 0
            for j in range(first, first + _GROUP):
                some += 1 if w[r.CHOSEN * L + j] > 0.0 else 0
            if some > 0:
                for j in range(first, first + _GROUP):
                    w[r.LIST * L + count] = j
                    count += 1 if w[r.CHOSEN * L + j] > 0.0 else 0
        return count

    @part
    def find_potentials(w: Floats, is_linear: int) -> None:
        """Write the potentials at both ends of each step; the first is the end of the last one."""
        L = r.LANES
        for j in range(width_of(w)):
            w[r.P0 * L + j] = w[r.P1 * L + j]
            w[r.P1 * L + j] = potential(w[r.X * L + j], is_linear)

    @part
    def find_turns(w: Floats) -> None:
        """Write the angle at which each lane turns round."""
        L, width = r.LANES, width_of(w)
        for j in range(width):
            w[r.TURN * L + j] = w[r.X * L + j]
            w[r.CHOSEN * L + j] = 1.0 if w[r.V0 * L + j] * w[r.V * L + j] < 0.0 else 0.0
        for i in range(list_chosen(w)):
            j = int(w[r.LIST * L + i])
            per_h, rate, g = w[r.PER_H * L + j], w[r.RATE * L + j], w[r.G * L + j]
            v0, v1 = w[r.V0 * L + j] * per_h, w[r.V * L + j] * per_h
            a0 = (g + w[r.C0 * L + j]) * w[r.S0 * L + j] * per_h * per_h - rate * v0
            a1 = (g + w[r.C * L + j]) * w[r.S * L + j] * per_h * per_h - rate * v1
            x0, x1 = w[r.X0 * L + j], w[r.X * L + j]
            w[r.TURN * L + j] = turning_angle(w[r.H * L + j], x0, v0, a0, x1, v1, a1)

    def find_shared(slots: int, workspace: int, matrix: int, is_linear: int) -> None:
        w = numbers_at(workspace, r.ROWS * r.LANES)
        if energy:
            find_potentials(w, is_linear)
        if turn:
            find_turns(w)

    return find_shared


def make_step_report(
    formula: Callable[..., None], restoring: Formula, potential_of: Formula, part: Part, *,
    energy: bool, turn: bool,
) -> Callable[..., None]:  # fmt: skip
    """Return the kernel that reports every lane's step to an observable, an undone one as 0 s.

    The flags say what `make_shared_values` has found; if the formula reads the other it is found
    here.
    """
    potential = restoring_laws(restoring, potential_of, part).potential
    numbers_at = array_at()

    def report(slots: int, workspace: int, matrix: int, is_linear: int) -> None:
        acc, w = numbers_at(slots, ANY_SIZE), numbers_at(workspace, r.ROWS * r.LANES)
        L = r.LANES
        for j in range(width_of(w)):
            h = w[r.H * L + j]
            per_h, rate = w[r.PER_H * L + j], w[r.RATE * L + j]
            t0 = w[r.T * L + j] + w[r.N * L + j] * h
            x0, x1 = w[r.X0 * L + j], w[r.X * L + j]
            v0, v1 = w[r.V0 * L + j] * per_h, w[r.V * L + j] * per_h
            s0, s1 = w[r.S0 * L + j], w[r.S * L + j]
            per_h2 = per_h * per_h
            g = w[r.G * L + j]
            a0 = (g + w[r.C0 * L + j]) * s0 * per_h2 - rate * v0
            a1 = (g + w[r.C * L + j]) * s1 * per_h2 - rate * v1
            stiffness = -g * per_h2
            p0 = w[r.P0 * L + j] if energy else potential(x0, is_linear)
            p1 = w[r.P1 * L + j] if energy else potential(x1, is_linear)
            turns = w[r.TURN * L + j] if turn else turning_angle(h, x0, v0, a0, x1, v1, a1)
            segment = Step(
                t0, t0 + w[r.TAKEN * L + j] * h, x0, x1, v0, v1, a0, a1,
                0.5 * v0 * v0 + stiffness * p0, 0.5 * v1 * v1 + stiffness * p1,
                v0 * (a0 + stiffness * s0), v1 * (a1 + stiffness * s1), 0.0, turns,
            )  # fmt: skip
            formula(acc, j, L, segment)

    return report


def make_jacobian_report(formula: Callable[..., None], part: Part) -> Callable[..., None]:
    """Return the kernel that reports the Jacobian of every step taken to an observable."""
    first, second = r.ANGLE_OF_ANGLE, r.ANGLE_OF_VELOCITY
    numbers_at, (rows, columns) = array_at(), MATRIX_SHAPE
    matrix_at = array_at(np.dtype(np.float64), columns)

    def report(slots: int, workspace: int, matrix: int, is_linear: int) -> None:
        acc, w = numbers_at(slots, ANY_SIZE), numbers_at(workspace, r.ROWS * r.LANES)
        jacobian = matrix_at(matrix, rows)
        L = r.LANES
        for j in range(width_of(w)):
            if w[r.TAKEN * L + j] == 0.0:
                continue
            h = w[r.H * L + j]
            step = (
                w[first * L + j], w[second * L + j] * h,
                w[(first + 1) * L + j] * w[r.PER_H * L + j], w[(second + 1) * L + j],
            )  # fmt: skip
            write_matrix(jacobian, 0, step)
            formula(acc, j, L, 2, h, -w[r.RATE * L + j] * h, jacobian)

    return report
