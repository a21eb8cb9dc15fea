"""Branches of periodic motions: known special points, folds, grazing, and ends that are said."""

import math
from functools import cache

import numpy as np
import pytest

import latolato as ll
from hanging import tongue_edges
from latolato.analysis.closed_forms import fall_time
from latolato.analysis.continue_orbit import continue_orbit
from latolato.analysis.flow import value_of, varied
from latolato.core.errors import InputError

NATURAL = math.sqrt(9.8)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=0.245, mass=0.1, radius=0.0196, damping=0.00274, restitution=0.9)


def toy_shake(ratio, amplitude=0.03):
    return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * TOY.natural_frequency)


def test_hanging_still_doubles_its_period_at_both_edges_of_the_tongue():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=1.85 * NATURAL)
    branch = continue_orbit(PENDULUM, drive, low=1.8, high=2.2)
    edges = tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
    assert list(branch.special_kind.values) == ["period_doubling", "period_doubling"]
    # Bisected to 1e-11 of a step, on orbits known to 1e-11.
    assert branch.special_value.values == pytest.approx(edges, abs=1e-8)
    assert branch.status.item() == "end of range"
    assert branch.frequency_ratio.values[-1] == pytest.approx(2.2, abs=1e-8)
    inside = (branch.frequency_ratio > edges[0]) & (branch.frequency_ratio < edges[1])
    assert np.array_equal(branch.is_stable.values == 0, inside.values)


@pytest.mark.parametrize("ratio, flip", [(16.0, 1.1098), (40.0, 1.0768)])
def test_a_bouncing_ball_flips_where_it_is_known_to(ratio, flip):
    # PHYSICS: C = 0, e = 0.8, low contact angle 0.1; the limit for fast drives is 1.0708.
    system = ll.LatoLato(length=1.0, mass=0.8, radius=math.sin(0.1), restitution=0.8)
    w = ratio * NATURAL
    drive = ll.Harmonic(drive_amplitude=1.0 / ratio**2, drive_frequency=w)
    speed = 0.9 * 9.8 * math.sin(0.1) * math.pi / w  # of a bounce that lasts a drive period
    branch = continue_orbit(
        system, drive, parameter="drive_acceleration_ratio", low=0.95, high=1.2,
        initial_offset=0.0, initial_angular_velocity=speed,
    )  # fmt: skip
    assert list(branch.special_kind.values) == ["period_doubling"]
    assert branch.special_value.item() == pytest.approx(flip, abs=5e-5)  # printed to 4 digits
    assert set(branch.impacts.values) == {1}


@cache
def softening_branch(amplitude):
    return continue_orbit(
        TOY, toy_shake(2.389, amplitude), low=1.0, high=3.0, direction="down", points=300,
        initial_angle=0.3, initial_angular_velocity=1.0,
    )  # fmt: skip


def test_the_softening_branch_folds_further_left_at_larger_amplitude():
    folds = []
    for amplitude in (0.02, 0.03):
        branch = softening_branch(amplitude)
        kinds = list(branch.special_kind.values)
        folds.append(branch.special_value.values[kinds.index("fold")])
        # The branch turns round at the fold and both sides are on it.
        ratio = branch.frequency_ratio.values
        assert ratio.min() == pytest.approx(folds[-1], abs=1e-3)
        assert {0, 1} == set(branch.is_stable.values)
    assert folds[1] < folds[0] - 0.1


def test_at_a_fold_a_multiplier_is_one():
    branch = softening_branch(0.03)
    at = int(np.argmin(branch.frequency_ratio.values))
    near = branch.multipliers.values[at - 1 : at + 2]
    assert np.min(np.abs(near - 1.0)) < 0.1
    assert near[:, 0].real.min() < 1.0 < near[:, 0].real.max() + 0.1


