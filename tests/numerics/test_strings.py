"""Balls on strings against independent programs, the energy ledger, and the order of the step.

`string_balls` is one such program, SciPy's DOP853 at 1e-13. `tests/reference/strings.json` holds
motions of another one, which is not in this repository.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import latolato as ll
from string_balls import LEDGER, Body, Strings
from string_motions import (
    CASES,
    MOTIONS,
    PAIRS,
    TOYS,
    any_ball,
    any_pair,
    any_toy,
    assert_agree,
    read,
    rows,
    simulated,
    total,
)  # fmt: skip


class TestReferences:
    """Both programs hold the file's motions; stated there: repeated values agree to 5e-12."""

    @pytest.fixture(params=CASES)
    def case(self, request):
        return CASES[request.param]

    def check(self, samples, case, bound):
        for i, name in enumerate(("angle", "distance", "slack")):
            if name in samples:  # a rod's run has an angle only
                np.testing.assert_allclose(
                    np.squeeze(samples[name]),
                    [row[i] for row in case["samples"]],
                    rtol=0,
                    atol=bound,
                )

    def test_the_independent_program(self, case):
        motion, start, times = read(case)
        result = motion.run(start, times)
        self.check(result.samples, case, 1e-10)
        assert [e.kind for e in result.events] == [row[1] for row in case["events"]]
        np.testing.assert_allclose(
            [e.time for e in result.events], [row[0] for row in case["events"]], atol=1e-10
        )

    def test_latolato(self, case):
        run = simulated(*read(case))
        self.check(run, case, 1e-9)
        for kind in ("bottom", "slack", "taut"):
            listed = [row[0] for row in case["events"] if row[1] == kind and row[0] > 1e-12]
            np.testing.assert_allclose(rows(run, kind), listed, rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("string", [False, True])
def test_the_independent_impact_of_equal_lengths_is_the_rods(string, seed):
    rng = np.random.default_rng(seed)
    bodies = [Body(0.3, rng.uniform(0.05, 0.2), r=0.03) for _ in range(2)]
    e, turn, apart = rng.uniform(0.0, 1.0), rng.uniform(-3.0, 3.0), 2.0 * math.asin(0.1)
    w2, closing = rng.uniform(5.0, 9.0), rng.uniform(0.1, 5.0)
    top = bool(rng.integers(2))
    start = [(turn + (math.tau - apart if top else apart), w2 + (closing if top else -closing))]
    start.append((turn, w2))
    event = Strings(bodies, string=string, e=e).run(start, [1e-6]).events[0]
    (v1, _), (v2, _) = event.after
    i1, i2 = (b.m * b.l**2 for b in bodies)
    mean = (i1 * start[0][1] + i2 * w2) / (i1 + i2)
    rebound = e * (start[0][1] - w2) / (i1 + i2)
    assert event.kind == ("top" if top else "bottom")
    # Angles of several radians are rounded to 1e-15, velocities are ten.
    assert (v1, v2) == pytest.approx((mean - i2 * rebound, mean + i1 * rebound), rel=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_the_independent_impact_gains_nothing_and_stretches_no_string(seed):
    rng = np.random.default_rng(seed)
    # l1^2 - l2^2 > (r1 + r2)^2: the line of centres points up the shorter string.
    bodies = [Body(l, rng.uniform(0.05, 0.2), r=0.03) for l in (0.3, rng.uniform(0.25, 0.29))]
    l1, l2 = (b.l for b in bodies)
    apart = math.acos((l1**2 + l2**2 - 0.06**2) / (2.0 * l1 * l2))
    turn, w2 = rng.uniform(-1.0, 1.0), rng.uniform(5.0, 9.0)
    start = [(turn + apart, w2 - rng.uniform(0.1, 5.0)), (turn, w2)]
    motion = Strings(bodies, e=rng.uniform(0.0, 1.0))
    result = motion.run(start, [1e-9])
    hit = next(event for event in result.events if event.kind == "bottom")

    def plane(ball, velocities):
        """Return position and velocity in the plane."""
        (th, _), l, (w, out) = start[ball], bodies[ball].l, velocities[ball]
        along, across = (
            np.array([math.sin(th), -math.cos(th)]),
            np.array([math.cos(th), math.sin(th)]),
        )
        return l * along, l * w * across + out * along

    def seen(velocities):
        """Return the speed at which the balls part and the kinetic energy."""
        (p1, u1), (p2, u2) = (plane(ball, velocities) for ball in (0, 1))
        energy = sum(0.5 * b.m * u @ u for b, u in zip(bodies, (u1, u2), strict=True))
        return (p1 - p2) @ (u1 - u2) / 0.06, energy

    (before, first), (after, last) = seen(hit.before), seen(hit.after)
    assert after == pytest.approx(-motion.e * before, abs=1e-12)
    assert last <= first
    assert first - last == pytest.approx(result.samples["impact_loss"][-1], abs=1e-14)
    assert all(out <= 1e-14 for _, out in hit.after)
    assert hit.after[1][1] < 0.0


@pytest.mark.parametrize("make, seed, end", MOTIONS)
def test_motions_works_and_losses_are_those_of_the_independent_program(make, seed, end):
    # None of these multiplies a deviation of the start by more than a hundred.
    motion, start = make(np.random.default_rng(seed))
    times = np.linspace(0.0, end, 41)
    run = simulated(motion, start, times)
    assert_agree(run, motion.run(start, times), 1e-8)
    assert run.attrs["status"] == "complete"


class TestLedger:
    # With other strings a ball of a pair may meet the other's string, which ends the run.
    @pytest.mark.filterwarnings("ignore:the run stopped")
    @pytest.mark.parametrize("seed", range(8))
    @pytest.mark.parametrize("make", [any_ball, any_toy, any_pair])
    @pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
    def test_it_closes_to_1e_9_of_the_largest_energy(self, make, seed, restitution):
        if make is any_pair:
            seed = PAIRS[seed]
        motion, start = make(np.random.default_rng(seed))
        motion.es = restitution
        run = simulated(motion, start, np.linspace(0.0, 0.7, 71), tolerance=1e-10)
        energy, expected = total(run)
        largest = np.nanmax(np.abs(energy))
        assert np.isfinite(energy).sum() > 30
        assert np.nanmax(np.abs(energy - expected)) <= 1e-9 * largest
        assert run.attrs["energy_residual"] <= 1e-9 * largest

    @pytest.mark.parametrize("frame", ["pivot", "lab"])
    def test_it_closes_with_friction_at_the_hinge(self, frame):
        # Friction vanishes while slack.
        system = ll.Pendulum(
            length=0.3, mass=0.1, damping=1e-3, coulomb_damping=0.02, suspension="string",
            drag_frame=frame,
        )  # fmt: skip
        drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=12.0)
        run = ll.simulate(
            system, drive, initial_angle=1.0, initial_angular_velocity=7.0, duration=3.0
        )
        energy, expected = total(run)
        assert (run.slack == 1).any()
        assert np.abs(energy - expected).max() <= 1e-9 * np.abs(energy).max()

    @pytest.mark.parametrize("seed", range(4))
    def test_powers_are_the_rates_of_the_works(self, seed):
        # Differences of order 4 over 1e-4 s at some 20 rad/s: (w h)^4 = 2e-11 of the rates.
        motion, start = any_ball(np.random.default_rng(seed))
        times = np.linspace(0.0, 0.2, 2001)
        run = simulated(motion, start, times)
        smooth = np.ones(1997, dtype=bool)
        for event in run.contact_time.values:
            smooth &= np.abs(times[2:-2] - event) > 3e-4
        assert smooth.sum() > 1000
        for work, power in (("drive_work", "drive_power"), ("damping_loss", "damping_power")):
            w, p = run[work].values, run[power].values
            rate = (8.0 * (w[3:-1] - w[1:-3]) - (w[4:] - w[:-4])) / 12e-4
            error = np.abs(rate - p[2:-2])[smooth].max()
            assert error <= 1e-8 * max(np.abs(p).max(), 1e-3)

    def test_elastic_strings_keep_the_energy(self):
        system = ll.Pendulum(length=0.3, mass=0.1, suspension="string", string_restitution=1.0)
        run = ll.simulate(system, initial_angle=1.1, initial_angular_velocity=9.0, duration=10.0)
        assert len(run.contact) > 10
        energy, _ = total(run)
        assert float(run.retension_loss.max()) == 0.0
        # The ledger's bound.
        np.testing.assert_allclose(energy, energy[0], rtol=1e-9)

    def test_chattering_strings_are_captured_and_their_energy_is_booked(self):
        system = ll.Pendulum(length=0.3, mass=0.1, suspension="string", string_restitution=0.5)
        times = np.linspace(0.0, 1.0, 201)
        run = ll.simulate(
            system, initial_angle=0.0, initial_distance=0.1, times=times, tolerance=1e-12
        )
        # A fall through 0.2 m, then hops that halve: at rest after t (1 + 2 (1/2 + 1/4 + ...)).
        fall = math.sqrt(2.0 * 0.2 / 9.8)
        assert (run.slack.values == (times < 3.0 * fall)).all()
        assert float(run.retension_loss[-1]) == pytest.approx(0.1 * 9.8 * 0.2, rel=1e-12)
        assert float(run.total_energy[-1]) == pytest.approx(0.0, abs=1e-14)
        assert run.attrs["slack_fraction"] == pytest.approx(3.0 * fall, rel=1e-6)
        impulse = 1.5 * 0.1 * math.sqrt(2.0 * 9.8 * 0.2)
        assert run.attrs["largest_string_impulse"] == pytest.approx(impulse, rel=1e-12)


class TestPair:
    @pytest.mark.parametrize("seed", TOYS)
    def test_equal_balls_are_the_mirrored_toy(self, seed):
        motion, start = any_toy(np.random.default_rng(seed))
        times = np.linspace(0.0, 1.0, 41)
        toy = simulated(motion, start, times)
        mirrored = [tuple(x) for x in (start[0], [-start[0][0], -start[0][1], *start[0][2:]])]
        two = replace(motion, walls=False, bodies=motion.bodies * 2)
        pair = simulated(two, mirrored, times)
        for name in ("angle", "distance", "slack", "kinetic_energy"):
            np.testing.assert_allclose(pair[name][0], toy[name], rtol=0, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(pair.angle[1], -toy.angle, rtol=0, atol=1e-9)
        for name in LEDGER:
            np.testing.assert_allclose(pair[name], 2.0 * toy[name], rtol=0, atol=1e-9)
        for kind in ("bottom", "top", "slack"):
            expected = np.repeat(rows(toy, kind), 2 if kind == "slack" else 1)
            np.testing.assert_allclose(rows(pair, kind), expected, rtol=0, atol=1e-9)

    # At a coarse tolerance the ball is past the string at the end of the step, or long in it.
    @pytest.mark.filterwarnings("ignore:the run stopped")
    @pytest.mark.parametrize("seed", [45, 64, 100, 212])
    def test_a_ball_that_brushes_a_string_ends_the_run_where_they_meet(self, seed):
        motion, start = any_pair(np.random.default_rng(seed))
        coarse, fine = (
            simulated(motion, start, [0.0, 2.0], tolerance=tolerance).attrs["status"]
            for tolerance in (1e-6, 1e-12)
        )
        assert "a string ran into a ball" in fine
        # Both have the time to nine digits; that of the coarse run is as wrong as its motion.
        times = [float(status.partition("t = ")[2].split()[0]) for status in (coarse, fine)]
        assert times[0] == pytest.approx(times[1], abs=1e-6)


class TestObservables:
    NAMES = ("slack_fraction", "first_slack", "largest_string_impulse", "top_contacts")

    @pytest.mark.parametrize("restitution", [0.0, 0.6])
    @pytest.mark.parametrize("kind", ["pendulum", "toy", "pair"])
    def test_a_sweep_is_the_run_at_each_point(self, kind, restitution):
        own = {"suspension": "string", "string_restitution": restitution}
        ball = {"length": 0.22, "mass": 0.06, "damping": 1e-3}
        start = {"initial_angle": 1.2, "initial_angular_velocity": 9.0}
        names = list(self.NAMES)
        if kind == "pendulum":
            system = ll.Pendulum(**ball, **own)
            names.remove("top_contacts")
        elif kind == "toy":
            system = ll.LatoLato(**ball, radius=0.02, restitution=0.85, **own)
        else:
            each = ll.Ball(**ball, radius=0.02)
            system = ll.BallPair(right=each, left=each, restitution=0.85, **own)
            start = {"initial_angle": (1.2, -0.9), "initial_angular_velocity": (6.0, -6.0)}
        # Driven harder, some pairs come to what is not described.
        amplitudes = np.linspace(0.0, 0.03 if kind == "pair" else 0.09, 4)
        axes = {"drive_amplitude": amplitudes, "drive_frequency": [12.0, 15.0, 18.0]}
        drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=15.0)
        result = ll.sweep(
            system, drive, axes=axes, observables=names, duration=0.6, tolerance=1e-12, **start
        ).transpose("drive_amplitude", "drive_frequency", ...)
        assert float(result.slack_fraction.max()) > 0.0
        for i, amplitude in enumerate(amplitudes):
            for k, frequency in enumerate(axes["drive_frequency"]):
                one = ll.Harmonic(drive_amplitude=amplitude, drive_frequency=frequency)
                run = ll.simulate(system, one, duration=0.6, tolerance=1e-12, **start)
                here = result.isel(drive_amplitude=i, drive_frequency=k)
                # Lanes and single runs round differently; these motions are short.
                for name in names[:3]:
                    np.testing.assert_allclose(
                        here[name], run.attrs[name], rtol=0, atol=1e-9, err_msg=name
                    )
                if "top_contacts" in names:
                    assert (here.top_contacts == int((run.contact_kind == "top").sum())).all()

    def test_slack_fraction_is_the_share_of_slack_time(self):
        motion, start = any_ball(np.random.default_rng(2))
        run = simulated(motion, start, np.linspace(0.0, 1.0, 100_001))
        times, kinds = run.contact_time.values, run.contact_kind.values
        counted = sum(
            (1.0 if kind == "taut" else -1.0) * time
            for time, kind in zip(times, kinds, strict=True)
            if time > 0.0
        )
        counted += float(run.slack[-1])
        assert run.attrs["slack_fraction"] == pytest.approx(counted, abs=1e-12)
        # Each event misses or adds less than the distance of two samples.
        assert run.attrs["slack_fraction"] == pytest.approx(
            float(run.slack.mean()), abs=1e-5 * (len(times) + 1)
        )


class TestOrder:
    """The step has order 6 in flight too, and so have the instants at which strings change.

    The works of a pivot that moves sideways have order 4.

    Errors are geometric means over many starts of the distance to the independent program.
    """

    TOLERANCES = np.geomspace(1e-4, 1e-8, 7)

    def order(self, error_of):
        """Return the slope of log(error) over log(step)."""
        steps, errors = zip(*[error_of(tolerance) for tolerance in self.TOLERANCES], strict=True)
        return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])

    @pytest.mark.parametrize("drag", [{"C": 2e-2}, {"C": 1e-2, "C2": 0.1}])
    def test_of_the_slack_step(self, drag):
        # Little gravity, a fast drive and a long string: many steps before it is taut. The ball is
        # fast, as quadratic drag bends where it is at rest in the pivot's frame.
        motions = [
            Strings(
                [Body(3.0, 0.05, **drag)], A0=0.01, w=25.0, phase=0.4 * k, Ax=0.007, phx=0.3,
                g=0.2, lab=k % 2 == 0 and "C2" not in drag,
            )
            for k in range(12)
        ]  # fmt: skip
        times = np.linspace(0.2, 1.0, 17)
        start = [(0.4, 3.0, 0.5)]
        exact = [motion.run(start, times).samples for motion in motions]
        assert all(samples["slack"].all() for samples in exact)

        def error_of(tolerance):
            errors = []
            for motion, samples in zip(motions, exact, strict=True):
                run = simulated(motion, start, times, tolerance=tolerance)
                gap = run.distance - samples["distance"][0]
                errors.append(float(np.sqrt((gap**2).mean())))
            return run.attrs["step"], np.exp(np.mean(np.log(errors)))

        assert self.order(error_of) == pytest.approx(6.0, abs=0.1)

    @pytest.mark.parametrize(
        "direction, expected", [("vertical_amplitude", 6.0), ("horizontal_amplitude", 4.0)]
    )
    def test_of_the_works(self, direction, expected):
        amplitudes = {"vertical_amplitude": 0.0, "horizontal_amplitude": 0.0, direction: 0.07}
        drive = ll.PlanarHarmonic(**amplitudes, drive_frequency=14.0)
        rod = ll.Pendulum(length=1.0, mass=1.0)

        def error_of(tolerance):
            run = ll.simulate(rod, drive, initial_angle=1.0, duration=5.0, tolerance=tolerance)
            return run.attrs["step"], run.attrs["energy_residual"]

        assert self.order(error_of) == pytest.approx(expected, abs=0.2)

    def test_of_slack_and_taut(self):
        starts = [(1.0 + 0.05 * k, 7.0) for k in range(16)]
        motion = Strings([Body(0.3, 0.1, C=2e-3)], A0=0.004, w=40.0, phase=0.4)
        times = np.array([0.5, 1.0])
        exact = [motion.run([start], times).events[:2] for start in starts]
        assert all([event.kind for event in two] == ["slack", "taut"] for two in exact)

        def error_of(tolerance):
            errors = []
            for start, two in zip(starts, exact, strict=True):
                run = simulated(motion, [start], times, tolerance=tolerance)
                late = run.contact_time.values[:2] - [event.time for event in two]
                errors.append(np.abs(late) + 1e-16)
            return run.attrs["step"], np.exp(np.mean(np.log(errors), axis=0))

        steps, errors = zip(*[error_of(tolerance) for tolerance in self.TOLERANCES], strict=True)
        for each in np.transpose(errors):
            slope = float(np.polyfit(np.log(steps), np.log(each), 1)[0])
            assert slope == pytest.approx(6.0, abs=0.5)


