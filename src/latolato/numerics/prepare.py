"""From the public parameters of a run to what the engine reads: walls, bodies, start, step.

The same formulas serve a single run, the points of a sweep and hosts other than Python; parameters
come as records of `records.CASE`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.core.scalar import cosine, formula, sine
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.records import (
    BODY,
    CASE,
    PROBLEM,
    SETTINGS,
    Body,
    Case,
    Floats,
    Integers,
    Problem,
    Records,
    Settings,
    ball_record,
    segment_dtype,
)
from latolato.numerics.run_record import STATE, UNSETTLED, State
from latolato.numerics.steppers import BLANES_MOAN_GENERAL, BLANES_MOAN_RKN, Stepper
from latolato.physics import problems
from latolato.physics.contacts import ContactLaw, half_width, meeting
from latolato.physics.drives.segment import fastest_frequency, largest_acceleration
from latolato.physics.pair import joint_inverse_length, runs_through
from latolato.physics.pendulum import Ball, System

# Step in units of 1/(fastest angular rate) at tolerance 1; the error goes as step^6. Measured in
# benchmarks/steps.py: of the regular, undamped 300 s runs over the paper's map 90 percent have an
# error below a third of `tolerance`, half of them below a thirtieth.
_STEP_AT_UNIT_TOLERANCE = 5.0
# How much the drag's own rate counts. Measured with m l = 1 kg m and C, C2 from 30 to 1e4: ledger
# and angle keep all tolerances from 1e-4 to 1e-12 at 0.2 to 0.35, whatever the drag; the rest is
# left to the repetition with half the step.
_DRAG_WEIGHT = 0.3
_ORDER, _SMOOTH, _ROUGH = (
    BLANES_MOAN_RKN.order,
    BLANES_MOAN_RKN.step_factor,
    BLANES_MOAN_GENERAL.step_factor,
)
# A start this close to a wall is on it.
ON_WALL = 1e-12  # rad
# Hours of computing; beyond it the input is taken for a mistake.
MOST_STEPS = 1e10


class Cases(NamedTuple):
    """Cases to prepare, and what becomes of them; the first dimension is the case unless noted.

    Attributes
    ----------
    cases : ndarray
        Records of `CASE`.
    segments : ndarray, shape (segment,)
        The drives' segments; those of case k begin at ``firsts[k]``. They are read only where a
        case leaves its drive's bounds open.
    firsts : ndarray, shape (case + 1,)
    settings, bodies, states : ndarray
        Records of shapes (case,), (case, body) and (case,), zero before.
    problems : ndarray
        Records of `PROBLEM`; a case with one from before is left out.
    """

    cases: Records
    segments: Records
    firsts: Integers
    settings: Records
    bodies: Records
    states: Records
    problems: Records


@functools.cache
def empty_cases() -> Cases:
    """Return no cases, in arrays of the kinds that cases have."""
    return Cases(
        np.zeros(0, dtype=CASE), np.zeros(0, dtype=segment_dtype()), np.zeros(0, dtype=np.int64),
        np.zeros(0, dtype=SETTINGS), np.zeros((0, 4), dtype=BODY), np.zeros(0, dtype=STATE),
        np.zeros(0, dtype=PROBLEM),
    )  # fmt: skip


@formula
def rate_of(
    gravity: float, length: float, acceleration: float, frequency: float, speed: float,
    linear: float, quadratic: float,
) -> float:  # fmt: skip
    """Return the fastest angular rate of a ball [rad/s].

    The largest of the drive's frequency, the swing's under the strongest pull
    ``sqrt((g + |y0''|)/l)``, the largest angular velocity that is known, and 0.3 times the rate of
    the drag: that is c1 [1/s] and the larger of c2 times that velocity and
    ``2 sqrt(c2 (g + |y0''|)/l)``, the rate at which quadratic drag settles under that pull.
    """
    stiffness = (gravity + acceleration) / length
    settling = linear + max(2.0 * math.sqrt(quadratic * stiffness), quadratic * speed)
    return max(math.sqrt(stiffness), frequency, speed, _DRAG_WEIGHT * settling)


@formula
def step_for(rate: float, tolerance: float, is_nonsmooth: bool) -> float:
    """Return the step [s] at which the fastest rates allow `tolerance`.

    ``5 step_factor tolerance^(1/order)`` over the rate.
    """
    factor = _ROUGH if is_nonsmooth else _SMOOTH
    return _STEP_AT_UNIT_TOLERANCE * factor * tolerance ** (1.0 / _ORDER) / rate


@formula
def has_nonsmooth_drag(balls: Sequence[Ball], count: int) -> bool:
    """Return whether the drag of any ball is not linear in its velocity."""
    for i in range(count):
        if balls[i].quadratic_damping > 0.0 or balls[i].coulomb_damping > 0.0:
            return True
    return False


@formula
def body_record(ball: Ball) -> tuple[float, float, float, float, float, float, float]:
    """Return one ball's numbers in the order of `BODY`."""
    l, m = ball.length, ball.mass
    return (
        1.0 / l,
        ball.damping / (m * l),
        ball.quadratic_damping / (m * l),
        ball.coulomb_damping / (m * l),
        m * l * l,
        ball.damping / (m * l * l),
        0.0,
    )


