"""A run as a frozen plan: all that determines its numbers, checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from latolato.core.parameters import Parameter
from latolato.core.registry import check_increasing, checked_array, in_unit
from latolato.core.rules import broken_rule
from latolato.numerics.integrate import Floats, Start, choose_step
from latolato.physics.contacts import ContactLaw
from latolato.physics.drives import Drive
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import System
from latolato.simulation.parameters import MOST_SAMPLES, RUN_PARAMETERS
from latolato.simulation.sensitivity import checked_names
from latolato.simulation.start import (
    DEFAULT_REST_SPEED,
    checked_contact,
    checked_drive,
    checked_start,
    checked_system,
    kicks_of,
    warn_of_degrees,
)

SAMPLES_PER_PERIOD = 100


@dataclass(frozen=True, kw_only=True, eq=False)
class RunPlan:
    """Everything that determines the numbers of a run.

    Attributes
    ----------
    law : ContactLaw
        What happens where balls touch.
    instants : ndarray, shape (time,)
        When the state is wanted [s].
    end : float
        End of the run [s].
    step : float
        Length of the first try's steps [s].
    kick_times, kick_sizes : ndarray, shapes (kick,) and (ball, kick), or None
        Of the noise [s], [rad/s].
    offset : float or None
        The angle above the low contact angle at which the run starts, if that was given [rad].
    sensitivity_to : tuple of Parameter
        With respect to what the run is differentiated.
    """

    system: System
    drive: Drive
    law: ContactLaw
    start: Start
    instants: Floats
    end: float
    step: float
    tolerance: float
    rest_speed: float
    frame: str
    contact_limit: int
    noise: VelocityKicks | None
    kick_times: Floats | None
    kick_sizes: Floats | None
    offset: float | None = None
    sensitivity_to: tuple[Parameter, ...] = ()


def make_run_plan(
    system: System,
    drive: Drive | None = None,
    *,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    initial_distance: float | Sequence[float] | None = None,
    duration: float | None = None,
    times: Sequence[float] | Floats | None = None,
    tolerance: float = 1e-10,
    contact: str | ContactLaw | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
    frame: str = "pivot",
    noise: VelocityKicks | None = None,
    contact_limit: int = 1_000_000,
    sensitivity_to: str | Sequence[str] = (),
) -> RunPlan:
    """Return the plan of a run; parameters and errors are those of `latolato.simulate`."""
    drive = checked_drive(drive, checked_system(system))
    law = checked_contact(contact, system)
    tolerance = RUN_PARAMETERS["tolerance"].checked(tolerance)
    rest_speed = RUN_PARAMETERS["rest_speed"].checked(rest_speed)
    contact_limit = RUN_PARAMETERS["contact_limit"].checked(contact_limit)
    frame = RUN_PARAMETERS["frame"].checked(frame)
    instants, end = _checked_times(system, drive, times, duration)
    start = checked_start(
        system,
        law,
        initial_angle,
        initial_angular_velocity,
        initial_offset,
        initial_distance,
    )
    warn_of_degrees("initial_angle", start.angles, stacklevel=3)
    kick_times, kick_sizes = kicks_of(noise, system, end)
    if law.fixed_step is not None and law.fixed_step > end:
        raise broken_rule("clamp_step", {"end": end}, parameter="clamp_step", value=law.fixed_step)
    step = choose_step(system, drive, start, tolerance, law, duration=end)
    offset = None
    if initial_offset is not None:  # checked with the start
        offset = float(in_unit("initial_offset", initial_offset, "rad"))
    plan = RunPlan(
        system=system,
        drive=drive,
        law=law,
        start=start,
        instants=instants,
        end=end,
        step=step,
        tolerance=tolerance,
        rest_speed=rest_speed,
        frame=frame,
        contact_limit=contact_limit,
        noise=noise,
        kick_times=kick_times,
        kick_sizes=kick_sizes,
        offset=offset,
    )
    if isinstance(sensitivity_to, (list, tuple)) and not sensitivity_to:
        return plan
    return replace(plan, sensitivity_to=checked_names(sensitivity_to, plan))


def _checked_times(
    system: System, drive: Drive, times: Any, duration: float | None
) -> tuple[Floats, float]:
    """Return the sample instants and the end of the run [s]."""
    if times is None:
        if duration is None:
            raise broken_rule("duration_needed", parameter="duration")
        end = RUN_PARAMETERS["duration"].checked(duration)
        fastest = max(system.natural_frequency, drive.fastest_frequency)
        periods = end * fastest / (2.0 * math.pi)
        if periods * SAMPLES_PER_PERIOD > MOST_SAMPLES:
            count = periods * SAMPLES_PER_PERIOD
            raise broken_rule("default_samples", {"count": count, "limit": MOST_SAMPLES})
        count = math.ceil(periods * SAMPLES_PER_PERIOD) + 1
        return np.linspace(0.0, end, max(count, 2)), end
    parameter = RUN_PARAMETERS["times"]
    times = in_unit("times", times, parameter.unit)
    is_one = isinstance(times, (int, float)) or getattr(times, "shape", None) == ()
    times = [times] if is_one else times
    numbers = checked_array("times", times, parameter.allowed, unit=parameter.unit)
    instants = np.array(numbers)
    if np.any(np.diff(instants) <= 0.0):
        check_increasing("times", numbers)
    if duration is None and instants[-1] <= 0.0:
        raise broken_rule("later_times", {"last": instants[-1]}, parameter="times")
    end = RUN_PARAMETERS["duration"].checked(instants[-1] if duration is None else duration)
    if instants[0] < 0.0 or instants[-1] > end:
        outside = instants[0] if instants[0] < 0.0 else instants[-1]
        raise broken_rule("times_of_run", {"end": end}, parameter="times", value=outside)
    return instants, end
