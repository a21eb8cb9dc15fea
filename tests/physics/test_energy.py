"""Energies, powers and tensions against their derivation by computer algebra."""

import math

import numpy as np
import pytest
import sympy as sp

import latolato as ll
from latolato.numerics.prepare import body_record
from latolato.numerics.records import BODY
from latolato.physics import energy as law
from latolato.physics.damping import damping_power, drag, drag_force
from latolato.physics.pendulum import (
    potential_linear,
    potential_sine,
    restoring_linear,
    restoring_sine,
    swung,
    systems,
)
from latolato.physics.tension import tension, wall_tension

POINTS = [(0.3, 0.0), (1.2, -2.0), (2.9, 4.0), (-0.8, 1.5), (7.0, 12.0)]
l, m, g, C = 0.8, 0.35, 9.8, 0.07


def derive():
    """Angular acceleration and rod force of a ball on a pivot y(t), from first principles.

    Lagrangian of the laboratory for the acceleration (with the drag as a generalised force),
    Newton's law along the rod for the tension.
    """
    t = sp.symbols("t")
    th, y = sp.Function("th")(t), sp.Function("y")(t)
    L, M, G, c = sp.symbols("l m g C", positive=True)
    px, py = L * sp.sin(th), y - L * sp.cos(th)
    kinetic = M * (sp.diff(px, t) ** 2 + sp.diff(py, t) ** 2) / 2
    lagrangian = kinetic - M * G * py
    rate = sp.diff(th, t)
    equation = (
        sp.diff(sp.diff(lagrangian, rate), t) - sp.diff(lagrangian, th) + c * L * rate
    )  # torque of the drag force C th'
    (alpha,) = sp.solve(equation, sp.diff(th, t, 2))
    # Newton along the rod, towards the pivot; the drag is tangential.
    along = sp.Matrix([-sp.sin(th), sp.cos(th)])
    across = sp.Matrix([sp.cos(th), sp.sin(th)])
    needed = M * sp.Matrix([sp.diff(px, t, 2), sp.diff(py, t, 2) + G])
    force_along = sp.simplify(needed.dot(along))
    force_across = sp.simplify(needed.dot(across).subs(sp.diff(th, t, 2), alpha))
    vertical = needed[1].subs(sp.diff(th, t, 2), alpha)
    symbols = sp.symbols("angle speed height rise lift")

    def evaluate(expression):
        swapped = (
            expression.subs(sp.diff(y, t, 2), symbols[4])
            .subs(sp.diff(th, t), symbols[1])
            .subs(sp.diff(y, t), symbols[3])
            .subs(th, symbols[0])
            .subs(y, symbols[2])
        )
        return sp.lambdify((*symbols, L, M, G, c), swapped)

    lab = kinetic + M * G * py
    return {
        "alpha": evaluate(alpha),
        "along": evaluate(force_along),
        "across": evaluate(force_across),
        "vertical": evaluate(vertical),
        "lab": evaluate(lab),
    }


@pytest.fixture(scope="module")
def derived():
    return derive()


@pytest.mark.parametrize("angle,speed", POINTS)
@pytest.mark.parametrize("lift", [0.0, 13.0, -21.0])
def test_acceleration_of_eq10_follows_from_its_lagrangian(derived, angle, speed, lift):
    ball = ll.Ball(length=l, mass=m, damping=C)
    body = np.rec.array([body_record(ball)], dtype=BODY)[0]
    restored = restoring_sine(angle)
    alpha = swung(g + lift, body.inverse_length, restored)
    alpha -= drag(speed, float(np.sign(speed)), body)
    assert alpha == pytest.approx(derived["alpha"](angle, speed, 0, 0, lift, l, m, g, C), rel=1e-13)
    driven = swung(lift, body.inverse_length, restored)
    assert driven == pytest.approx(-lift * math.sin(angle) / l, rel=1e-14)


