"""The exact solutions against mpmath, quadrature, integration, limits and printed numbers."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from latolato import analysis as exact

G = 9.8
TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
TOY = {"length": 1.0, "radius": 0.1, "initial_angle": 0.6}
# Swings, falls from near the top, both senses of rotation, and starts beyond one turn.
STATES = [
    (0.6, 0.0),
    (-1.5, 0.0),
    (3.0, 0.0),
    (0.5, -3.0),
    (7.0, 1.0),
    (1.0, 6.0),
    (-20.0, -9.0),
    (0.0, -30.0),
]


def mpmath_motion(time, angle, velocity):
    """Angle and velocity for length 1, by mpmath's elliptic functions of k^2 at 70 digits."""
    with mp.workdps(70):
        t, angle, velocity = mp.mpf(time), mp.mpf(angle), mp.mpf(velocity)
        w0 = mp.sqrt(mp.mpf(G))
        turns = 2 * mp.pi * mp.nint(angle / (2 * mp.pi))
        half = (angle - turns) / 2
        sign = 1 if velocity >= 0 else -1
        m = mp.sin(half) ** 2 + (velocity / (2 * w0)) ** 2
        k = mp.sqrt(m)
        if m < 1:
            quarter = mp.ellipk(m)
            u = mp.ellipf(mp.asin(min(mp.sin(half) / k, 1)), m)
            u = (u if sign > 0 else 2 * quarter - u) + w0 * t
            u -= 4 * quarter * mp.nint(u / (4 * quarter))
            sn, cn, dn = (mp.ellipfun(name, u, m=m) for name in ("sn", "cn", "dn"))
            return float(turns + 2 * mp.atan2(k * sn, dn)), float(2 * w0 * k * cn)
        half_turn = 2 * mp.ellipk(1 / m)
        u = k * w0 * t + mp.ellipf(sign * half, 1 / m)
        count = mp.nint(u / half_turn)
        sn, cn, dn = (
            mp.ellipfun(name, u - count * half_turn, m=1 / m) for name in ("sn", "cn", "dn")
        )
        amplitude = count * mp.pi + mp.atan2(sn, cn)
        return float(turns + sign * 2 * amplitude), float(sign * 2 * w0 * k * dn)


def energy(angle, velocity, gravity=G, length=1.0):
    return 0.5 * velocity**2 + 2.0 * gravity / length * np.sin(0.5 * np.asarray(angle)) ** 2


