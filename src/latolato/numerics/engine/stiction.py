"""Balls without motion: when a contact or friction lets go, and whether the rod is pushed then."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.core.scalar import cosine, formula
from latolato.numerics.contact_time import make_lowest
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.taut_step import TautStep
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import Run, State
from latolato.physics.pendulum import swung

# How much finer than the step the search for the end of rest looks at the drive.
_REST_FRACTION = 0.25


class Stiction(NamedTuple):
    """The functions of a ball without motion; see `make_stiction`."""

    release_time: Callable[..., float]
    note_compression: Callable[..., None]


@formula
def compression_share(left: float, right: float) -> float:
    """Share of a short interval in which a nearly linear tension is negative."""
    if left < 0.0 and right < 0.0:
        return 1.0
    if left >= 0.0 and right >= 0.0:
        return 0.0
    return min(left, right) / (min(left, right) - max(left, right))


@formula
def add_compression(
    state: State, ball: int, left: float, right: float, t: float, end: float
) -> None:
    """Add the compression in an interval in which the tension is nearly linear."""
    share = compression_share(left, right)
    state.compression_time[ball] += share * (end - t)
    if share > 0.0 and math.isnan(state.compression_start[ball]):
        state.compression_start[ball] = t if left < 0.0 else end - share * (end - t)


def make_stiction(swing: TautStep, laws: Laws, part: Part = as_it_stands) -> Stiction:
    """Make the functions of a ball that a wall or friction holds."""
    restoring, in_plane = laws.restoring, laws.plane is not None

    @part
    def hold(run: Run, t: float, ball: int, side: float, angle: float) -> float:
        """Guard of the release: acceleration that holds the ball [rad/s^2], negative once it moves.

        `side` is that of the wall, or 0 where only friction holds the ball.
        """
        free, friction = swing.free(run, ball, t, angle), run.bodies[ball].coulomb
        if side == 0.0:
            return friction - abs(free)
        pressed = friction + side * free
        if in_plane and run.settings.is_string != 0:  # friction holds no ball on a slack string
            pull: float = run.bodies[ball].inverse_length * swing.static_tension(
                run, ball, t, angle
            )
            return min(pressed, pull)
        return pressed

    find_lowest = make_lowest(hold, part)

    @part
    def release_time(
        run: Run, ball: int, side: float, angle: float, begin: float, goal: float
    ) -> float:
        """First instant in [begin, goal] at which the ball is released, or infinity [s].

        The hold is sampled four times a step; a dip between samples is followed to its bottom.
        """
        old = hold(run, begin, ball, side, angle)
        if old < 0.0:
            return begin
        gravity, bound = run.settings.gravity, run.settings.pivot_bound
        if not in_plane and side == -1.0 and bound <= gravity:
            return math.inf
        b = run.bodies[ball]
        restored = restoring(angle, run.settings.is_linear)
        strongest = abs(swung(gravity + bound, b.inverse_length, restored))
        if not in_plane and side == 0.0 and strongest <= b.coulomb:
            return math.inf
        dt = run.settings.step * _REST_FRACTION
        older, old_t = math.inf, begin
        for i in range(1, math.ceil((goal - begin) / dt) + 1):
            now_t = min(begin + i * dt, goal)
            now = hold(run, now_t, ball, side, angle)
            low, high = old_t, now_t
            if now >= 0.0:
                # The parabola through three samples tells how deep a dip between them can be.
                dips = i > 1 and older >= old <= now and older + now > 2.0 * old
                if dips:
                    bottom = old - 0.125 * (now - older) ** 2 / (older - 2.0 * old + now)
                    dips = bottom <= 0.02 * (now + older)
                if dips:
                    low = old_t - dt
                    high = find_lowest(run, low, now_t, ball, side, angle)
                    dips = hold(run, high, ball, side, angle) < 0.0
                if not dips:
                    older, old, old_t = old, now, now_t
                    continue
            for _ in range(200):  # bisection to neighbouring doubles
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if hold(run, middle, ball, side, angle) < 0.0:
                    high = middle
                else:
                    low = middle
            return high
        return math.inf

    @part
    def note_compression(run: Run, ball: int, angle: float) -> None:
        """Add the compression in a step without motion.

        On a wall and where friction holds the ball, the tension has the sign of
        `swing.static_tension`, ``(g + y0'') cos(angle)`` above a pivot that moves up and down; it
        is sampled four times a step.
        """
        if not in_plane and run.settings.pivot_bound < run.settings.gravity and cosine(angle) > 0.0:
            return
        dt = run.settings.step * _REST_FRACTION
        left = swing.static_tension(run, ball, run.t, angle)
        for i in range(math.ceil((run.t_end - run.t) / dt)):
            begin, end = run.t + i * dt, min(run.t + (i + 1) * dt, run.t_end)
            right = swing.static_tension(run, ball, end, angle)
            add_compression(run.state, ball, left, right, begin, end)
            left = right

    return Stiction(release_time, note_compression)