def test_a_branch_goes_on_past_grazes_with_more_and_more_impacts():
    branch = continue_orbit(
        TOY, toy_shake(4.5), low=1.0, high=5.0, points=110,
        initial_angle=0.0803, initial_angular_velocity=0.045,
    )  # fmt: skip
    assert list(branch.special_kind.values[:3]) == ["grazing", "period_doubling", "fold"]
    assert branch.special_value.values[0] == pytest.approx(4.57, abs=0.01)
    impacts = branch.impacts.values
    assert set(impacts) >= {1, 2, 3}
    assert np.all(np.diff(impacts) >= 0)
    # The motion with one impact more exists on the side from which the graze was reached.
    after = int(np.flatnonzero(impacts == 2)[0])
    assert branch.frequency_ratio.values[after] < branch.special_value.values[0]
    # Each point is an orbit by itself, found without the branch.
    for i in (after, after + 5, int(np.flatnonzero(impacts == 3)[3])):
        point = branch.isel(point=i)
        again = ll.analysis.floquet(
            TOY, toy_shake(float(point.frequency_ratio)),
            initial_angle=float(point.initial_angle),
            initial_angular_velocity=float(point.initial_angular_velocity),
        )  # fmt: skip
        assert int(again.impacts) == int(point.impacts)
        assert float(again.initial_angle) == pytest.approx(float(point.initial_angle), abs=1e-9)


def test_a_motion_keeps_its_impacts_where_another_one_is_nearly_the_same():
    # That with 13 impacts lies so near that longer steps end on it, far from its graze.
    toy = ll.LatoLato(length=0.245, mass=0.106, radius=0.02, damping=0.005, restitution=0.85)
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=3.0865 * toy.natural_frequency)
    branch = continue_orbit(
        toy, drive, low=3.0, high=3.125, points=60,
        initial_angle=0.08192930, initial_angular_velocity=0.01312817,
    )  # fmt: skip
    assert branch.status.item() == "end of range"
    assert set(branch.impacts.values) == {14}
    assert "grazing" not in branch.special_kind.values


@pytest.mark.parametrize("mass", [0.106, 0.11])
def test_two_balls_go_on_past_a_graze_equal_or_not(mass):
    right, left = (
        ll.Ball(length=0.245, mass=each, damping=0.005, radius=0.02) for each in (0.106, mass)
    )
    pair = ll.BallPair(right=right, left=left, restitution=0.85)
    # The unstable twin of the swing with one impact in every shake.
    angle, velocity = 0.0878438, 0.0193421

    branch = continue_orbit(
        pair, ll.Harmonic(drive_amplitude=0.03, drive_frequency=4.0 * pair.natural_frequency),
        low=3.9, high=4.9, points=80, initial_angle=(angle, -angle),
        initial_angular_velocity=(velocity, -velocity),
    )  # fmt: skip
    assert list(branch.special_kind.values) == ["grazing"]
    assert branch.status.item() == "end of range"
    impacts = branch.impacts.values
    assert (impacts[0], impacts[-1]) == (1, 2)
    graze = branch.special_value.item()
    # Where the single ball of the mirror image grazes; masses that differ by 4 % shift it little.
    assert graze == pytest.approx(4.5727423, abs=1e-6 if mass == 0.106 else 1e-3)
    # The motions beyond repeat themselves, with two impacts, in a run of their own.
    for i in np.flatnonzero(impacts == 2)[[1, -1]]:
        drive = ll.Harmonic(
            drive_amplitude=0.03,
            drive_frequency=float(branch.frequency_ratio[i]) * pair.natural_frequency,
        )
        period = math.tau / drive.drive_frequency
        run = ll.simulate(
            pair, drive, times=[0.0, period], tolerance=1e-12,
            initial_angle=branch.initial_angle.values[i],
            initial_angular_velocity=branch.initial_angular_velocity.values[i],
        )  # fmt: skip
        assert run.sizes["contact"] == 2
        np.testing.assert_allclose(run.angle.values[:, 1], run.angle.values[:, 0], atol=1e-8)
        np.testing.assert_allclose(
            run.angular_velocity.values[:, 1], run.angular_velocity.values[:, 0], atol=1e-7
        )


def test_the_swing_branch_meets_the_hanging_one_in_a_pitchfork():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=2.0 * NATURAL)
    end = 400 * math.tau / drive.drive_frequency
    run = ll.simulate(PENDULUM, drive, initial_angle=0.1, times=[0.0, end])
    branch = continue_orbit(
        PENDULUM, drive, low=1.5, high=2.2, period=2, points=60,
        initial_angle=run.angle.values[-1],
        initial_angular_velocity=run.angular_velocity.values[-1],
    )  # fmt: skip
    edges = tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
    assert branch.special_kind.values[0] == "symmetry_breaking"
    # The amplitude starts as a square root: the edge is met to the square of its error.
    assert branch.special_value.values[0] == pytest.approx(edges[1], abs=1e-7)


