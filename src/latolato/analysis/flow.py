"""The motion over a given time, and how it changes perturbations."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import checked_repeating, hits_pull
from latolato.analysis.rules import broken_analysis, said
from latolato.core.errors import Sentence, name_gap
from latolato.core.parameters import Parameter
from latolato.core.quantities import POSITIVE
from latolato.core.registry import checked_number, suggest
from latolato.core.rules import broken_rule
from latolato.numerics.integrate import Start, Trajectory, integrate
from latolato.observables import LargestAngle, Observable
from latolato.observables.base import STATE_SIZE
from latolato.observables.perturbations import FundamentalMatrix
from latolato.physics.contacts import REST, SLACK
from latolato.physics.drives import Drive, PeriodicDrive, PlanarHarmonic
from latolato.physics.pendulum import System
from latolato.simulation.record import Record
from latolato.simulation.run import record
from latolato.simulation.start import (
    DEFAULT_REST_SPEED,
    check_perturbations,
    checked_contact,
    checked_system,
    walls_of,
)
from latolato.simulation.vary import DERIVED, parameters_of, replaced

Floats = NDArray[np.float64]
# Drives under which orbits are followed.
Repeating = PeriodicDrive | PlanarHarmonic

# Orbits of slower drives last thousands of steps and more.
SLOWEST_RATIO = 0.01
# A motion with more contacts is given up.
_MOST_CONTACTS = 100_000
# One list for all analyses, so that a kernel is compiled once.
_WATCHED: tuple[Observable, ...] = (FundamentalMatrix(), LargestAngle())


@dataclass(frozen=True)
class Passage:
    """Where a motion ends, and what happens on the way.

    Attributes
    ----------
    end : ndarray, shape (state,)
        Angle and angular velocity of the right, then of the left ball.
    matrix : ndarray, shape (state, state)
        Multiplies perturbations of the start.
    spread : float
        Logarithm of the determinant that the laws of motion give the matrix.
    largest_angle : float
        Largest |angle| of the right ball [rad].
    contact_times, contact_kinds, contact_values
        The contact table as in `latolato.numerics.integrate.Trajectory`.
    grazes : int
        Contacts that were nearly missed, or nearly happened.
    is_complete : bool
        False where the numbers or the contacts overflowed, or a string is slack at the end.
    slack_time : float
        When a string first goes slack [s]; infinite if none does, and for rods.
    """

    end: Floats
    matrix: Floats
    spread: float
    largest_angle: float
    contact_times: Floats
    contact_kinds: NDArray[np.int64]
    contact_values: Floats
    grazes: int
    is_complete: bool
    slack_time: float

    @property
    def impacts(self) -> int:
        """How many rows of the table are impacts."""
        return int(np.sum(self.contact_kinds < REST))


@dataclass(frozen=True)
class Flow:
    """The motion of a system under a drive, ready to be followed from many starts.

    Strings are followed as rods, which they are until the first rod would push, or through slack
    from taut strings to taut strings.

    Parameters
    ----------
    system, drive : System, Drive
        The drive is given, one that repeats itself.
    contact, tolerance, rest_speed
        As of `latolato.simulate`; without clamped contact.
    speed : float
        The largest angular velocity expected at a start [rad/s]; sets the step.
    compiled : bool
        Whether kernels are compiled or run as plain Python.
    through_slack : bool
        Whether strings may go slack.
    """

    system: System
    drive: Repeating
    contact: Any = "exact"
    tolerance: float = 1e-12
    rest_speed: float = DEFAULT_REST_SPEED
    speed: float = 0.0
    compiled: bool = True
    through_slack: bool = False

    def __post_init__(self) -> None:
        law = checked_contact(self.contact, self.system)
        if law.fixed_step is not None:
            raise broken_analysis("unclamped", parameter="contact")
        object.__setattr__(self, "contact", law)
        if self.through_slack:
            check_perturbations(self.system, "orbits")

    @property
    def is_string(self) -> bool:
        """Whether the balls hang on strings."""
        return self.system.suspension == "string"

    @property
    def size(self) -> int:
        """Count of the numbers of the state."""
        return 2 * self.system.angles

    @property
    def walls(self) -> tuple[float, float]:
        """Contact angles of one ball or contact separations of two [rad]."""
        return walls_of(self.system, self.contact)

    def follow(self, start: Floats, duration: float) -> Passage:
        """Return the motion from a start over `duration` seconds.

        Parameters
        ----------
        start : ndarray, shape (state,)
            Angle and angular velocity of the right, then of the left ball, at time zero.
        duration : float
            Time [s], positive.
        """
        numbers = np.asarray(start, dtype=np.float64)
        angles, velocities = numbers[0::2], numbers[1::2]
        system: Any = self.system
        if self.is_string and not self.through_slack:
            system = replace(system, suspension="rod", string_restitution=0.0)
        result = integrate(
            system,
            self.drive,
            Start(tuple(angles), tuple(velocities)),
            np.zeros(0),
            duration,
            tolerance=self.tolerance,
            speed=self.speed,
            rest_speed=self.rest_speed,
            contact_limit=_MOST_CONTACTS,
            law=self.contact,
            compiled=self.compiled,
            watched=_WATCHED,
        )
        return Passage(
            np.array([result.state.angle, result.state.velocity]).T.ravel()[: self.size],
            result.slots[: STATE_SIZE * STATE_SIZE, 0].reshape(STATE_SIZE, STATE_SIZE)[
                : self.size, : self.size
            ],
            float(result.slots[STATE_SIZE * STATE_SIZE, 0]),
            float(result.slots[-1, 0]),
            result.contact_times,
            result.contact_kinds,
            result.contact_values,
            int(result.state.grazes),
            result.status == "complete" and not result.state.is_slack.any(),
            self._slack_time(result) if self.is_string else math.inf,
        )

    def sampled(self, start: Floats, times: Floats) -> Record:
        """Return the record of the motion from a start, at some times [s]."""
        two = self.size == 4
        return record(
            self.system, self.drive, times=times, contact=self.contact, tolerance=self.tolerance,
            initial_angle=tuple(start[0::2]) if two else float(start[0]),
            initial_angular_velocity=tuple(start[1::2]) if two else float(start[1]),
        )  # fmt: skip

    def _slack_time(self, result: Trajectory) -> float:
        """Return when a string first goes slack, or a rod is first pushed [s], also by a hit."""
        if self.through_slack:
            slackened = result.contact_times[result.contact_kinds == SLACK]
            return float(np.min(slackened, initial=math.inf))
        times = result.state.compression_start[: self.system.angles]
        if not hits_pull(self.system):
            times = np.append(times, result.contact_times[result.contact_kinds < REST])
        return float(np.nanmin(times, initial=math.inf))


def checked_flow(
    system: System, drive: Drive | None, *, contact: Any, tolerance: float, rest_speed: float,
    through_slack: bool = False,
) -> Flow:  # fmt: skip
    """Return the motion under a drive that repeats itself, ready to be followed along orbits."""
    return Flow(
        system,
        periodic_drive(system, drive),
        contact=contact,
        tolerance=tolerance,
        rest_speed=rest_speed,
        speed=2.0 * system.natural_frequency,
        through_slack=through_slack and system.suspension == "string",
    )


def drive_period(drive: Repeating) -> float:
    """Return the period of a periodic drive [s].

    Raises
    ------
    InputError
        For a drive of frequency zero, which does not repeat itself.
    """
    return math.tau / checked_number("drive_frequency", drive.drive_frequency, POSITIVE, "rad/s")


def periodic_drive(system: System, drive: Drive | None) -> Repeating:
    """Return a checked drive that has a period, and one that can be followed in a short time."""
    result = checked_repeating(system, drive)
    ratio = math.tau / drive_period(result) / checked_system(system).natural_frequency
    if ratio < SLOWEST_RATIO:
        raise broken_analysis(
            "slowest_orbit", {"ratio": SLOWEST_RATIO}, parameter="drive_frequency", value=ratio
        )
    return result


def varied(system: System, drive: Drive, name: str, value: float) -> tuple[System, Drive]:
    """Return system and drive with one parameter changed, derived ones included.

    Raises
    ------
    InputError
        For an unknown parameter, with the closest known one, and a value out of range.
    """
    parameter = parameter_of(system, drive, name)
    checked_number(name, value, parameter.allowed, parameter.unit)
    target = value * (_unit_of(system, drive, name) if name in DERIVED else 1.0)
    if parameter.owner == "drive":
        return system, replaced(drive, {parameter.path: target})
    return replaced(system, {parameter.path: target}), drive


def value_of(system: System, drive: Drive, name: str) -> float:
    """Return the value of a parameter, derived ones included."""
    parameter = parameter_of(system, drive, name)
    owner: Any = system if parameter.owner == "system" else drive
    for part in parameter.path:
        owner = getattr(owner, part)
    return float(owner) / (_unit_of(system, drive, name) if name in DERIVED else 1.0)


def parameter_of(system: System, drive: Drive, name: Any) -> Parameter:
    """Return a parameter of the laws; the start is none here, as an orbit brings its own."""
    laws: tuple[Any, Any] = type(system), type(drive)
    known = _parameters_of_laws(*laws)
    if not isinstance(name, str) or name not in known:
        hint = suggest(str(name), list(known))
        raise broken_rule("unknown", {"kind": "parameter", "name": name, "hint": hint})
    return known[name]


def named_value(flow: Flow, name: str, value: float) -> Sentence:
    """Return the value of a parameter with its name and its unit."""
    unit = parameter_of(flow.system, flow.drive, name).quantity.unit
    tail = "" if unit == "1" else f" {unit}"
    return said("value_of", name=name_gap(name), value=value, unit=tail)


@cache
def _parameters_of_laws(system: Any, drive: Any) -> dict[str, Parameter]:
    """Return the parameters of two classes of laws; continuation needs them at every motion."""
    return {k: v for k, v in parameters_of(system, drive).items() if v.owner != "run"}


def _unit_of(system: System, drive: Any, name: str) -> float:
    """Return the factor from a derived parameter to the one that it sets."""
    if name == "frequency_ratio":
        return system.natural_frequency
    if name == "amplitude_ratio":
        return system.balls[0].length
    return float(system.gravity / drive.drive_frequency**2)