@formula
def _write_body(body: Body, numbers: Any) -> None:
    """Write the numbers of a body in the order of `BODY`."""
    body.inverse_length, body.damping_rate, body.quadratic, body.coulomb = numbers[:4]
    body.inertia, body.wind_drag, body.wind_offset = numbers[4:]


@formula
def _write_joint(body: Body, right: Body, left: Body, separation: float) -> float:
    """Write the body that two balls form in sticking contact; return its angle offset [rad]."""
    one, other = right.inertia, left.inertia
    total = one + other
    moments = one * right.inverse_length, other * left.inverse_length
    inverse_length, offset = joint_inverse_length(*moments, total, separation)
    sails = one * right.wind_drag, other * left.wind_drag
    wind_drag, wind_offset = joint_inverse_length(*sails, total, separation)
    _write_body(body, (
        inverse_length,
        (one * right.damping_rate + other * left.damping_rate) / total,
        (one * right.quadratic + other * left.quadratic) / total,
        (one * right.coulomb + other * left.coulomb) / total,
        total,
        wind_drag,
        wind_offset - offset,
    ))  # fmt: skip
    return offset


@formula
def _gap(angles: Floats, count: int) -> float:
    """Return the angle of one ball, or the separation of two [rad]."""
    return float(angles[0] - angles[1] if count == 2 else angles[0])


@formula
def move_between(angles: Floats, count: int, low: float, high: float) -> None:
    """Move the angle of one ball between the walls, or the separation of two by both [rad]."""
    gap = _gap(angles, count)
    inside = min(max(gap, low), high)
    if count == 1:
        angles[0] = inside
    else:
        angles[0] += 0.5 * (inside - gap)
        angles[1] -= 0.5 * (inside - gap)


@formula
def _report(problem: Problem, number: int, values: tuple[float, ...]) -> None:
    """Write the number of a problem and the values that its rule names."""
    problem.number = number
    for i in range(len(values)):
        problem.values[i] = values[i]


@formula
def _geometry(case: Case, problem: Problem) -> tuple[float, float]:
    """Return the two angles or separations of contact [rad]; report what is wrong with them."""
    right, left = case.balls[0], case.balls[1]
    for i in range(case.angles):
        ball = case.balls[i]
        if not 0.0 <= ball.radius < ball.length:
            number = problems.RADIUS if case.angles == 1 else problems.RIGHT_RADIUS + i
            _report(problem, number, (ball.radius, ball.length))
            return 0.0, math.pi
    if case.angles == 1:
        low = half_width(right.length, right.radius)
        return low, math.pi - low
    l1, l2, r1, r2 = right.length, left.length, right.radius, left.radius
    separation, width, number = meeting(l1, l2, r1, r2)
    if number != problems.FINE:
        _report(problem, number, (l1, l2, r1, r2, width, separation))
    return separation, math.tau - separation


