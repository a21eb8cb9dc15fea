"""How far balls in the plane are from touching, and from the ends of their strings.

Two balls touch as discs. One ball stands for itself and its mirror image: it touches that where its
centre is one radius from the mirror.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.engine.slack_step import radial_rate
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import Point, Run

# A ball this close to another one, or to its string's end, is there; and what rounding can take
# from such a distance. Shares of the string's length.
THERE, ROUNDING = 1e-12, 1e-14


class Gaps(NamedTuple):
    """The functions of distances; see `make_gaps`."""

    gap: Callable[..., Any]
    line_of_centres: Callable[..., Any]
    spare_length: Callable[..., Any]
    is_tensile: Callable[..., bool]
    side: Callable[..., float]


def make_gaps(count: int, part: Part = as_it_stands) -> Gaps:
    """Make the functions for one ball and its mirror image, or for two balls."""
    two = count == 2

    @part
    def line_of_centres(points: list[Point]) -> tuple[float, float, float]:
        """Unit vector from the other ball to the first one, and their distance [m]."""
        if not two:
            return 1.0, 0.0, points[0].x
        x, y = points[0].x - points[1].x, points[0].y - points[1].y
        distance = math.hypot(x, y)
        return (x / distance, y / distance, distance) if distance > 0.0 else (1.0, 0.0, 0.0)

    @part
    def gap(run: Run, points: list[Point]) -> tuple[float, float]:
        """Gap between the balls [m] and its rate [m/s]; infinite if they never touch."""
        if run.settings.high == math.inf:
            return math.inf, 0.0
        x, y, distance = line_of_centres(points)
        if not two:
            return distance - run.settings.radius[0], points[0].vx
        vx, vy = points[0].vx - points[1].vx, points[0].vy - points[1].vy
        reach = run.settings.radius[0] + run.settings.radius[1]
        return distance - reach, x * vx + y * vy

    @part
    def spare_length(run: Run, i: int, point: Point) -> tuple[float, float]:
        """Length of a string beyond its ball's distance [m], and its rate [m/s]."""
        length = 1.0 / run.bodies[i].inverse_length
        return length - math.hypot(point.x, point.y), -radial_rate(point)

    @part
    def is_tensile(run: Run, points: list[Point]) -> bool:
        """Whether an impulse that parts the balls pulls at the strings of both."""
        x, y, _ = line_of_centres(points)
        pulls = x * points[0].x + y * points[0].y >= 0.0
        if two:
            pulls = pulls and x * points[1].x + y * points[1].y <= 0.0
        return pulls

    @part
    def side(points: list[Point]) -> float:
        """-1 for a contact at the bottom, 1 for one at the top of the circle."""
        separation = points[0].angle - points[1].angle if two else 2.0 * points[0].angle
        return 1.0 if separation > math.pi else -1.0

    return Gaps(
        gap=gap,
        line_of_centres=line_of_centres,
        spare_length=spare_length,
        is_tensile=is_tensile,
        side=side,
    )
