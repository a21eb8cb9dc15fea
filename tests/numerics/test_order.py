"""Measured order equals declared order: motion, works and contact times, for every drag and drive.

An order is the least-squares slope of log(error) over log(step) for thirteen step sizes. The error
of a trajectory is a root mean square over many instants, and the geometric mean is taken over many
starts: events cut steps at other places for each step size, which scatters the error of one
trajectory by more than the tolerance of 0.1. Errors are measured against a run with a step several
times smaller, and lie far above rounding.
"""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.numerics.integrate import Start, integrate
from latolato.numerics.prepare import choose_stepper
from latolato.numerics.records import S_DAMPED, S_WORK
from latolato.numerics.steppers import BLANES_MOAN_GENERAL, BLANES_MOAN_RKN

DRAGS = [
    pytest.param({}, id="undamped"),
    pytest.param({"damping": 0.3}, id="linear"),
    pytest.param({"quadratic_damping": 0.15}, id="quadratic"),
    pytest.param({"coulomb_damping": 0.2}, id="coulomb"),
    pytest.param({"damping": 0.2, "quadratic_damping": 0.1}, id="linear+quadratic"),
    pytest.param({"damping": 0.2, "coulomb_damping": 0.15}, id="linear+coulomb"),
    pytest.param({"quadratic_damping": 0.1, "coulomb_damping": 0.15}, id="quadratic+coulomb"),
    pytest.param(
        {"damping": 0.1, "quadratic_damping": 0.1, "coulomb_damping": 0.1}, id="all three"
    ),
]
DRIVES = [
    pytest.param(
        ll.Harmonic(drive_amplitude=0.1, drive_frequency=9.3, drive_phase=0.4), id="harmonic"
    ),
    pytest.param(
        ll.FrequencySchedule(
            drive_amplitude=0.1, times=[0.0, 1.3, 3.1], drive_frequencies=[10.0, 7.0, 9.0]
        ),
        id="schedule",
    ),
    pytest.param(
        ll.FrequencySchedule(
            drive_amplitude=0.1, times=[0.0, 1.3, 3.1], drive_frequencies=[10.0, 7.0, 9.0], ramp=0.7
        ),
        id="ramped schedule",
    ),
    pytest.param(
        ll.CrankSlider(drive_amplitude=0.1, drive_frequency=6.0, connecting_rod_length=0.6),
        id="crank",
    ),
    # Long segments: many steps lie in each.
    pytest.param(
        ll.MeasuredPivot(
            times=np.arange(0.0, 9.0),
            pivot_heights=0.15 * np.cos(2.5 * np.arange(0.0, 9.0)),
        ),
        id="measured",
    ),
]
# One drag for each of the two methods. A drive enters the kicks and a drag the drifts: each drag
# with one drive and each drive with either method show the order of both. An impact is located on
# the step, whatever its drag: each method shows the order of both kinds of walls.
EACH_METHOD = ("linear", "all three")


def unless(is_short, *values, name):
    """A case that `make test` leaves to `make test-all` unless it is among the short ones."""
    return pytest.param(*values, id=name, marks=[] if is_short else [pytest.mark.slow])


MOTIONS = [
    unless(
        drag.id == "all three" or drive.id == "harmonic",
        *(*drive.values, *drag.values),
        name=f"{drive.id}-{drag.id}",
    )
    for drive in DRIVES
    for drag in DRAGS
    if drive.id == "harmonic" or drag.id in EACH_METHOD
]
IMPACTS = [
    unless(
        drag.id in EACH_METHOD,
        *(restitution, *drag.values),
        name=f"{restitution}-{drag.id}",
    )
    for restitution in (0.8, 1.0)
    for drag in DRAGS
    if restitution < 1.0 or drag.id in EACH_METHOD
]
SMALL = [unless(drag.id in EACH_METHOD, *drag.values, name=drag.id) for drag in DRAGS]
# Friction stops a swing that is not driven hard: these starts keep turning for the whole run.
STARTS = [(2.2 * math.cos(1.1 * k), 3.0 * math.sin(2.7 * k + 0.4)) for k in range(110)]
END = 5.0