def test_every_parameter_can_be_read_and_set():
    drive = toy_shake(2.0)
    for name, value in (
        ("frequency_ratio", 2.5), ("amplitude_ratio", 0.2), ("drive_acceleration_ratio", 1.5),
        ("damping", 0.01), ("restitution", 0.7), ("drive_frequency", 9.0), ("radius", 0.01),
    ):  # fmt: skip
        system, changed = varied(TOY, drive, name, value)
        assert value_of(system, changed, name) == pytest.approx(value, rel=1e-14)
    pair = ll.BallPair(right=TOY.balls[0], left=TOY.balls[0])
    changed_pair, _ = varied(pair, drive, "left_mass", 0.3)
    assert changed_pair.left.mass == 0.3


def test_the_branch_of_a_shorter_period_is_named():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=1.85 * NATURAL)
    branch = continue_orbit(PENDULUM, drive, low=1.8, high=2.0, period=3)
    assert "repeats after 1 of 3 drive periods" in branch.attrs["message"]
    assert branch.special_value.values == pytest.approx([1.909946298], abs=1e-9)


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"parameter": "frequency_ration"}, "did you mean 'frequency_ratio'"),
        ({"low": 2.1}, "must enclose"),
        ({"low": 3.0, "high": 1.0}, "low must be less than high"),
        ({"direction": "left"}, "'up' or 'down'"),
        ({"points": 0}, "points"),
        ({"drive": None}, "must repeat itself"),
        ({"drive": ll.Harmonic(drive_amplitude=0.1, drive_frequency=0.0)}, "must lie in"),
        ({"period": 1.5}, "whole number"),
        ({"parameter": "drive_amplitude", "low": -0.1}, r"low .* must lie in \[0, inf\) m"),
        ({"parameter": "drive_amplitude", "low": math.nan}, "low must be a number"),
    ],
)
def test_bad_input_is_refused(changes, message):
    given = {"drive": ll.Harmonic(drive_amplitude=0.05, drive_frequency=2.0 * NATURAL)}
    given |= {"low": 1.8, "high": 2.2} | changes
    with pytest.raises(InputError, match=message):
        continue_orbit(PENDULUM, given.pop("drive"), **given)


def test_a_branch_without_a_first_orbit_is_empty():
    system = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    drive = ll.Harmonic(drive_amplitude=0.4, drive_frequency=9.0)
    with pytest.warns(RuntimeWarning, match="not found"):
        branch = continue_orbit(
            system, drive, low=2.5, high=3.5, tolerance=1e-6,
            initial_angle=1.0, initial_angular_velocity=2.0,
        )  # fmt: skip
    assert branch.sizes["point"] == 0
    assert branch.status.item() == "not found"


@pytest.mark.parametrize("turning_angle", [0.2, 0.6, 1.2, 2.0, 2.8])
def test_the_undriven_backbone_of_bounces_is_the_elliptic_one(turning_angle):
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    fall = fall_time(length=1.0, radius=0.1, initial_angle=turning_angle)
    run = ll.simulate(toy, None, initial_angle=turning_angle, duration=6.5 * fall, tolerance=1e-13)
    period = np.diff(run.contact_time.values)
    assert len(period) == 2
    frequency = math.pi / fall  # a bounce lasts two falls
    assert math.tau / period == pytest.approx(frequency, rel=1e-10)  # asked for


@pytest.mark.parametrize(
    "parameter, low, high, direction, end",
    [
        ("restitution", 0.7, 1.0, "up", 1.0),
        ("damping", 0.0, 0.05, "down", 0.0),
        ("radius", 0.0, 0.05, "down", 0.0),
    ],
)
def test_a_branch_reaches_the_end_of_what_a_parameter_may_be(parameter, low, high, direction, end):
    branch = continue_orbit(
        TOY, toy_shake(2.4), parameter=parameter, low=low, high=high, direction=direction,
        initial_offset=0.7, points=400,
    )  # fmt: skip
    assert branch.status.item() == "end of range"
    assert branch[parameter].values[-1] == pytest.approx(end, abs=2e-6 * (high - low))


def test_a_toy_at_rest_lifts_off_where_gravity_is_exceeded():
    drive = ll.Harmonic(drive_amplitude=0.0098, drive_frequency=4.5 * TOY.natural_frequency)
    # A0 w^2 = g at the ratio sqrt(l/A0) = 5.
    branch = continue_orbit(TOY, drive, low=4.0, high=6.5, initial_offset=0.0, points=40)
    assert branch.special_kind.values[0] == "lift_off"
    # The first hops are too small to be seen.
    assert branch.special_value.values[0] == pytest.approx(5.0, abs=1e-2)
    resting = branch.frequency_ratio.values < 5.0
    assert branch.impacts.values[resting].max() == 0


