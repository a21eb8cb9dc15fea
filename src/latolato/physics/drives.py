"""Motions of the pivot: each a sequence of smooth stretches with scalar formulas.

A drive is a frozen class with its parameters as fields and three static formulas, `height`,
`velocity` and `acceleration` of ``(time, stretch)``. `stretches` lists where each smooth stretch
begins and the numbers (`stretch_fields`) that the formulas read from it; integrators end a step
at each such instant. Adding a drive is one class here with the `register` decorator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from latolato.quantities import (
    ANY,
    NON_NEGATIVE,
    POSITIVE,
    QUANTITIES,
    quantity_field,
)
from latolato.registry import Registry, check_fields, checked_number
from latolato.scalar import cosine, formula, sine

drives: Registry[type] = Registry("drive")

Stretch = tuple[float, tuple[float, ...]]


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What every drive offers; subclasses are final.

    Attributes
    ----------
    stretch_fields : tuple of str
        Names of the numbers that the formulas read from a stretch.
    """

    stretch_fields: ClassVar[tuple[str, ...]] = ("unused",)
    height: ClassVar[Any]
    velocity: ClassVar[Any]
    acceleration: ClassVar[Any]

    def __post_init__(self) -> None:
        check_fields(self)

    def stretches(self, duration: float) -> list[Stretch]:
        """Return (start time [s], numbers) of every smooth stretch that meets [0, duration]."""
        raise TypeError(f"{type(self).__name__} must say its stretches")

    def velocity_jumps(self, duration: float) -> list[float]:
        """Return the pivot's velocity jump that is transmitted at each start [m/s]."""
        return [0.0] * len(self.stretches(duration))

    @property
    def fastest_frequency(self) -> float:
        """Largest angular frequency in the motion [rad/s]; sets the step."""
        return 0.0

    @property
    def largest_acceleration(self) -> float:
        """Bound of |pivot_acceleration| [m/s^2]; sets the step."""
        return 0.0


@formula
def _nothing(t: float, p: Any) -> float:
    """Return 0."""
    return 0.0


@drives.register("static")
@dataclass(frozen=True, kw_only=True)
class Static(Drive):
    """A pivot at rest; what ``drive=None`` means."""

    height: ClassVar[Any] = staticmethod(_nothing)
    velocity: ClassVar[Any] = staticmethod(_nothing)
    acceleration: ClassVar[Any] = staticmethod(_nothing)

    def stretches(self, duration: float) -> list[Stretch]:
        """Return one stretch of rest."""
        return [(0.0, (0.0,))]


@formula
def _harmonic_height(t: float, p: Any) -> float:
    """Return A0 cos(w t + phase)."""
    return p.drive_amplitude * cosine(p.drive_frequency * t + p.drive_phase)


@formula
def _harmonic_velocity(t: float, p: Any) -> float:
    """Return -A0 w sin(w t + phase)."""
    w = p.drive_frequency
    return -p.drive_amplitude * w * sine(w * t + p.drive_phase)


@formula
def _harmonic_acceleration(t: float, p: Any) -> float:
    """Return -A0 w^2 cos(w t + phase)."""
    w = p.drive_frequency
    return -p.drive_amplitude * w * w * cosine(w * t + p.drive_phase)


@drives.register("harmonic")
@dataclass(frozen=True, kw_only=True)
class Harmonic(Drive):
    """``y0 = A0 cos(w t + phase)`` (Paper, before eq8)."""

    stretch_fields: ClassVar[tuple[str, ...]] = (
        "drive_amplitude",
        "drive_frequency",
        "drive_phase",
    )
    height: ClassVar[Any] = staticmethod(_harmonic_height)
    velocity: ClassVar[Any] = staticmethod(_harmonic_velocity)
    acceleration: ClassVar[Any] = staticmethod(_harmonic_acceleration)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the one stretch."""
        return [(0.0, (self.drive_amplitude, self.drive_frequency, self.drive_phase))]

    @property
    def fastest_frequency(self) -> float:
        """The drive's angular frequency [rad/s]."""
        return self.drive_frequency

    @property
    def largest_acceleration(self) -> float:
        """A0 w^2 [m/s^2]."""
        return self.drive_amplitude * self.drive_frequency**2