@formula
def _place(case: Case, state: State) -> None:
    """Write the start as it is given, whatever may be wrong with it."""
    ball, touch = case.balls[0], 0.0
    for i in range(case.angles):
        state.angle[i] = case.initial_angle[i]
        state.velocity[i] = case.initial_angular_velocity[i]
    if not math.isnan(case.initial_offset):
        if 0.0 <= ball.radius < ball.length:
            touch = half_width(ball.length, ball.radius)
        state.angle[0] = touch + case.initial_offset


@formula
def _check_walls(case: Case, low: float, high: float, state: State, problem: Problem) -> None:
    """Move a start close to a wall onto it; report one beyond."""
    gap = _gap(state.angle, case.angles)
    if not low - ON_WALL <= gap <= high + ON_WALL:
        number, value, least, most = problems.ANGLE, gap, low, high
        if case.angles == 2:
            number = problems.SEPARATION
        if not math.isnan(case.initial_offset):
            number, value, least, most = problems.OFFSET, case.initial_offset, 0.0, high - low
        radians = value * (math.pi / 180.0)
        # Each of these problems is followed by that of a value in degrees.
        if value > math.pi and least <= radians <= most:
            number += 1
        _report(problem, number, (value, least, most, radians))
        return
    for wall in (low, high):
        if abs(gap - wall) <= ON_WALL:
            if case.angles == 1:
                state.angle[0] = wall
            else:  # both alike, so that mirror images remain so
                shift = 0.5 * (wall - gap)
                state.angle[0] += shift
                state.angle[1] -= shift
            return


@formula
def _check_apart(case: Case, state: State, problem: Problem) -> None:
    """Report balls that overlap each other or a taut string where a string is slack.

    One ball has its mirror image beside it. How a slack string hangs is not described, so it may
    lie anywhere.
    """
    two = case.angles == 2
    gap = _gap(state.angle, case.angles)
    if not 0.0 <= gap <= (math.tau if two else math.pi):
        _report(problem, problems.TURN if two else problems.HALF_TURN, (gap,))
        return
    i, gap = (1, gap) if two else (0, 2.0 * gap)
    d0, d1 = case.balls[0].length, case.balls[i].length
    if state.is_slack[0] != 0:
        d0 = case.initial_distance[0]
    if state.is_slack[i] != 0:
        d1 = case.initial_distance[i]
    r0, r1 = case.balls[0].radius, case.balls[i].radius
    along, beside, half = cosine(gap), sine(gap), sine(0.5 * gap)
    apart = math.sqrt((d0 - d1) ** 2 + 4.0 * d0 * d1 * half * half)
    if apart < (r0 + r1) * (1.0 - ON_WALL):
        _report(problem, problems.OVERLAP, (r0 + r1, apart))
    elif two and (
        (state.is_slack[0] == 0 and runs_through(d0, d1 * along, d1 * beside, r1))
        or (state.is_slack[1] == 0 and runs_through(d1, d0 * along, d0 * beside, r0))
    ):
        problem.number = problems.STRING_HITS


@formula
def _hang(state: State, i: int, distance: float, length: float) -> None:
    """Place a ball on a slack string at its distance [m] if that is less than the length [m]."""
    if distance < length:
        s, c, speed = sine(state.angle[i]), cosine(state.angle[i]), distance * state.velocity[i]
        state.place[i, 0], state.place[i, 1] = distance * s, -distance * c
        state.place[i, 2], state.place[i, 3] = speed * c, speed * s
        state.is_slack[i] = 1


@formula
def _is_mirrored(case: Case, state: State) -> bool:
    """Return whether two equal balls begin as mirror images of each other."""
    right, left, velocity = case.balls[0], case.balls[1], case.initial_angular_velocity
    return bool(
        state.angle[0] == -state.angle[1]
        and velocity[0] == -velocity[1]
        and right.length == left.length
        and right.mass == left.mass
        and right.radius == left.radius
        and right.damping == left.damping
        and right.quadratic_damping == left.quadratic_damping
        and right.coulomb_damping == left.coulomb_damping
    )


