"""Evaluates energies, powers and tensions of a sampled motion in the plane."""

from __future__ import annotations

import math
from collections.abc import Callable

from latolato.core.scalar import cosine, sine
from latolato.numerics.derived import (
    DAMPING,
    DRIVE,
    KINETIC,
    LAB,
    POTENTIAL,
    ROD,
    TENSION,
    Observation,
)
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.records import S_DISTANCE
from latolato.numerics.run_record import REST, STICKING
from latolato.physics.damping import drag_force, static_friction
from latolato.physics.pair import contact_torque, radial_push
from latolato.physics.pendulum import Ball

# The formulas that `make_plane_observer` takes: height, velocity and acceleration, up and across.
PLANE_OBSERVED = 6


def make_plane_observer(
    height: Callable[..., float],
    velocity: Callable[..., float],
    acceleration: Callable[..., float],
    across: Callable[..., float],
    across_velocity: Callable[..., float],
    across_acceleration: Callable[..., float],
    part: Part = as_it_stands,
) -> Callable[..., None]:
    """Return the function that fills `pivot` and `out` of an `Observation`.

    Each kilogram is pulled by ``(-ax - c wx, -(g + ay) - c wy)``, with c the rate of the linear
    drag, and w the pivot's velocity against the air or zero; see `engine.forces.make_planar`.
    """

    @part
    def pull(o: Observation, b: Ball, i: int) -> tuple[float, float, float, float]:
        """Return the force on a ball by gravity, drive and wind [N], and the wind's part."""
        rate = b.damping / b.length
        wind_x = -rate * o.pivot[4, i] * o.in_lab
        wind_y = -rate * o.pivot[1, i] * o.in_lab
        x = -b.mass * o.pivot[5, i] + wind_x
        return x, -b.mass * (o.gravity + o.pivot[2, i]) + wind_y, wind_x, wind_y

    @part
    def around(o: Observation, j: int, i: int) -> float:
        """Return the force that turns a ball on its taut string, with all drag [N]."""
        b, angle, w = o.balls[j], o.samples[2 * j, i], o.samples[2 * j + 1, i]
        x, y, _, _ = pull(o, b, i)
        force = x * cosine(angle) + y * sine(angle)
        if w == 0.0:
            return force - static_friction(force, b.coulomb_damping)
        sign = math.copysign(1.0, w)
        return force - drag_force(w, sign, b.damping, b.quadratic_damping, b.coulomb_damping)

    @part
    def observe_ball(o: Observation, j: int, i: int, is_still: bool) -> None:
        """Fill all rows of one ball but what a second one adds to its tension."""
        b, samples, out = o.balls[j], o.samples, o.out
        angle, w, row = samples[2 * j, i], samples[2 * j + 1, i], S_DISTANCE + 3 * j
        distance, outward, slack = samples[row, i], samples[row + 1, i], samples[row + 2, i]
        s, c, speed = sine(angle), cosine(angle), distance * w
        vx, vy = outward * s + speed * c, -outward * c + speed * s
        x, y, wind_x, wind_y = pull(o, b, i)
        l, squared = b.length, vx * vx + vy * vy
        rubbed = 0.0 if slack != 0.0 else b.coulomb_damping
        size = math.sqrt(squared)
        drag = (b.damping + b.quadratic_damping * size / l) / l  # over the velocity [kg/s]
        out[j, KINETIC, i] = 0.5 * b.mass * squared
        out[j, POTENTIAL, i] = b.mass * o.gravity * (l - distance * c)
        out[j, DRIVE, i] = -b.mass * (o.pivot[5, i] * vx + o.pivot[2, i] * vy)
        out[j, DAMPING, i] = drag * squared + rubbed * abs(speed) - wind_x * vx - wind_y * vy
        tension = b.mass * l * w * w + x * s - y * c
        if is_still and len(o.balls) == 1:
            tension = -y / c
        out[j, TENSION, i] = 0.0 if slack != 0.0 else tension

    @part
    def observe_lab(o: Observation, j: int, i: int) -> None:
        """Fill the rows of one ball in the laboratory."""
        b, samples, out, pivot = o.balls[j], o.samples, o.out, o.pivot
        angle, w, row = samples[2 * j, i], samples[2 * j + 1, i], S_DISTANCE + 3 * j
        distance, outward, slack = samples[row, i], samples[row + 1, i], samples[row + 2, i]
        s, c = sine(angle), cosine(angle)
        vx = pivot[4, i] + outward * s + distance * w * c
        vy = pivot[1, i] - outward * c + distance * w * s
        height = pivot[0, i] - distance * c
        out[j, LAB, i] = b.mass * (0.5 * (vx * vx + vy * vy) + o.gravity * height)
        pulled = out[j, TENSION, i]
        rubbed = 0.0 if slack != 0.0 or w == 0.0 else math.copysign(b.coulomb_damping, w)
        # Drag against the pivot is passed on to it by whatever makes it.
        held = 1.0 - o.in_lab
        size = math.hypot(vx - pivot[4, i], vy - pivot[1, i])
        drag = held * (b.damping + b.quadratic_damping * size / b.length) / b.length
        x = -pulled * s - drag * (vx - pivot[4, i]) - rubbed * c
        y = pulled * c - drag * (vy - pivot[1, i]) - rubbed * s
        out[j, ROD, i] = x * pivot[4, i] + y * pivot[1, i]

    def observe(o: Observation) -> None:
        times, samples, modes, balls = o.times, o.samples, o.modes, o.balls
        k = 0
        for i in range(len(times)):
            t = times[i]
            while k + 1 < len(o.segments) and o.segments[k + 1].start <= t:
                k += 1
            p = o.segments[k]
            o.pivot[0, i], o.pivot[1, i] = height(t, p), velocity(t, p)
            o.pivot[2, i], o.pivot[3, i] = acceleration(t, p), across(t, p)
            o.pivot[4, i], o.pivot[5, i] = across_velocity(t, p), across_acceleration(t, p)
            for j in range(len(balls)):
                observe_ball(o, j, i, modes[i] == REST)
            if modes[i] == STICKING:
                b1, b2 = balls[0], balls[1]
                inertia_1, inertia_2 = b1.mass * b1.length**2, b2.mass * b2.length**2
                torque = contact_torque(
                    around(o, 0, i) / (b1.mass * b1.length),
                    around(o, 1, i) / (b2.mass * b2.length), inertia_1, inertia_2,
                )  # fmt: skip
                gap = samples[0, i] - samples[2, i]
                o.out[0, TENSION, i] += radial_push(torque, b1.length, b2.length, gap)
                o.out[1, TENSION, i] += radial_push(torque, b2.length, b1.length, gap)
            for j in range(len(balls) if o.with_lab != 0 else 0):
                observe_lab(o, j, i)

    return observe