def measured_order(steps, errors):
    """Least-squares slope of log(error) over log(step)."""
    slope, _ = np.polyfit(np.log(steps), np.log(errors), 1)
    return float(slope)


def runs(system, drive, step, times, starts, end=END, **options):
    """One trajectory for each start."""
    return [
        integrate(system, drive, Start((a,), (v,)), times, end, step=step, **options)
        for a, v in starts
    ]


def typical(errors):
    """Geometric mean over the middle half of the starts of root mean squares over the rest.

    The lowest quarter nears rounding, the highest passes close to grazes and sticking.
    """
    flat = np.asarray(errors).reshape(len(errors), -1)
    ranked = np.sort(np.sqrt(np.mean(flat**2, axis=1)))
    quarter = len(ranked) // 4
    return float(np.exp(np.mean(np.log(ranked[quarter : len(ranked) - quarter]))))


def choose_drag(system):
    """Whether the system has any drag."""
    return system.damping + system.quadratic_damping + system.coulomb_damping > 0.0


def convergence(system, drive):
    """Steps, and typical errors of angle, velocity and works there, an array (step,) each."""
    times = np.linspace(0.05, END, 67)
    rows = [0, 1, S_WORK, S_DAMPED] if choose_drag(system) else [0, 1, S_WORK]

    def values(step):
        return np.array([r.samples[rows] for r in runs(system, drive, step, times, STARTS)])

    finest = values(0.004)
    steps = window(lambda step: typical((values(step) - finest)[:, 0]))
    errors = [values(step) - finest for step in steps]
    return steps, {row: [typical(e[:, i]) for e in errors] for i, row in enumerate(rows)}


def window(error_of, largest=2e-10):
    """Thirteen steps within a factor of 3 whose errors go from about `largest` down to 1/729 of it.

    Above, higher powers of the step bend the line; below, rounding (some 1e-14) does.
    """
    pilot = 0.03
    first = pilot * (largest / error_of(pilot)) ** (1.0 / 6.0)
    return first * 3.0 ** (-np.arange(13) / 12.0)


@pytest.mark.parametrize("drive, drag", MOTIONS)
def test_order_of_motion_and_works_through_turning_points(drive, drag):
    system = ll.Pendulum(length=1.0, mass=0.8, **drag)
    steps, errors = convergence(system, drive)
    declared = choose_stepper(system).order
    for row, seen in errors.items():
        assert measured_order(steps, seen) == pytest.approx(declared, abs=0.1), (row, seen)


@pytest.mark.parametrize("drag", SMALL)
def test_order_of_the_small_angle_model(drag):
    system = ll.Mathieu(length=1.0, mass=0.8, **drag)
    drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=9.3, drive_phase=0.4)
    steps, errors = convergence(system, drive)
    for row, seen in errors.items():
        assert measured_order(steps, seen) == pytest.approx(6.0, abs=0.1), (row, seen)


@pytest.mark.parametrize("restitution, drag", IMPACTS)
def test_order_of_contact_times_and_velocities(restitution, drag):
    # Many drive periods, and so many steps, lie between two contacts: steps that end at an event
    # are shorter, err less, and would bend the line if they were many.
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=18.0, drive_phase=0.4)
    system = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=restitution, **drag)
    # Spread evenly in two directions by irrational steps.
    starts = [(0.6 + 1.2 * (0.7549 * k % 1.0), 1.5 - 3.0 * (0.5698 * k % 1.0)) for k in range(400)]
    end = 2.0
    times = np.array([end])

    def contacts(step):
        result = runs(system, drive, step, times, starts, end, rest_speed=1e-6, contact_limit=50)
        return [(r.contact_times[:2], r.contact_values[0, :2]) for r in result]

    exact = contacts(0.0015)

    def late_and_fast(step):
        pairs = list(zip(contacts(step), exact, strict=True))
        return [typical([a[i] - b[i] for a, b in pairs]) for i in (0, 1)]

    # A flight between events takes few steps; only small ones show the order of many.
    smooth = choose_stepper(system) is BLANES_MOAN_RKN
    steps = window(lambda step: late_and_fast(step)[0], largest=3e-10 if smooth else 1.2e-11)
    late, fast = np.transpose([late_and_fast(step) for step in steps])
    assert all(len(t) == 2 for t, _ in exact)
    assert measured_order(steps, late) == pytest.approx(6.0, abs=0.1), late
    assert measured_order(steps, fast) == pytest.approx(6.0, abs=0.1), fast


