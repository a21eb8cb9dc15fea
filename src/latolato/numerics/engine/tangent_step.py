"""How a step changes perturbations in the plane: those of falling balls and of taut ones.

As for taut balls (`forces.py`) the splitting step itself is differentiated, so the result belongs
to the very step that was taken. In a fall it is ``v -= h (g + y0'' + c w)``, which perturbations
do not change, and the flow of the drag along the velocity, which is a function of the speed alone.
A taut ball's perturbation is read as one of angle and angular velocity, multiplied by the tangent
map of its swing, and written back.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.perturbations import Perturbations
from latolato.numerics.engine.taut_step import TautStep
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import ANY_LENGTH, DRIFT_TIME, KICK, OFFSET, Point, Run
from latolato.physics.damping import drift_changes_in_plane, drift_slopes_in_plane


def make_fall_forcing(
    swing: TautStep, count: int, part: Part = as_it_stands
) -> tuple[Callable[..., None], Callable[..., None]]:
    """Make the functions that add what parameters change in a kick and in a drift of a fall."""
    size = 2 * count

    @part
    def kick_forcing(run: Run, i: int, t: float, h: float, wx: float, wy: float) -> None:
        """Add what parameters change in a kick of a falling ball."""
        z, row, rate = run.state.tangent_map, 4 * i, run.bodies[i].damping_rate
        for p in range(run.parameters):
            change, column = run.changes[p], size + p
            dax, day, dwx, dwy = swing.pivot_change(run, t, p)
            rate_change = change.bodies[i].damping_rate
            z[row + 2, column] -= h * (dax + rate_change * wx + rate * dwx)
            z[row + 3, column] -= h * (change.gravity + day + rate_change * wy + rate * dwy)

    @part
    def drift_forcing(
        run: Run, i: int, speed: float, interval: float, ux: float, uy: float
    ) -> None:
        """Add what parameters change in a drift of a falling ball in the direction (ux, uy)."""
        z, row, b = run.state.tangent_map, 4 * i, run.bodies[i]
        for p in range(run.parameters):
            column = size + p
            far, fast = drift_changes_in_plane(speed, interval, b, run.changes[p].bodies[i])
            z[row, column] += far * ux
            z[row + 1, column] += far * uy
            z[row + 2, column] += fast * ux
            z[row + 3, column] += fast * uy

    return kick_forcing, drift_forcing


def make_follow_fall(
    swing: TautStep, perturbations: Perturbations, laws: Laws, count: int,
    part: Part = as_it_stands,
) -> Callable[..., None]:  # fmt: skip
    """Make the function ``(run, i)`` that follows perturbations of a ball through its fall."""
    columns_of, sensitive = perturbations.columns_of, len(laws.changes) > 0
    kick_forcing, drift_forcing = make_fall_forcing(swing, count, part)

    @part
    def follow_fall(run: Run, i: int) -> None:
        """Follow the perturbation of a falling ball through a step.

        Gravity and pivot pull alike everywhere in the plane, so a kick leaves a perturbation as it
        is. A drift multiplies the velocity by a factor that depends on the speed: along the
        velocity the perturbation sees the derivative of `drift`, beside it only the factor.
        """
        z, row, b, table = run.state.tangent_map, 4 * i, run.bodies[i], ANY_LENGTH + i
        vx, vy, gravity = run.now[i].vx, run.now[i].vy, run.settings.gravity
        ax, ay = run.now[i].across, run.now[i].pivot_acceleration
        wx, wy = run.now[i].wind_x, run.now[i].wind_y
        t, span = run.t, run.tables[table, OFFSET, run.stages - 1]
        for k in range(run.stages):
            h, drift_time = run.tables[table, KICK, k], run.tables[table, DRIFT_TIME, k]
            vx -= h * (ax + b.damping_rate * wx)
            vy -= h * (gravity + ay + b.damping_rate * wy)
            if sensitive:
                kick_forcing(run, i, t, h, wx, wy)
            speed = math.hypot(vx, vy)
            far, kept, far_beside, kept_beside = drift_slopes_in_plane(speed, drift_time, b)
            ux, uy = (vx / speed, vy / speed) if speed > 0.0 else (0.0, 0.0)
            for column in range(columns_of(run)):
                x, y = z[row + 2, column], z[row + 3, column]
                along = ux * x + uy * y
                farther, faster = (far - far_beside) * along, (kept - kept_beside) * along
                z[row, column] += far_beside * x + farther * ux
                z[row + 1, column] += far_beside * y + farther * uy
                z[row + 2, column] = kept_beside * x + faster * ux
                z[row + 3, column] = kept_beside * y + faster * uy
            if sensitive:
                drift_forcing(run, i, speed, run.drifts[k] * span, ux, uy)
            vx *= kept_beside
            vy *= kept_beside
            t = run.t + run.tables[table, OFFSET, k]
            swing.write_pivot_motion(run, t, run.inside[i])
            ax, ay = run.inside[i].across, run.inside[i].pivot_acceleration
            wx, wy = run.inside[i].wind_x, run.inside[i].wind_y
        if sensitive:
            kick_forcing(run, i, t, run.tables[table, KICK, run.stages], wx, wy)

    return follow_fall


def make_tangent_step(
    swing: TautStep, perturbations: Perturbations, laws: Laws, count: int,
    part: Part = as_it_stands,
) -> Callable[..., None]:  # fmt: skip
    """Make the function ``(run, length, points)`` for a part of the step of `count` balls."""
    size, sensitive = 2 * count, len(laws.changes) > 0
    columns_of, write_taut = perturbations.columns_of, perturbations.write_taut
    taut_perturbation = perturbations.taut_perturbation
    follow_fall = make_follow_fall(swing, perturbations, laws, count, part)

    @part
    def step_by(run: Run, length: float, points: list[Point]) -> None:
        """Follow the perturbations through a part of the step to `points`: fall or taut swing."""
        if run.state.has_tangent_map == 0:
            return
        for i in range(count):
            if run.state.is_slack[i] != 0:
                swing.prepare(run, i, ANY_LENGTH + i, length)
                follow_fall(run, i)
                continue
            swing.prepare_tangent(run, i, ANY_LENGTH + i, length, run.now[i])
            m11, m12, m21, m22 = swing.tangent(run, i, ANY_LENGTH + i, run.now[i])
            for column in range(columns_of(run)):
                angle, velocity = taut_perturbation(run, i, column, run.now[i])
                later, faster = m11 * angle + m12 * velocity, m21 * angle + m22 * velocity
                if sensitive and column >= size:
                    p = column - size
                    later += run.forcing[2 * i, p]
                    faster += run.forcing[2 * i + 1, p]
                    run.forcing[2 * i, p] = run.forcing[2 * i + 1, p] = 0.0
                write_taut(run, i, column, points[i], later, faster)

    return step_by