def test_orbits_of_absurdly_slow_drives_and_of_no_system_are_refused():
    slow = ll.Harmonic(drive_amplitude=1e-3, drive_frequency=1e-4)
    with pytest.raises(ValueError, match=r"at least 0\.01 natural frequencies"):
        continue_orbit(PENDULUM, slow, low=1.0, high=2.0)
    with pytest.raises(InputError, match="system must be one of"):
        continue_orbit(5, slow, low=1.0, high=2.0)


@pytest.mark.parametrize(
    "ratio, period", [(70, 1), (100, 1), (100, 2), (300, 2), (1000, 2), (4000, 2)]
)
def test_hops_of_any_size_fold_where_bouncing_can_no_longer_pay_for_its_impacts(ratio, period):
    system = ll.LatoLato(length=1.0, mass=0.8, radius=math.sin(0.1), restitution=0.7)
    w = ratio * NATURAL
    # On a table a flight of n periods begins at g n T/2 and the ball arrives as fast; the impact
    # gives that back for (1 + e) A0 w cos(phase) = (1 - e) g n T/2: A0 w^2/g has this minimum.
    least = period * math.pi * (1.0 - 0.7) / (1.0 + 0.7)
    branch = continue_orbit(
        system, ll.Harmonic(drive_amplitude=1.05 * least * 9.8 / w**2, drive_frequency=w),
        parameter="drive_acceleration_ratio", low=0.9 * least, high=1.2 * least,
        direction="down", period=period, initial_offset=0.0,
        initial_angular_velocity=9.8 * math.sin(0.1) * period * math.pi / w,
    )  # fmt: skip
    assert list(branch.special_kind.values) == ["fold"]
    # The pendulum differs from the table by the square of the flight time.
    assert branch.special_value.item() == pytest.approx(least, rel=20.0 / ratio**2 + 2e-6)
    # Beyond the fold the branch goes back along its unstable side, to the other end.
    assert branch.status.item() == "end of range"
    assert {0, 1} == set(branch.is_stable.values)


def test_hanging_loses_its_mirror_symmetry_in_the_second_tongue():
    edges = tongue_edges(
        drive_amplitude=0.3, length=1.0, mass=0.8, damping=0.05, order=2
    )  # fmt: skip
    drive = ll.Harmonic(drive_amplitude=0.3, drive_frequency=0.8 * NATURAL)
    branch = continue_orbit(PENDULUM, drive, low=0.8, high=1.2)
    assert list(branch.special_kind.values) == ["symmetry_breaking", "symmetry_breaking"]
    assert branch.special_value.values == pytest.approx(edges, abs=1e-8)


def test_a_large_swing_loses_its_mirror_symmetry_before_it_doubles_its_period():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=2.0 * NATURAL)
    branch = continue_orbit(
        PENDULUM, drive, parameter="drive_amplitude", low=0.01, high=0.6, period=2,
        initial_angle=0.9, initial_angular_velocity=0.0,
    )  # fmt: skip
    assert list(branch.special_kind.values) == ["symmetry_breaking"]
    place = branch.special_value.item()

    def settled(amplitude):
        near = branch.isel(point=int(np.argmin(np.abs(branch.drive_amplitude.values - amplitude))))
        changed = ll.Harmonic(
            drive_amplitude=near.drive_amplitude.item(), drive_frequency=2.0 * NATURAL
        )
        return near.is_stable.item(), ll.analysis.response_period(
            PENDULUM, changed, initial_angle=near.initial_angle.item() + 1e-4,
            initial_angular_velocity=near.initial_angular_velocity.item(),
            transient_periods=2000,
        )  # fmt: skip

    # Below, the swing is its own mirror image one drive period later; above, it leaves for one of
    # two motions of the same period that are not.
    (stable, below), (unstable, above) = settled(place - 0.013), settled(place + 0.007)
    assert (stable, unstable) == (1, 0)
    assert below.response_period == above.response_period == 2.0
    assert below.mirror_residual < 1e-8
    assert above.mirror_residual > 0.1


