"""Other integrators on the same motions: SciPy's DOP853 with events, and heyoka's Taylor series."""

import math
import platform
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import latolato as ll

G = 9.8
DRIVEN = [
    pytest.param(
        ll.Pendulum(length=1.0, mass=0.8, damping=0.05),
        ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26),
        0.3,
        id="fig2",
    ),
    pytest.param(
        ll.Pendulum(length=0.363, mass=0.10804, damping=0.00274),
        ll.CrankSlider(drive_amplitude=0.02, drive_frequency=10.09, connecting_rod_length=0.15),
        0.2,
        id="fig8 crank",
    ),
    pytest.param(
        ll.Pendulum(length=1.0, mass=0.8, damping=0.02, quadratic_damping=0.03),
        ll.Chirp(
            drive_amplitude=0.1, drive_frequency=7.0, drive_frequency_final=5.0, sweep_time=12.0
        ),
        0.5,
        id="chirp with quadratic drag",
    ),
    pytest.param(
        ll.Mathieu(length=1.0, mass=0.8, damping=0.05),
        ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.1, drive_phase=1.0),
        0.1,
        id="eq14",
    ),
]
WALLS = [
    pytest.param(
        ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1, restitution=1.0),
        ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26),
        0.3,
        id="fig4 with a push",
    ),
    pytest.param(
        ll.LatoLato(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196, restitution=0.9),
        ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.109),
        0.7,
        id="fig12",
    ),
    pytest.param(
        ll.LatoLato(length=1.0, mass=0.8, radius=0.3, restitution=0.8),
        ll.Harmonic(drive_amplitude=0.3, drive_frequency=7.0, drive_phase=0.5),
        2.5,
        id="top and bottom",
    ),
]


def acceleration(system, drive):
    """The equation of motion, written down again."""
    (ball,) = system.balls
    segments = drive.segments(100.0)
    starts = [segment.start for segment in segments]
    linear = isinstance(system, ll.Mathieu)
    m, l = ball.mass, ball.length

    def rates(t, y):
        k = max(i for i, start in enumerate(starts) if start <= t + 1e-15)
        lift = drive.acceleration(t, segments[k])
        pull = y[0] if linear else math.sin(y[0])
        drag = ball.damping * y[1] + ball.quadratic_damping * y[1] * abs(y[1])
        return [y[1], -(G + lift) / l * pull - drag / (m * l)]

    return rates


def with_scipy(system, drive, angle, end, walls=None, restitution=1.0):
    """Final state and contacts (time, velocity before) by DOP853, restarted at each contact."""
    rates = acceleration(system, drive)
    t, y, contacts = 0.0, [angle, 0.0], []
    events = []
    if walls:
        for wall, direction in zip(walls, (-1, 1), strict=True):
            event = lambda _, y, wall=wall: y[0] - wall  # noqa: E731
            event.terminal, event.direction = True, direction
            events.append(event)
    while True:
        solution = solve_ivp(
            rates, (t, end), y, method="DOP853", rtol=1e-13, atol=1e-13, events=events or None
        )
        t, y = solution.t[-1], list(solution.y[:, -1])
        if solution.status == 0:
            return y, contacts
        contacts.append((t, y[1]))
        y = [min(walls, key=lambda w: abs(w - y[0])), -restitution * y[1]]


@pytest.mark.parametrize("system,drive,angle", DRIVEN)
def test_scipy_agrees_without_walls(system, drive, angle):
    exact, _ = with_scipy(system, drive, angle, 15.0)
    run = ll.simulate(system, drive, initial_angle=angle, times=[15.0], tolerance=1e-12)
    # DOP853 at 1e-13 errs by about 1e-11 over these runs.
    assert float(run.angle[0]) == pytest.approx(exact[0], abs=1e-9)
    assert float(run.angular_velocity[0]) == pytest.approx(exact[1], abs=3e-9)


