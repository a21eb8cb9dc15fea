"""A cosine whose amplitude and frequency both move smoothly from stage to stage."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from latolato.errors import InputError
from latolato.physics.drives.base import (
    Drive,
    Stretch,
    check_increasing,
    checked_array,
    drives,
)
from latolato.quantities import ANY, NON_NEGATIVE, POSITIVE, array_field, quantity_field
from latolato.scalar import cosine, formula, sine


@formula
def _staged_height(t: float, p: Any) -> float:
    """Return A(s) cos(phase + w s + rate s^2/2) with s the time since the stretch began."""
    s = t - p.start
    amplitude = p.c0 + s * (p.c1 + s * (p.c2 + s * p.c3))
    return amplitude * cosine(p.phase + s * (p.frequency + 0.5 * p.rate * s))


@formula
def _staged_velocity(t: float, p: Any) -> float:
    """Return the time derivative of `_staged_height`."""
    s = t - p.start
    amplitude = p.c0 + s * (p.c1 + s * (p.c2 + s * p.c3))
    growth = p.c1 + s * (2.0 * p.c2 + s * 3.0 * p.c3)
    w = p.frequency + p.rate * s
    phase = p.phase + s * (p.frequency + 0.5 * p.rate * s)
    return growth * cosine(phase) - amplitude * w * sine(phase)


@formula
def _staged_acceleration(t: float, p: Any) -> float:
    """Return the second time derivative of `_staged_height`."""
    s = t - p.start
    amplitude = p.c0 + s * (p.c1 + s * (p.c2 + s * p.c3))
    growth = p.c1 + s * (2.0 * p.c2 + s * 3.0 * p.c3)
    bend = 2.0 * p.c2 + s * 6.0 * p.c3
    w = p.frequency + p.rate * s
    phase = p.phase + s * (p.frequency + 0.5 * p.rate * s)
    across = 2.0 * growth * w + amplitude * p.rate
    return (bend - amplitude * w * w) * cosine(phase) - across * sine(phase)


class Stage(NamedTuple):
    """One smooth stretch: cubic amplitude, linear frequency; the fields that formulas read."""

    start: float  # s
    phase: float  # rad, there
    frequency: float  # rad/s, there
    rate: float  # rad/s^2
    c0: float  # m, amplitude there; then the cubic's further coefficients
    c1: float
    c2: float
    c3: float

    def at(self, time: float) -> Stage:
        """Return the same motion with another start [s]."""
        s = time - self.start
        return Stage(
            time,
            self.phase + s * (self.frequency + 0.5 * self.rate * s),
            self.frequency + self.rate * s,
            self.rate,
            self.c0 + s * (self.c1 + s * (self.c2 + s * self.c3)),
            self.c1 + s * (2.0 * self.c2 + s * 3.0 * self.c3),
            self.c2 + 3.0 * self.c3 * s,
            self.c3,
        )

    def acceleration_bound(self, span: float) -> float:
        """Return a bound of |pivot_acceleration| within `span` seconds from the start [m/s^2]."""
        if self.c1 == self.c2 == self.c3 == 0.0:
            fastest = max(abs(self.frequency), abs(self.frequency + self.rate * span))
            return abs(self.c0) * (fastest * fastest + abs(self.rate))
        end = self.at(self.start + span)
        fastest = max(abs(self.frequency), abs(end.frequency))
        # A cubic is below the largest of its Bezier points, and so are its derivatives.
        third = span / 3.0
        points = (self.c0, self.c0 + third * self.c1, end.c0 - third * end.c1, end.c0)
        middle = self.c1 + span * self.c2
        amplitude = max(map(abs, points))
        growth = max(abs(self.c1), abs(middle), abs(end.c1))
        bend = 2.0 * max(abs(self.c2), abs(end.c2))
        return bend + 2.0 * growth * fastest + amplitude * (fastest * fastest + abs(self.rate))


def moved(
    before: Stage, time: float, amplitude: float, frequency: float, ramp: float
) -> tuple[Stage, Stage]:
    """Return the stretch from `time` that leads to a new amplitude and frequency, and the next.

    Height and velocity of the pivot are continuous at both ends: the amplitude is the cubic that
    begins with the value and the slope that `before` has there and ends level, the frequency is
    linear, the phase is carried on.
    """
    now = before.at(time)
    rise = (amplitude - now.c0) / ramp
    way = Stage(
        time,
        now.phase,
        now.frequency,
        (frequency - now.frequency) / ramp,
        now.c0,
        now.c1,
        (3.0 * rise - 2.0 * now.c1) / ramp,
        (now.c1 - 2.0 * rise) / (ramp * ramp),
    )
    phase = now.phase + ramp * 0.5 * (now.frequency + frequency)
    return way, Stage(time + ramp, phase, frequency, 0.0, amplitude, 0.0, 0.0, 0.0)


@drives.register("stages")
@dataclass(frozen=True, kw_only=True)
class Stages(Drive):
    """Stages of constant amplitude and frequency, with a smooth change at the start of each.

    Stage k begins at ``times[k]`` (the first at 0, without a change); within ``ramps[k]`` seconds
    from there the amplitude moves along a cubic, the frequency along a line, from what they are to
    ``drive_amplitudes[k]`` and ``drive_frequencies[k]``. A stage that begins before the last
    change has ended goes on from where that is. `ramps` counts from the second stage on.

    Notes
    -----
    ``y0 = A(t) cos(phase(t))``: height and velocity of the pivot are continuous, so that no change
    is a blow.
    """

    stretch_fields: ClassVar[tuple[str, ...]] = Stage._fields
    height: ClassVar[Any] = staticmethod(_staged_height)
    velocity: ClassVar[Any] = staticmethod(_staged_velocity)
    acceleration: ClassVar[Any] = staticmethod(_staged_acceleration)

    times: Sequence[float] = array_field("times", "stage starts")
    drive_amplitudes: Sequence[float] = array_field(
        "drive_amplitudes", "driving amplitude of each stage"
    )
    drive_frequencies: Sequence[float] = array_field(
        "drive_frequencies", "angular frequency of each stage"
    )
    ramps: Sequence[float] = array_field("ramps", "time of the change into each stage")
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))
    _stages: tuple[Stage, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        columns = {
            "times": checked_array("times", self.times, ANY, 1),
            "drive_amplitudes": checked_array("drive_amplitudes", self.drive_amplitudes, ANY, 1),
            "drive_frequencies": checked_array(
                "drive_frequencies", self.drive_frequencies, NON_NEGATIVE, 1
            ),
            "ramps": checked_array("ramps", self.ramps, POSITIVE, 1),
        }
        if len({len(column) for column in columns.values()}) > 1:
            found = ", ".join(str(len(column)) for column in columns.values())
            raise InputError(f"{', '.join(columns)} must be of one length, got {found}")
        if columns["times"][0] != 0.0:
            raise InputError(
                f"times must begin with 0, got {columns['times'][0]:g}; the first stage is there"
            )
        check_increasing("times", columns["times"])
        for name, column in columns.items():
            object.__setattr__(self, name, column)
        object.__setattr__(self, "_stages", tuple(self._follow()))

    def _follow(self) -> list[Stage]:
        """Return the stretches, changes and what lies between them."""
        rows = zip(self.times, self.drive_amplitudes, self.drive_frequencies, self.ramps,
                   strict=True)  # fmt: skip
        _, amplitude, frequency, _ = next(rows)
        found = [Stage(0.0, self.drive_phase, frequency, 0.0, amplitude, 0.0, 0.0, 0.0)]
        for time, amplitude, frequency, ramp in rows:
            if found[-1].start >= time:  # the last change has not ended
                found.pop()
            found.extend(moved(found[-1], time, amplitude, frequency, ramp))
        return found

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the stretches that meet [0, duration]."""
        return [(stage.start, tuple(stage)) for stage in self._stages if stage.start <= duration]

    @property
    def fastest_frequency(self) -> float:
        """Largest angular frequency of any stage [rad/s]."""
        return max(self.drive_frequencies)

    @property
    def largest_acceleration(self) -> float:
        """Bound of |pivot_acceleration|, stretch by stretch [m/s^2]."""
        ends = [stage.start for stage in self._stages[1:]] + [math.inf]
        return max(
            stage.acceleration_bound(end - stage.start if math.isfinite(end) else 0.0)
            for stage, end in zip(self._stages, ends, strict=True)
        )