class TestFreePendulum:
    # 3.1415926 and math.pi start 5e-8 and 1e-16 below the top; 2 w0 = 6.26099: just below, above.
    @pytest.mark.parametrize(
        "angle,velocity",
        [*STATES, (1e-8, 0.0), (3.1415926, 0.0), (math.pi, 0.0), (0.0, 6.26), (0.0, 6.261)],
    )
    def test_motion_equals_mpmath(self, angle, velocity):
        times = np.array([-3.3, 0.0, 0.1, 0.77, 1.5, 10.0, 50.0])
        angles, velocities = exact.undriven_motion(
            times, length=1.0, initial_angle=angle, initial_angular_velocity=velocity
        )
        reference = np.array([mpmath_motion(t, angle, velocity) for t in times])
        # The phase w0 t is rounded at 1e-16 of 150 rad (of k w0 t = 750 rad at 30 rad/s); times
        # the speed, and in the velocity times g/l.
        np.testing.assert_allclose(angles, reference[:, 0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(velocities, reference[:, 1], rtol=0, atol=1e-12)

    @pytest.mark.parametrize("angle,velocity", STATES)
    def test_motion_equals_an_integration(self, angle, velocity):
        times = np.linspace(0.0, 5.0, 51)
        run = solve_ivp(
            lambda _, y: (y[1], -G / 0.7 * math.sin(y[0])),
            (0.0, 5.0),
            (angle, velocity),
            t_eval=times,
            **TIGHT,
        )
        angles, velocities = exact.undriven_motion(
            times, length=0.7, initial_angle=angle, initial_angular_velocity=velocity
        )
        # The integrator's own error at rtol 1e-13 over 5 s, measured by halving its tolerance.
        np.testing.assert_allclose(angles, run.y[0], rtol=0, atol=1e-9)
        np.testing.assert_allclose(velocities, run.y[1], rtol=0, atol=1e-9)

    @settings(deadline=None)
    @given(
        angle=st.floats(-10.0, 10.0),
        velocity=st.floats(-20.0, 20.0),
        length=st.floats(0.05, 5.0),
        gravity=st.floats(1.0, 30.0),
    )
    def test_energy_is_kept(self, angle, velocity, length, gravity):
        angles, velocities = exact.undriven_motion(
            np.linspace(-50.0, 300.0, 400),
            length=length,
            initial_angle=angle,
            initial_angular_velocity=velocity,
            gravity=gravity,
        )
        expected = energy(angle, velocity, gravity, length)
        # sn, cn and dn obey their identities to some 1e-15 whatever the phase; the angle itself
        # is rounded at 1e-16 of its size (up to some 1e4 rad in rotation), times the torque.
        atol = 1e-15 * gravity / length * (20.0 + np.max(np.abs(angles)))
        np.testing.assert_allclose(
            energy(angles, velocities, gravity, length), expected, rtol=2e-14, atol=atol
        )

    @settings(deadline=None)
    @given(angle=st.floats(-3.0, 3.0), velocity=st.floats(-12.0, 12.0), pause=st.floats(-2.0, 2.0))
    def test_a_restart_continues_the_same_motion(self, angle, velocity, pause):
        # Nearer to the separatrix the rounding of the state at the pause is amplified.
        assume(abs(energy(angle, velocity) - 2.0 * G) > 0.5)
        first = exact.undriven_motion(
            pause, length=1.0, initial_angle=angle, initial_angular_velocity=velocity
        )
        second = exact.undriven_motion(
            1.0, length=1.0, initial_angle=first[0], initial_angular_velocity=first[1]
        )
        whole = exact.undriven_motion(
            pause + 1.0, length=1.0, initial_angle=angle, initial_angular_velocity=velocity
        )
        # Rounding of the state, 1e-15, amplified by at most exp(w0 * 1 s) = 23, and the velocity
        # by another w0.
        np.testing.assert_allclose(second, whole, rtol=0, atol=1e-12)

    @pytest.mark.parametrize("angle,velocity", STATES)
    def test_motion_repeats_after_the_period(self, angle, velocity):
        start = {"length": 1.0, "initial_angle": angle, "initial_angular_velocity": velocity}
        period = exact.undriven_period(**start)
        angles, velocities = exact.undriven_motion([0.0, period, 2.0 * period], **start)
        turn = 2.0 * math.pi * np.sign(velocity) if energy(angle, velocity) > 2.0 * G else 0.0
        np.testing.assert_allclose(np.diff(angles), turn, rtol=0, atol=1e-13)  # 1e-16 * 30 rad
        np.testing.assert_allclose(velocities, velocity, rtol=0, atol=1e-13)

    def test_time_reversal(self):
        times = np.linspace(0.0, 9.0, 91)
        forth = exact.undriven_motion(
            times, length=1.0, initial_angle=0.4, initial_angular_velocity=2.0
        )
        back = exact.undriven_motion(
            -times, length=1.0, initial_angle=0.4, initial_angular_velocity=-2.0
        )
        np.testing.assert_allclose(back[0], forth[0], rtol=0, atol=1e-13)  # 1e-16 * 28 rad
        np.testing.assert_allclose(back[1], -forth[1], rtol=0, atol=1e-13)

    def test_small_swings_have_the_series_of_the_period(self):
        a = 0.01
        series = 1.0 + a**2 / 16.0 + 11.0 * a**4 / 3072.0  # next term 173 a^6/737280 = 2e-16
        period = exact.undriven_period(length=2.0, initial_angle=a)
        assert period == pytest.approx(
            2.0 * math.pi * math.sqrt(2.0 / G) * series, rel=1e-15, abs=0.0
        )

    def test_period_from_90_degrees_is_lemniscatic(self):
        quarter = math.gamma(0.25) ** 2 / (4.0 * math.sqrt(math.pi))  # K at k^2 = 1/2
        period = exact.undriven_period(length=1.0, initial_angle=math.pi / 2.0)
        assert period == pytest.approx(4.0 * quarter / math.sqrt(G), rel=1e-15, abs=0.0)

    def test_period_near_the_top_is_logarithmic(self):
        gap = 1e-9
        angle = math.pi - gap
        complement = math.cos(0.5 * angle)  # K -> ln(4/k') with a remainder of k'^2 ln(4/k')
        period = exact.undriven_period(length=1.0, initial_angle=angle)
        assert period == pytest.approx(
            4.0 * math.log(4.0 / complement) / math.sqrt(G), rel=1e-15, abs=0.0
        )

    def test_separatrix_is_a_gudermannian(self):
        times = np.array([-900.0, -2.0, 0.0, 1.0, 3.0, 900.0])
        start = {
            "length": 1.0,
            "initial_angle": 0.0,
            "initial_angular_velocity": -2.0,  # exactly 2 w0
            "gravity": 1.0,
        }
        angles, velocities = exact.undriven_motion(times, **start)
        np.testing.assert_allclose(angles, -4.0 * np.arctan(np.tanh(times / 2.0)), rtol=1e-15)
        assert velocities[3] == pytest.approx(-2.0 / math.cosh(1.0), rel=1e-15, abs=0.0)
        assert exact.undriven_period(**start) == math.inf

    def test_lowest_point_at_rest_stays(self):
        angles, velocities = exact.undriven_motion([0.0, 1.0], length=1.0, initial_angle=0.0)
        assert angles.tolist() == velocities.tolist() == [0.0, 0.0]
        period = exact.undriven_period(length=1.0, initial_angle=0.0)
        assert period == pytest.approx(2.0 * math.pi / math.sqrt(G), rel=1e-15, abs=0.0)

    @pytest.mark.parametrize("shape", [(), (3,), (2, 3)])
    def test_result_has_the_shape_of_the_times(self, shape):
        for velocity in (0.0, 1.0, 9.0):
            motion = exact.undriven_motion(
                np.ones(shape), length=1.0, initial_angle=0.0, initial_angular_velocity=velocity
            )
            assert [part.shape for part in motion] == [shape, shape]


class TestDecay:
    def test_printed_rates(self):
        # Printed C, m, l of paper Figs. 7 and 10; the digits of PHYSICS.md.
        single = exact.decay_rate(damping=0.00274, mass=0.10804, length=0.3630)
        coupled = exact.decay_rate(damping=0.00506, mass=0.10644, length=0.2450)
        assert single == pytest.approx(0.0349325, abs=5e-8)
        assert coupled == pytest.approx(0.0970174, abs=5e-8)
        back = exact.damping_from_decay_rate(single, mass=0.10804, length=0.3630)
        assert back == pytest.approx(0.00274, rel=1e-15, abs=0.0)

    def test_angle_equals_eq13_as_printed(self):
        l, m, C, start = 0.3630, 0.10804, 0.00274, 0.2
        t = np.linspace(0.0, 60.0, 301)
        k = C / (2.0 * m * l)
        W = math.sqrt(G / l - k**2)
        printed = (
            start
            * np.exp(-k * t)
            * math.sqrt(1.0 + (k / W) ** 2)
            * np.cos(W * t - math.atan(k / W))
        )
        angle, _ = exact.damped_small_angle(t, length=l, mass=m, damping=C, initial_angle=start)
        np.testing.assert_allclose(
            angle, printed, rtol=0, atol=1e-14
        )  # 1e-16 * W t = 3e-14 * start

    # 2 m l w0 = 6.26...: weak, strong, nearly critical from both sides, over- and overcritical.
    @pytest.mark.parametrize("damping", [0.0, 3.0, 6.2609903, 6.2609904, 12.0, 400.0])
    def test_motion_solves_eq12_at_any_damping(self, damping):
        times = np.linspace(0.0, 4.0, 41)
        run = solve_ivp(
            lambda _, y: (y[1], -G * y[0] - damping * y[1]),
            (0.0, 4.0),
            (0.1, 0.0),
            t_eval=times,
            method="Radau" if damping > 100.0 else "DOP853",
            rtol=1e-12,
            atol=1e-14,
        )
        angle, velocity = exact.damped_small_angle(
            times, length=1.0, mass=1.0, damping=damping, initial_angle=0.1
        )
        # The integrator's error; Radau's is the largest, 3e-12.
        np.testing.assert_allclose(angle, run.y[0], rtol=0, atol=2e-11)
        np.testing.assert_allclose(velocity, run.y[1], rtol=0, atol=2e-11)

    def test_critical_damping_is_the_polynomial_solution(self):
        times = np.array([0.0, 0.5, 2.0])
        angle, velocity = exact.damped_small_angle(
            times, length=1.0, mass=1.0, damping=4.0, initial_angle=1.0, gravity=4.0
        )
        np.testing.assert_allclose(angle, np.exp(-2.0 * times) * (1.0 + 2.0 * times), rtol=1e-15)
        np.testing.assert_allclose(velocity, -4.0 * times * np.exp(-2.0 * times), rtol=1e-15)


class TestBounces:
    def test_printed_fall_time_and_impact_speed(self):
        # 30 digits were computed beforehand; double precision keeps 15.
        assert exact.fall_time(**TOY) == pytest.approx(0.458901167124134085956, rel=1e-15, abs=0.0)
        speed = exact.impact_angular_velocity(**TOY)
        assert speed == pytest.approx(1.82350643406050434667, rel=1e-15, abs=0.0)

    @pytest.mark.parametrize(
        "length,radius,top",
        [(1.0, 0.1, 0.6), (0.245, 0.02, 3.0), (0.245, 0.02, 0.0817242), (1.0, 0.0, 1.0)],
    )
    def test_fall_time_equals_quadrature(self, length, radius, top):
        with mp.workdps(30):
            low, high, w0 = (
                mp.asin(mp.mpf(radius) / length),
                mp.mpf(top),
                mp.sqrt(G / mp.mpf(length)),
            )
            # angle = high - s^2 removes the root singularity at the turning point.
            tau = mp.quad(
                lambda s: s / mp.sqrt(mp.sin(high - s * s / 2) * mp.sin(s * s / 2)) / w0,
                [0, mp.sqrt(high - low)],
            )
        result = exact.fall_time(length=length, radius=radius, initial_angle=top)
        # The third case falls 2.7e-7 of its angle: asin(r/l) is rounded at 1e-16 of 0.08.
        assert result == pytest.approx(float(tau), rel=2e-9 if top < 0.09 else 2e-15, abs=0.0)

    def test_without_walls_the_fall_is_a_quarter_swing(self):
        fall = exact.fall_time(length=0.7, radius=0.0, initial_angle=2.0)
        period = exact.undriven_period(length=0.7, initial_angle=2.0)
        assert fall == pytest.approx(period / 4.0, rel=1e-15, abs=0.0)

    def test_collisions_are_those_of_an_integration_with_reflection(self):
        low = math.asin(0.1)

        def wall(_, y):
            return y[0] - low

        wall.terminal, wall.direction = True, -1
        time, state, result = 0.0, (0.6, 0.0), []
        while len(result) < 5:
            run = solve_ivp(
                lambda _, y: (y[1], -G * math.sin(y[0])),
                (time, time + 5.0),
                state,
                events=wall,
                **TIGHT,
            )
            time, state = run.t_events[0][0], (low, -run.y_events[0][0][1])
            result.append(time)
        np.testing.assert_allclose(
            exact.collision_times(5, **TOY), result, rtol=0, atol=1e-11
        )  # event location on the integrator's interpolant

    def test_bounces_reflect_at_each_collision_and_stay_above_the_wall(self):
        low, tau = math.asin(0.1), exact.fall_time(**TOY)
        speed = exact.impact_angular_velocity(**TOY)
        collisions = exact.collision_times(20, **TOY)
        angle, before = exact.elastic_bounces(collisions - 1e-9, **TOY)
        _, after = exact.elastic_bounces(collisions + 1e-9, **TOY)
        np.testing.assert_allclose(angle, low, rtol=0, atol=2e-9)  # 1e-9 s at 1.8 rad/s
        np.testing.assert_allclose(before, -speed, rtol=0, atol=2e-9)  # 1e-9 s at 1 rad/s^2
        np.testing.assert_allclose(after, speed, rtol=0, atol=2e-9)
        times = np.linspace(0.0, 300.0, 20001)
        angle, velocity = exact.elastic_bounces(times, **TOY)
        assert low <= angle.min() <= angle.max() <= 0.6
        # Only at the wall itself does clipping touch the energy: 1e-16 * 650 phases * g/l.
        np.testing.assert_allclose(energy(angle, velocity), energy(0.6, 0.0), rtol=0, atol=1e-12)
        again, _ = exact.elastic_bounces(times + 2.0 * tau, **TOY)
        np.testing.assert_allclose(again, angle, rtol=0, atol=1e-12)  # 300 s * 1e-16 * speed

    def test_printed_zeno_time(self):
        time = exact.zeno_time(length=1.0, radius=0.1, initial_angle=math.pi / 2, restitution=0.6)
        assert time == pytest.approx(5.45806, abs=5e-6)  # printed to five decimals

    @pytest.mark.parametrize("restitution", [0.1, 0.6, 0.9])
    def test_zeno_time_equals_the_summed_flights(self, restitution):
        with mp.workdps(40):
            w0, low = mp.sqrt(mp.mpf(G)), mp.asin(mp.mpf(0.1))

            def half_flight(speed):
                m = mp.sin(low / 2) ** 2 + (speed / (2 * w0)) ** 2
                return (mp.ellipk(m) - mp.ellipf(mp.asin(mp.sin(low / 2) / mp.sqrt(m)), m)) / w0

            speed = w0 * mp.sqrt(2 * (mp.cos(low) - mp.cos(mp.mpf(1.2))))
            total = half_flight(speed)
            while speed > 1e-18:
                speed *= mp.mpf(restitution)
                total += 2 * half_flight(speed)
        time = exact.zeno_time(length=1.0, radius=0.1, initial_angle=1.2, restitution=restitution)
        assert time == pytest.approx(float(total), rel=1e-15, abs=0.0)

    def test_zeno_time_close_to_the_wall_is_that_of_constant_weight(self):
        # From 1e-6 of the wall angle the tangential weight is constant to about 1e-6.
        drop = {"length": 1.0, "radius": 0.1, "initial_angle": math.asin(0.1) * (1.0 + 1e-6)}
        for e in (0.3, 0.9, 0.999):
            expected = exact.fall_time(**drop) * (1.0 + e) / (1.0 - e)
            assert exact.zeno_time(restitution=e, **drop) == pytest.approx(expected, rel=1e-6)

    def test_zeno_limits(self):
        assert exact.zeno_time(restitution=0.0, **TOY) == exact.fall_time(**TOY)
        without_radius = {"length": 1.0, "radius": 0.0, "initial_angle": 0.6}
        assert exact.zeno_time(restitution=0.5, **without_radius) == math.inf


class TestFolding:
    def test_fold_is_the_wrapped_magnitude(self):
        angles = [0.0, -0.5, math.pi, 4.0, -4.0, 20.0]
        expected = [0.0, 0.5, math.pi, 2 * math.pi - 4.0, 2 * math.pi - 4.0, 20.0 - 6 * math.pi]
        np.testing.assert_allclose(exact.reflected_angle(angles), expected, rtol=0, atol=4e-15)

    def test_reflecting_walls_at_0_and_pi_fold_the_driven_free_motion(self):
        def motion(t, y):
            weight = G - 0.3 * 49.0 * math.cos(7.0 * t)
            return y[1], -weight * math.sin(y[0]) - 0.1 * y[1]

        def low(_, y):
            return y[0]

        def high(_, y):
            return math.pi - y[0]

        for wall in (low, high):
            wall.terminal, wall.direction = True, -1
        times = np.linspace(0.0, 4.0, 41)
        free = solve_ivp(motion, (0.0, 4.0), (0.3, 8.0), t_eval=times, **TIGHT)
        walled, time, state = [], 0.0, (0.3, 8.0)
        hits = {0: 0, 1: 0}
        while time < 4.0:
            run = solve_ivp(
                motion, (time, 4.0), state, events=(low, high), dense_output=True, **TIGHT
            )
            due = times[(times >= time) & ((times < run.t[-1]) | (run.status == 0))]
            walled.extend(run.sol(due)[0])
            time = run.t[-1]
            for side in (0, 1):
                if run.t_events[side].size:
                    hits[side] += 1
                    state = ((0.0, math.pi)[side], -run.y_events[side][0][1])
        assert min(hits.values()) > 0  # both walls took part
        # Integration and event errors of both runs, amplified by a rotating, driven motion.
        np.testing.assert_allclose(exact.reflected_angle(free.y[0]), walled, rtol=0, atol=1e-9)


class TestMessages:
    @pytest.mark.parametrize("bad", [math.nan, math.inf, 0.0, -1.0])
    def test_length_is_checked(self, bad):
        with pytest.raises(ValueError, match="length must"):
            exact.undriven_period(length=bad, initial_angle=0.1)

    def test_times_must_be_numbers(self):
        with pytest.raises(ValueError, match=r"times\[1\] must be a number"):
            exact.undriven_motion([0.0, math.nan], length=1.0, initial_angle=0.1)
        with pytest.raises(ValueError, match=r"free_angle\[0\] must be a number"):
            exact.reflected_angle([math.inf])

    def test_start_must_lie_between_the_walls(self):
        for angle in (0.05, math.asin(0.1), 3.1):
            with pytest.raises(ValueError, match="above the low wall"):
                exact.fall_time(length=1.0, radius=0.1, initial_angle=angle)
        with pytest.raises(ValueError, match=r"radius must lie in \[0, length\)"):
            exact.fall_time(length=0.4, radius=0.5, initial_angle=1.0)

    def test_other_ranges(self):
        with pytest.raises(ValueError, match="restitution must"):
            exact.zeno_time(length=1.0, radius=0.1, initial_angle=0.6, restitution=1.0)
        with pytest.raises(ValueError, match="count must"):
            exact.collision_times(-1, length=1.0, radius=0.1, initial_angle=0.6)
        with pytest.raises(ValueError, match="damping must"):
            exact.decay_rate(damping=-0.1, mass=1.0, length=1.0)
        with pytest.raises(ValueError, match="decay_rate must"):
            exact.damping_from_decay_rate(math.nan, mass=1.0, length=1.0)
        with pytest.raises(ValueError, match="initial_angular_velocity must"):
            exact.undriven_period(length=1.0, initial_angle=0.0, initial_angular_velocity=math.inf)