@formula
def _rate(case: Case, bodies: Records, bound: float, frequency: float) -> float:
    """Return the fastest angular rate that is known beforehand [rad/s]."""
    speed, rate = case.speed, case.law_rate
    for i in range(case.angles):
        speed = max(speed, abs(case.initial_angular_velocity[i]))
    for i in range(case.angles):
        b, length = bodies[i], case.balls[i].length
        own = rate_of(case.gravity, length, bound, frequency, speed, b.damping_rate, b.quadratic)
        rate = max(rate, own)
    return rate


@formula
def _check_start(case: Case, low: float, high: float, state: State, problem: Problem) -> None:
    """Move balls onto slack strings and nearby walls; report starts that are not allowed."""
    if case.clamps_start != 0:
        move_between(state.angle, case.angles, low, high)
    for i in range(case.angles):
        distance, length = case.initial_distance[i], case.balls[i].length
        _hang(state, i, distance, length)
        if distance > length:
            number = problems.DISTANCE if case.angles == 1 else problems.RIGHT_DISTANCE + i
            _report(problem, number, (distance, length))
            return
        if distance <= 0.0:
            problem.number = problems.OUT_OF_RANGE
            return
    if case.is_exact == 0:
        if state.is_slack[0] == 0 and state.is_slack[1] == 0:
            _check_walls(case, low, high, state, problem)
        elif case.collides != 0:
            _check_apart(case, state, problem)
    is_asked = case.angles == 2 and case.mirrored != 0
    if is_asked and problem.number == problems.FINE and not _is_mirrored(case, state):
        problem.number = problems.NOT_MIRRORED


@formula
def _is_computable(case: Case, bodies: Records, step: float) -> bool:
    """Return whether all numbers of a run are within the range of floats."""
    for i in range(case.angles):
        b = bodies[i]
        if not math.isfinite(
            b.inverse_length + b.damping_rate + b.quadratic + b.coulomb + b.inertia
        ):
            return False
    return step > 0.0 and math.isfinite(step)


@formula
def prepare(
    case: Case,
    segments: Records,
    settings: Settings,
    bodies: Records,
    state: State,
    problem: Problem,
) -> None:
    """Fill the settings, bodies and state of a case; report what is wrong with it."""
    _place(case, state)
    touch, high = _geometry(case, problem)
    if problem.number != problems.FINE:
        return
    for i in range(case.angles):
        _write_body(bodies[i], body_record(case.balls[i]))
    if case.angles == 2:
        first, last = (touch, high) if case.collides != 0 else (0.0, 0.0)
        settings.offset_low = _write_joint(bodies[2], bodies[0], bodies[1], first)
        settings.offset_high = _write_joint(bodies[3], bodies[0], bodies[1], last)
    bound, frequency = case.pivot_bound, case.drive_rate
    if math.isnan(bound):
        bound = largest_acceleration(segments, case.duration)
        frequency = fastest_frequency(segments, case.duration)
    rate = _rate(case, bodies, bound, frequency)
    step = case.step if case.step > 0.0 else step_for(rate, case.tolerance, case.is_nonsmooth != 0)
    settings.gravity, settings.restitution = case.gravity, case.restitution
    settings.low, settings.high = -math.inf, math.inf
    if case.collides != 0:
        settings.low, settings.high = touch, high
    settings.rest_speed, settings.step, settings.pivot_bound = case.rest_speed, step, bound
    settings.drive_rate = frequency
    settings.tension_dip = 0.5 * (step * rate) ** 2
    settings.follows_tension, settings.follows_ledger = case.follows_tension, case.follows_ledger
    settings.mirrored, settings.is_linear = case.mirrored, case.is_linear
    settings.law[0], settings.law[1] = case.law[0], case.law[1]
    settings.is_string, settings.in_lab = case.is_string, case.in_lab
    settings.string_restitution = case.string_restitution
    for i in range(case.angles):
        settings.radius[i] = case.balls[i].radius
    state.mode = UNSETTLED
    state.compression_start[0] = state.compression_start[1] = math.nan
    state.slack_start[0] = state.slack_start[1] = math.nan
    _check_start(case, settings.low, settings.high, state, problem)
    if problem.number == problems.FINE and not _is_computable(case, bodies, step):
        problem.number = problems.OUT_OF_RANGE
    if problem.number == problems.FINE and not case.duration <= MOST_STEPS * step:
        _report(problem, problems.TOO_LONG, (case.duration / step, step, MOST_STEPS))


