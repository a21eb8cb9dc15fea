"""The project's own integrator as fits need it: angles at given instants, from any instant on."""

from __future__ import annotations

from typing import Any

import numpy as np

from latolato.experiment.fits.least_squares import Floats
from latolato.numerics.integrate import Directions, Start, integrate
from latolato.numerics.prepare import choose_stepper, rate_of, step_for
from latolato.numerics.steppers import BLANES_MOAN_GENERAL
from latolato.physics.contacts import ExactContact
from latolato.physics.drives import Drive, MeasuredPivot, Segment
from latolato.physics.pendulum import System

# Aimed-at error of fitted angles [rad]; a camera sees a thousandth at best.
_TOLERANCE = 1e-8
# Balls that part more slowly rest on each other [rad/s].
_REST_SPEED = 1e-5
# What happens where balls meet.
EXACT = ExactContact()


class LaterDrive:
    """A drive whose time zero is `origin` of another one's; what `integrate` asks of a drive.

    Formulas read time only against a segment's start, so shifting that is all.
    """

    def __init__(self, drive: Drive, origin: float, duration: float) -> None:
        self.height, self.velocity = drive.height, drive.velocity
        self.acceleration, self.rotation = drive.acceleration, drive.rotation
        self.across, self.across_velocity = drive.across, drive.across_velocity
        self.across_acceleration, self.moves_across = drive.across_acceleration, drive.moves_across
        # Properties of a measured pivot look at every sample: ask once.
        self.fastest_frequency = drive.fastest_frequency
        self.largest_acceleration = drive.largest_acceleration
        end = origin + duration
        if isinstance(drive, MeasuredPivot):  # whose last piece holds a moment longer
            end = min(end, drive.times[-1])
        segments = drive.segments(end)
        begin = max((i for i, s in enumerate(segments) if s.start <= origin), default=0)
        self._stretches = [s._replace(start=s.start - origin) for s in segments[begin:]]

    def segments(self, duration: float) -> list[Segment]:
        """Return the segments that meet [0, duration]."""
        return [segment for segment in self._stretches if segment.start <= duration]


def step_of(system: System, drive: Any, speed: float) -> float:
    """Return the step [s] of a fit, the same for all trials so that they differ smoothly."""
    shortest = min(ball.length for ball in system.balls)
    bounds = drive.largest_acceleration, drive.fastest_frequency
    rate = rate_of(system.gravity, shortest, *bounds, speed, 0.0, 0.0)
    return step_for(rate, _TOLERANCE, choose_stepper(system) is BLANES_MOAN_GENERAL)


def motion_at(
    system: System,
    drive: Any,
    start: Start,
    times: Floats,
    directions: Directions | None = None,
    *,
    step: float,
) -> tuple[Floats, Floats, Floats]:
    """Return angles and angular velocities at instants, and derivatives of the angles.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive or LaterDrive
        How the pivot moves.
    start : Start
        Angles and angular velocities at time 0 [rad, rad/s].
    times : ndarray, shape (time,)
        Increasing instants from 0 on [s].
    directions : Directions, optional
        Those in which derivatives are taken.
    step : float
        Step of the integrator [s].

    Returns
    -------
    angles, velocities : ndarray, shape (angle, time)
        Right ball first [rad, rad/s]; NaN where the motion fails.
    slopes : ndarray, shape (direction, angle, time)
        NaN where they do not exist.
    """
    run = integrate(
        system,
        drive,
        start,
        np.ascontiguousarray(times, dtype=np.float64),
        max(float(times[-1]), 1e-9),
        law=EXACT,
        step=step,
        rest_speed=_REST_SPEED,
        contact_limit=10_000,
        directions=directions,
    )
    size = 2 * system.angles
    count = 0 if directions is None else len(directions.changes)
    rows = run.samples[len(run.samples) - size * count :].reshape(count, size, len(times))
    return run.samples[0:size:2], run.samples[1:size:2], rows[:, 0::2]
