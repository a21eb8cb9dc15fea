"""Lift-off from rest: closed forms, the largest acceleration, and runs."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.figures.analyses import self_start as picture

TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.9)


def crank(rod, guide="below"):
    return ll.CrankSlider(
        drive_amplitude=0, drive_frequency=1, connecting_rod_length=rod, guide=guide
    )


def start(system, ratio, drive=None):
    return float(ll.analysis.self_start(system, ratio, drive).drive_amplitude)


@pytest.mark.parametrize("ratio", [1.0, 3.0, 10.0])
def test_a_cosine_lifts_where_its_acceleration_reaches_gravity(ratio):
    result = ll.analysis.self_start(TOY, ratio)
    assert float(result.drive_amplitude) == pytest.approx(1.0 / ratio**2, rel=1e-15)
    assert float(result.drive_acceleration_ratio) == pytest.approx(1.0, rel=1e-15)


def test_a_guide_above_lowers_the_amplitude_and_one_below_raises_it():
    # A (1 +- A/L) = l/ratio^2, as long as A < L/4
    below, above = (start(TOY, 5.0, crank(1.0, guide)) for guide in ("below", "above"))
    assert below * (1.0 - below) == pytest.approx(0.04, rel=1e-13)
    assert above * (1.0 + above) == pytest.approx(0.04, rel=1e-13)


@pytest.mark.parametrize("rod,guide", [(0.2, "below"), (0.4, "below"), (0.2, "above")])
def test_the_largest_acceleration_is_gravity_there(rod, guide):
    amplitude, w = start(TOY, 3.0, crank(rod, guide)), 3.0 * TOY.natural_frequency
    drive = ll.CrankSlider(
        drive_amplitude=amplitude, drive_frequency=w, connecting_rod_length=rod, guide=guide
    )
    times = np.linspace(0.0, 2.0 * math.pi / w, 20001)
    run = ll.simulate(ll.Pendulum(length=1.0, mass=0.8), drive, initial_angle=0.0, times=times)
    # the sampled peak is lower by the square of half a spacing, some 1e-7
    assert float(-run.pivot_acceleration.min()) == pytest.approx(9.8, rel=1e-6)


@pytest.mark.parametrize("drive", [None, crank(0.2), crank(0.4), crank(0.4, "above")])
def test_runs_leave_rest_at_the_same_amplitude(drive):
    result = ll.analysis.self_start(TOY, 3.5, drive, check=True)
    # bisected to 1e-11; runs see a hop once it exceeds the last digits of the force
    expected = float(result.drive_amplitude)
    assert float(result.simulated_amplitude) == pytest.approx(expected, rel=1e-9, abs=0.0)


def test_friction_raises_the_amplitude():
    # -(g + y'') m sin(low) = C0
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, coulomb_damping=0.05)
    result = ll.analysis.self_start(toy, 3.0, check=True)
    expected = (9.8 + 0.05 / (0.8 * 0.1)) / (9.0 * 9.8)
    assert float(result.drive_amplitude) == pytest.approx(expected, rel=1e-14)
    assert float(result.simulated_amplitude) == pytest.approx(expected, rel=1e-9)


def pair(right_friction=0.0, left_friction=0.0):
    return ll.BallPair(
        right=ll.Ball(length=1.0, mass=0.8, radius=0.1, coulomb_damping=right_friction),
        left=ll.Ball(length=0.95, mass=0.3, radius=0.08, coulomb_damping=left_friction),
        restitution=0.9,
    )


def test_unequal_balls_part_from_their_joint_equilibrium_like_equal_ones():
    result = ll.analysis.self_start(pair(), 3.0, check=True)
    assert float(result.drive_amplitude) == pytest.approx(1.0 / 9.0, rel=1e-14)
    assert float(result.simulated_amplitude) == pytest.approx(1.0 / 9.0, rel=1e-9)


def test_of_unequal_balls_the_one_of_least_friction_leaves_first():
    result = ll.analysis.self_start(pair(0.05, 0.03), 3.0, check=True)
    # of held balls a dip within a step is followed from its ends and middle, to some 1e-5
    expected = float(result.drive_amplitude)
    assert float(result.simulated_amplitude) == pytest.approx(expected, rel=1e-5)
    assert start(pair(0.05, 0.02), 3.0) < expected < start(pair(0.05, 0.04), 3.0)
    assert start(pair(0.06, 0.03), 3.0) == expected


def test_a_crank_that_is_too_short_is_refused():
    with pytest.warns(RuntimeWarning, match="no amplitude below 0.999 of the drive"):
        result = ll.analysis.self_start(TOY, 1.0, crank(0.2, "above"), check=True)
    assert str(result.status.values) == "out of reach"
    assert math.isnan(result.drive_amplitude)
    assert math.isnan(result.simulated_amplitude)


def test_systems_without_a_wall_or_a_radius_are_refused():
    with pytest.raises(ValueError, match="a Pendulum has no wall to start from"):
        start(ll.Pendulum(length=1.0, mass=0.8), 2.0)
    with pytest.raises(ValueError, match="balls without a radius rest straight below"):
        start(ll.LatoLato(length=1.0, mass=0.8, radius=0.0), 2.0)
    ball = ll.Ball(length=1.0, mass=0.8)
    with pytest.raises(ValueError, match="balls without a radius rest straight below"):
        start(ll.BallPair(right=ball, left=ball), 2.0)
    with pytest.raises(ValueError, match=r"frequency_ratio must lie in \[0.01, inf\)"):
        start(TOY, 0.0)


def test_the_picture_shows_the_amplitude():
    result = ll.analysis.self_start(TOY, 3.0, crank(0.4))
    texts = [text.get_text() for text in picture.draw(result).axes[0].texts]
    assert f"{1e3 * float(result.drive_amplitude):.4g} mm" in texts
