"""What of a toy may be steered, how far, and from where it may go on."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES, Range
from latolato.core.registry import checked_number
from latolato.physics.drives import Drive
from latolato.physics.drives.stretch import COSINE, STILL, SWEPT
from latolato.physics.pendulum import System

# What may be set: up to so many lengths and natural frequencies.
MOST_AMPLITUDE, MOST_FREQUENCY, MOST_DAMPING_RATIO = 0.5, 40.0, 2.0


def cosine_of(drive: Drive, system: System) -> tuple[float, float, float]:
    """Return amplitude [m], angular frequency [rad/s] and phase [rad] that a drive begins with."""

    def first(name: str, several: str, otherwise: float) -> float:
        result: Sequence[float] = getattr(drive, several, (getattr(drive, name, otherwise),))
        return float(result[0])

    usual = drive.fastest_frequency if drive.moves else 2.0 * system.natural_frequency
    heights = getattr(drive, "pivot_heights", (0.0,))
    return (
        first("drive_amplitude", "drive_amplitudes", 0.5 * (max(heights) - min(heights))),
        first("drive_frequency", "drive_frequencies", usual),
        float(getattr(drive, "drive_phase", 0.0)),
    )


def is_by_cosine(drive: Drive) -> bool:
    """Return whether a drive rests or moves as a cosine, whose amplitude and frequency may vary."""
    forms = {getattr(stretch, "form", None) for stretch in drive.stretches(math.inf)}
    return forms <= {STILL, COSINE, SWEPT}


def limits_of(system: System) -> dict[str, tuple[float, float]]:
    """Return the least and the largest value of each control, in SI units."""
    ball = min(system.balls, key=lambda b: b.mass * b.length)
    longest = max(b.length for b in system.balls)
    rate = MOST_DAMPING_RATIO * system.natural_frequency
    return {
        "drive_amplitude": (0.0, MOST_AMPLITUDE * longest),
        "drive_frequency": (0.0, MOST_FREQUENCY * system.natural_frequency),
        "damping": (0.0, rate * ball.mass * ball.length),
        "restitution": (0.0, 1.0),
    }


def checked_state(was: Mapping[str, Any], angles: int) -> tuple[Any, ...]:
    """Return time, phase, angles, velocities, amplitude and frequency of an earlier toy."""
    if not isinstance(was, Mapping):
        raise InputError(f"state must be an object, got {was!r}")
    anything = Range(-1e9, 1e9)
    time = checked_number("time", was.get("time"), Range(0.0, 1e7), "s")
    phase = checked_number("phase", was.get("phase"), anything, "rad")
    lists = []
    for name in ("angles", "velocities"):
        values = was.get(name)
        if not isinstance(values, list) or len(values) < angles:
            raise InputError(f"must be a list of {angles} numbers", parameter=name, value=values)
        numbers = [checked_number(name, value, anything, "") for value in values[:angles]]
        lists.append(numbers if angles == 2 else numbers[0])
    drive = [
        checked_number(name, was.get(name), anything, QUANTITIES[name].unit)
        for name in ("drive_amplitude", "drive_frequency")
    ]
    # A change that was interrupted may have swung a little below zero.
    return time, phase, *lists, max(drive[0], 0.0), max(drive[1], 0.0)
