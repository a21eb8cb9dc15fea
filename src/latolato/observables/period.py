"""The response period: after how many drive periods the motion repeats, and what it does in one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from latolato.core.errors import InputError
from latolato.core.quantities import Quantity, Range, quantity_field
from latolato.core.scalar import floor, formula
from latolato.observables.base import Observable, Outcome, Step, observables
from latolato.observables.final import PoincareSection
from latolato.physics.contacts import BOTTOM, TOP

# What the values of `periodicity` mean.
PERIODICITY = ("rest", "periodic", "grazing", "aperiodic")
# Periods watched for each drive period of the longest response: it must recur twice and more.
REPEATS = 3
LONGEST = 64
# What is found, in the order of its slots behind the two parameters.
_VARIABLES: dict[str, Quantity] = {
    "response_period": Quantity("1", "p", "response period in drive periods"),
    "periodicity": Quantity("1", "", "periodicity (0 rest, 1 periodic, 2 grazing, 3 aperiodic)"),
    "recurrence_residual": Quantity("rad", r"\epsilon_p", "distance left after one period"),
    "windings": Quantity("1", "W", "swings per drive period"),
    "turns_per_period": Quantity("1", "R", "net turns per drive period"),
    "impacts_per_period": Quantity("1", "N_c", "impacts per drive period"),
    "mirror_residual": Quantity("rad", r"\epsilon_m", "distance from the mirror image"),
    "mirror_shift": Quantity("1", "k", "drive periods to the closest mirror image"),
    "slowest_impact": Quantity("rad/s", r"v_{min}", "closing speed of the slowest impact"),
    "fastest_speed": Quantity("rad/s", r"\dot\theta_{max}", "largest angular speed"),
    "largest_angle_watched": Quantity(
        "rad", r"\theta_{max,late}", "largest angle in the periods watched"
    ),
}
# Behind them come angles and angular velocities of all marks, then their times and the passages and
# impacts until then, then running numbers: both counts, the fastest speed, the slowest impact, the
# time held and the largest angle.
_LONGEST_PERIOD, _TOLERANCE, _FIRST = 0, 1, 2
_ANGLES = _FIRST + len(_VARIABLES)
_PER_MARK = 5
_PASSAGES, _IMPACTS, _FASTEST, _SLOWEST_IMPACT, _HELD, _LARGEST, _RUNNING = range(7)


def wrapped(angle: Any) -> Any:
    """Return angles moved into [-pi, pi) by whole turns [rad]."""
    return (angle + math.pi) % math.tau - math.pi


class Samples(NamedTuple):
    """Where stroboscopic samples lie in an array of numbers, once per drive period.

    Attributes
    ----------
    angle, velocity : int
        Places of the first sample of the first ball [rad], [rad/s].
    step : int
        From one sample to the next.
    ball : int
        From one ball to the next.
    marks, balls : int
        Samples, and balls.
    """

    angle: int
    velocity: int
    step: int
    ball: int
    marks: int
    balls: int


@formula
def _distance(
    numbers: Any, at: Samples, lag: int, frequency: float, image: bool, limit: float
) -> float:
    """Return the largest distance between samples that far apart, or from their mirror image.

    Once it exceeds the limit any larger number will do.
    """
    result: float = 0.0
    for ball in range(at.balls):
        other = at.balls - 1 - ball if image else ball
        sign = 1.0 if image else -1.0
        for late in range(lag, at.marks):
            here = late * at.step + ball * at.ball
            there = (late - lag) * at.step + other * at.ball
            turn = numbers[at.angle + here] + sign * numbers[at.angle + there]
            turn -= math.tau * floor(turn / math.tau + 0.5)
            speed = numbers[at.velocity + here] + sign * numbers[at.velocity + there]
            result = max(result, abs(turn), abs(speed) / frequency)
            if result > limit:
                return result
    return result


@formula
def find_period(
    numbers: Any, at: Samples, frequency: float, longest: int, angle_tolerance: float
) -> tuple[float, float]:
    """Return the shortest lag after which stroboscopic samples recur, and how far they are apart.

    Parameters
    ----------
    numbers : sequence of float
        All samples, none of them NaN.
    frequency : float
        Of the drive [rad/s].
    longest : int
        Largest lag to try.
    angle_tolerance : float
        Largest distance that counts as recurrence [rad].

    Returns
    -------
    period, residual : float
        The lag in drive periods (NaN if no lag recurs) and the largest distance
        ``max(|wrap(angle)|, |velocity|/frequency)`` between samples that far apart [rad], of the
        closest lag where none recurs.
    """
    residual = math.inf
    for lag in range(1, longest + 1):
        distance = _distance(numbers, at, lag, frequency, False, max(residual, angle_tolerance))
        residual = min(residual, distance)
        if distance <= angle_tolerance:
            return float(lag), residual
    return math.nan, residual


@formula
def find_mirror(numbers: Any, at: Samples, frequency: float, period: float) -> tuple[float, float]:
    """Return how far periodic samples are from their mirror image, and the shift of the closest.

    The mirror image of one ball is ``-angle``, of two balls ``(-angle of the other)``. A motion is
    symmetric if it equals its image, possibly some whole drive periods later. `period` is the
    result of `find_period`, other parameters are the same; NaN where the period is.
    """
    residual, shift = math.inf, math.nan
    for lag in range(at.marks):
        if lag < period:
            distance = _distance(numbers, at, lag, frequency, True, residual)
            shift = float(lag) if distance < residual else shift
            residual = min(residual, distance)
    return residual if residual < math.inf else math.nan, shift


@formula
def marks_of(acc: Any, i: int, n: int) -> int:
    """Return how many ends of drive periods a `Watched` observable marks."""
    return REPEATS * int(acc[i]) + 1


@formula
def _running(acc: Any, i: int, n: int) -> int:
    """Return the index of the first running number."""
    return i + (_ANGLES + _PER_MARK * marks_of(acc, i, n)) * n


@formula
def _start(acc: Any, i: int, n: int, angle: float) -> None:
    """Note that there are no samples yet."""
    for m in range(_ANGLES, _ANGLES + _PER_MARK * marks_of(acc, i, n)):
        acc[i + m * n] = math.nan
    acc[_running(acc, i, n) + _SLOWEST_IMPACT * n] = math.inf


@formula
def _step(acc: Any, i: int, n: int, s: Step) -> None:
    """Count passages through the hanging position, keep extremes and the time held."""
    j = _running(acc, i, n)
    acc[j] += abs(floor(s.x1 / math.tau) - floor(s.x0 / math.tau))
    acc[j + _FASTEST * n] = max(acc[j + _FASTEST * n], abs(s.v1))
    acc[j + _HELD * n] += s.held * (s.t1 - s.t0)
    turns = math.tau * floor(s.x0 / math.tau + 0.5)
    high = max(abs(s.x0 - turns), abs(s.x1 - turns), abs(s.turn - turns))
    acc[j + _LARGEST * n] = max(acc[j + _LARGEST * n], min(high, math.pi))


@formula
def _contact(
    acc: Any, i: int, n: int, t: float, kind: int, before: float, after: float, closing: float
) -> None:
    """Count an impact and keep the slowest."""
    if kind in (BOTTOM, TOP):
        j = _running(acc, i, n)
        acc[j + _IMPACTS * n] += 1.0
        acc[j + _SLOWEST_IMPACT * n] = min(acc[j + _SLOWEST_IMPACT * n], closing)


@formula
def _mark(acc: Any, i: int, n: int, number: int, t: float, angle: float, velocity: float) -> None:
    """Note state and counts; the extremes count from the first mark on."""
    j, marks = _running(acc, i, n), marks_of(acc, i, n)
    if number == 0:
        acc[j + _FASTEST * n] = abs(velocity)
        acc[j + _SLOWEST_IMPACT * n] = math.inf
        acc[j + _HELD * n] = 0.0
        acc[j + _LARGEST * n] = abs(angle - math.tau * math.floor(angle / math.tau + 0.5))
    first, apart = i + (_ANGLES + number) * n, marks * n
    acc[first] = angle
    acc[first + apart] = velocity
    acc[first + 2 * apart] = t
    acc[first + 3 * apart] = acc[j]
    acc[first + 4 * apart] = acc[j + _IMPACTS * n]


@formula
def _finish(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write period, class, counts per drive period and distances."""
    watched, j = marks_of(acc, i, n) - 1, _running(acc, i, n)
    first, apart = i + _ANGLES * n, (watched + 1) * n
    last = first + watched * n
    samples = Samples(first, first + apart, n, 1, watched + 1, 1)
    span, angles = acc[last + 2 * apart] - acc[first + 2 * apart], 0.0
    for m in range(watched + 1):
        angles += acc[first + m * n] - acc[first + m * n]
    for m in range(_FIRST, _ANGLES):
        acc[i + m * n] = math.nan
    if not (span > 0.0 and angles == 0.0):
        return
    frequency = math.tau * watched / span
    slow = acc[i + _TOLERANCE * n] * frequency
    fastest, slowest = acc[j + _FASTEST * n], acc[j + _SLOWEST_IMPACT * n]
    longest = int(acc[i + _LONGEST_PERIOD * n])
    period, residual = find_period(acc, samples, frequency, longest, acc[i + _TOLERANCE * n])
    rests = fastest <= slow
    period = 1.0 if rests else period
    recurs = period > 0.0
    grazes = slowest <= slow and acc[j + _HELD * n] <= 0.0
    lag = watched
    if recurs:
        lag -= watched % int(period)
    turns = (acc[last] - acc[last - lag * n]) / lag / math.tau
    passages = (acc[last + 3 * apart] - acc[last + 3 * apart - lag * n]) / lag
    impacts = (acc[last + 4 * apart] - acc[last + 4 * apart - lag * n]) / lag
    mirror, shift = find_mirror(acc, samples, frequency, period)
    k = i + _FIRST * n
    acc[k] = period
    acc[k + n] = 0.0 if rests else (2.0 if grazes else 1.0) if recurs else 3.0
    acc[k + 2 * n] = residual
    acc[k + 3 * n] = 0.0 if rests else 0.5 * passages
    acc[k + 4 * n] = floor(turns * lag + 0.5) / lag if recurs else turns  # whole ones in a period
    acc[k + 5 * n] = impacts
    acc[k + 6 * n] = mirror
    acc[k + 7 * n] = shift
    acc[k + 8 * n] = slowest if slowest < math.inf else math.nan
    acc[k + 9 * n] = fastest
    acc[k + 10 * n] = acc[j + _LARGEST * n]