def test_air_at_rest_in_the_room_turns_two_unlike_balls_as_one():
    # Their drag per moment of inertia differs twentyfold; SciPy adds both torques.
    right, left = (
        ll.Ball(length=l, mass=m, radius=0.03, damping=c)
        for l, m, c in ((0.3, 0.1, 0.02), (0.29, 0.2, 0.001))
    )
    pair = ll.BallPair(right=right, left=left, restitution=0.0, drag_frame="lab")
    ax, ay, w, phase = 0.04, 0.03, 6.0, 0.4
    drive = ll.PlanarHarmonic(
        vertical_amplitude=ay, horizontal_amplitude=ax, drive_frequency=w, horizontal_phase=phase
    )
    apart, begin, times = pair.contact_separation, 0.3, np.linspace(0.0, 1.5, 31)
    run = ll.simulate(
        pair, drive, initial_angle=(begin + apart, begin), times=times, tolerance=1e-12
    )
    np.testing.assert_allclose(run.angle[0] - run.angle[1], apart, rtol=0, atol=1e-12)

    def slopes(t, state):
        (angle, velocity), inertia, torque = state, 0.0, 0.0
        x, y = -ax * w * w * math.cos(w * t + phase), -ay * w * w * math.cos(w * t)
        u, v = -ax * w * math.sin(w * t + phase), -ay * w * math.sin(w * t)
        for ball, q in ((right, angle + apart), (left, angle)):
            m, l, c, s = ball.mass, ball.length, math.cos(q), math.sin(q)
            inertia += m * l * l
            torque -= m * l * ((9.8 + y) * s + x * c) + ball.damping * (
                l * velocity + u * c + v * s
            )
        return [velocity, torque / inertia]

    exact = solve_ivp(slopes, (0.0, 1.5), [begin, 0.0], t_eval=times, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(run.angle[1], exact.y[0], rtol=0, atol=1e-10)


def test_quadratic_drag_is_resolved_where_a_falling_ball_nearly_stops():
    # Starts a millionth of a radian apart end on a parabola, to rounding.
    system = ll.Pendulum(length=1.0, mass=0.8, quadratic_damping=0.05, suspension="string")
    drive = ll.Harmonic(drive_amplitude=0.10413436925839377, drive_frequency=5.303049059197439)
    shifts = np.arange(-10, 11)
    ends = [
        ll.simulate(
            system, drive, initial_angle=-0.41465962 + 1e-6 * k,
            initial_angular_velocity=4.91316647, duration=1.379, tolerance=1e-12,
        ).angle.values[-1]
        for k in shifts
    ]  # fmt: skip
    off = ends - np.polyval(np.polyfit(shifts, ends, 2), shifts)
    assert np.abs(off).max() < 1e-12


HUNG = {"length": 1.0, "mass": 1.0, "suspension": "string"}
STRONG = ll.Harmonic(drive_amplitude=0.1, drive_frequency=12.0)


@pytest.mark.parametrize(
    "toy, start",
    [
        (ll.LatoLato(**HUNG, radius=0.1, coulomb_damping=1.0), {"initial_offset": 0.0}),
        (ll.LatoLato(**HUNG, radius=0.0, restitution=0.5), {"initial_angle": 0.0}),
    ],
    ids=["held by friction", "on a wall of zero radius"],
)
def test_a_resting_ball_leaves_a_string_that_would_push(toy, start):
    run = ll.simulate(toy, STRONG, **start, duration=3.0)
    taut = run.slack.values == 0
    assert run.tension.values[taut].min() > -1e-9  # of 24 N; rounding of the event's instant
    assert (run.contact_kind == "slack").sum() == 6


def test_an_elastic_string_comes_to_rest_between_walls_that_take_energy():
    toy = ll.LatoLato(**HUNG, radius=0.1, restitution=0.5, string_restitution=1.0)
    run = ll.simulate(toy, initial_angle=0.3, initial_distance=0.9, duration=60.0)
    assert run.attrs["status"] == "complete"
    assert run.slack.values[-1] == 0


def test_two_balls_that_friction_holds_together_let_go_where_a_string_would_push():
    ball = ll.Ball(length=1.0, mass=1.0, coulomb_damping=1.0, radius=0.1)
    pair = ll.BallPair(right=ball, left=ball, restitution=0.0, suspension="string")
    start = (0.15, 0.15 - pair.contact_separation)
    run = ll.simulate(pair, STRONG, initial_angle=start, duration=3.0)
    assert run.attrs["status"] == "complete"


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("above", [1e-12, 1.1e-11, 1e-9, 1e-8, 1.3e-8, 1e-6])
def test_a_ball_let_go_just_above_the_horizontal_hops_too_little_to_be_seen(above, restitution):
    string = ll.Pendulum(**HUNG, string_restitution=restitution)
    start = {"initial_angle": 0.5 * math.pi + above, "duration": 3.0, "tolerance": 1e-10}
    run = ll.simulate(string, **start, contact_limit=1000)
    rod = ll.simulate(replace(string, suspension="rod", string_restitution=0.0), **start)
    assert run.attrs["status"] == "complete"
    # The hop lasts 0.6 ms at most and takes what the rod's motion has there.
    assert np.abs(run.angle.values - rod.angle.values).max() < 10.0 * above + 1e-9
