"""The tangent map of a motion through slack: how it changes perturbations of its start.

With all strings taut a perturbation has an angle and an angular velocity per ball. A slack string
gives its ball two more degrees of freedom. From the instant at which the first string goes slack
each unit perturbation of the taut state is therefore followed as one of position and velocity in
the plane (`perturbations.py`), through steps (`tangent_step.py`) and events (`tangent_delays.py`,
`tangent_resets.py`). Once all strings are taut again the columns are written as angles and angular
velocities; the matrix from the former to the latter is the tangent map of the whole interval, which
is reported to the observables.

At an event `reach_contact` or `reach_full_length` shifts all perturbations there, `tighten` or
`collide` multiplies by the derivative of the reset, and `leave_event` shifts back.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.core.scalar import cosine, sine
from latolato.numerics.callbacks import Accumulators
from latolato.numerics.engine.gaps import Gaps
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.perturbations import Perturbations, make_perturbations
from latolato.numerics.engine.report import Report
from latolato.numerics.engine.slack_step import SlackStep, place_taut
from latolato.numerics.engine.tangent_delays import (
    make_shifts,
    make_slack_delays,
    make_slackens_by_itself,
)
from latolato.numerics.engine.tangent_resets import make_collide, make_kick, make_tighten
from latolato.numerics.engine.tangent_step import make_tangent_step
from latolato.numerics.engine.taut_step import TautStep
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import DELAY_ROWS, Run


class TangentMap(NamedTuple):
    """The functions of the tangent map; see `make_tangent_map`. No-ops where nothing wants it."""

    begin: Callable[..., None]
    step: Callable[..., None]
    write_tangent: Callable[..., None]
    reach_contact: Callable[..., None]
    reach_full_length: Callable[..., None]
    reach_slack: Callable[..., None]
    find_delays: Callable[..., None]
    tighten: Callable[..., None]
    collide: Callable[..., None]
    leave_event: Callable[..., None]
    kick: Callable[..., None]
    mark_undefined: Callable[..., None]
    finish: Callable[..., None]


def make_begin(
    swing: TautStep, gaps: Gaps, report: Report, perturbations: Perturbations,
    slackens_by_itself: Callable[..., bool], laws: Laws, count: int, part: Part = as_it_stands,
) -> Callable[..., None]:  # fmt: skip
    """Make the function ``(run)`` that begins a tangent map when the first string goes slack.

    A column begins as a unit of angle or angular velocity. Where the string goes slack with an
    impact, the ball falls from the impact on, and not from the later one of the perturbed motion.
    """
    size, sensitive = 2 * count, len(laws.changes) > 0
    columns_of, write_taut = perturbations.columns_of, perturbations.write_taut
    gap_perturbation = perturbations.gap_perturbation

    @part
    def impact_delay(run: Run, column: int, rate: float) -> float:
        """By how much a perturbation delayed the impact that balls leave at this rate [m/s].

        Without a rebound it shows no more; the delays by parameters are known from the impact.
        """
        if run.settings.restitution > 0.0:
            return -gap_perturbation(run, column) / rate
        late = 0.0
        if sensitive and column >= size:
            late = run.delay[column - size]
        return late

    @part
    def begin(run: Run) -> None:
        """Begin with a unit perturbation of each angle and angular velocity, all strings taut.

        A string that an impact would make push goes slack at that impact. Its ball then falls from
        the impact on, which the perturbation delays, and not from this instant on.
        """
        state = run.state
        is_slack = state.is_slack[0] != 0 or state.is_slack[count - 1] != 0
        if is_slack or state.has_tangent_map != 0 or not report.wants_tangent_map(run):
            return
        state.has_tangent_map, state.tangent_map_start = 1, run.t
        for column in range(columns_of(run)):
            for i in range(count):
                angle = 1.0 if column == 2 * i else 0.0
                velocity = 1.0 if column == 2 * i + 1 else 0.0
                write_taut(run, i, column, run.now[i], angle, velocity)
                state.tangent_map[DELAY_ROWS + i, column] = 0.0
        for i in range(count):
            place_taut(run.now[i], 1.0 / run.bodies[i].inverse_length)
        _, rate = gaps.gap(run, run.now)
        if state.touch == 0.0 or (run.settings.restitution > 0.0 and rate <= 0.0):
            return
        # Between the impact of the perturbed motion and this one the string does not push: what it
        # would have pushed, ``l w^2 - ...`` < 0 per mass, is missing for the time of the delay.
        for i in range(count):
            point, length = run.now[i], 1.0 / run.bodies[i].inverse_length
            pushed = length * swing.tension(run, i, point)
            if pushed >= 0.0 or slackens_by_itself(run, i, point):
                continue
            for column in range(columns_of(run)):
                missing = pushed * impact_delay(run, column, rate)
                state.tangent_map[4 * i + 2, column] -= missing * sine(point.angle)
                state.tangent_map[4 * i + 3, column] += missing * cosine(point.angle)

    return begin


def make_tangent_map(
    swing: TautStep, fall: SlackStep, gaps: Gaps, report: Report, laws: Laws, count: int,
    part: Part = as_it_stands,
) -> TangentMap:  # fmt: skip
    """Make the functions of the tangent map of `count` balls."""
    size, perturbations = 2 * count, make_perturbations(gaps, laws, count, part)
    columns_of, write_map = perturbations.columns_of, perturbations.write_map
    slackens_by_itself = make_slackens_by_itself(swing, part)
    begin = make_begin(
        swing, gaps, report, perturbations, slackens_by_itself, laws, count, part
    )  # fmt: skip
    step_by = make_tangent_step(swing, perturbations, laws, count, part)
    shifts = make_shifts(fall, gaps, perturbations, count, begin, part)
    find_delays, reach_slack = make_slack_delays(
        swing, perturbations, slackens_by_itself, laws, count, part
    )

    @part
    def step(run: Run) -> None:
        """Follow the perturbations through the planned step."""
        step_by(run, run.length, run.end)

    @part
    def write_tangent(run: Run, length: float) -> None:
        """Write the tangent map from where slack began to a point in the step, ``run.inside``."""
        z, columns = run.state.tangent_map, columns_of(run)
        for column in range(columns):
            for row in range(len(z)):
                run.kept[row, column] = z[row, column]
        step_by(run, length, run.inside)
        write_map(run, run.inside)
        for column in range(columns):
            for row in range(len(z)):
                z[row, column] = run.kept[row, column]

    @part
    def mark_undefined(run: Run) -> None:
        """Mark the tangent map as undefined (NaN): perturbations do not stay small here."""
        for column in range(columns_of(run)):
            run.state.tangent_map[0, column] = math.nan

    @part
    def finish(run: Run, accumulators: Accumulators) -> None:
        """Report the tangent map, now that all strings are taut.

        The logarithm of its determinant does not follow from the laws of motion alone: NaN.
        """
        if run.state.has_tangent_map == 0:
            return
        run.state.has_tangent_map = 0
        for i in range(count):
            place_taut(run.now[i], 1.0 / run.bodies[i].inverse_length)
        write_map(run, run.now)
        report.matrix(run, accumulators, size, run.t - run.state.tangent_map_start, math.nan)

    return TangentMap(
        begin=begin,
        step=step,
        write_tangent=write_tangent,
        reach_contact=shifts.reach_contact,
        reach_full_length=shifts.reach_full_length,
        reach_slack=reach_slack,
        find_delays=find_delays,
        tighten=make_tighten(perturbations, laws, count, part),
        collide=make_collide(gaps, perturbations, laws, count, part),
        leave_event=shifts.leave_event,
        kick=make_kick(perturbations, part),
        mark_undefined=mark_undefined,
        finish=finish,
    )
