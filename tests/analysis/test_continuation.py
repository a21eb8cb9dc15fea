"""Branches of periodic motions: known special points, folds, grazing, and ends that are said."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.analysis.closed_forms import fall_time, mathieu_tongue_edges
from latolato.analysis.continuation import continue_orbit
from latolato.analysis.flow import value_of, varied
from latolato.errors import InputError

NATURAL = math.sqrt(9.8)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=0.245, mass=0.1, radius=0.0196, damping=0.00274, restitution=0.9)


def toy_shake(ratio, amplitude=0.03):
    return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * TOY.natural_frequency)


def test_hanging_still_doubles_its_period_at_both_edges_of_the_tongue():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=1.85 * NATURAL)
    branch = continue_orbit(PENDULUM, drive, low=1.8, high=2.2)
    edges = mathieu_tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
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


def test_the_softening_branch_folds_further_left_at_larger_amplitude():
    folds = []
    for amplitude in (0.02, 0.03):
        branch = continue_orbit(
            TOY, toy_shake(2.389, amplitude), low=1.0, high=3.0, direction="down", points=300,
            initial_angle=0.3, initial_angular_velocity=1.0,
        )  # fmt: skip
        kinds = list(branch.special_kind.values)
        folds.append(branch.special_value.values[kinds.index("fold")])
        # The branch turns round at the fold and both sides are on it.
        ratio = branch.frequency_ratio.values
        assert ratio.min() == pytest.approx(folds[-1], abs=1e-3)
        assert {0, 1} == set(branch.is_stable.values)
    assert folds[1] < folds[0] - 0.1


def test_at_a_fold_a_multiplier_is_one():
    branch = continue_orbit(
        TOY, toy_shake(2.389), low=1.0, high=3.0, direction="down", points=300,
        initial_angle=0.3, initial_angular_velocity=1.0,
    )  # fmt: skip
    at = int(np.argmin(branch.frequency_ratio.values))
    near = branch.multipliers.values[at - 1 : at + 2]
    assert np.min(np.abs(near - 1.0)) < 0.1
    assert near[:, 0].real.min() < 1.0 < near[:, 0].real.max() + 0.1


def test_a_branch_that_ends_in_grazing_says_so():
    with pytest.warns(RuntimeWarning, match="was lost at frequency_ratio = 4.57.* by grazing"):
        branch = continue_orbit(
            TOY, toy_shake(4.5), low=1.0, high=5.0,
            initial_angle=0.0803, initial_angular_velocity=0.045,
        )  # fmt: skip
    assert branch.status.item() == "lost"
    assert list(branch.special_kind.values) == ["grazing"]


def test_the_swing_branch_meets_the_hanging_one_in_a_pitchfork():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=2.0 * NATURAL)
    end = 400 * math.tau / drive.drive_frequency
    run = ll.simulate(PENDULUM, drive, initial_angle=0.1, times=[0.0, end])
    branch = continue_orbit(
        PENDULUM, drive, low=1.5, high=2.2, period=2, points=60,
        initial_angle=run.angle.values[-1],
        initial_angular_velocity=run.angular_velocity.values[-1],
    )  # fmt: skip
    edges = mathieu_tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
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
        ({"low": 3.0, "high": 1.0}, "must enclose"),
        ({"direction": "left"}, "'up' or 'down'"),
        ({"points": 0}, "points"),
        ({"drive": None}, "must repeat itself"),
        ({"drive": ll.Harmonic(drive_amplitude=0.1, drive_frequency=0.0)}, "must lie in"),
        ({"period": 1.5}, "whole number"),
        ({"parameter": "drive_amplitude", "low": -0.1}, r"low .* must lie in \[0, inf\) m"),
        ({"parameter": "drive_amplitude", "low": math.nan}, "low .* must be finite"),
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
            initial_angle=1.0, initial_angular_velocity=3.0,
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
    with pytest.warns(RuntimeWarning, match="was lost"):  # among more and more tiny hops
        branch = continue_orbit(TOY, drive, low=4.0, high=6.5, initial_offset=0.0, points=100)
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