def cases_of(
    system: System,
    law: ContactLaw,
    *,
    angles: Sequence[Any] = (0.0, 0.0),
    velocities: Sequence[Any] = (0.0, 0.0),
    bounds: tuple[float, float] = (math.nan, math.nan),
    count: int = 1,
    **numbers: Any,
) -> NDArray[Any]:
    """Return equal cases of a system, of shape (count,), with what is given of them.

    Parameters
    ----------
    angles, velocities : sequences of float or ndarray
        Of each ball at time zero [rad, rad/s].
    bounds : tuple of float
        Largest acceleration [m/s^2] and fastest frequency [rad/s] of the drive, if they are not to
        be found from its segments.
    numbers : float or ndarray
        Other fields of `CASE`.
    """
    cases = np.zeros(count, dtype=CASE)
    write_numbers(cases, system, angles, velocities)
    cases["initial_offset"], cases["initial_distance"] = math.nan, math.nan
    cases["is_string"], cases["in_lab"] = system.suspension == "string", system.drag_frame == "lab"
    cases["pivot_bound"], cases["drive_rate"] = bounds
    cases["law"], cases["law_rate"] = law.numbers, law.fastest_rate
    cases["step"] = law.fixed_step or 0.0
    cases["angles"], cases["collides"] = system.angles, system.has_contacts and law.meets
    cases["is_linear"] = system.is_linear
    cases["is_nonsmooth"] = choose_stepper(system) is BLANES_MOAN_GENERAL
    for name, value in numbers.items():
        cases[name] = value
    return cases


def write_numbers(
    cases: NDArray[Any], system: System, angles: Sequence[Any], velocities: Sequence[Any]
) -> None:
    """Write the numbers of a system and of a start into cases; see `cases_of`."""
    cases["gravity"], cases["restitution"] = system.gravity, getattr(system, "restitution", 1.0)
    cases["string_restitution"] = system.string_restitution
    for i, ball in enumerate(system.balls):
        cases["balls"][:, i] = ball_record(ball)
    for i in range(system.angles):
        cases["initial_angle"][:, i] = angles[i]
        cases["initial_angular_velocity"][:, i] = velocities[i]


def choose_stepper(system: System) -> Stepper:
    """Return the splitting whose order holds for the motion and the works of this system."""
    return (
        BLANES_MOAN_GENERAL if has_nonsmooth_drag(system.balls, system.angles) else BLANES_MOAN_RKN
    )


def write_stepper(runs: NDArray[Any], stepper: Stepper) -> None:
    """Write a stepper's weights into runs."""
    stages = len(stepper.drifts)
    runs["stages"] = stages
    runs["kicks"][..., : stages + 1] = stepper.kicks
    runs["drifts"][..., :stages], runs["nodes"][..., :stages] = stepper.drifts, stepper.nodes


def make_prepare(part: Part = as_it_stands) -> Callable[[Any], None]:
    """Return the function that prepares all `Cases`."""

    def prepare_all(work: Cases) -> None:
        for k in range(len(work.cases)):
            case, state, problem = work.cases[k], work.states[k], work.problems[k]
            if problem.number == problems.FINE:
                segments = work.segments[work.firsts[k] : work.firsts[k + 1]]
                prepare(case, segments, work.settings[k], work.bodies[k], state, problem)
            # In a continuation the next point begins where one that cannot run would.
            if problem.number != problems.FINE:
                _place(case, state)

    return part(prepare_all)
