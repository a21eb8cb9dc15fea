"""Resting contact: it lasts as long as it must, ends at the exact phase, and closes the ledger."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

import latolato as ll

G = 9.8


def toy(**arguments):
    return ll.LatoLato(**{"length": 1.0, "mass": 0.8, "radius": 0.1, **arguments})


def harmonic(ratio, frequency=8.0, phase=0.0):
    """A drive whose largest acceleration is `ratio` times gravity."""
    return ll.Harmonic(
        drive_amplitude=ratio * G / frequency**2, drive_frequency=frequency, drive_phase=phase
    )


def rows(run):
    """The contact table as (kind, time, before, after)."""
    return list(
        zip(
            run.contact_kind.values,
            run.contact_time.values,
            run.angular_velocity_before.values,
            run.angular_velocity_after.values,
            strict=True,
        )
    )


def check_table(run, system):
    """Rows follow each other as events can, with the velocities that belong to their kind."""
    times = run.contact_time.values
    assert np.all(np.diff(times) >= 0.0)
    assert np.all((times >= 0.0) & (times <= run.attrs["duration"]))
    e, slow = system.restitution, run.attrs["rest_speed"]
    resting = None
    for i, (kind, t, before, after) in enumerate(rows(run)):
        where = (i, kind, t, before, after)
        if kind == "release":
            assert before == 0.0, where
            assert resting or i == 0, where
            resting = False
            continue
        assert not resting, where
        if kind == "rest":
            assert after == 0.0, where
            assert abs(before) <= slow, where
            resting = True
        else:
            outward = 1.0 if kind == "bottom" else -1.0
            assert before * outward <= 0.0, where
            assert after == pytest.approx(-e * before, rel=1e-15), where


def check_ledger(run, bound=1e-9):
    scale = max(float(run.total_energy.max()), 1e-12)
    assert run.attrs["energy_residual"] <= bound * scale
    balance = (
        run.total_energy
        - run.total_energy[0]
        - run.drive_work
        + run.damping_loss
        + run.impact_loss
        + run.capture_loss
    )
    # Sample zero lies after an impact at time zero, whose losses are booked by then.
    balance = balance - balance[0]
    assert float(np.abs(balance).max()) <= bound * scale
    for name in ("damping_loss", "impact_loss", "capture_loss"):
        assert np.all(np.diff(run[name].values) >= -1e-13 * scale), name


class TestRestAtTheBottom:
    @pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
    @pytest.mark.parametrize("ratio", [0.0, 0.5, 0.8, 1.0 - 1e-12])
    def test_nothing_moves_while_the_pivot_falls_slower_than_gravity(self, ratio, restitution):
        system = toy(damping=0.02, restitution=restitution)
        run = ll.simulate(system, harmonic(ratio), initial_offset=0.0, duration=60.0)
        assert np.all(run.angle.values == system.contact_angle_low)
        assert np.all(run.angular_velocity.values == 0.0)
        assert np.all(run.drive_work.values == 0.0)
        assert "release" not in run.contact_kind.values

    def test_fig4_as_printed_is_a_constant_line(self):
        for amplitude in (0.2, 0.02):
            drive = ll.Harmonic(drive_amplitude=amplitude, drive_frequency=6.26)
            run = ll.simulate(toy(damping=0.02), drive, initial_offset=0.0, duration=100.0)
            assert np.all(run.angle.values == math.asin(0.1))

    @pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
    @pytest.mark.parametrize("ratio", [1.001, 1.1, 2.0, 50.0])
    @pytest.mark.parametrize("phase", [math.pi, 0.5 * math.pi, -2.5])
    def test_ball_lifts_off_at_the_exact_phase(self, ratio, phase, restitution):
        # Rest ends where A0 w^2 cos(w t + phase) = g while rising.
        drive = harmonic(ratio, phase=phase)
        angle = -math.acos(1.0 / ratio)
        turns = math.ceil((phase - angle) / (2.0 * math.pi))
        exact = (angle + 2.0 * math.pi * turns - phase) / drive.drive_frequency
        run = ll.simulate(toy(restitution=restitution), drive, initial_offset=0.0, duration=3.0)
        kind, t, before, after = rows(run)[0]
        assert (kind, before, after) == ("release", 0.0, 0.0)
        # At ratio 1.001 the hold's slope is small: rounding of the cosine moves its zero.
        slope = math.sqrt(ratio**2 - 1.0) / ratio * drive.drive_frequency
        assert t == pytest.approx(exact, abs=1e-14 / slope + 2e-15)
        still = run.time.values <= exact
        assert np.all(run.angle.values[still] == math.asin(0.1))
        assert float(run.angle.max()) > math.asin(0.1)
        check_ledger(run)
        check_table(run, toy(restitution=restitution))

    def test_lift_off_at_time_zero_needs_no_rest(self):
        run = ll.simulate(toy(), harmonic(2.0), initial_offset=0.0, duration=1.0)
        first = run.angle.values[1:20]
        assert np.all(np.diff(first) > 0.0)

    @pytest.mark.parametrize("excess", [1e-3, 1e-5, 1e-7, 1e-9, 1e-12])
    @pytest.mark.parametrize("phase", [0.0, 1.0, math.pi])
    @pytest.mark.parametrize("restitution", [0.0, 0.6])
    def test_drive_that_only_just_exceeds_gravity(self, excess, phase, restitution):
        # The lift lasts for acos(1/(1 + excess)) only; its height goes as excess^2: the run must
        # go on, release and rest in turn, in order of time, and never go below the wall.
        system = toy(restitution=restitution)
        run = ll.simulate(
            system,
            harmonic(1.0 + excess, phase=phase),
            initial_offset=0.0,
            duration=5.0,
            contact_limit=2000,
        )
        assert run.attrs["status"] == "complete"
        check_table(run, system)
        check_ledger(run)
        assert float(run.angle.min()) >= system.contact_angle_low
        # At most a few rows in each of the 6.4 drive periods, not a rattle of rounding errors.
        assert run.sizes["contact"] < 7 * 40
        # Fall from the height that the lift gives: below 2 pi excess of the gravity's angle.
        assert float(run.angle.max()) - system.contact_angle_low < 10.0 * excess

    @pytest.mark.parametrize("excess", [1e-5, 1e-6, 1e-7])
    @pytest.mark.parametrize("balls", [1, 2])
    def test_lift_off_shorter_than_a_step_is_seen_at_its_exact_phase(self, excess, balls):
        # g is exceeded for 2 acos(1/(1 + excess))/w, at most 1.2 ms, at the eighth of a turn; the
        # quarter of a step at which rest is looked at is 3.4 ms, a step 13 ms, and the instant
        # moves through such a quarter. (A lift of 1e-9 g moves the ball by less than the digits
        # of its angle: no release.)
        one = toy(restitution=0.6)
        low, ball = one.contact_angle_low, one.balls[0]
        pair = ll.BallPair(right=ball, left=ball, restitution=0.6)
        for share in np.arange(8) / 8.0:
            phase = 0.25 * math.pi + share * 3.4e-3 * 8.0
            run = ll.simulate(
                one if balls == 1 else pair,
                harmonic(1.0 + excess, phase=-phase),
                initial_angle=low if balls == 1 else (low, -low),
                duration=0.12,
            )
            assert "release" in run.contact_kind.values
            first = run.contact_time.values[run.contact_kind.values == "release"][0]
            exact = (phase - math.acos(1.0 / (1.0 + excess))) / 8.0
            # Some roundings of the acceleration, over its slope near the largest fall.
            assert first == pytest.approx(exact, abs=2e-15 / (math.sqrt(2.0 * excess) * 8.0))

    def test_visible_motion_from_rest_needs_a_little_more_than_g(self):
        # PHYSICS section 3: about 1.04 for e = 1: just above 1 an elastic ball still rattles low.
        drive = harmonic(1.5, frequency=6.0)
        run = ll.simulate(toy(restitution=0.9), drive, initial_offset=0.0, duration=60.0)
        assert float(run.angle.max()) > 0.3

    @pytest.mark.parametrize("kind", ["crank", "schedule", "chirp", "measured"])
    def test_lift_off_of_other_drives(self, kind):
        w = 8.0
        a = 1.3 * G / w**2
        t = np.arange(0.0, 4.01, 0.02)
        drive = {
            "crank": ll.CrankSlider(
                drive_amplitude=a,
                drive_frequency=w,
                drive_phase=math.pi,
                connecting_rod_length=1.0,
                guide="above",
            ),
            "schedule": ll.FrequencySchedule(
                drive_amplitude=a, times=[0.0, 1.0], drive_frequencies=[4.0, w], ramp=0.5
            ),
            "chirp": ll.Chirp(
                drive_amplitude=a, drive_frequency=2.0, drive_frequency_final=w, sweep_time=3.0
            ),
            "measured": ll.MeasuredPivot(times=t, pivot_heights=-a * np.cos(w * t)),
        }[kind]
        system = toy(restitution=0.7)
        times = np.linspace(0.0, 4.0, 40_001)
        run = ll.simulate(system, drive, initial_offset=0.0, times=times)
        kind, lift, before, after = rows(run)[0]
        assert (kind, before, after) == ("release", 0.0, 0.0)
        # The pivot's own acceleration passes -g there, for the first time.
        above = run.pivot_acceleration.values + G
        first = int(np.argmax(above < 0.0))
        assert times[first - 1] <= lift <= times[first]
        assert np.interp(lift, times, above) == pytest.approx(0.0, abs=1e-4)
        check_table(run, system)
        check_ledger(run)

    def test_bound_between_the_samples_of_a_measured_pivot_is_seen(self):
        # Samples straddle the peaks: at the samples the fall is below g, in between above.
        w, t = 2.0 * math.pi, (np.arange(0, 60) - 0.5) / 6.0
        a = 1.05 * G / w**2
        pivot = ll.MeasuredPivot(times=t, pivot_heights=-a * np.cos(w * t))
        run = ll.simulate(toy(), pivot, initial_offset=0.0, duration=8.0)
        assert float(run.pivot_acceleration.min()) < -G
        assert "release" in run.contact_kind.values


class TestRestAtTheTop:
    def test_ball_rests_at_the_top_while_the_pivot_falls_faster_than_gravity(self):
        system = toy()
        drive = harmonic(2.0)  # cos(w t) > 1/2 at the start
        run = ll.simulate(
            system, drive, initial_angle=system.contact_angle_high, duration=1.0, tolerance=1e-12
        )
        kind, t, before, after = rows(run)[0]
        assert (kind, before, after) == ("release", 0.0, 0.0)
        assert t == pytest.approx(math.acos(0.5) / 8.0, abs=1e-14)
        still = run.time.values < t
        assert np.all(run.angle.values[still] == system.contact_angle_high)
        assert float(run.angle[-1]) < system.contact_angle_high

    def test_ball_falls_from_the_top_when_the_pivot_stands(self):
        system = toy()
        run = ll.simulate(system, initial_angle=system.contact_angle_high, duration=1.0)
        assert np.all(np.diff(run.angle.values) < 0.0)
        assert "rest" not in run.contact_kind.values

    def test_plastic_impact_at_the_top_rests_and_is_released(self):
        # Thrown upwards against the top wall while the pivot falls faster than gravity.
        system = toy(restitution=0.0)
        drive = harmonic(3.0, frequency=5.0, phase=-0.3)
        run = ll.simulate(
            system, drive, initial_angle=2.9, initial_angular_velocity=4.0, duration=1.0
        )
        kinds = [row[0] for row in rows(run)[:3]]
        assert kinds == ["top", "rest", "release"]
        exact = (math.acos(1.0 / 3.0) + 0.3) / 5.0
        assert rows(run)[2][1] == pytest.approx(exact, abs=1e-14)
        check_table(run, system)
        check_ledger(run)


def accumulation_time(e, start, low, length=1.0):
    """Fall and all bounces until rest, undriven and undamped, by quadrature of the exact motion."""

    def swing(top):
        # Time from `top` to the wall: dt = dth / sqrt(2 g/l (cos th - cos top));
        # th = top - (top - low) sin^2 takes the root away.
        def slope(s):
            below = (top - low) * math.sin(s) ** 2
            drop = 2.0 * math.sin(top - 0.5 * below) * math.sin(0.5 * below)
            return (top - low) * math.sin(2.0 * s) / math.sqrt(2.0 * G / length * drop)

        return quad(slope, 0.0, 0.5 * math.pi, epsabs=0.0, epsrel=1e-12)[0]

    total = swing(start)
    energy = math.cos(low) - math.cos(start)
    for _ in range(10_000):
        energy *= e * e
        if energy < 1e-13:
            # Flat bounces: t = 2 v/(g sin low), v geometric.
            v = math.sqrt(2.0 * G / length * energy)
            return total + 2.0 * v / (G / length * math.sin(low)) / (1.0 - e)
        top = brentq(lambda x, e=energy: math.cos(low) - math.cos(x) - e, low, start, xtol=1e-15)
        total += 2.0 * swing(top)
    raise AssertionError


class TestZenoCascade:
    def test_accumulation_time_of_the_papers_toy(self):
        system = toy(restitution=0.6)
        run = ll.simulate(system, initial_angle=0.5 * math.pi, duration=10.0)
        *_, last = rows(run)
        assert last[0] == "rest"
        # Capture at 1e-6 rad/s leaves out 2 v/(g sin low (1 - e)) of the infinite sum, 5e-6 s.
        exact = accumulation_time(0.6, 0.5 * math.pi, system.contact_angle_low)
        assert exact == pytest.approx(5.45806, abs=5e-6)
        assert last[1] == pytest.approx(exact, abs=6e-6)
        assert last[1] <= exact
        late = run.time.values > last[1]
        assert np.all(run.angle.values[late] == system.contact_angle_low)
        assert np.all(run.angular_velocity.values[late] == 0.0)
        check_table(run, system)
        check_ledger(run)

    def test_captured_energy_is_booked(self):
        system = toy(restitution=0.6)
        for rest_speed in (1e-6, 1e-3, 0.3):
            run = ll.simulate(
                system, initial_angle=0.5 * math.pi, duration=10.0, rest_speed=rest_speed
            )
            kind, _, before, after = rows(run)[-1]
            assert kind == "rest"
            assert after == 0.0
            assert 0.0 < abs(before) <= rest_speed
            captured = 0.5 * 0.8 * before**2
            assert float(run.capture_loss[-1]) == pytest.approx(captured, rel=1e-12)
            # All energy above the wall is gone, to impacts and capture.
            above = 0.8 * G * math.cos(system.contact_angle_low)
            gone = float(run.impact_loss[-1]) + float(run.capture_loss[-1])
            assert gone == pytest.approx(above, rel=1e-11)

    @settings(max_examples=15, deadline=None)
    @given(e=st.floats(0.05, 0.75), start=st.floats(0.3, 2.5), share=st.floats(0.05, 0.25))
    def test_accumulation_time_of_any_cascade(self, e, start, share):
        system = ll.LatoLato(length=1.0, mass=0.8, radius=share, restitution=e)
        exact = accumulation_time(e, start, system.contact_angle_low)
        run = ll.simulate(system, initial_angle=start, duration=1.5 * exact + 1.0)
        kind, t, _, _ = rows(run)[-1]
        missing = 2.0 * 1e-6 / (G * share * (1.0 - e))
        assert kind == "rest"
        assert exact - missing - 1e-8 <= t <= exact + 1e-8

    def test_cascade_ends_at_any_rest_speed(self):
        # Even 0: below the resolution of the angle the bounces end, or the contact limit says so.
        system = toy(restitution=0.6)
        for rest_speed in (1e-12, 1e-9):
            run = ll.simulate(
                system, initial_angle=0.5 * math.pi, duration=10.0, rest_speed=rest_speed
            )
            assert run.attrs["status"] == "complete"
            assert run.contact_kind.values[-1] == "rest"
            assert float(run.contact_time[-1]) == pytest.approx(5.458062, abs=2e-6)

    @pytest.mark.filterwarnings("ignore:the run stopped:RuntimeWarning")
    def test_rest_speed_of_zero_terminates(self):
        run = ll.simulate(
            toy(restitution=0.6),
            initial_angle=0.5 * math.pi,
            duration=6.0,
            rest_speed=0.0,
            contact_limit=5000,
        )
        assert run.attrs["status"] == "complete" or "contact_limit" in run.attrs["status"]

    def test_plastic_impact_rests_at_once(self):
        system = toy(restitution=0.0)
        run = ll.simulate(system, initial_angle=1.0, duration=3.0)
        assert [row[0] for row in rows(run)] == ["bottom", "rest"]
        first, second = rows(run)
        assert first[1] == second[1]
        speed = math.sqrt(2.0 * G * (math.cos(system.contact_angle_low) - math.cos(1.0)))
        assert first[2] == pytest.approx(-speed, rel=1e-11)
        assert float(run.impact_loss[-1]) == pytest.approx(0.4 * speed**2, rel=1e-11)
        assert float(run.capture_loss[-1]) == 0.0
        check_ledger(run)

    def test_elastic_ball_never_rests(self):
        run = ll.simulate(toy(), initial_offset=1e-6, duration=2.0)
        assert set(run.contact_kind.values) == {"bottom"}
        # Flat bounces: period 2 v/(g sin low), v = sqrt(2 g sin(low) offset).
        fall = math.sqrt(2.0 * 1e-6 / (G * 0.1))
        gaps = np.diff(run.contact_time.values)
        np.testing.assert_allclose(gaps, 2.0 * fall, rtol=1e-5)

    @pytest.mark.parametrize("restitution", [1.0, 0.999])
    @pytest.mark.parametrize("balls", [1, 2])
    def test_only_bounces_that_die_out_are_captured(self, balls, restitution):
        # From 1e-4 rad above the wall the ball comes back at sqrt(2 g sin(low) 1e-4) = 0.014 rad/s,
        # far below a rest speed of 1 rad/s: without loss it bounces on, with any loss it rests.
        one = toy(restitution=restitution)
        start, ball = one.contact_angle_low + 1e-4, one.balls[0]
        arguments = {"duration": 1.0, "rest_speed": 1.0}
        run = (
            ll.simulate(one, initial_angle=start, **arguments)
            if balls == 1
            else ll.simulate(
                ll.BallPair(right=ball, left=ball, restitution=restitution),
                initial_angle=(start, -start),
                **arguments,
            )
        )
        # A fall takes sqrt(2 1e-4/(g sin(low))) = 14.3 ms, so bounces are 28.6 ms apart.
        expected = ["bottom"] * 35 if restitution == 1.0 else ["rest"]
        assert list(run.contact_kind.values) == expected
        above = float((run.total_energy[..., 0] - run.total_energy[..., -1]).sum())
        assert float(run.capture_loss[-1]) == pytest.approx(above, abs=1e-13)
        assert (above > 1e-6) == (restitution < 1.0)

    def test_driven_cascade_rests_and_lifts_off_in_turn(self):
        system = toy(restitution=0.5)
        run = ll.simulate(system, harmonic(1.3, frequency=5.0), initial_angle=0.4, duration=30.0)
        kinds = run.contact_kind.values
        assert np.count_nonzero(kinds == "rest") > 3
        assert np.count_nonzero(kinds == "release") > 3
        check_table(run, system)
        check_ledger(run)


class TestCoulombFriction:
    def test_pendulum_sticks_where_friction_holds_it(self):
        # Decrement of Coulomb friction: sin(th) < C0/(m g) holds.
        system = ll.Pendulum(length=1.0, mass=0.8, coulomb_damping=0.4)
        run = ll.simulate(system, initial_angle=0.5, duration=30.0)
        last = float(run.angle[-1])
        assert abs(0.8 * G * math.sin(last)) <= 0.4
        assert float(run.angular_velocity[-1]) == 0.0
        stuck = np.flatnonzero(run.angular_velocity.values == 0.0)[1]
        assert np.all(run.angle.values[stuck:] == last)
        check_ledger(run)

    def test_stuck_start_stays_until_the_pivot_tears_it_loose(self):
        system = ll.Pendulum(length=1.0, mass=0.8, coulomb_damping=1.0)
        # Held while m |g + y''| sin(th) <= C0; the pivot's acceleration grows with a chirp.
        drive = ll.Chirp(
            drive_amplitude=0.1, drive_frequency=0.0, drive_frequency_final=12.0, sweep_time=10.0
        )
        times = np.linspace(0.0, 10.0, 20_001)
        run = ll.simulate(system, drive, initial_angle=0.1, times=times)
        load = 0.8 * np.abs(G + run.pivot_acceleration.values) * math.sin(0.1)
        loose = int(np.argmax(load > 1.0))
        assert loose > 1000
        assert np.all(run.angle.values[:loose] == 0.1)
        assert run.angle.values[loose + 5] != 0.1

    def test_ball_is_released_from_a_stuck_angle_at_the_exact_time(self):
        system = ll.Pendulum(length=1.0, mass=0.8, coulomb_damping=1.0)
        drive = harmonic(0.5, frequency=4.0, phase=1.5 * math.pi)
        angle = 0.1
        # m (g - A0 w^2 cos(w t + phase)) sin(th) = C0 with the cosine on its way down.
        cosine = (G - 1.0 / (0.8 * math.sin(angle))) / (0.5 * G)
        exact = (2.0 * math.pi + math.acos(cosine) - 1.5 * math.pi) / 4.0
        times = [exact - 1e-9, exact + 1e-3]
        run = ll.simulate(system, drive, initial_angle=angle, times=times)
        assert float(run.angle[0]) == angle
        # Just loose, the ball falls towards the middle with a force that starts from zero:
        # w = slope t^2/2, angle = slope t^3/6.
        rate = 0.5 * G * 4.0 * math.sin(math.acos(cosine)) * math.sin(angle)
        assert float(run.angular_velocity[1]) == pytest.approx(-rate * 1e-6 / 2.0, rel=1e-2)

    def test_friction_keeps_a_ball_on_the_wall_beyond_g(self):
        # Outward pull m (A0 w^2 - g) sin(low) = 0.5 g m 0.1 = 0.39 N stays below 0.5 N.
        system = toy(coulomb_damping=0.5)
        run = ll.simulate(system, harmonic(1.5), initial_offset=0.0, duration=20.0)
        assert np.all(run.angle.values == system.contact_angle_low)
        run = ll.simulate(
            toy(coulomb_damping=0.3), harmonic(1.5), initial_offset=0.0, duration=20.0
        )
        assert float(run.angle.max()) > system.contact_angle_low

    @pytest.mark.parametrize("share, leaves", [(1.0 - 1e-5, True), (1.0 + 1e-5, False)])
    def test_a_ball_leaves_the_wall_if_friction_is_a_little_too_small(self, share, leaves):
        # The outward pull m (A0 w^2 - g) sin(low) is 0.392 N at most.
        system = toy(coulomb_damping=share * 0.8 * 0.5 * G * 0.1)
        run = ll.simulate(system, harmonic(1.5, phase=1.0), initial_offset=0.0, duration=1.0)
        assert ("release" in run.contact_kind.values) == leaves
        assert leaves or run.attrs["grazing_contacts"] == 0

    def test_friction_lets_go_of_two_balls_that_press_on_each_other_as_one(self):
        # Gravity's pull on both grows from 3.0 N beyond the friction of 4.0 N; the ball behind,
        # on the right, has hardly any friction of its own and pushes the one ahead.
        ball = {"length": 1.0, "mass": 0.8, "radius": 0.1}
        pair = ll.BallPair(
            right=ll.Ball(**ball, coulomb_damping=0.5), left=ll.Ball(**ball, coulomb_damping=3.5)
        )
        start = (0.3 + pair.contact_separation, 0.3)
        run = ll.simulate(pair, harmonic(0.5, frequency=4.0), initial_angle=start, duration=0.45)
        assert run.sizes["contact"] == run.attrs["grazing_contacts"] == 0
        assert float(run.angle[1, -1]) < 0.29
        apart = run.angle.values[0] - run.angle.values[1]
        np.testing.assert_allclose(apart, pair.contact_separation, rtol=0.0, atol=1e-15)

    def test_friction_ends_elastic_bounces_in_finite_time(self):
        # The way up costs and the way down gives less: v falls by sqrt((a - c)/(a + c)) a bounce,
        # a = g sin(low), c = C0/m, a Zeno cascade although e = 1.
        system = toy(coulomb_damping=0.3)
        run = ll.simulate(system, initial_offset=0.01, duration=5.0, contact_limit=5000)
        assert run.attrs["status"] == "complete"
        assert run.contact_kind.values[-1] == "rest"
        speed = run.angular_velocity_after.values[:10]
        a, c = G * 0.1, 0.3 / 0.8
        np.testing.assert_allclose(speed[1:] / speed[:-1], math.sqrt((a - c) / (a + c)), rtol=0.02)
        check_ledger(run)

    @pytest.mark.parametrize("speed", [1e-3, 1e-7, 1e-9])
    def test_friction_slows_bounces_of_any_size_alike(self, speed):
        # Up against a + c, down with a - c, a = g sin(low), c = C0/m. A bounce at 1e-3 rad/s rises
        # by 4e-7 rad; at 1e-7 rad/s by 4e-15 rad, of which the angle resolves two digits.
        system = toy(coulomb_damping=0.3)
        run = ll.simulate(
            system,
            initial_offset=0.0,
            initial_angular_velocity=speed,
            duration=5.0,
            rest_speed=1e-3 * speed,
        )
        assert run.contact_kind.values[-1] == "rest"
        up = np.abs(run.angular_velocity_after.values[:-1])
        a, c = G * 0.1, 0.3 / 0.8
        ratio = math.sqrt((a - c) / (a + c))
        # An angle of 0.1 rad is rounded by 1.4e-17 rad, 1.4e-5 of the smallest rise that is not
        # taken as a parabola, 1e-12 rad. A rise of 4e-7 rad changes the pull by 4e-6 of it.
        down = np.abs(run.angular_velocity_before.values)
        np.testing.assert_allclose(down[1:] / up, ratio, rtol=2e-5)
        # All bounces of a geometric series, but those below the rest speed: v/(a + c) up, and
        # down v ratio/(a - c).
        whole = speed * (1.0 / (a + c) + ratio / (a - c)) / (1.0 - ratio)
        assert float(run.contact_time[-1]) == pytest.approx(whole, rel=2e-3)
        # Nothing but friction takes the energy away, up to the millionth that is captured.
        gone = 0.4 * speed**2
        assert float(run.damping_loss[-1]) == pytest.approx(gone, rel=1e-5)

    @pytest.mark.parametrize("restitution", [0.0, 0.7, 1.0])
    def test_walls_and_friction_close_the_ledger(self, restitution):
        system = toy(coulomb_damping=0.2, quadratic_damping=0.03, restitution=restitution)
        run = ll.simulate(system, harmonic(2.0, frequency=6.5), initial_angle=0.8, duration=60.0)
        check_ledger(run)
        check_table(run, system)

    def test_slack_of_a_stuck_ball_above_the_pivot_is_seen(self):
        # Held at rest above the pivot: T = m g cos(th) < 0 from the first instant on.
        system = ll.Pendulum(length=1.0, mass=0.8, coulomb_damping=20.0)
        run = ll.simulate(system, initial_angle=2.5, duration=2.0)
        assert float(run.tension[0]) == pytest.approx(0.8 * G * math.cos(2.5))
        assert run.attrs["compression_time"] == 0.0
        assert run.attrs["compression_fraction"] == pytest.approx(1.0)

    @pytest.mark.parametrize("start", ["hanging", "on the wall", "two hanging", "in contact"])
    @pytest.mark.parametrize("phase", [1.2, 1.5, 1.8])
    def test_slack_of_balls_that_friction_holds_lasts_while_the_pivot_falls(self, start, phase):
        # Nothing moves, so the tension has the sign of g + y0'' = g (1 - 1.5 cos(w t - phase)).
        drive = harmonic(1.5, phase=-phase)
        one, angle = toy(coulomb_damping=20.0), 0.5
        if start in ("on the wall", "in contact"):
            angle = one.contact_angle_low
        ball = one.balls[0]
        run = (
            ll.simulate(one, drive, initial_angle=angle, duration=0.6)
            if start in ("hanging", "on the wall")
            else ll.simulate(
                ll.BallPair(right=ball, left=ball),
                drive,
                initial_angle=(angle, -angle),
                duration=0.6,
            )
        )
        assert np.ptp(np.atleast_2d(run.angle.values), axis=-1).max() == 0.0
        begins, ends = ((phase + side * math.acos(1.0 / 1.5)) / 8.0 for side in (-1.0, 1.0))
        # The tension is taken as linear over a step h at most: h^2/8 times its curvature over its
        # slope at zero, w/sqrt(1.5^2 - 1), is the error of an end.
        error = run.attrs["step"] ** 2 / 8.0 * 8.0 / math.sqrt(1.25)
        assert 100.0 * error < ends - begins
        np.testing.assert_allclose(run.attrs["compression_time"], begins, rtol=0.0, atol=error)
        np.testing.assert_allclose(
            np.multiply(run.attrs["compression_fraction"], 0.6),
            ends - begins,
            rtol=0.0,
            atol=2.0 * error,
        )


def pair_rows_are_in_order(run):
    """Rest ends by a release, and nothing else happens before that."""
    resting = False
    for kind in run.contact_kind.values:
        assert resting == (kind == "release"), run.contact_kind.values
        resting = kind == "rest"
    return resting


def check_pair_ledger(run, bound=1e-10):
    total = run.total_energy.sum("ball")
    losses = run.damping_loss + run.impact_loss + run.capture_loss
    balance = total - total[0] - run.drive_work + losses
    assert float(abs(balance).max()) <= bound * float(total.max())
    assert run.attrs["energy_residual"] <= bound * float(total.max())


class TestPlasticPairs:
    """Two balls that part, by too little to be seen, and stay together after all."""

    def pair(self, left_length, right, left):
        return ll.BallPair(
            right=ll.Ball(length=1.0, radius=0.1, **right),
            left=ll.Ball(length=left_length, radius=0.1, **left),
            restitution=0.0,
        )

    def test_both_let_go_at_one_instant(self):
        # Friction frees one ball 3e-14 s after the other and the run came to a halt there.
        system = self.pair(
            1.00715750981523,
            {"mass": 0.9404568537522469, "quadratic_damping": 0.1, "coulomb_damping": 0.1},
            {"mass": 1.246746674271368, "coulomb_damping": 0.1},
        )
        drive = ll.Harmonic(
            drive_amplitude=0.12439057308040585,
            drive_frequency=13.329045036927392,
            drive_phase=2.2769354498052854,
        )
        run = ll.simulate(system, drive, initial_angle=(0.8, -0.5), duration=6.0)
        assert run.attrs["status"] == "complete"
        pair_rows_are_in_order(run)
        check_pair_ledger(run)

    def test_rest_after_a_plastic_impact_at_the_top_is_recorded_and_free_of_charge(self):
        # The balls were moved together by 2e-8 J here, and their rest was not in the table.
        system = self.pair(
            1.0222273773597386,
            {"mass": 0.19258445092347187, "damping": 0.5},
            {"mass": 1.3978296938196701, "damping": 0.1},
        )
        drive = ll.Harmonic(
            drive_amplitude=0.4043968450414003, drive_frequency=1.8177154631414352 * 3.13
        )
        run = ll.simulate(system, drive, initial_angle=(0.8, -0.5), duration=300.0)
        check_pair_ledger(run)
        resting = pair_rows_are_in_order(run)
        gap, touch = float(run.angle[0, -1] - run.angle[1, -1]), system.contact_separation
        together = min(abs(gap - touch), abs(gap - 2.0 * math.pi + touch)) < 1e-12
        assert resting == together


class TestRoundedPairs:
    """Two balls whose impacts are as small as the rounding of their velocities."""

    @pytest.mark.parametrize("speed", [-1.0050472609141177, -0.7, 0.3])
    def test_impacts_end_without_a_capture_speed(self, speed):
        # A closing speed of two units in the last place came back from each impact, for ever.
        ball = ll.Ball(length=1.0, mass=1.0, radius=0.1, damping=0.05)
        run = ll.simulate(
            ll.BallPair(right=ball, left=ball, restitution=0.8), duration=8.0, rest_speed=0.0,
            initial_angle=(0.5647431704349991, -0.2), initial_angular_velocity=(speed, 0.0),
        )  # fmt: skip
        assert run.attrs["status"] == "complete"
        check_pair_ledger(run)

    def test_points_that_stay_together_do_not_push_each_other_along_their_rods(self):
        def tension(radius):
            ball = ll.Ball(length=1.0, mass=1.0, radius=radius)
            pair = ll.BallPair(right=ball, left=ball, restitution=0.0)
            run = ll.simulate(pair, initial_angle=(0.5, -0.3), times=np.linspace(0.0, 2.0, 50))
            return run.tension, run.attrs["compression_fraction"]

        points, share = tension(0.0)
        assert not share.any()
        # The push goes with the radius.
        np.testing.assert_allclose(points, tension(1e-7)[0], rtol=0, atol=1e-5)


class TestTensionAtRest:
    def test_tension_of_a_resting_ball_carries_weight_and_contact(self):
        system = toy()
        run = ll.simulate(system, harmonic(0.5), initial_offset=0.0, duration=5.0)
        exact = 0.8 * (G + run.pivot_acceleration) / math.cos(system.contact_angle_low)
        np.testing.assert_allclose(run.tension, exact, rtol=1e-14)
        assert math.isnan(run.attrs["compression_time"])
        assert run.attrs["compression_fraction"] == 0.0

    def test_slack_of_unequal_balls_in_contact_begins_where_each_tension_turns(self):
        # Friction slows the ball ahead, so that both swing over the top as one; their rods are
        # pushed from about 114 degrees on, by the weight and by the contact.
        pair = ll.BallPair(
            right=ll.Ball(length=1.0, mass=0.8, radius=0.1, coulomb_damping=3.0),
            left=ll.Ball(length=0.95, mass=0.5, radius=0.1),
            restitution=0.0,
        )
        run = ll.simulate(
            pair,
            harmonic(0.5),
            initial_angle=(2.0 + pair.contact_separation, 2.0),
            initial_angular_velocity=(3.6, 3.6),
            times=np.linspace(0.0, 0.4, 4001),
            tolerance=1e-14,
        )
        assert run.sizes["contact"] == 0
        pushed = run.tension.values < 0.0
        begins = run.time.values[np.argmax(pushed, axis=1)]
        assert np.all(pushed.any(axis=1) & ~pushed[:, 0])
        # samples are 0.1 ms apart, and the tension is taken as linear over a step of 5 ms
        np.testing.assert_allclose(run.attrs["compression_time"], begins, rtol=0.0, atol=2e-4)


def test_a_stop_at_the_very_instant_of_lift_off_is_reached():
    # A0 w^2 exceeds g by a rounding, so rest ends for 1e-8 s, once per period: at the stroboscope.
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.9)
    drive = ll.Harmonic(
        drive_amplitude=0.16, drive_frequency=2.5000000000000004 * toy.natural_frequency
    )
    assert 0.0 < 0.16 * drive.drive_frequency**2 / toy.gravity - 1.0 < 1e-14
    period = math.tau / drive.drive_frequency
    run = ll.simulate(toy, drive, initial_offset=0.0, duration=7 * period, contact_limit=100)
    assert run.attrs["status"] == "complete"
    assert np.ptp(run.angle.values) == 0.0
    ball = toy.balls[0]
    pair = ll.BallPair(right=ball, left=ball, restitution=0.9)
    low = toy.contact_angle_low
    run = ll.simulate(
        pair, drive, initial_angle=(low, -low), duration=7 * period, contact_limit=100
    )
    assert run.attrs["status"] == "complete"