def test_a_bounce_of_two_periods_ends_where_a_bounce_of_one_doubles_its_period():
    system = ll.LatoLato(length=1.0, mass=0.8, radius=math.sin(0.1), restitution=0.8)
    w = 40.0 * NATURAL

    def follow(ratio, low, period, offset, velocity, direction):
        drive = ll.Harmonic(drive_amplitude=ratio * 9.8 / w**2, drive_frequency=w)
        return continue_orbit(
            system, drive, parameter="drive_acceleration_ratio", low=low, high=1.2, points=60,
            direction=direction, period=period, initial_offset=offset,
            initial_angular_velocity=velocity,
        )  # fmt: skip

    speed = 0.9 * 9.8 * math.sin(0.1) * math.pi / w
    single = follow(1.0, 1.0, 1, 0.0, speed, "up")
    flip = single.special_value.item()
    # Seen over two periods the same point is no loss of symmetry: the walls leave none.
    twice = follow(1.0, 1.0, 2, 0.0, speed, "up")
    assert list(twice.special_kind.values) == ["period_doubling"]
    assert twice.special_value.item() == pytest.approx(flip, abs=1e-7)
    # The doubled branch turns round there into itself, one drive period later.
    near = int(np.searchsorted(single.drive_acceleration_ratio.values, 1.0775))
    start = single.isel(point=near)
    ratio = start.drive_acceleration_ratio.item()
    run = ll.simulate(
        system, ll.Harmonic(drive_amplitude=ratio * 9.8 / w**2, drive_frequency=w),
        initial_angle=start.initial_angle.item(),
        initial_angular_velocity=1.01 * start.initial_angular_velocity.item() + 1e-5,
        times=[2000 * math.tau / w],
    )  # fmt: skip
    doubled = follow(
        ratio, 1.0, 2, run.angle.item() - 0.1, run.angular_velocity.item(), "down"
    )  # fmt: skip
    assert list(doubled.special_kind.values) == ["period_doubling"]
    assert doubled.special_value.item() == pytest.approx(flip, abs=1e-6)


def test_the_branches_that_leave_a_tongue_are_one_swing_of_twice_the_period():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=1.85 * NATURAL)
    hanging = continue_orbit(PENDULUM, drive, low=1.5, high=2.3)
    left, right = (
        continue_orbit(PENDULUM, drive, low=1.0, high=2.3, at=hanging.special[k], points=300)
        for k in range(2)
    )
    for swing, edge in zip((left, right), hanging.special_value.values, strict=True):
        assert swing.frequency_ratio.values[0] == pytest.approx(edge, abs=1e-12)
        # It leaves along the motion: the parameter changes with the square of the angle.
        bent = (swing.frequency_ratio.values[1:6] - edge) / swing.largest_angle.values[1:6] ** 2
        np.testing.assert_allclose(bent, bent[-1], rtol=0.01)
    # Softening: at the right edge stable swings grow out of the tongue, at the left unstable ones.
    assert right.is_stable.values[5] == 1
    assert left.is_stable.values[5] == 0
    # Both are the same branch, which folds once; found from a start on it by another way.
    swinging = continue_orbit(
        PENDULUM,
        drive,
        low=1.0,
        high=1.9,
        direction="down",
        period=2,
        initial_angle=0.9,
        points=300,
    )
    fold = swinging.special_value.values[list(swinging.special_kind.values).index("fold")]
    assert list(left.special_kind.values) == list(right.special_kind.values) == ["fold"]
    assert left.special_value.item() == pytest.approx(fold, abs=1e-8)
    assert right.special_value.item() == pytest.approx(fold, abs=1e-8)


def test_a_bouncing_toy_doubles_its_period_twice():
    toy = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.85)
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.2 * toy.natural_frequency)
    bounce = continue_orbit(
        toy, drive, low=0.5, high=6.0, initial_angle=0.3177, initial_angular_velocity=5.398
    )
    twice = continue_orbit(toy, drive, low=0.5, high=6.0, at=bounce.special[0], points=60)
    assert list(twice.special_kind.values) == ["period_doubling"]
    assert set(twice.impacts.values) == {2}
    # Between both doublings a run settles on it, from a start beside it.
    ratio = 0.5 * (bounce.special_value.item() + twice.special_value.item())
    run = ll.analysis.response_period(
        toy, ll.Harmonic(drive_amplitude=0.03, drive_frequency=ratio * toy.natural_frequency),
        initial_angle=0.12,
    )  # fmt: skip
    assert run.response_period.item() == 2.0


def test_a_branch_begins_at_special_points_only():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=1.85 * NATURAL)
    with pytest.raises(InputError, match="must be a special point of continue_orbit"):
        continue_orbit(PENDULUM, drive, low=1.5, high=2.3, at=1)
