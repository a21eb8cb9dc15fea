"""The physics of strings: closed forms, where strings are rods, self-start, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest

import latolato as ll
from string_balls import Body, Strings
from string_motions import any_ball, any_pair, any_toy, assert_agree, simulated

BALL = {"length": 0.3, "mass": 0.1}
TOY = {"length": 0.25, "mass": 0.1, "radius": 0.02, "restitution": 0.9}


class TestClosedForms:
    """A ball at a pivot at rest, pushed at the bottom, without drag."""

    length, mass, g = 0.4, 0.07, 9.8

    @pytest.fixture(params=[2.1, 3.0, 3.7, 4.9])
    def push(self, request):
        return math.sqrt(request.param * self.g * self.length)

    def go(self, push, times, suspension="string"):
        system = ll.Pendulum(length=self.length, mass=self.mass, suspension=suspension)
        return ll.simulate(
            system, initial_angle=0.0, initial_angular_velocity=push / self.length, times=times,
            tolerance=1e-12,
        )  # fmt: skip

    def test_loop(self, push):
        l, g = self.length, self.g
        angle = math.acos((2.0 * g * l - push**2) / (3.0 * g * l))
        v = math.sqrt(-g * l * math.cos(angle))
        flight = 4.0 * v * math.sin(angle) / g
        run = self.go(push, [2.0])
        slack, taut = run.contact_time.values[:2]
        assert list(run.contact_kind.values[:2]) == ["slack", "taut"]
        assert taut - slack == pytest.approx(flight, rel=1e-10)
        assert run.attrs["first_slack"] == slack

        run = self.go(push, np.linspace(0.0, taut * (1.0 + 1e-12), 60))
        t = run.time.values - slack
        flying = (t > 0.0) & (t < flight)
        x = l * math.sin(angle) + v * math.cos(angle) * t
        y = -l * math.cos(angle) + v * math.sin(angle) * t - 0.5 * g * t * t
        d, th = run.distance.values, run.angle.values
        assert flying.sum() > 10
        assert (run.slack.values == flying).all()
        # Ten tolerances.
        for seen, expected in ((d * np.sin(th), x), (-d * np.cos(th), y)):
            np.testing.assert_allclose(seen[flying], expected[flying], rtol=0, atol=1e-11)

        # At its end, with the unit vector away from the pivot.
        x = math.sin(angle) + v * math.cos(angle) * flight / l
        y = -math.cos(angle) + (v * math.sin(angle) * flight - 0.5 * g * flight**2) / l
        u, w = v * math.cos(angle), v * math.sin(angle) - g * flight
        radial = x * u + y * w
        assert float(run.radial_velocity_before[1]) == pytest.approx(radial, rel=1e-9)
        assert float(run.radial_velocity_after[1]) == 0.0
        assert float(run.retension_loss[-1]) == pytest.approx(0.5 * self.mass * radial**2, rel=1e-9)
        turning = (w * x - u * y) / l
        assert float(run.angular_velocity_after[1]) == pytest.approx(turning, rel=1e-9)

    @pytest.mark.parametrize("share", [1.9, 5.1])
    def test_no_string_is_slack_below_the_horizontal_and_in_full_turns(self, share):
        push = math.sqrt(share * self.g * self.length)
        times = np.linspace(0.0, 3.0, 100)
        run = self.go(push, times)
        assert run.attrs["slack_fraction"] == 0.0
        assert math.isnan(run.attrs["first_slack"])
        # Full turns of a thousand steps, rounded to some 1e-15 each.
        rod = self.go(push, times, "rod")
        np.testing.assert_allclose(run.angle, rod.angle, rtol=0, atol=1e-12)

    def test_a_slack_ball_falls_and_meets_its_string(self):
        # Straight down: the velocity along the string is all there is.
        system = ll.Pendulum(length=self.length, mass=self.mass, suspension="string")
        run = ll.simulate(system, initial_angle=0.0, initial_distance=0.1, duration=1.0)
        fall = math.sqrt(2.0 * 0.3 / self.g)
        assert float(run.contact_time[0]) == pytest.approx(fall, rel=1e-12)
        assert float(run.retension_loss[-1]) == pytest.approx(self.mass * self.g * 0.3, rel=1e-12)
        assert float(run.distance[-1]) == self.length


class TestRods:
    """Where strings and rods are the same, and where a drive in the plane is one along a line."""

    def check(self, one, other, bound=1e-12, angle=0.0):
        # Some thousand steps, rounding errors of 1e-15 each; motions that multiply them tenfold.
        assert len(one.contact) == len(other.contact)
        np.testing.assert_allclose(one.angle, other.angle + angle, rtol=0, atol=bound)
        if "slack" in one and "slack" in other:
            np.testing.assert_allclose(one.distance, other.distance, rtol=0, atol=bound)
            np.testing.assert_array_equal(one.slack, other.slack)

    @pytest.mark.parametrize("lab", [False, True])
    @pytest.mark.parametrize("make", [any_ball, any_toy, any_pair])
    def test_strings_are_rods_while_they_pull(self, make, lab):
        motion, _ = make(np.random.default_rng(1))
        if make is any_pair:
            # Of equal lengths: every string's impulse is a pull.
            motion.bodies[1] = replace(motion.bodies[1], l=motion.bodies[0].l)
        motion.A0, motion.lab, motion.es, motion.e = 0.01, lab, 0.5, 0.95
        motion.Ax = 0.0 if motion.walls else 0.005
        start = [(0.9, 0.0), (-0.6, 0.0)][: len(motion.bodies)]
        times = np.linspace(0.0, 1.5, 100)
        strings = simulated(motion, start, times)
        rods = simulated(replace(motion, string=False), start, times)
        assert float(rods.tension.min()) > 0.0
        assert make is any_ball or len(rods.contact) > 2
        self.check(strings, rods)
        for name in ("drive_work", "damping_loss", "impact_loss", "tension"):
            np.testing.assert_allclose(strings[name], rods[name], rtol=0, atol=1e-12)

    @pytest.mark.parametrize("suspension", ["rod", "string"])
    def test_a_planar_drive_without_its_horizontal_part_is_the_harmonic_one(self, suspension):
        system = ll.Pendulum(length=0.3, mass=0.1, damping=1e-3, suspension=suspension)
        start = {"initial_angle": 1.0, "initial_angular_velocity": 7.0, "duration": 1.0}
        planar = ll.PlanarHarmonic(
            vertical_amplitude=0.05, horizontal_amplitude=0.0, drive_frequency=12.0,
            vertical_phase=0.4,
        )  # fmt: skip
        line = ll.Harmonic(drive_amplitude=0.05, drive_frequency=12.0, drive_phase=0.4)
        self.check(ll.simulate(system, planar, **start), ll.simulate(system, line, **start))

    @pytest.mark.parametrize("suspension", ["rod", "string"])
    @pytest.mark.parametrize("count", [1, 2])
    def test_a_pivot_that_accelerates_sideways_is_another_gravity(self, count, suspension):
        # 1e-6 rad/s for a second: the acceleration is constant to 1e-12.
        w, sideways = 1e-6, 6.0
        slow = ll.PlanarHarmonic(
            vertical_amplitude=0.0, horizontal_amplitude=sideways / w**2, drive_frequency=w
        )
        down, gravity = math.atan2(sideways, 9.8), math.hypot(sideways, 9.8)
        ball = ll.Ball(length=0.3, mass=0.1, damping=1e-3, radius=0.03)
        own = {"suspension": suspension}
        starts = (1.0, -0.7), (9.0, -3.0)

        def go(g, drive, turned):
            angles = tuple(a + turned for a in starts[0])
            times = np.linspace(0.0, 0.8, 60)
            if count == 2:
                system = ll.BallPair(right=ball, left=ball, restitution=0.8, gravity=g, **own)
                return ll.simulate(
                    system, drive, initial_angle=angles, initial_angular_velocity=starts[1],
                    times=times, tolerance=1e-12,
                )  # fmt: skip
            system = ll.Pendulum(length=0.3, mass=0.1, damping=1e-3, gravity=g, **own)
            return ll.simulate(
                system, drive, initial_angle=angles[0], initial_angular_velocity=starts[1][0],
                times=times, tolerance=1e-12,
            )  # fmt: skip

        self.check(go(9.8, slow, down), go(gravity, None, 0.0), 1e-10, down)

    @pytest.mark.parametrize("suspension", ["rod", "string"])
    @pytest.mark.parametrize("frame", ["pivot", "lab"])
    def test_without_gravity_a_tilted_drive_is_the_vertical_one_turned(self, frame, suspension):
        system = ll.Pendulum(
            length=0.3, mass=0.1, damping=2e-3, gravity=1e-13, suspension=suspension,
            drag_frame=frame,
        )  # fmt: skip
        tilt, amplitude, w, phase = 0.7, 0.05, 12.0, 0.4
        tilted = ll.PlanarHarmonic(
            vertical_amplitude=amplitude * math.cos(tilt),
            horizontal_amplitude=amplitude * math.sin(tilt),
            drive_frequency=w,
            vertical_phase=phase,
            horizontal_phase=phase + math.pi,  # hanging turns by +tilt, so up turns to -x
        )
        line = ll.Harmonic(drive_amplitude=amplitude, drive_frequency=w, drive_phase=phase)
        times = np.linspace(0.0, 1.0, 60)

        def go(drive, angle):
            return ll.simulate(
                system, drive, initial_angle=angle, initial_angular_velocity=2.0, times=times,
                tolerance=1e-12,
            )  # fmt: skip

        turned = go(tilted, 1.0 + tilt)
        assert suspension == "rod" or turned.slack.any()
        self.check(turned, go(line, 1.0), 1e-11, tilt)

    def test_without_gravity_a_rod_on_a_circling_pivot_is_a_pendulum_seen_turning(self):
        # The pivot's acceleration has the size A w^2 and turns with w: psi = th - w t - pi/2.
        amplitude, w, l = 0.04, 15.0, 0.3
        circle = ll.PlanarHarmonic(
            vertical_amplitude=amplitude, horizontal_amplitude=amplitude, drive_frequency=w,
            vertical_phase=-0.5 * math.pi,
        )  # fmt: skip
        times = np.linspace(0.0, 2.0, 60)
        seen = ll.simulate(
            ll.Pendulum(length=l, mass=0.1, gravity=1e-13), circle, initial_angle=2.0,
            initial_angular_velocity=3.0, times=times, tolerance=1e-12,
        )  # fmt: skip
        still = ll.simulate(
            ll.Pendulum(length=l, mass=0.1, gravity=amplitude * w**2),
            initial_angle=2.0 - 0.5 * math.pi, initial_angular_velocity=3.0 - w, times=times,
            tolerance=1e-12,
        )  # fmt: skip
        # Some 5 turns a second against the tolerance of 1e-12 for both.
        turned = still.angle + 0.5 * math.pi + w * times
        np.testing.assert_allclose(seen.angle, turned, rtol=0, atol=1e-10)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("across", [0.04, 0.05])
def test_a_slack_ball_falls_on_one_that_hangs(across, side):
    b = Body(0.3, 0.1, r=0.03)
    balls = [(side * math.atan2(across, 0.1), 0.0, math.hypot(across, 0.1)), (0.0, 0.0, b.l)]
    start, times = balls[::side], np.linspace(0.0, 0.19, 20)
    motion = Strings([b, b], e=0.9)
    run = simulated(motion, start, times)
    # It falls until the centres are two radii apart.
    fall = b.l - math.sqrt(4.0 * b.r**2 - across**2) - 0.1
    assert list(run.contact_kind.values) == ["bottom"]
    assert float(run.contact_time[0]) == pytest.approx(math.sqrt(2.0 * fall / 9.8), rel=1e-12)
    assert_agree(run, motion.run(start, times), 1e-10)


@pytest.mark.parametrize("drags", [{"C": 2e-3}, {"C": 1e-3, "C2": 2e-3}])
def test_two_balls_that_do_not_meet_are_two_single_ones(drags):
    # The right one is taut and turns round, the left one is slack.
    b = Body(0.3, 0.1, r=0.02, **drags)
    start = [(1.2, 2.0, b.l), (-1.5, 1.0, 0.2)]
    times = np.linspace(0.0, 0.15, 21)
    both = simulated(Strings([b, b], A0=0.01, w=12.0), start, times)
    assert (both.slack.values == [[0], [1]]).all()
    assert (np.diff(both.angle[0]) > 0).any()
    assert (np.diff(both.angle[0]) < 0).any()
    for i in (0, 1):
        alone = simulated(Strings([b], A0=0.01, w=12.0), [start[i]], times)
        np.testing.assert_allclose(both.angle[i], alone.angle, rtol=0, atol=1e-10)
        np.testing.assert_allclose(both.distance[i], alone.distance, rtol=0, atol=1e-10)


def test_two_balls_that_pass_through_each_other_pass_through_strings_too():
    b = Body(0.3, 0.1, r=0.05)
    start, times = [(0.6, 0.0, 0.15), (0.5, 2.0, b.l)], np.linspace(0.0, 0.15, 21)
    both = simulated(Strings([b, b]), start, times, contact=None)
    assert both.attrs["status"] == "complete"
    assert (np.diff(np.sign(both.angle[0] - both.angle[1])) != 0).any()
    for i in (0, 1):
        alone = simulated(Strings([b]), [start[i]], times)
        np.testing.assert_allclose(both.angle[i], alone.angle, rtol=0, atol=1e-10)


def test_a_shorter_ball_is_pushed_up_its_string():
    # l_long^2 - l_short^2 > (r1 + r2)^2: at the bottom the line of centres points inwards.
    right, left = (ll.Ball(length=l, mass=0.1, radius=0.03) for l in (0.3, 0.27))
    pair = {"right": right, "left": left, "restitution": 0.9}
    start = {"initial_angle": (1.0, -0.2), "initial_angular_velocity": (-3.0, 0.0)}
    run = ll.simulate(ll.BallPair(**pair, suspension="string"), **start, duration=0.3)
    first = int(np.flatnonzero(run.contact_kind == "bottom")[0])
    after = run.radial_velocity_after[:, first]
    assert float(after[0]) == 0.0
    assert float(after[1]) < -0.01
    rod = ll.simulate(ll.BallPair(**pair), **start, duration=0.3)
    assert float(run.impact_loss[-1]) > 0.0
    assert float(rod.distance.min() if "distance" in rod else 0.27) == 0.27


class TestSelfStart:
    """A toy that rests on its contact angle begins to move where A0 w^2 = g, hung either way."""

    def go(self, lift, suspension, **own):
        system = ll.LatoLato(**TOY, suspension=suspension, **own)
        drive = ll.Harmonic(drive_amplitude=lift * 9.8 / 25.0**2, drive_frequency=25.0)
        return ll.simulate(system, drive, initial_offset=0.0, duration=0.6)

    @pytest.mark.parametrize("suspension", ["rod", "string"])
    def test_onset(self, suspension):
        low = math.asin(0.02 / 0.25)
        for lift, moves in ((0.99, False), (1.01, True)):
            run = self.go(lift, suspension)
            assert (float(np.abs(run.angle - low).max()) > 1e-6) == moves

    def test_strings_throw_the_balls_together_and_rods_apart(self):
        rod, string = self.go(1.5, "rod"), self.go(1.5, "string")
        assert "bottom" in rod.contact_kind
        kinds = [str(kind) for kind in string.contact_kind.values]
        assert "taut" in kinds
        snap = kinds.index("taut")
        assert kinds[snap + 1] == "bottom"
        assert float(string.contact_time[snap]) == float(string.contact_time[snap + 1])
        # Side by side until the strings snap: X = r.
        flying = string.time < string.contact_time[snap]
        across = (string.distance * np.sin(string.angle))[flying.values]
        np.testing.assert_allclose(across, 0.02, rtol=0, atol=1e-14)
        # It comes to the angle -X' of its fall: the tangential part of a vertical velocity.
        before, after = (
            float(string[f"angular_velocity_{when}"][snap + 1]) for when in ("before", "after")
        )
        down = float(string.radial_velocity_before[snap]) / math.cos(math.asin(0.08))
        assert before == pytest.approx(-down * 0.08 / 0.25, rel=1e-9)
        assert after == pytest.approx(-0.9 * before, rel=1e-12)
        assert string.attrs["first_slack"] == 0.0
        assert float(np.abs(string.angle - rod.angle).max()) > 1e-3  # of 0.01 rad of motion

    @pytest.mark.parametrize("phase", [2.0, 4.0])
    @pytest.mark.parametrize("frame", ["pivot", "lab"])
    @pytest.mark.parametrize("restitution", [0.0, 0.6])
    def test_a_late_lift_off_is_that_of_the_independent_program(self, phase, frame, restitution):
        body = Body(0.25, 0.1, C=3e-3, r=0.02)
        motion = Strings(
            [body], walls=True, e=0.9, es=restitution, lab=frame == "lab", A0=0.03, w=25.0,
            phase=phase,
        )  # fmt: skip
        start, times = [(math.asin(0.02 / 0.25), 0.0)], np.linspace(0.0, 0.6, 61)
        assert_agree(simulated(motion, start, times), motion.run(start, times), 1e-8)


class TestRefusals:
    @pytest.mark.parametrize("value", [-0.1, 1.1, math.nan])
    def test_string_restitution(self, value):
        with pytest.raises(ll.InputError, match=r"string_restitution must .*"):
            ll.Pendulum(**BALL, suspension="string", string_restitution=value)

    def test_an_unknown_suspension(self):
        with pytest.raises(ll.InputError, match=r"suspension must be .*rod.*string.*wire"):
            ll.Pendulum(**BALL, suspension="wire")

    def test_an_unknown_frame_of_the_drag(self):
        with pytest.raises(ll.InputError, match=r"drag_frame must be .*pivot.*lab.*room"):
            ll.Pendulum(**BALL, drag_frame="room")

    def test_quadratic_drag_relative_to_the_room(self):
        with pytest.raises(ll.InputError, match=r"drag_frame must be 'pivot'.*quadratic_damping"):
            ll.Pendulum(**BALL, quadratic_damping=0.01, drag_frame="lab")

    @pytest.mark.parametrize("suspension", ["rod", "string"])
    def test_a_toy_that_is_moved_sideways(self, suspension):
        toy = ll.LatoLato(**BALL, radius=0.03, suspension=suspension)
        sideways = ll.PlanarHarmonic(
            vertical_amplitude=0.01, horizontal_amplitude=0.01, drive_frequency=10.0
        )
        with pytest.raises(ll.InputError, match="BallPair"):
            ll.simulate(toy, sideways, initial_angle=1.0, duration=1.0)

    @pytest.mark.parametrize("distance", [0.31, -0.1, math.nan])
    def test_a_start_beyond_the_string(self, distance):
        system = ll.Pendulum(**BALL, suspension="string")
        with pytest.raises(ll.InputError, match=r"initial_distance must .*"):
            ll.simulate(system, initial_angle=1.0, initial_distance=distance, duration=1.0)

    def test_a_rod_that_begins_slack(self):
        with pytest.raises(ll.InputError, match="initial_distance"):
            ll.simulate(ll.Pendulum(**BALL), initial_angle=1.0, initial_distance=0.2, duration=1.0)
