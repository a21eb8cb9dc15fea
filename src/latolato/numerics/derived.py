"""Evaluates energies, powers and tensions of a sampled motion with the formulas of `physics`."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from latolato.numerics.engine.laws import restoring_laws
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.records import BALL, Floats, Records, ball_record
from latolato.numerics.run_record import REST, STICKING
from latolato.physics import energy
from latolato.physics.damping import damping_power, drag_force, static_friction
from latolato.physics.energy import drive_power, kinetic_energy, potential_energy
from latolato.physics.pair import contact_torque, radial_push
from latolato.physics.pendulum import Ball, swung
from latolato.physics.tension import tension, wall_tension

PIVOT_ROWS = ("pivot_height", "pivot_velocity", "pivot_acceleration")
ACROSS_ROWS = ("pivot_across", "pivot_across_velocity", "pivot_across_acceleration")
BALL_ROWS = (
    "kinetic_energy",
    "potential_energy",
    "drive_power",
    "damping_power",
    "tension",
    "lab_energy",
    "rod_power",
)
KINETIC, POTENTIAL, DRIVE, DAMPING, TENSION, LAB, ROD = range(len(BALL_ROWS))

lab_energy, rod_power = energy.lab_energy, energy.rod_power


def ball_records(balls: tuple[Ball, ...]) -> Any:
    """Return the balls' parameters, shape (ball,)."""
    return np.array([ball_record(ball) for ball in balls], dtype=BALL)


class Observation(NamedTuple):
    """What is observed, and where the result goes.

    Attributes
    ----------
    times, modes : ndarray, shape (time,)
    samples : ndarray, shape (SAMPLE_ROWS, time)
    segments : ndarray, shape (segment,)
        See `records.segment_records`.
    balls : ndarray, shape (ball,)
        See `ball_records`.
    gravity : float
        [m/s^2]
    is_linear : int
        Whether the package's linear restoring law holds.
    in_lab : int
        Whether the air is at rest in the room.
    with_lab : int
        Whether the laboratory's rows are filled as well.
    pivot : ndarray, shape (3 or 6, time)
        Rows are `PIVOT_ROWS` and, in the plane, `ACROSS_ROWS`.
    out : ndarray, shape (ball, row, time)
        Rows are `BALL_ROWS`.
    """

    times: Floats
    modes: Floats
    samples: Floats
    segments: Records
    balls: Records
    gravity: float
    is_linear: int
    in_lab: int
    with_lab: int
    pivot: Floats
    out: Floats


@functools.cache
def empty_observation(segment: np.dtype[Any]) -> Observation:
    """Return an observation of nothing."""
    floats, table = np.zeros(0), np.zeros((1, 0))
    segments, balls = np.zeros(0, dtype=segment), np.zeros(0, dtype=BALL)
    out = np.zeros((1, 1, 0))
    return Observation(floats, floats, table, segments, balls, 0.0, 0, 0, 0, table, out)


def make_observer(
    height: Callable[..., float],
    velocity: Callable[..., float],
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    potential: Callable[..., float],
    part: Part = as_it_stands,
) -> Callable[..., None]:
    """Return the function that fills `pivot` and `out` of an `Observation`."""
    laws = restoring_laws(restoring, potential, part)
    restored_at, potential_at = laws.restoring, laws.potential

    @part
    def resistance(o: Observation, speed: float, angle: float, ay: float, b: Ball) -> float:
        """Return the drag on a ball, or what friction opposes to the force on one at rest [N]."""
        if speed == 0.0:
            force = -b.mass * (o.gravity + ay) * restored_at(angle, o.is_linear)
            return static_friction(force, b.coulomb_damping)
        sign = 1.0 if speed > 0.0 else -1.0
        return drag_force(speed, sign, b.damping, b.quadratic_damping, b.coulomb_damping)

    @part
    def joint_friction(o: Observation, samples: Floats, i: int, ay: float) -> float:
        """Return the share of its strength with which friction holds two balls in contact."""
        torque = limit = 0.0
        for j in range(2):
            b = o.balls[j]
            restored = restored_at(samples[2 * j, i], o.is_linear)
            torque -= b.mass * b.length * (o.gravity + ay) * restored
            limit += b.length * b.coulomb_damping
        return static_friction(torque, limit) / limit if limit > 0.0 else 0.0

    @part
    def free(o: Observation, angle: float, force: float, ay: float, b: Ball) -> float:
        """Return the angular acceleration that a ball would have without the other one."""
        restored = restored_at(angle, o.is_linear)
        return swung(o.gravity + ay, 1.0 / b.length, restored) - force / (b.mass * b.length)

    def observe(o: Observation) -> None:
        times, samples, modes, balls = o.times, o.samples, o.modes, o.balls
        segments, gravity, pivot, out = o.segments, o.gravity, o.pivot, o.out
        k = 0
        for i in range(len(times)):
            t = times[i]
            while k + 1 < len(segments) and segments[k + 1].start <= t:
                k += 1
            p = segments[k]
            y, vy, ay = height(t, p), velocity(t, p), acceleration(t, p)
            pivot[0, i], pivot[1, i], pivot[2, i] = y, vy, ay
            touching = modes[i] == REST or modes[i] == STICKING
            for j in range(len(balls)):
                b = balls[j]
                l, m = b.length, b.mass
                angle, speed = samples[2 * j, i], samples[2 * j + 1, i]
                restored = restored_at(angle, o.is_linear)
                out[j, KINETIC, i] = kinetic_energy(speed, m, l)
                out[j, POTENTIAL, i] = potential_energy(
                    potential_at(angle, o.is_linear), m, l, gravity
                )
                out[j, DRIVE, i] = drive_power(speed, restored, ay, m, l)
                out[j, DAMPING, i] = damping_power(
                    speed, l, b.damping, b.quadratic_damping, b.coulomb_damping
                )
                out[j, TENSION, i] = tension(angle, speed, ay, m, l, gravity)
                if touching and len(balls) == 1:
                    out[j, TENSION, i] = wall_tension(angle, ay, m, gravity)
            share = 0.0
            if touching and len(balls) == 2:
                # Which ball's friction holds how much is left open; here each gives its share.
                share = joint_friction(o, samples, i, ay) if samples[1, i] == 0.0 else 0.0
                b1, b2 = balls[0], balls[1]
                one, two = samples[1, i], samples[3, i]
                force_1, force_2 = share * b1.coulomb_damping, share * b2.coulomb_damping
                if one != 0.0:
                    force_1 = resistance(o, one, samples[0, i], ay, b1)
                    force_2 = resistance(o, two, samples[2, i], ay, b2)
                torque = contact_torque(
                    free(o, samples[0, i], force_1, ay, b1),
                    free(o, samples[2, i], force_2, ay, b2),
                    b1.mass * b1.length**2, b2.mass * b2.length**2,
                )  # fmt: skip
                gap = samples[0, i] - samples[2, i]
                out[0, TENSION, i] += radial_push(torque, b1.length, b2.length, gap)
                out[1, TENSION, i] += radial_push(torque, b2.length, b1.length, gap)
            for j in range(len(balls) if o.with_lab != 0 else 0):
                b = balls[j]
                angle, speed = samples[2 * j, i], samples[2 * j + 1, i]
                force = share * b.coulomb_damping
                if speed != 0.0 or not touching:
                    force = resistance(o, speed, angle, ay, b)
                out[j, LAB, i] = lab_energy(angle, speed, y, vy, b.mass, b.length, gravity)
                out[j, ROD, i] = rod_power(angle, force, out[j, TENSION, i], vy)

    return observe