@formula
def _swept_height(t: float, p: Any) -> float:
    """Return A0 cos(phase + w s + rate s^2/2) with s the time since the stretch began."""
    s = t - p.start
    return p.drive_amplitude * cosine(p.phase + s * (p.frequency + 0.5 * p.rate * s))


@formula
def _swept_velocity(t: float, p: Any) -> float:
    """Return the time derivative of `_swept_height`."""
    s = t - p.start
    w = p.frequency + p.rate * s
    return -p.drive_amplitude * w * sine(p.phase + s * (p.frequency + 0.5 * p.rate * s))


@formula
def _swept_acceleration(t: float, p: Any) -> float:
    """Return the second time derivative of `_swept_height`."""
    s = t - p.start
    w = p.frequency + p.rate * s
    phase = p.phase + s * (p.frequency + 0.5 * p.rate * s)
    return -p.drive_amplitude * (w * w * cosine(phase) + p.rate * sine(phase))


@dataclass(frozen=True, kw_only=True)
class _Swept(Drive):
    """A cosine whose frequency is piecewise linear in time, phase-continuous."""

    stretch_fields: ClassVar[tuple[str, ...]] = (
        "drive_amplitude",
        "start",
        "phase",
        "frequency",
        "rate",
    )
    height: ClassVar[Any] = staticmethod(_swept_height)
    velocity: ClassVar[Any] = staticmethod(_swept_velocity)
    acceleration: ClassVar[Any] = staticmethod(_swept_acceleration)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))

    def _knots(self) -> list[tuple[float, float, float]]:
        """Return (start, frequency there, rate of change) of each stretch."""
        raise TypeError(f"{type(self).__name__} must say its knots")

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the stretches with the phase carried on from one to the next."""
        found: list[Stretch] = []
        knots = self._knots()
        phase = self.drive_phase
        for i, (start, frequency, rate) in enumerate(knots):
            if i:
                before, w, r = knots[i - 1]
                s = start - before
                phase += s * (w + 0.5 * r * s)
            if start <= duration:
                found.append((start, (self.drive_amplitude, start, phase, frequency, rate)))
        return found

    @property
    def fastest_frequency(self) -> float:
        """Largest angular frequency of any stretch [rad/s]."""
        return max(w for _, w, _ in self._knots())

    @property
    def largest_acceleration(self) -> float:
        """Bound A0 (w^2 + |rate|) [m/s^2]."""
        steepest = max(abs(r) for _, _, r in self._knots())
        return self.drive_amplitude * (self.fastest_frequency**2 + steepest)


def _checked_array(name: str, values: Any, allowed: Any, at_least: int) -> tuple[float, ...]:
    """Return a tuple of checked floats."""
    unit = QUANTITIES[name].unit
    if isinstance(values, (str, bytes)) or not hasattr(values, "__iter__"):
        raise TypeError(f"{name} must be a sequence of numbers in {unit}, got {values!r}")
    numbers = tuple(checked_number(name, v, allowed, unit) for v in values)
    if len(numbers) < at_least:
        raise ValueError(f"{name} must hold at least {at_least} values, got {len(numbers)}")
    return numbers


def _check_increasing(name: str, values: tuple[float, ...]) -> None:
    """Raise ValueError unless each value is larger than the one before."""
    for i, (a, b) in enumerate(zip(values, values[1:], strict=False)):
        if not b > a:
            raise ValueError(
                f"{name} must increase strictly, got {b:g} after {a:g} at position {i + 1}; "
                "sort them and remove repeats"
            )


@drives.register("frequency_schedule")
@dataclass(frozen=True, kw_only=True)
class FrequencySchedule(_Swept):
    """Stages of constant frequency, phase-continuous, with an optional ramp between them.

    Stage k begins at ``times[k]`` (the first at 0) with ``drive_frequencies[k]``; with ``ramp > 0``
    the frequency moves there linearly within `ramp` seconds from ``times[k]`` on.

    Notes
    -----
    With ``ramp = 0`` the pivot's height is continuous but its velocity jumps by
    ``-A0 (w_new - w_old) sin(phase)``. Each stage's smooth acceleration is used and the jump is
    not transmitted to the balls, unless ``step_impulse`` is true: then the balls get the velocity
    that a vanishing ramp would give them, ``-jump sin(angle)/length``, booked as drive work.
    """

    times: Sequence[float] = field(
        metadata={"quantity": QUANTITIES["times"], "array": True, "description": "stage starts"}
    )
    drive_frequencies: Sequence[float] = field(
        metadata={
            "quantity": QUANTITIES["drive_frequencies"],
            "array": True,
            "description": "angular frequency of each stage",
        }
    )
    ramp: float = quantity_field("ramp", NON_NEGATIVE, default=0.0, suggested=(0.0, 2.0))
    step_impulse: bool = field(
        default=False, metadata={"description": "transmit the pivot's velocity jump at a step"}
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        times = _checked_array("times", self.times, ANY, 1)
        rates = _checked_array("drive_frequencies", self.drive_frequencies, NON_NEGATIVE, 1)
        if len(times) != len(rates):
            raise ValueError(
                f"times and drive_frequencies must be of one length, got {len(times)} and "
                f"{len(rates)}"
            )
        if times[0] != 0.0:
            raise ValueError(f"times must begin with 0, got {times[0]:g}; the first stage is there")
        _check_increasing("times", times)
        gaps = [b - a for a, b in zip(times, times[1:], strict=False)]
        if gaps and self.ramp > min(gaps):
            raise ValueError(
                f"ramp must not exceed the shortest stage {min(gaps):g} s, got {self.ramp:g}"
            )
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "drive_frequencies", rates)

    def _knots(self) -> list[tuple[float, float, float]]:
        knots = [(0.0, self.drive_frequencies[0], 0.0)]
        for start, old, new in zip(
            self.times[1:], self.drive_frequencies, self.drive_frequencies[1:], strict=False
        ):
            if self.ramp > 0.0:
                knots.append((start, old, (new - old) / self.ramp))
                if knots[-1][0] + self.ramp not in self.times:
                    knots.append((start + self.ramp, new, 0.0))
            else:
                knots.append((start, new, 0.0))
        return knots

    def velocity_jumps(self, duration: float) -> list[float]:
        """Return the transmitted velocity jumps; all zero unless `step_impulse` and no ramp."""
        found = self.stretches(duration)
        if not self.step_impulse or self.ramp > 0.0:
            return [0.0] * len(found)
        jumps = [0.0]
        for (_, (_, _, _, old, _)), (_, (amplitude, _, phase, new, _)) in zip(
            found, found[1:], strict=False
        ):
            jumps.append(-amplitude * (new - old) * sine(phase))
        return jumps


@drives.register("chirp")
@dataclass(frozen=True, kw_only=True)
class Chirp(_Swept):
    """A frequency that moves linearly within `sweep_time` and stays at its end value then."""

    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    drive_frequency_final: float = quantity_field(
        "drive_frequency_final", NON_NEGATIVE, suggested=(0.1, 40.0)
    )
    sweep_time: float = quantity_field("sweep_time", POSITIVE, suggested=(1.0, 600.0))

    def _knots(self) -> list[tuple[float, float, float]]:
        w0, w1, span = self.drive_frequency, self.drive_frequency_final, self.sweep_time
        return [(0.0, w0, (w1 - w0) / span), (span, w1, 0.0)]


@formula
def _crank_height(t: float, p: Any) -> float:
    """Return A0 cos p + s (sqrt(L^2 - A0^2 sin^2 p) - L), p = w t + phase."""
    a, rod = p.drive_amplitude, p.connecting_rod_length
    phase = p.drive_frequency * t + p.drive_phase
    sine = a * sine(phase)
    # sqrt(L^2 - x^2) - L without cancellation
    return a * cosine(phase) - p.side * sine * sine / (rod + math.sqrt(rod * rod - sine * sine))


@formula
def _crank_velocity(t: float, p: Any) -> float:
    """Return the time derivative of `_crank_height`."""
    a, rod, w = p.drive_amplitude, p.connecting_rod_length, p.drive_frequency
    phase = w * t + p.drive_phase
    sine, cosine = sine(phase), cosine(phase)
    root = math.sqrt(rod * rod - a * a * sine * sine)
    return -a * w * sine * (1.0 + p.side * a * cosine / root)


@formula
def _crank_acceleration(t: float, p: Any) -> float:
    """Return -A0 w^2 [cos p + s lam (cos 2p + lam^2 sin^4 p)/(1 - lam^2 sin^2 p)^(3/2)]."""
    a, w = p.drive_amplitude, p.drive_frequency
    lam = a / p.connecting_rod_length
    phase = w * t + p.drive_phase
    square = sine(phase) ** 2
    inner = 1.0 - lam * lam * square
    bend = (1.0 - 2.0 * square + lam * lam * square * square) / (inner * math.sqrt(inner))
    return -a * w * w * (cosine(phase) + p.side * lam * bend)


@drives.register("crank_slider")
@dataclass(frozen=True, kw_only=True)
class CrankSlider(Drive):
    """The paper's motor: a crank of radius A0 moves a guided piston by a connecting rod.

    `guide` says whether the piston lies ``"below"`` (the paper's) or ``"above"`` the crank.
    """

    stretch_fields: ClassVar[tuple[str, ...]] = (
        "drive_amplitude",
        "drive_frequency",
        "drive_phase",
        "connecting_rod_length",
        "side",
    )
    height: ClassVar[Any] = staticmethod(_crank_height)
    velocity: ClassVar[Any] = staticmethod(_crank_velocity)
    acceleration: ClassVar[Any] = staticmethod(_crank_acceleration)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.1))
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    connecting_rod_length: float = quantity_field(
        "connecting_rod_length", POSITIVE, suggested=(0.05, 1.0)
    )
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))
    guide: str = field(
        default="below",
        metadata={"description": "side of the guide", "choices": ("below", "above")},
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.guide not in ("below", "above"):
            raise ValueError(f"guide must be 'below' or 'above', got {self.guide!r}")
        if not self.drive_amplitude < self.connecting_rod_length:
            raise ValueError(
                f"drive_amplitude must be less than connecting_rod_length "
                f"{self.connecting_rod_length:g}, got {self.drive_amplitude:g}: the crank would jam"
            )

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the one stretch."""
        side = -1.0 if self.guide == "below" else 1.0
        return [
            (
                0.0,
                (
                    self.drive_amplitude,
                    self.drive_frequency,
                    self.drive_phase,
                    self.connecting_rod_length,
                    side,
                ),
            )
        ]

    @property
    def fastest_frequency(self) -> float:
        """Angular frequency of the strongest overtone that matters [rad/s]."""
        lam = self.drive_amplitude / self.connecting_rod_length
        return self.drive_frequency / math.sqrt(1.0 - lam * lam) * (1.0 + lam)

    @property
    def largest_acceleration(self) -> float:
        """Bound of the acceleration [m/s^2], reached at a dead centre or at a right angle."""
        a, w = self.drive_amplitude, self.drive_frequency
        lam = a / self.connecting_rod_length
        return a * w * w * max(1.0 + lam, lam / math.sqrt(1.0 - lam * lam))


@formula
def _polynomial_height(t: float, p: Any) -> float:
    """Return the quintic of the stretch."""
    s = t - p.start
    return p.c0 + s * (p.c1 + s * (p.c2 + s * (p.c3 + s * (p.c4 + s * p.c5))))


@formula
def _polynomial_velocity(t: float, p: Any) -> float:
    """Return the quintic's first derivative."""
    s = t - p.start
    return p.c1 + s * (2.0 * p.c2 + s * (3.0 * p.c3 + s * (4.0 * p.c4 + s * 5.0 * p.c5)))


@formula
def _polynomial_acceleration(t: float, p: Any) -> float:
    """Return the quintic's second derivative."""
    s = t - p.start
    return 2.0 * p.c2 + s * (6.0 * p.c3 + s * (12.0 * p.c4 + s * 20.0 * p.c5))


@drives.register("measured_pivot")
@dataclass(frozen=True, kw_only=True)
class MeasuredPivot(Drive):
    """A pivot that follows measured heights: a quintic spline through, or close to, the samples.

    Parameters
    ----------
    times : sequence of float, shape (sample,)
        Strictly increasing instants [s]; the run must lie between the first and the last.
    pivot_heights : sequence of float, shape (sample,)
        Heights at these instants [m].
    height_sigma : float
        Standard deviation of the heights [m]; 0 interpolates, larger values smooth until the
        residual sum of squares is that of such noise (Dierckx's criterion, SciPy's
        ``UnivariateSpline``).
    """

    stretch_fields: ClassVar[tuple[str, ...]] = ("start", "c0", "c1", "c2", "c3", "c4", "c5")
    height: ClassVar[Any] = staticmethod(_polynomial_height)
    velocity: ClassVar[Any] = staticmethod(_polynomial_velocity)
    acceleration: ClassVar[Any] = staticmethod(_polynomial_acceleration)

    times: Sequence[float] = field(
        metadata={"quantity": QUANTITIES["times"], "array": True, "description": "sample instants"}
    )
    pivot_heights: Sequence[float] = field(
        metadata={
            "quantity": QUANTITIES["pivot_height"],
            "array": True,
            "description": "height of the pivot at each instant",
        }
    )
    height_sigma: float = quantity_field(
        "pivot_height", NON_NEGATIVE, description="standard deviation of the heights", default=0.0
    )
    _pieces: list[Stretch] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        times = _checked_array("times", self.times, ANY, 6)
        heights = _checked_array("pivot_height", self.pivot_heights, ANY, 6)
        if len(times) != len(heights):
            raise ValueError(
                f"times and pivot_heights must be of one length, got {len(times)} and "
                f"{len(heights)}"
            )
        _check_increasing("times", times)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "pivot_heights", heights)
        object.__setattr__(self, "_pieces", self._fit())

    def _fit(self) -> list[Stretch]:
        """Return the spline's pieces as stretches."""
        from scipy.interpolate import PPoly, UnivariateSpline, make_interp_spline

        if self.height_sigma > 0.0:
            weights = [1.0 / self.height_sigma] * len(self.times)
            smooth = UnivariateSpline(self.times, self.pivot_heights, w=weights, k=5)
            pieces = PPoly.from_spline(smooth._eval_args)
        else:
            pieces = PPoly.from_spline(make_interp_spline(self.times, self.pivot_heights, k=5))
        return [
            (float(a), (float(a), *(float(c) for c in pieces.c[::-1, i])))
            for i, (a, b) in enumerate(zip(pieces.x[:-1], pieces.x[1:], strict=True))
            if b > a
        ]

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the pieces between 0 and `duration`.

        Raises
        ------
        ValueError
            If the samples do not cover the run.
        """
        first, last = self.times[0], self.times[-1]
        if first > 0.0 or last < duration:
            raise ValueError(
                f"the pivot samples cover {first:g} to {last:g} s, but the run goes from 0 to "
                f"{duration:g} s; shorten the duration or shift the samples"
            )
        starts = [start for start, _ in self._pieces]
        begin = max(i for i, start in enumerate(starts) if start <= 0.0)
        return [(start, p) for start, p in self._pieces[begin:] if start <= duration]

    @property
    def fastest_frequency(self) -> float:
        """Angular frequency whose half period is one typical knot spacing, at most [rad/s]."""
        return math.sqrt(self.largest_acceleration / max(self._amplitude, 1e-300))

    @property
    def _amplitude(self) -> float:
        """Half the peak-to-peak height [m]."""
        return 0.5 * (max(self.pivot_heights) - min(self.pivot_heights))

    @property
    def largest_acceleration(self) -> float:
        """Largest acceleration at the knots [m/s^2]."""
        return max(abs(2.0 * p[3]) for _, p in self._pieces)