class TestSteppers:
    @pytest.mark.parametrize("stepper", [BLANES_MOAN_RKN, BLANES_MOAN_GENERAL])
    def test_coefficients_are_consistent_and_palindromic(self, stepper):
        assert stepper.kicks.sum() == pytest.approx(1.0, abs=1e-15)
        assert stepper.drifts.sum() == pytest.approx(1.0, abs=1e-15)
        np.testing.assert_array_equal(stepper.kicks, stepper.kicks[::-1])
        np.testing.assert_array_equal(stepper.drifts, stepper.drifts[::-1])
        np.testing.assert_allclose(stepper.nodes, np.cumsum(stepper.drifts), atol=1e-15)
        assert len(stepper.kicks) == len(stepper.drifts) + 1

    @pytest.mark.parametrize("stepper", [BLANES_MOAN_RKN, BLANES_MOAN_GENERAL])
    def test_order_conditions_of_quadratures(self, stepper):
        # The kicks are a quadrature at nodes c: sum b c^k = 1/(k + 1) up to the order, which a
        # force that depends on time alone needs.
        c = np.concatenate([[0.0], stepper.nodes])
        for k in range(stepper.order):
            assert (stepper.kicks * c**k).sum() == pytest.approx(1.0 / (k + 1), abs=2e-13), k
        # And of double integrals: sum b (1 - c) c^k = 1/((k + 1)(k + 2)).
        for k in range(stepper.order - 1):
            result = (stepper.kicks * (1.0 - c) * c**k).sum()
            assert result == pytest.approx(1.0 / ((k + 1) * (k + 2)), abs=2e-13), k

    @pytest.mark.parametrize("stepper", [BLANES_MOAN_RKN, BLANES_MOAN_GENERAL])
    def test_order_on_the_harmonic_oscillator(self, stepper):
        # Product of shear matrices against the rotation: the local error goes as h^7.
        steps = 0.8 * 2.0 ** (-np.arange(5) / 2.0)
        errors = []
        for h in steps:
            flow = np.eye(2)
            for b, a in zip(stepper.kicks, [*stepper.drifts, 0.0], strict=True):
                flow = np.array([[1.0, 0.0], [-b * h, 1.0]]) @ flow
                flow = np.array([[1.0, a * h], [0.0, 1.0]]) @ flow
            exact = np.array([[math.cos(h), math.sin(h)], [-math.sin(h), math.cos(h)]])
            errors.append(np.abs(flow - exact).max())
            assert np.linalg.det(flow) == pytest.approx(1.0, abs=1e-14)
        assert measured_order(steps, errors) == pytest.approx(7.0, abs=0.1)

    def test_nonlinear_drag_gets_the_general_method(self):
        assert choose_stepper(ll.Pendulum(length=1, mass=1, damping=0.1)) is BLANES_MOAN_RKN
        for law in ("quadratic_damping", "coulomb_damping"):
            system = ll.Pendulum(length=1, mass=1, **{law: 0.1})
            assert choose_stepper(system) is BLANES_MOAN_GENERAL
        ball, rough = ll.Ball(length=1, mass=1), ll.Ball(length=1, mass=1, coulomb_damping=0.1)
        assert choose_stepper(ll.BallPair(right=ball, left=rough)) is BLANES_MOAN_GENERAL