@pytest.mark.parametrize("angle,speed", POINTS)
@pytest.mark.parametrize("lift", [0.0, 13.0, -21.0])
def test_tension_follows_from_newtons_law(derived, angle, speed, lift):
    exact = derived["along"](angle, speed, 0, 0, lift, l, m, g, C)
    assert tension(angle, speed, lift, m, l, g) == pytest.approx(exact, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("angle,speed", POINTS)
def test_rod_power_is_the_vertical_force_on_the_ball_times_the_pivots_velocity(
    derived, angle, speed
):
    lift, rise = -7.0, 1.3
    force = drag_force(speed, float(np.sign(speed)), C, 0.0, 0.0)
    pull = tension(angle, speed, lift, m, l, g)
    exact = derived["vertical"](angle, speed, 0, rise, lift, l, m, g, C) * rise
    assert law.rod_power(angle, force, pull, rise) == pytest.approx(exact, rel=1e-12)
    # The tangential force on the ball is the drag alone.
    assert derived["across"](angle, speed, 0, 0, lift, l, m, g, C) == pytest.approx(-force)


@pytest.mark.parametrize("angle,speed", POINTS)
def test_lab_energy_is_kinetic_plus_height(derived, angle, speed):
    exact = derived["lab"](angle, speed, 0.04, -1.1, 0, l, m, g, C)
    assert law.lab_energy(angle, speed, 0.04, -1.1, m, l, g) == pytest.approx(exact, rel=1e-13)


def test_lab_energy_at_a_pivot_at_rest_is_the_pivot_frames():
    for angle, speed in POINTS:
        inside = law.kinetic_energy(speed, m, l) + law.potential_energy(
            potential_sine(angle), m, l, g
        )
        lab = law.lab_energy(angle, speed, 0.0, 0.0, m, l, g)
        assert lab == pytest.approx(inside - m * g * l, rel=1e-13)


@pytest.mark.parametrize(
    "restoring,potential",
    [(restoring_sine, potential_sine), (restoring_linear, potential_linear)],
)
def test_restoring_factor_is_the_slope_of_the_potential(restoring, potential):
    h = 1e-4
    for angle in (0.0, 0.4, -1.3, 3.0):
        slope = (potential(angle + h) - potential(angle - h)) / (2.0 * h)
        assert restoring(angle) == pytest.approx(slope, abs=1e-8)
    assert potential(0.0) == 0.0


def test_every_system_pairs_a_restoring_law_with_its_potential():
    for kind in systems.values():
        for angle in (0.2, 1.4):
            slope = (kind.potential(angle + 1e-4) - kind.potential(angle - 1e-4)) / 2e-4
            assert kind.restoring(angle) == pytest.approx(slope, abs=1e-8)


def test_potential_keeps_its_digits_near_zero():
    assert potential_sine(1e-9) == pytest.approx(0.5e-18, rel=1e-14)


@pytest.mark.parametrize("angle,speed", POINTS)
def test_pivot_frame_energy_grows_by_drive_less_damping(derived, angle, speed):
    lift = 4.2
    alpha = derived["alpha"](angle, speed, 0, 0, lift, l, m, g, C)
    growth = m * l * l * speed * alpha + m * g * l * math.sin(angle) * speed
    power = law.drive_power(speed, math.sin(angle), lift, m, l)
    assert growth == pytest.approx(
        power - damping_power(speed, l, C, 0.0, 0.0), rel=1e-12, abs=1e-14
    )


def test_wall_tension_balances_weight_and_contact():
    # At rest on the other ball: contact force N horizontal, T cos = m (g + y''), T sin = N.
    angle, lift = 0.3, 2.0
    pull = wall_tension(angle, lift, m, g)
    assert pull * math.cos(angle) == pytest.approx(m * (g + lift))
    # At the verge of lift-off both the tension and the weight vanish.
    assert wall_tension(angle, -g, m, g) == 0.0


@pytest.mark.parametrize("name", ["pendulum", "latolato"])
def test_lab_energy_balance_holds_along_a_run(name, damping_law):
    # dE_L/dt = rod power - drag power, by a sixth-order difference of the samples; drag power in
    # the laboratory is the drag force on the ball's tangential velocity, including the pivot's.
    kind = systems[name]
    own = {"radius": 0.05} if name == "latolato" else {}
    system = kind(length=l, mass=m, **own, **damping_law)
    drive = ll.Harmonic(drive_amplitude=0.06, drive_frequency=7.0, drive_phase=0.4)
    h = 1e-3
    run = ll.simulate(
        system,
        drive,
        initial_angle=1.1,
        initial_angular_velocity=0.5,
        times=np.arange(0.0, 3.0, h),
        frame="both",
        tolerance=1e-12,
    )
    E, speed, angle = run.lab_energy.values, run.angular_velocity.values, run.angle.values
    slope = (45.0 * (E[4:-2] - E[2:-4]) - 9.0 * (E[5:-1] - E[1:-5]) + (E[6:] - E[:-6])) / (60.0 * h)
    ball = system.balls[0]
    force = (
        ball.damping * speed
        + ball.quadratic_damping * speed * np.abs(speed)
        + ball.coulomb_damping * np.sign(speed)
    )
    drag_power = force * (l * speed)
    balance = (run.rod_power.values - drag_power)[3:-3]
    # Differences are spoilt where a contact or a turning point lies within three samples.
    clear = np.abs(speed[3:-3]) > 0.1
    for t in run.contact_time.values:
        clear &= np.abs(run.time.values[3:-3] - t) > 4.0 * h
    assert clear.sum() > 2000
    # Difference error: (w h)^6/140 of the scale, w up to about 25 rad/s; rounding eps/h.
    np.testing.assert_allclose(slope[clear], balance[clear], rtol=0, atol=2e-9)
    assert np.all(np.isfinite(angle))


def test_the_rod_carries_a_ball_that_friction_holds():
    # All of m (g + y0'') comes from the rod then, part of it through friction at the pivot.
    system = ll.Pendulum(length=l, mass=m, coulomb_damping=5.0)
    drive = ll.Harmonic(drive_amplitude=0.06, drive_frequency=7.0, drive_phase=0.4)
    run = ll.simulate(
        system, drive, initial_angle=0.4, times=np.linspace(0.0, 3.0, 200), frame="both"
    )
    assert np.all(run.angle == 0.4)
    carried = m * (system.gravity + run.pivot_acceleration) * run.pivot_velocity
    np.testing.assert_allclose(run.rod_power, carried, rtol=1e-13, atol=1e-14)


def test_the_rod_carries_a_ball_that_lies_against_the_other():
    # The other ball pushes sideways only, and friction has nothing to do.
    system = ll.LatoLato(length=l, mass=m, radius=0.05, coulomb_damping=5.0)
    drive = ll.Harmonic(drive_amplitude=0.06, drive_frequency=7.0, drive_phase=0.4)
    run = ll.simulate(
        system, drive, initial_offset=0.0, times=np.linspace(0.0, 3.0, 200), frame="both"
    )
    assert np.all(run.angular_velocity == 0.0)
    carried = m * (system.gravity + run.pivot_acceleration) * run.pivot_velocity
    np.testing.assert_allclose(run.rod_power, carried, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("strengths", [(5.0, 5.0), (1.0, 9.0)])
def test_both_rods_carry_two_balls_that_friction_holds_against_each_other(strengths):
    # How they share it is left open; the sum is not.
    right, left = (
        ll.Ball(length=l, mass=m, radius=0.05, coulomb_damping=strength) for strength in strengths
    )
    pair = ll.BallPair(right=right, left=left, restitution=0.5)
    drive = ll.Harmonic(drive_amplitude=0.06, drive_frequency=7.0, drive_phase=0.4)
    half = np.arcsin(0.05 / l)
    run = ll.simulate(
        pair, drive, initial_angle=(0.5 + half, 0.5 - half), times=np.linspace(0.0, 3.0, 200),
        frame="both",
    )  # fmt: skip
    assert np.all(run.angular_velocity == 0.0)
    carried = 2.0 * m * (pair.gravity + run.pivot_acceleration) * run.pivot_velocity
    np.testing.assert_allclose(run.rod_power.sum("ball"), carried, rtol=1e-12, atol=1e-13)
