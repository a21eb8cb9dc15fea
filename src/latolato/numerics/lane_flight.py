"""What all lanes do together: a full step, its judgement, and showing it to observables.

Loops run over all lanes without branches, so that they become vector instructions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics import lane_rows as r
from latolato.numerics.flight import Part
from latolato.numerics.tangent import write_matrix
from latolato.numerics.watch import Watch
from latolato.observables import Segment
from latolato.physics.pendulum import SLOPES


class LaneFlight(NamedTuple):
    """The functions of all lanes; see `make_lane_flight`."""

    advance_all: Callable[..., None]
    judge_all: Callable[..., float]
    put_back: Callable[..., None]
    count_all: Callable[..., None]
    watch_all: Callable[..., None]
    follow_all: Callable[..., None]


def make_lane_flight(
    restoring: Callable[..., float],
    potential: Callable[..., float],
    watch: Watch,
    compile_part: Part | None = None,
    *,
    damped: bool,
    walled: bool,
    works: bool,
    tangents: bool,
) -> LaneFlight:
    """Return the functions of all lanes; the arguments are those of `lanes.make_lanes`."""
    part: Part = compile_part or (lambda function: function)
    copied = 7 if works else 5
    watch_step, watch_tangent, slope = watch.step, watch.tangent, SLOPES[restoring]
    first, second = r.ANGLE_OF_ANGLE, r.ANGLE_OF_VELOCITY

    @part
    def advance_all(w: Any, table: Any, kicks: Any) -> None:
        """Take a full step in every lane, keeping what was before."""
        L = r.LANES
        for row in range(copied):
            for j in range(L):
                w[(row + r.COPY) * L + j] = w[row * L + j]
        if tangents:
            for j in range(L):
                w[first * L + j] = w[(second + 1) * L + j] = 1.0
                w[(first + 1) * L + j] = w[second * L + j] = 0.0
        stages = table.shape[0] - 1
        for i in range(stages):
            b = kicks[i]
            reach, left = table[i, r.REACH], table[i, r.LEFT]
            cos, sin = table[i, r.COS], table[i, r.SIN]
            for j in range(L):
                driven = w[r.C * L + j] * cos[j] - w[r.D * L + j] * sin[j]
                v, s = w[r.V * L + j], w[r.S * L + j]
                change = b * (w[r.G * L + j] + driven) * s
                if works:
                    w[r.WORK * L + j] += b * driven * s * (v + 0.5 * change)
                if tangents:
                    bend = b * (w[r.G * L + j] + driven) * slope(w[r.X * L + j])
                    kept = left[j] if damped else 1.0
                    v1 = w[(first + 1) * L + j] + bend * w[first * L + j]
                    v2 = w[(second + 1) * L + j] + bend * w[second * L + j]
                    w[first * L + j] += v1 * reach[j]
                    w[second * L + j] += v2 * reach[j]
                    w[(first + 1) * L + j] = v1 * kept
                    w[(second + 1) * L + j] = v2 * kept
                v += change
                x = w[r.X * L + j] + v * reach[j]
                w[r.X * L + j] = x
                w[r.S * L + j] = restoring(x)
                if damped:
                    slowed = v * left[j]
                    if works:
                        w[r.LOSS * L + j] += 0.5 * (v - slowed) * (v + slowed)
                    v = slowed
                w[r.V * L + j] = v
        b = kicks[stages]
        cos, sin = table[stages, r.COS], table[stages, r.SIN]
        for j in range(L):
            driven = w[r.C * L + j] * cos[j] - w[r.D * L + j] * sin[j]
            w[r.D * L + j] = w[r.D * L + j] * cos[j] + w[r.C * L + j] * sin[j]
            w[r.C * L + j] = driven
            v, s = w[r.V * L + j], w[r.S * L + j]
            change = b * (w[r.G * L + j] + driven) * s
            if works:
                w[r.WORK * L + j] += b * driven * s * (v + 0.5 * change)
            w[r.V * L + j] = v + change
            if tangents:
                bend = b * (w[r.G * L + j] + driven) * slope(w[r.X * L + j])
                w[(first + 1) * L + j] += bend * w[first * L + j]
                w[(second + 1) * L + j] += bend * w[second * L + j]

    @part
    def judge_all(w: Any) -> float:
        """Find the lanes whose full step must not be taken, and return how many they are.

        That is at a halt, where the end lies beyond a wall, and beside a wall where the force
        changes sign or where the ball turns round and may have been beyond in between.
        """
        L = r.LANES
        count = 0.0
        for j in range(L):
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
            count += stays
        return count

    @part
    def put_back(w: Any) -> None:
        """Note the ends of steps that are not taken, and put these lanes back to their start."""
        L = r.LANES
        for j in range(L):
            per_h = w[r.PER_H * L + j]
            w[r.X1 * L + j], w[r.V1 * L + j] = w[r.X * L + j], w[r.V * L + j] * per_h
            a = (w[r.G * L + j] + w[r.C * L + j]) * w[r.S * L + j]
            w[r.A1 * L + j] = a * per_h * per_h
        for row in range(copied):
            for j in range(L):
                now, before = w[row * L + j], w[(row + r.COPY) * L + j]
                w[row * L + j] = now if w[r.TAKEN * L + j] > 0.0 else before

    @part
    def count_all(w: Any) -> None:
        """Count the steps that were taken."""
        for j in range(r.LANES):
            w[r.N * r.LANES + j] += w[r.TAKEN * r.LANES + j]

    @part
    def watch_all(w: Any, acc: Any) -> None:
        """Show the observables the step of every lane; one put back shows a step of no length."""
        L = r.LANES
        for j in range(L):
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
            segment = Segment(
                t0, t0 + w[r.TAKEN * L + j] * h, x0, x1, v0, v1, a0, a1,
                0.5 * v0 * v0 + stiffness * potential(x0),
                0.5 * v1 * v1 + stiffness * potential(x1),
                v0 * (a0 + stiffness * s0), v1 * (a1 + stiffness * s1), 0.0,
            )  # fmt: skip
            watch_step(acc, j, L, segment)

    @part
    def follow_all(w: Any, acc: Any, jacobian: Any) -> None:
        """Show the observables the matrix of every step that was taken."""
        L = r.LANES
        for j in range(L):
            if w[r.TAKEN * L + j] == 0.0:
                continue
            h = w[r.H * L + j]
            matrix = (
                w[first * L + j], w[second * L + j] * h,
                w[(first + 1) * L + j] * w[r.PER_H * L + j], w[(second + 1) * L + j],
            )  # fmt: skip
            write_matrix(jacobian, 0, matrix)
            watch_tangent(acc, j, L, 2, h, -w[r.RATE * L + j] * h, jacobian)

    return LaneFlight(advance_all, judge_all, put_back, count_all, watch_all, follow_all)
