"""The drag laws: exact flows, their semigroup, signs and series."""

import math
from types import SimpleNamespace

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from latolato.numerics.prepare import body_record
from latolato.numerics.records import BODY
from latolato.physics.damping import damping_power, drag, drift, effective_time
from latolato.physics.pendulum import Ball

RATES = [0.0, 1e-6, 0.02, 1.7]
QUADRATICS = [0.0, 1e-4, 0.3, 2.0]


def flow(velocity, time, rate, quadratic):
    """Angle travelled and velocity after `time` with the sign that the velocity has."""
    sign = math.copysign(1.0, velocity)
    body = SimpleNamespace(damping_rate=rate, quadratic=quadratic)
    return drift(velocity, sign, effective_time(rate, time), body)


def body_of(ball):
    """The body of one ball, as kernels read it."""
    return np.rec.array([body_record(ball)], dtype=BODY)[0]


@pytest.mark.parametrize("time", [1e-9, 1e-4, 0.05, 3.0, -0.02])
@pytest.mark.parametrize("rate", [0.0, 1e-12, 1e-5, 0.0199, 0.0201, 1.0, 30.0])
def test_effective_time_is_exact_to_rounding_on_both_sides_of_its_series(rate, time):
    with mp.workdps(50):
        exact = mp.mpf(time) if rate == 0.0 else -mp.expm1(-mp.mpf(rate) * time) / mp.mpf(rate)
    assert effective_time(rate, time) == pytest.approx(float(exact), rel=4e-16)


@pytest.mark.parametrize("velocity", [-4.0, -0.01, 0.3, 7.0])
@pytest.mark.parametrize("quadratic", QUADRATICS)
@pytest.mark.parametrize("rate", RATES)
def test_drift_solves_its_equation(velocity, rate, quadratic):
    solution = solve_ivp(
        lambda _, y: (y[1], -rate * y[1] - quadratic * y[1] * abs(y[1])),
        (0.0, 1.3),
        (0.0, velocity),
        method="DOP853",
        rtol=1e-13,
        atol=1e-15,
    )
    travelled, slower = flow(velocity, 1.3, rate, quadratic)
    assert travelled == pytest.approx(solution.y[0, -1], rel=1e-11)
    assert slower == pytest.approx(solution.y[1, -1], rel=1e-11)


@pytest.mark.parametrize("quadratic", QUADRATICS)
@pytest.mark.parametrize("rate", RATES)
def test_drift_is_a_semigroup_forwards_and_backwards(rate, quadratic):
    first, middle = flow(3.0, 0.4, rate, quadratic)
    second, last = flow(middle, 0.25, rate, quadratic)
    travelled, slower = flow(3.0, 0.65, rate, quadratic)
    assert first + second == pytest.approx(travelled, rel=1e-14)
    assert last == pytest.approx(slower, rel=1e-14)
    # The splitting has backward substeps.
    back, start = flow(middle, -0.4, rate, quadratic)
    assert back == pytest.approx(-first, rel=1e-14)
    assert start == pytest.approx(3.0, rel=1e-14)


def test_drift_without_drag_is_uniform_motion():
    assert flow(2.5, 0.2, 0.0, 0.0) == (0.5, 2.5)


def test_small_quadratic_drag_tends_to_none():
    without = flow(2.0, 0.5, 0.3, 0.0)
    for quadratic in (1e-6, 1e-9):
        assert flow(2.0, 0.5, 0.3, quadratic) == pytest.approx(without, rel=2.0 * quadratic)


@given(
    velocity=st.floats(-50.0, 50.0).filter(lambda v: abs(v) > 1e-6),
    time=st.floats(1e-6, 5.0),
    rate=st.floats(0.0, 5.0),
    quadratic=st.just(0.0) | st.floats(1e-200, 5.0),
)
@settings(max_examples=200, deadline=None)
def test_drag_only_takes_energy_and_never_turns_the_motion(velocity, time, rate, quadratic):
    travelled, slower = flow(velocity, time, rate, quadratic)
    assert abs(slower) <= abs(velocity)
    assert slower * velocity >= 0.0
    assert travelled * velocity > 0.0
    assert abs(travelled) <= abs(velocity) * time * (1.0 + 1e-15)


@given(
    velocity=st.floats(-20.0, 20.0),
    length=st.floats(0.05, 3.0),
    mass=st.floats(0.01, 3.0),
    laws=st.tuples(*[st.floats(0.0, 1.0)] * 3),
)
def test_dissipated_power_is_drag_force_times_speed(velocity, length, mass, laws):
    # P = l w F with F = m l drag: the two formulas are written apart.
    linear, quadratic, coulomb = laws
    ball = Ball(
        length=length,
        mass=mass,
        damping=linear,
        quadratic_damping=quadratic,
        coulomb_damping=coulomb,
    )
    body = body_of(ball)
    sign = float(np.sign(velocity))
    power = damping_power(velocity, length, linear, quadratic, coulomb)
    assert power >= 0.0
    assert power == pytest.approx(body.inertia * drag(velocity, sign, body) * velocity, rel=1e-12)


def test_drag_opposes_the_motion(damping_law):
    ball = Ball(length=0.9, mass=0.5, **damping_law)
    body = body_of(ball)
    for velocity in (0.7, 5.0):
        forward = drag(velocity, 1.0, body)
        assert forward == -drag(-velocity, -1.0, body)
        assert (forward > 0.0) == bool(damping_law)


def test_papers_decay_rate_is_half_the_velocity_rate():
    # Figs. 7 and 10: k = C/(2 m l).
    ball = Ball(length=0.3630, mass=0.10804, damping=0.00274)
    assert body_record(ball)[1] / 2.0 == pytest.approx(0.0349325, abs=5e-8)
