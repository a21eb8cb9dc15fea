"""The response period: after how many drive periods the motion repeats, and what it does in one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from latolato.errors import InputError
from latolato.observables.base import Observable, Outcome, Segment, observables
from latolato.observables.final import Stroboscope
from latolato.physics.contacts import BOTTOM, TOP
from latolato.quantities import Quantity, Range, quantity_field
from latolato.scalar import floor, formula

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# What the values of `periodicity` mean.
PERIODICITY = ("rest", "periodic", "grazing", "aperiodic")
# Periods watched for each drive period of the longest response: it must recur twice and more.
_REPEATS = 3
_LONGEST = 64
# Slots behind the running counts of passages and impacts; then come those of each mark.
_FASTEST, _SLOWEST_IMPACT, _HELD, _LARGEST, _RUNNING = 2, 3, 4, 5, 6
_PER_MARK = 5  # time, angle, angular velocity, passages, impacts


def wrapped(angle: Any) -> Any:
    """Return angles moved into [-pi, pi) by whole turns [rad]."""
    return (angle + math.pi) % math.tau - math.pi


def find_period(
    angle: Floats, velocity: Floats, frequency: Floats, *, longest: int, angle_tolerance: float
) -> tuple[Floats, Floats]:
    """Return the shortest lag after which stroboscopic samples recur, and the distance left.

    Parameters
    ----------
    angle, velocity : ndarray, shape (point, ball, sample)
        Once per drive period [rad], [rad/s].
    frequency : ndarray, shape (point,)
        Of the drive [rad/s].
    longest : int
        Largest lag that is tried.
    angle_tolerance : float
        Largest distance that counts as recurrence [rad].

    Returns
    -------
    period, residual : ndarray, shape (point,)
        The lag in drive periods (NaN if none recurs) and the largest distance
        ``max(|wrap(angle)|, |velocity|/frequency)`` between samples that far apart [rad], of the
        closest lag where none recurs.
    """
    import numpy as np

    scaled = velocity / frequency[:, None, None]
    period = np.full(len(angle), math.nan)
    residual = np.full(len(angle), math.inf)
    for lag in range(1, longest + 1):
        turn = abs(wrapped(angle[..., lag:] - angle[..., :-lag])).max(axis=(1, 2))
        speed = abs(scaled[..., lag:] - scaled[..., :-lag]).max(axis=(1, 2))
        distance = np.maximum(turn, speed)
        better = np.isnan(period) & (distance < residual)
        residual = np.where(better, distance, residual)
        period = np.where(better & (distance <= angle_tolerance), float(lag), period)
    return period, np.where(np.isfinite(residual), residual, math.nan)


def find_mirror(
    angle: Floats, velocity: Floats, frequency: Floats, period: Floats
) -> tuple[Floats, Floats]:
    """Return how far periodic samples are from their mirror image, and the shift of the closest.

    The mirror image of one ball is ``-angle``, of two balls ``(-angle of the other)``. A motion is
    symmetric if it equals its image, maybe some whole drive periods later. Arrays as in
    `find_period`; NaN where the period is.
    """
    import numpy as np

    scaled = velocity / frequency[:, None, None]
    residual = np.full(len(angle), math.inf)
    shift = np.full(len(angle), math.nan)
    for lag in range(int(np.nanmax(period, initial=0.0))):
        late, early = slice(lag, None), slice(None, angle.shape[-1] - lag)
        turn = abs(wrapped(angle[..., late] + angle[:, ::-1, early])).max(axis=(1, 2))
        speed = abs(scaled[..., late] + scaled[:, ::-1, early]).max(axis=(1, 2))
        distance = np.maximum(turn, speed)
        better = (lag < period) & (distance < residual)
        residual, shift = np.where(better, distance, residual), np.where(better, lag, shift)
    return np.where(np.isfinite(residual), residual, math.nan), shift


@formula
def _step(acc: Any, i: int, n: int, s: Segment) -> None:
    """Count passages through the hanging position, keep extremes and the time held."""
    acc[i] += abs(floor(s.x1 / math.tau) - floor(s.x0 / math.tau))
    acc[i + 2 * n] = max(acc[i + 2 * n], abs(s.v1))
    acc[i + 4 * n] += s.held * (s.t1 - s.t0)
    turns = math.tau * floor(s.x0 / math.tau + 0.5)
    high = max(abs(s.x0 - turns), abs(s.x1 - turns), abs(s.turn - turns))
    acc[i + 5 * n] = max(acc[i + 5 * n], min(high, math.pi))


@formula
def _contact(
    acc: Any, i: int, n: int, t: float, kind: int, before: float, after: float, closing: float
) -> None:
    """Count an impact and keep the slowest."""
    if kind in (BOTTOM, TOP):
        acc[i + n] += 1.0
        acc[i + 3 * n] = min(acc[i + 3 * n], closing)


@formula
def _mark(acc: Any, i: int, n: int, number: int, t: float, angle: float, velocity: float) -> None:
    """Note state and counts; the extremes count from the first mark on."""
    if number == 0:
        acc[i + 2 * n] = abs(velocity)
        acc[i + 3 * n] = math.inf
        acc[i + 4 * n] = 0.0
        acc[i + 5 * n] = abs(angle - math.tau * math.floor(angle / math.tau + 0.5))
    first = i + (6 + 5 * number) * n
    acc[first] = t
    acc[first + n] = angle
    acc[first + 2 * n] = velocity
    acc[first + 3 * n] = acc[i]
    acc[first + 4 * n] = acc[i + n]


@observables.register("response_period")
@dataclass(frozen=True, kw_only=True)
class ResponsePeriod(Observable):
    """After how many drive periods the motion repeats, from the last drive periods of the run.

    ``3 longest`` drive periods before the end are watched. The motion has the period p if all
    samples that are p drive periods apart agree within `angle_tolerance` in the angle, modulo
    2 pi, and in the angular velocity over the drive frequency. `periodicity` tells rest (0: never
    faster than `angle_tolerance` times the drive frequency; its period is 1), periodic (1),
    grazing (2: periodic without rest, with an impact slower than that) and aperiodic (3: chaotic,
    quasiperiodic, longer than `longest`, or not settled yet). NaN where the run is too short.

    `windings` are half the passages through the hanging position per drive period: swings per
    drive period. `turns_per_period` are net turns per drive period; a rotating pendulum passes the
    hanging position once per turn. `impacts_per_period` counts impacts. All are over the largest
    whole number of response periods watched. `mirror_residual` is the distance of a periodic
    motion of one angle without walls from its mirror image, at any shift.
    `largest_angle_watched` is the largest angle from hanging, modulo 2 pi: pi for rotation.
    """

    variables: ClassVar[Any] = {
        "response_period": Quantity("1", "p", "response period in drive periods"),
        "periodicity": Quantity(
            "1", "", "periodicity (0 rest, 1 periodic, 2 grazing, 3 aperiodic)"
        ),
        "recurrence_residual": Quantity("rad", r"\epsilon_p", "distance left after one period"),
        "windings": Quantity("1", "W", "swings per drive period"),
        "turns_per_period": Quantity("1", "R", "net turns per drive period"),
        "impacts_per_period": Quantity("1", "N_c", "impacts per drive period"),
        "mirror_residual": Quantity("rad", r"\epsilon_m", "distance from the mirror image"),
        "slowest_impact": Quantity("rad/s", r"v_{min}", "closing speed of the slowest impact"),
        "fastest_speed": Quantity("rad/s", r"\dot\theta_{max}", "largest angular speed"),
        "largest_angle_watched": Quantity(
            "rad", r"\theta_{max,late}", "largest angle in the periods watched"
        ),
    }
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_step)
    contact: ClassVar[Any] = staticmethod(_contact)
    mark: ClassVar[Any] = staticmethod(_mark)

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
        if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= _LONGEST:
            raise InputError(f"longest must be an integer in [1, {_LONGEST}], got {count!r}")

    @property
    def marks(self) -> int:
        """How many ends of drive periods are marked: both of each period watched."""
        return _REPEATS * self.longest + 1

    def initial(self, angle: Any) -> list[Any]:
        """Return counts of zero and no marks."""
        return [0.0, 0.0, 0.0, math.inf, 0.0, 0.0, *[math.nan] * (_PER_MARK * self.marks)]

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return period, class, counts per drive period and distances."""
        import numpy as np

        t, angle, velocity, passages, impacts = (
            slots[_RUNNING + row :: _PER_MARK].T for row in range(_PER_MARK)
        )
        span = t[:, -1] - t[:, 0]
        frequency = math.tau * (self.marks - 1) / span
        known = np.isfinite(span) & np.isfinite(angle).all(axis=1)
        nothing = np.where(known, 0.0, math.nan)
        x, v = angle[:, None], velocity[:, None]
        period, residual = find_period(
            x, v, frequency, longest=self.longest, angle_tolerance=self.angle_tolerance
        )
        slow = self.angle_tolerance * frequency
        rests = slots[_FASTEST] <= slow
        period = np.where(rests, 1.0, period)
        grazes = (slots[_SLOWEST_IMPACT] <= slow) & (slots[_HELD] <= 0.0)
        periodicity = np.where(np.isfinite(period), np.where(grazes, 2.0, 1.0), 3.0)
        watched = self.marks - 1
        cycles = np.where(np.isfinite(period), period, 1.0)
        lag = (watched // cycles * cycles).astype(np.int64)
        rows = np.arange(len(lag))

        def rate(counts: Any) -> Any:
            return (counts[:, -1] - counts[rows, watched - lag]) / lag + nothing

        turns = rate(angle) / math.tau
        # Whole turns in a period, and no -0.0.
        turns = np.where(np.isfinite(period), np.round(turns * lag) / lag, turns) + 0.0
        slowest = np.where(np.isfinite(slots[_SLOWEST_IMPACT]), slots[_SLOWEST_IMPACT], math.nan)
        return {
            "response_period": period + nothing,
            "periodicity": np.where(rests, 0.0, periodicity) + nothing,
            "recurrence_residual": residual + nothing,
            "windings": np.where(rests, 0.0, 0.5) * rate(passages),
            "turns_per_period": np.where(np.isfinite(period), np.round(turns * lag) / lag, turns)
            + 0.0,
            "impacts_per_period": rate(impacts),
            "mirror_residual": find_mirror(x, v, frequency, period)[0] + nothing,
            "slowest_impact": slowest + nothing,
            "fastest_speed": slots[_FASTEST] + nothing,
            "largest_angle_watched": slots[_LARGEST] + nothing,
        }


@observables.register("response_samples")
@dataclass(frozen=True, kw_only=True)
class ResponseSamples(Observable):
    """What `ResponsePeriod` finds, with the samples it finds it from.

    The samples are those of `Stroboscope`: the ends of ``3 longest`` drive periods.
    """

    variables: ClassVar[Any] = {**ResponsePeriod.variables, **Stroboscope.variables}
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_step)
    contact: ClassVar[Any] = staticmethod(_contact)
    mark: ClassVar[Any] = staticmethod(_mark)
    dimension: ClassVar[str] = "sample"
    plain: ClassVar[Any] = frozenset(ResponsePeriod.variables)

    longest: int = field(default=16, metadata={"description": "longest response period"})
    angle_tolerance: float = quantity_field(
        "initial_offset",
        Range(0.0, 1.0, open_low=True),
        default=1e-4,
        description="distance below which samples agree",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        self._period  # noqa: B018 - checks the fields

    @property
    def _period(self) -> ResponsePeriod:
        """The observable that reads the samples."""
        return ResponsePeriod(longest=self.longest, angle_tolerance=self.angle_tolerance)

    @property
    def marks(self) -> int:
        """How many ends of drive periods are marked."""
        return self._period.marks

    def initial(self, angle: Any) -> list[Any]:
        """Return counts of zero and no marks."""
        return self._period.initial(angle)

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return what `ResponsePeriod` does, and the samples of shape (point, sample)."""
        return {
            **self._period.values(slots, outcome),
            "stroboscopic_angle": slots[_RUNNING + 1 :: _PER_MARK].T,
            "stroboscopic_angular_velocity": slots[_RUNNING + 2 :: _PER_MARK].T,
        }