@pytest.mark.parametrize("system,drive,angle", WALLS)
def test_scipy_agrees_with_walls(system, drive, angle):
    walls = (system.contact_angle_low, system.contact_angle_high)
    exact, contacts = with_scipy(system, drive, angle, 5.0, walls, system.restitution)
    run = ll.simulate(system, drive, initial_angle=angle, times=[5.0], tolerance=1e-12)
    assert len(contacts) >= 4
    assert run.sizes["contact"] == len(contacts)
    times, speeds = np.transpose(contacts)
    # Its events are located on an interpolant of order 7, to about 1e-10; contacts amplify.
    np.testing.assert_allclose(run.contact_time, times, rtol=0, atol=1e-8)
    np.testing.assert_allclose(run.angular_velocity_before, speeds, rtol=0, atol=1e-7)
    assert float(run.angle[0]) == pytest.approx(exact[0], abs=1e-7)


heyoka_runs_here = sys.platform == "linux" and platform.machine() in ("x86_64", "aarch64")


@pytest.fixture(scope="module")
def hy():
    if not heyoka_runs_here:
        pytest.skip("heyoka is published as Linux wheels only")
    import heyoka

    return heyoka


def taylor(hy, system, drive, events=(), fp=float):
    """heyoka's integrator of angle and velocity under a harmonic drive."""
    x, v = hy.make_vars("x", "v")
    (ball,) = system.balls
    m, l = ball.mass, ball.length
    a, w, phase = drive.drive_amplitude, drive.drive_frequency, drive.drive_phase
    lift = -a * w * w * hy.cos(w * hy.time + phase)
    pull = x if isinstance(system, ll.Mathieu) else hy.sin(x)
    drag = ball.damping / (m * l) * v
    return hy.taylor_adaptive(
        [(x, v), (v, -(G + lift) / l * pull - drag)], [0.0, 0.0], tol=1e-17, t_events=list(events)
    )


@pytest.mark.parametrize(
    "system,drive,angle", [p for p in DRIVEN if isinstance(p.values[1], ll.Harmonic)]
)
def test_heyoka_agrees_without_walls(hy, system, drive, angle):
    integrator = taylor(hy, system, drive)
    integrator.state[:] = [angle, 0.0]
    times = np.linspace(0.0, 30.0, 31)
    exact = integrator.propagate_grid(times)[-1]
    run = ll.simulate(system, drive, initial_angle=angle, times=times, tolerance=1e-13)
    np.testing.assert_allclose(run.angle, exact[:, 0], rtol=0, atol=2e-10)
    np.testing.assert_allclose(run.angular_velocity, exact[:, 1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("system,drive,angle", WALLS)
def test_heyoka_agrees_with_walls(hy, system, drive, angle):
    x, _ = hy.make_vars("x", "v")
    contacts = []

    def bounce(integrator, d_sgn):
        contacts.append((integrator.time, integrator.state[1]))
        integrator.state[1] *= -system.restitution
        return True

    events = [
        hy.t_event(x - system.contact_angle_low, callback=bounce,
                   direction=hy.event_direction.negative),
        hy.t_event(x - system.contact_angle_high, callback=bounce,
                   direction=hy.event_direction.positive),
    ]  # fmt: skip
    integrator = taylor(hy, system, drive, events)
    integrator.state[:] = [angle, 0.0]
    outcome = integrator.propagate_until(5.0)[0]
    assert outcome == hy.taylor_outcome.time_limit
    run = ll.simulate(system, drive, initial_angle=angle, times=[5.0], tolerance=1e-13)
    times, speeds = np.transpose(contacts)
    assert run.sizes["contact"] == len(contacts)
    np.testing.assert_allclose(run.contact_time, times, rtol=0, atol=1e-10)
    np.testing.assert_allclose(run.angular_velocity_before, speeds, rtol=0, atol=1e-9)
    assert float(run.angle[0]) == pytest.approx(integrator.state[0], abs=1e-9)
