"""What becomes of small deviations of two balls that collide: one matrix for each piece of motion.

The state is ``(angle_1, velocity_1, angle_2, velocity_2)``. In lasting contact deviations from
moving as one are lost, so the matrix has rank two from then on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.engine.swing import freed
from latolato.numerics.flight import Law, Method, Part, prepare
from latolato.numerics.pair_flight import FORCE, JOINT, STUCK, Pair, V, X, point_of
from latolato.numerics.tangent import (
    UNCHANGED,
    Matrix,
    clear_matrix,
    make_tangent,
    write_joint_matrix,
    write_matrix,
)
from latolato.physics.damping import drag
from latolato.physics.pair import write_pair_saltation
from latolato.physics.pendulum import SLOPES


class PairTangent(NamedTuple):
    """The functions that hand matrices on to the observables; see `make_pair_tangent`."""

    fly: Callable[..., None]
    turn: Callable[..., None]
    move_jointly: Callable[..., None]
    unite: Callable[..., None]
    collide: Callable[..., None]
    jump: Callable[..., None]


def make_pair_tangent(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    watch_tangent: Callable[..., None],
    compile_part: Part | None = None,
) -> PairTangent:
    """Return the functions for two balls; rows and columns are those of `make_pair_flight`.

    Each begins with ``(acc, column, columns, jacobian, ...)`` and calls `watch_tangent`.
    """
    part: Part = compile_part or (lambda function: function)
    tangent, slope = make_tangent(acceleration, restoring, compile_part), SLOPES[restoring]

    @part
    def matrix_of(
        hs: float, t: float, q: Any, row: int, sign: float, method: Method, law: Law
    ) -> Matrix:
        """Return the matrix of a step of one row; a held ball keeps nothing but its place."""
        if sign == STUCK:
            return 1.0, 0.0, 0.0, 0.0
        prepare(method, hs, law.body.rate)
        return tangent(point_of(t, q, row), sign, method.table, law)

    @part
    def turned(t: float, r: Any, row: int, law: Law) -> float:
        """Return by what a velocity's deviation changes where friction changes its sign."""
        free = -(law.gravity + acceleration(t, law.p)) * law.body.coupling * restoring(r[row, X])
        before = r[row, FORCE]
        return freed(free, 0.0, law.body) / before if before != 0.0 else 0.0

    @part
    def slow(a: float, v: float, sign: float, body: Any) -> float:
        """Return the acceleration with all drag from that of a kick."""
        return a - drag(v, sign, body.rate, body.quadratic, 0.0)

    @part
    def logarithm(ratio: float) -> float:
        return math.log(ratio) if ratio > 0.0 else -math.inf

    @part
    def fly(
        acc: Any, column: int, columns: int, jacobian: Any, hs: float, t: float, q: Any, r: Any,
        pair: Pair,
    ) -> None:  # fmt: skip
        """Follow a step of both balls."""
        clear_matrix(jacobian, 4)
        spread = 0.0
        for i in range(2):
            sign, law = pair.signs[i], pair.laws[i]
            write_matrix(jacobian, i, matrix_of(hs, t, q, i, sign, pair.methods[i], law))
            if sign == STUCK:
                spread = -math.inf
            else:
                spread -= law.body.rate * hs
                spread -= 2.0 * law.body.quadratic * abs(r[i, X] - q[i, X])
        watch_tangent(acc, column, columns, 4, hs, spread, jacobian)

    @part
    def turn(
        acc: Any, column: int, columns: int, jacobian: Any, t: float, r: Any, ball: int, pair: Pair
    ) -> None:
        """Follow the turning point of one ball at the end of a step; letting go changes nothing."""
        if pair.signs[ball] == STUCK:
            return
        ratio = turned(t, r, ball, pair.laws[ball])
        clear_matrix(jacobian, 4)
        write_matrix(jacobian, 1 - ball, UNCHANGED)
        write_matrix(jacobian, ball, (1.0, 0.0, 0.0, ratio))
        watch_tangent(acc, column, columns, 4, 0.0, logarithm(ratio), jacobian)

    @part
    def move_jointly(
        acc: Any, column: int, columns: int, jacobian: Any, hs: float, t: float, q: Any, r: Any,
        share: float, turns: bool, law: Law, pair: Pair,
    ) -> None:  # fmt: skip
        """Follow a step of both balls as one, and its turning point."""
        matrix = matrix_of(hs, t, q, JOINT, pair.signs[JOINT], pair.methods[JOINT], law)
        write_joint_matrix(jacobian, share, matrix)
        watch_tangent(acc, column, columns, 4, hs, -math.inf, jacobian)
        if turns:
            matrix = (1.0, 0.0, 0.0, turned(t + hs, r, JOINT, law))
            write_joint_matrix(jacobian, share, matrix)
            watch_tangent(acc, column, columns, 4, 0.0, -math.inf, jacobian)

    @part
    def unite(acc: Any, column: int, columns: int, jacobian: Any, share: float) -> None:
        """Follow the begin of lasting contact."""
        write_joint_matrix(jacobian, share, UNCHANGED)
        watch_tangent(acc, column, columns, 4, 0.0, -math.inf, jacobian)

    @part
    def collide(
        acc: Any, column: int, columns: int, jacobian: Any, share: float, restitution: float,
        before: Any, forces: Any, q: Any, pair: Pair,
    ) -> None:  # fmt: skip
        """Follow an impact from velocities `before`; `forces` are the accelerations then."""
        after = (q[0, V], q[1, V])
        slowed = (
            slow(q[0, FORCE], after[0], pair.signs[0], pair.laws[0].body),
            slow(q[1, FORCE], after[1], pair.signs[1], pair.laws[1].body),
        )
        write_pair_saltation(jacobian, share, restitution, before, after, forces, slowed)
        watch_tangent(acc, column, columns, 4, 0.0, 2.0 * logarithm(restitution), jacobian)

    @part
    def jump(
        acc: Any, column: int, columns: int, jacobian: Any, size: float, q: Any, pair: Pair
    ) -> None:
        """Follow a jump of the pivot's velocity."""
        clear_matrix(jacobian, 4)
        for i in range(2):
            bend = -size * pair.laws[i].body.coupling * slope(q[i, X])
            write_matrix(jacobian, i, (1.0, 0.0, bend, 1.0))
        watch_tangent(acc, column, columns, 4, 0.0, 0.0, jacobian)

    return PairTangent(fly, turn, move_jointly, unite, collide, jump)
