"""By how much perturbations in the plane delay events, and the shifts to these and back.

An event whose guard ``q`` a perturbation ``z`` reaches ``dt = -(dq/dz z)/(dq/dt)`` later changes it
by the saltation ``z+ = D z- + (D f- - f+) dt`` (Aizerman & Gantmacher 1958). The functions here
shift z to the event by ``f- dt`` and back from it by ``f+ dt``; f are the velocities and
accelerations before and after. Several resets D may follow each other at one instant, all between
the same two shifts (`tangent_resets.py`). The guards are the gap between the balls, and the spare
length or the tension of a string.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics.engine.gaps import THERE, Gaps
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.perturbations import Perturbations
from latolato.numerics.engine.slack_step import SlackStep
from latolato.numerics.engine.taut_step import TautStep, acceleration_with_drag
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import DELAY_ROWS, Point, Run

# A string goes slack by itself where its tension is below this share of what speed and gravity
# make.
_CROSSES = 1e-7


class Shifts(NamedTuple):
    """The functions that shift all columns to an event and back; see `make_shifts`."""

    reach_contact: Callable[..., None]
    reach_full_length: Callable[..., None]
    leave_event: Callable[..., None]


def make_shifts(
    fall: SlackStep, gaps: Gaps, perturbations: Perturbations, count: int,
    begin: Callable[..., None], part: Part = as_it_stands,
) -> Shifts:  # fmt: skip
    """Make the functions of shifts; `begin` begins a tangent map at a contact that needs one."""
    acceleration, columns_of = fall.acceleration, perturbations.columns_of
    stretch_of, gap_perturbation = perturbations.stretch_of, perturbations.gap_perturbation

    @part
    def move(run: Run, sign: float) -> None:
        """Shift all perturbations to the event (sign 1), or back from it (-1), by their delays."""
        z = run.state.tangent_map
        for i in range(count):
            row, point, (ax, ay) = 4 * i, run.now[i], acceleration(run, i, run.now[i])
            for column in range(columns_of(run)):
                delay = sign * z[DELAY_ROWS + i, column]
                z[row, column] += point.vx * delay
                z[row + 1, column] += point.vy * delay
                z[row + 2, column] += ax * delay
                z[row + 3, column] += ay * delay

    @part
    def reach_contact(run: Run) -> None:
        """Find by how much each perturbation delays the balls' contact, and shift it there."""
        begin(run)
        _, rate = gaps.gap(run, run.now)
        if run.state.has_tangent_map == 0 or rate >= 0.0:
            return
        for column in range(columns_of(run)):
            delay = -gap_perturbation(run, column) / rate
            for i in range(count):
                run.state.tangent_map[DELAY_ROWS + i, column] = delay
        move(run, 1.0)

    @part
    def reach_full_length(run: Run) -> None:
        """Find the delays of strings that reach their full length, and shift there."""
        if run.state.has_tangent_map == 0:
            return
        z = run.state.tangent_map
        for i in range(count):
            row, point, b = 4 * i, run.now[i], run.bodies[i]
            spare_length, rate = gaps.spare_length(run, i, point)
            if (
                run.state.is_slack[i] != 0
                and spare_length * b.inverse_length <= THERE
                and rate < 0.0
            ):
                for column in range(columns_of(run)):
                    longer = point.x * z[row, column] + point.y * z[row + 1, column]
                    spare = stretch_of(run, i, column) - longer * b.inverse_length
                    z[DELAY_ROWS + i, column] = -spare / rate
        move(run, 1.0)

    @part
    def leave_event(run: Run) -> None:
        """Shift back from the event, with the velocities and accelerations after it."""
        if run.state.has_tangent_map == 0:
            return
        move(run, -1.0)
        for column in range(columns_of(run)):
            for i in range(count):
                run.state.tangent_map[DELAY_ROWS + i, column] = 0.0

    return Shifts(
        reach_contact=reach_contact,
        reach_full_length=reach_full_length,
        leave_event=leave_event,
    )


def make_slackens_by_itself(swing: TautStep, part: Part = as_it_stands) -> Callable[..., bool]:
    """Make the function ``(run, i, point)`` that tells why a string goes slack."""

    @part
    def slackens_by_itself(run: Run, i: int, point: Point) -> bool:
        """Whether a string that goes slack does so for lack of tension, and not with an impact."""
        b = run.bodies[i]
        largest = point.velocity * point.velocity + run.settings.gravity * b.inverse_length
        slackens: bool = abs(swing.tension(run, i, point)) <= _CROSSES * largest
        return slackens

    return slackens_by_itself


def make_slack_delays(
    swing: TautStep, perturbations: Perturbations, slackens_by_itself: Callable[..., bool],
    laws: Laws, count: int, part: Part = as_it_stands,
) -> tuple[Callable[..., None], Callable[..., None]]:  # fmt: skip
    """Make `find_delays` and `reach_slack`, which find by how much parameters delay an event.

    A parameter acts by its own column, and by what it did before the first string went slack: the
    columns of the unit perturbations, times its derivatives at that time.
    """
    size, sensitive = 2 * count, len(laws.changes) > 0
    taut_perturbation = perturbations.taut_perturbation

    @part
    def find_delays(run: Run, i: int) -> None:
        """Find by how much parameters delay the present event of a ball."""
        if not sensitive:
            return
        z, row = run.state.tangent_map, DELAY_ROWS + i
        for p in range(run.parameters):
            run.delay[p] = z[row, size + p] if run.doubt == 0 else math.nan
            for column in range(size):
                run.delay[p] += z[row, column] * run.sensitivity[column, p]

    @part
    def reach_slack(run: Run, i: int) -> None:
        """Find by how much parameters delay the instant at which a taut string goes slack.

        The guard is the tension. A string that would push at once goes slack with the event of this
        instant, such as an impact or the start, and is as late as that.
        """
        if not sensitive:
            return
        swing.settle(run, i, run.t, run.now[i])
        point = run.now[i]
        rates = point.velocity, acceleration_with_drag(point, run.bodies[i])
        if not slackens_by_itself(run, i, point):
            return
        for p in range(run.parameters):
            own = run.sensitivity[2 * i, p], run.sensitivity[2 * i + 1, p]
            if run.state.has_tangent_map != 0:
                angle, velocity = taut_perturbation(run, i, size + p, point)
                for column in range(size):
                    one, other = taut_perturbation(run, i, column, point)
                    angle += one * run.sensitivity[column, p]
                    velocity += other * run.sensitivity[column, p]
                own = angle, velocity
            later = swing.tension_change(run, i, point, p, own)
            rate = swing.tension_change(run, i, point, run.parameters, rates)
            run.delay[p] = -later / rate if rate != 0.0 and run.doubt == 0 else math.nan

    return find_delays, reach_slack
