"""Rest: when a ball leaves a wall or friction lets go of it, and whether its rod is pushed then."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.engine.held import slack_share
from latolato.numerics.flight import Law, Part
from latolato.numerics.records import REST_HIGH, REST_LOW, STUCK
from latolato.scalar import cosine

# How much finer than the step the search for the end of rest looks at the drive.
_REST_FRACTION = 0.25


class Resting(NamedTuple):
    """The functions of a ball without motion; see `make_resting`."""

    find_release: Callable[..., Any]
    held_slack: Callable[..., Any]


def make_resting(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    compile_part: Part | None = None,
) -> Resting:
    """Return the functions of a ball that rests on a wall or is held by friction."""
    part: Part = compile_part or (lambda function: function)

    @part
    def hold(mode: int, t: float, pull: float, gravity: float, coulomb: float, p: Any) -> float:
        """Return how far [rad/s^2] the ball is from leaving rest; negative once it leaves."""
        free = -(gravity + acceleration(t, p)) * pull
        if mode == REST_LOW:
            return coulomb - free
        if mode == REST_HIGH:
            return coulomb + free
        return coulomb - abs(free)

    @part
    def find_release(
        mode: int, t: float, goal: float, angle: float, settings: Any, body: Any, p: Any
    ) -> float:
        """Return the first instant in [t, goal] at which rest ends, or infinity.

        The hold is sampled four times a step; a dip between samples is followed to its bottom.
        """
        gravity, coulomb = settings.gravity, body.coulomb
        pull = body.coupling * restoring(angle)
        if hold(mode, t, pull, gravity, coulomb, p) < 0.0:
            return t
        if mode == REST_LOW and settings.lift_bound <= gravity:
            return math.inf
        if mode == STUCK and (gravity + settings.lift_bound) * abs(pull) <= coulomb:
            return math.inf
        dt = settings.step * _REST_FRACTION
        count = math.ceil((goal - t) / dt)
        older, old, old_t = math.inf, hold(mode, t, pull, gravity, coulomb, p), t
        for i in range(1, count + 1):
            now_t = min(t + i * dt, goal)
            now = hold(mode, now_t, pull, gravity, coulomb, p)
            high = now_t
            if now >= 0.0:
                # The parabola through three samples tells how deep a dip between them can be.
                dips = i > 1 and older >= old <= now and older + now > 2.0 * old
                if dips:
                    bottom = old - 0.125 * (now - older) ** 2 / (older - 2.0 * old + now)
                    dips = bottom <= 0.02 * (now + older)
                if not dips:
                    older, old, old_t = old, now, now_t
                    continue
                a, b = old_t - dt, now_t  # golden section for the bottom of the dip
                for _ in range(80):
                    left, right = a + 0.382 * (b - a), a + 0.618 * (b - a)
                    if hold(mode, left, pull, gravity, coulomb, p) < hold(
                        mode, right, pull, gravity, coulomb, p
                    ):
                        b = right
                    else:
                        a = left
                high = 0.5 * (a + b)
                if hold(mode, high, pull, gravity, coulomb, p) >= 0.0:
                    older, old, old_t = old, now, now_t
                    continue
                low = old_t - dt
            else:
                low = old_t
            for _ in range(200):  # bisection to neighbouring doubles
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if hold(mode, middle, pull, gravity, coulomb, p) < 0.0:
                    high = middle
                else:
                    low = middle
            return high
        return math.inf

    @part
    def held_slack(
        first: float, total: float, t: float, until: float, angle: float, settings: Any, law: Law
    ) -> tuple[float, float]:
        """Return first instant and total time of slack after a stretch without motion.

        On a wall and where friction holds the ball, the tension has the sign of
        ``(g + y0'') cos(angle)``; it is sampled four times a step.
        """
        side = cosine(angle)
        if settings.lift_bound < settings.gravity and side > 0.0:
            return first, total
        dt = settings.step * _REST_FRACTION
        left = (settings.gravity + acceleration(t, law.p)) * side
        for i in range(math.ceil((until - t) / dt)):
            begin, end = t + i * dt, min(t + (i + 1) * dt, until)
            right = (settings.gravity + acceleration(end, law.p)) * side
            share = slack_share(left, right)
            total += share * (end - begin)
            if share > 0.0 and math.isnan(first):
                first = begin if left < 0.0 else end - share * (end - begin)
            left = right
        return first, total

    return Resting(find_release, held_slack)