@dataclass(frozen=True, kw_only=True)
class Watched(Observable):
    """Base of observables that watch ``3 longest`` drive periods before the end of a run."""

    longest: int = field(default=16, metadata={"description": "longest response period"})
    angle_tolerance: float = quantity_field(
        "initial_offset",
        Range(0.0, 1.0, open_low=True),
        default=1e-4,
        description="distance below which samples agree",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        count: object = self.longest
        if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= LONGEST:
            raise InputError(
                f"must be an integer in [1, {LONGEST}]", parameter="longest", value=count
            )

    @property
    def marks(self) -> int:
        """How many ends of drive periods are marked: both of each period watched."""
        return REPEATS * self.longest + 1


@dataclass(frozen=True, kw_only=True)
class _Period(Watched):
    """What both observables of periods share."""

    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    start: ClassVar[Any] = staticmethod(_start)
    step: ClassVar[Any] = staticmethod(_step)
    contact: ClassVar[Any] = staticmethod(_contact)
    mark: ClassVar[Any] = staticmethod(_mark)
    finish: ClassVar[Any] = staticmethod(_finish)

    @property
    def memory(self) -> int:
        """Variables, marks and what is running."""
        return _ANGLES - _FIRST + _PER_MARK * self.marks + _RUNNING


@observables.register("response_period")
@dataclass(frozen=True, kw_only=True)
class ResponsePeriod(_Period):
    """After how many drive periods the motion repeats, from the last drive periods of the run.

    ``3 longest`` drive periods before the end are watched. The motion has the period p if all
    samples that are p drive periods apart agree within `angle_tolerance` in the angle, modulo
    2 pi, and in the angular velocity over the drive frequency. `periodicity` tells rest (0: never
    faster than `angle_tolerance` times the drive frequency; its period is 1), periodic (1),
    grazing (2: periodic without rest, with an impact slower than that) and aperiodic (3: chaotic,
    quasiperiodic, longer than `longest`, or not settled yet). NaN where the run is too short.

    `windings` are swings per drive period: half the passages through the hanging
    position. `turns_per_period` are net turns per drive period; a rotating pendulum passes the
    hanging position once per turn. `impacts_per_period` counts impacts. All of them cover the
    largest whole number of response periods watched. `mirror_residual` is the distance of a
    periodic motion of one angle without walls from its mirror image, `mirror_shift` drive periods
    later. `largest_angle_watched` is the largest angle from hanging, modulo 2 pi: pi for rotation.
    """

    variables: ClassVar[Any] = _VARIABLES


@observables.register("response_samples")
@dataclass(frozen=True, kw_only=True)
class ResponseSamples(_Period):
    """The response period and what goes with it, with the samples that they come from.

    The results are those of `ResponsePeriod`, the samples those of `PoincareSection`: the ends of
    ``3 longest`` drive periods.
    """

    variables: ClassVar[Any] = {**_VARIABLES, **PoincareSection.variables}
    dimension: ClassVar[str] = "sample"
    plain: ClassVar[Any] = frozenset(_VARIABLES)
