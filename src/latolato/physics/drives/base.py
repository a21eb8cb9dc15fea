"""What every drive offers, and the registry of drives."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from types import SimpleNamespace
from typing import Any, ClassVar

from latolato.core.quantities import ANY, NON_NEGATIVE, quantity_field
from latolato.core.registry import Registry, check_fields, check_increasing, checked_array
from latolato.core.rules import broken_rule
from latolato.physics.drives.segment import (
    Segment,
    fastest_frequency,
    largest_acceleration,
    pivot_acceleration,
    pivot_across,
    pivot_across_acceleration,
    pivot_across_velocity,
    pivot_height,
    pivot_velocity,
    written,
)

drives: Registry[type] = Registry("drive")


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What every drive offers; subclasses are final.

    Attributes
    ----------
    moves : bool
        Whether the pivot moves at all.
    is_sinusoidal : bool
        Whether it rests or moves straight up and down as a sinusoid, whose amplitude and frequency
        may change: pages draw such a motion with a wheel, and the sliders of Live describe it.
    height, velocity, acceleration : formula
        Of ``(time, segment)`` [m, m/s, m/s^2]. Those of the package handle every form of `Segment`;
        a class with its own formulas has its own kernels.
    across, across_velocity, across_acceleration : formula
        The same for the horizontal position, positive to the right; called only if the drive
        `moves_across`.
    across_parameter : str or None
        Name of the parameter that moves the pivot sideways unless it is zero.
    rotation : formula or None
        If the acceleration is ``strength cos(frequency t + phase)``: returns these three numbers
        of a segment. Lanes then rotate the phase instead of computing cosines. Such a drive is one
        segment, and its `write` works for arrays too.
    write : formula or None
        ``number = write(out, numbers)`` writes the drive's segments, at most two for each of its
        `times` and two more, from its `numbers`.
    """

    moves: ClassVar[bool] = True
    is_sinusoidal: ClassVar[bool] = False
    across_parameter: ClassVar[str | None] = None
    height: ClassVar[Any] = staticmethod(pivot_height)
    velocity: ClassVar[Any] = staticmethod(pivot_velocity)
    acceleration: ClassVar[Any] = staticmethod(pivot_acceleration)
    across: ClassVar[Any] = staticmethod(pivot_across)
    across_velocity: ClassVar[Any] = staticmethod(pivot_across_velocity)
    across_acceleration: ClassVar[Any] = staticmethod(pivot_across_acceleration)
    rotation: ClassVar[Any] = None
    write: ClassVar[Any] = None

    def __init_subclass__(cls) -> None:
        if hasattr(cls, "velocity_jumps"):
            raise TypeError(f"{cls.__name__}.velocity_jumps is not read: a segment has its `jump`")

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def numbers(self) -> SimpleNamespace:
        """The parameters as `write` reads them, on pages too.

        A word is its place among the choices, a switch 0 or 1.
        """
        result = {}
        for f in fields(self):
            value = getattr(self, f.name)
            choices = f.metadata.get("choices")
            if choices:
                value = choices.index(value)
            result[f.name] = int(value) if isinstance(value, bool) else value
        return SimpleNamespace(**result)

    def segments(self, duration: float) -> list[Segment]:
        """Return every smooth segment that meets [0, duration].

        Formulas of one's own may read numbers of their own, from named tuples with a `start` [s]
        and, if its velocity jumps there and the balls are given that, a `jump` [m/s].
        """
        if self.write is None:
            raise TypeError(f"{type(self).__name__} must define segments(duration)")
        result = written(self.write, 2 * len(getattr(self, "times", ())) + 2, self.numbers)
        return [segment for segment in result if segment.start <= duration]

    def course(self) -> tuple[list[Segment], float]:
        """Return all segments and the time at which the last one ends [s].

        A segment that never ends must be steady.
        """
        if self.write is None:
            raise TypeError(
                f"{type(self).__name__} must define fastest_frequency and largest_acceleration"
            )
        return self.segments(math.inf), math.inf

    @property
    def is_cosine(self) -> bool:
        """Whether the pivot moves as one steady cosine, that is, has a `rotation`."""
        return self.rotation is not None

    @property
    def moves_across(self) -> bool:
        """Whether the pivot moves sideways too, which breaks the mirror symmetry of two balls."""
        value = getattr(self, self.across_parameter or "", None)
        return any(value) if isinstance(value, tuple) else bool(value)

    @cached_property
    def fastest_frequency(self) -> float:
        """Largest angular frequency in the motion [rad/s]; sets the step.

        A drive without `write` must define this and `largest_acceleration`.
        """
        return fastest_frequency(*self.course())

    @cached_property
    def largest_acceleration(self) -> float:
        """Bound of the pivot's acceleration [m/s^2], a vector's length; sets the step."""
        return largest_acceleration(*self.course())


@dataclass(frozen=True, kw_only=True)
class PeriodicDrive(Drive):
    """A drive that repeats itself: a function of ``drive_frequency t + drive_phase``.

    Its period in that phase is 2 pi, and the pivot is at rest for a `drive_amplitude` of zero;
    with a `rotation` it is the cosine of that amplitude. Analyses that look once per drive period,
    follow an orbit, or vary amplitude and frequency take every subclass.

    Attributes
    ----------
    amplitude_limit : tuple of str or None
        Name of the parameter below which `drive_amplitude` must stay, and what happens otherwise.
    """

    amplitude_limit: ClassVar[tuple[str, str] | None] = None

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.amplitude_limit and not self.drive_amplitude < self.largest_amplitude:
            name, otherwise = self.amplitude_limit
            raise broken_rule(
                "amplitude_limit",
                {"name": name, "end": self.largest_amplitude, "otherwise": otherwise},
                parameter="drive_amplitude",
                value=self.drive_amplitude,
            )

    @property
    def largest_amplitude(self) -> float:
        """Bound of `drive_amplitude` [m], infinite by default."""
        return getattr(self, self.amplitude_limit[0]) if self.amplitude_limit else math.inf


def checked_lists(drive: Drive) -> dict[str, tuple[float, ...]]:
    """Check every list of a drive, store it as a tuple and return them by name."""
    lists = {
        f.name: tuple(
            checked_array(
                f.name,
                getattr(drive, f.name),
                f.metadata["range"],
                unit=f.metadata["quantity"].unit,
            )
        )
        for f in fields(drive)
        if f.metadata.get("array")
    }
    for name, values in lists.items():
        object.__setattr__(drive, name, values)
    return lists


def check_stage_times(times: tuple[float, ...]) -> None:
    """Raise InputError unless the starts of a drive's stages begin with 0 and increase."""
    if times[0] != 0.0:
        raise broken_rule("first_stage", parameter="times", value=times[0])
    check_increasing("times", times)
