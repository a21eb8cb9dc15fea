"""Sections, impact maps and bifurcation diagrams: counts of points, known branches, hysteresis."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.analysis import bifurcation_diagram, impact_map, poincare_section, response_period
from latolato.analysis.bifurcation_diagram import _differ

SINGLE = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, restitution=0.9, damping=0.00506)
BALL = ll.Ball(length=0.245, mass=0.10644, radius=0.0196, damping=0.00506)
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
TONGUE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)


def toy_drive(ratio, amplitude=0.03):
    return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * TOY.natural_frequency)


@pytest.mark.parametrize("phase", [0.0, 1.0, math.pi, 5.0])
def test_the_section_of_period_two_is_two_mirrored_points_at_every_phase(phase):
    result = poincare_section(SINGLE, TONGUE, initial_angle=0.1, section_phase=phase, periods=20)
    angle, speed = result.angle.values, result.angular_velocity.values
    # The run's tolerance of 1e-9 and what is left of the transient.
    for samples in (angle, speed):
        assert np.ptp(samples[::2]) < 1e-6
        assert samples[1] == pytest.approx(-samples[0], abs=1e-6)


def test_points_of_a_section_lie_at_its_phase_after_the_transient():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26, drive_phase=2.0)
    result = poincare_section(
        SINGLE, drive, initial_angle=0.1, section_phase=1.0, periods=5, transient_periods=10
    )
    turns = (6.26 * result.time.values + 2.0 - 1.0) / math.tau
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)  # rounding
    assert result.time.values[0] >= 10 * math.tau / 6.26


def test_the_map_of_a_period_one_bounce_is_one_point():
    result = impact_map(TOY, toy_drive(2.4), initial_offset=0.2, periods=20)
    assert result.status == "complete"
    assert result.impacts_per_period == 1.0
    assert set(result.impact_side.values) == {"bottom"}
    assert np.ptp(result.impact_phase.values) < 1e-6  # tolerance 1e-9, and the transient's rest
    assert np.all(result.angular_velocity_after > 0.0)
    expected = response_period(TOY, toy_drive(2.4), initial_offset=0.2)
    assert result.impacts_per_period == expected.impacts_per_period


def test_strong_driving_knocks_at_bottom_and_top_alternately():
    result = impact_map(TOY, toy_drive(3.0, 0.1), initial_offset=0.2, periods=6)
    sides = list(result.impact_side.values)
    assert sides[:4] in (["top", "bottom"] * 2, ["bottom", "top"] * 2)
    # Away from the wall: inwards at the top, outwards at the bottom.
    assert np.all(
        np.sign(result.angular_velocity_after) == np.where(np.array(sides) == "top", -1, 1)
    )


def test_balls_at_rest_have_no_impacts():
    result = impact_map(TOY, toy_drive(2.4), initial_offset=0.0, periods=5, transient_periods=10)
    assert (result.status, result.sizes["impact"]) == ("no impacts", 0)


def test_two_balls_open_twice_as_fast_as_one_leaves_the_wall():
    one = impact_map(TOY, toy_drive(2.4), initial_offset=0.2, periods=5)
    low = TOY.contact_angle_low + 0.2
    two = impact_map(PAIR, toy_drive(2.4), initial_angle=(low, -low), periods=5)
    np.testing.assert_allclose(two.impact_phase, one.impact_phase, atol=1e-6)  # both runs' errors
    np.testing.assert_allclose(
        two.angular_velocity_after, 2.0 * one.angular_velocity_after, rtol=1e-6
    )


def test_figure_11_has_rest_on_the_way_up_and_motion_on_the_way_down():
    result = bifurcation_diagram(
        TOY,
        toy_drive(2.4),
        parameter="frequency_ratio",
        low=2.2,
        high=3.2,
        points=26,
        initial_offset=0.0,
    )
    between = result.sel(frequency_ratio=slice(2.21, 2.59))
    assert set(between.status.sel(direction="up").values) == {"rest"}
    assert set(between.status.sel(direction="down").values) == {"periodic"}
    assert np.all(between.is_hysteretic == 1)
    # Just above lift-off the balls hop low on the way up, and swing on the way down.
    assert np.all(result.is_hysteretic.sel(frequency_ratio=slice(3.03, 3.2)) == 0)
    # Lift-off from rest, A0 w^2 = g, comes before the upper branch is reached.
    lift_off = math.sqrt(TOY.length / 0.03)
    jump = result.frequency_ratio.where(result.status.sel(direction="up") != "rest").min()
    assert lift_off <= jump <= lift_off + 0.1
    # The upper branch softens: the angle grows towards lower frequencies.
    down = between.largest_angle_watched.sel(direction="down")
    assert np.all(np.diff(down) < 0.0)


def test_one_way_of_a_diagram_is_that_of_both():
    options = {"parameter": "drive_amplitude", "low": 0.02, "high": 0.04, "points": 5}
    both = bifurcation_diagram(TOY, toy_drive(3.0), **options, initial_offset=0.2)
    down = bifurcation_diagram(TOY, toy_drive(3.0), **options, initial_offset=0.2, direction="down")
    assert "is_hysteretic" not in down
    np.testing.assert_array_equal(
        down.section_angle.values[0], both.section_angle.sel(direction="down").values
    )


@pytest.mark.parametrize(
    "options, message",
    [
        ({"parameter": "restitutoin"}, "restitution"),
        ({"parameter": "initial_angle"}, "unknown parameter"),
        ({"low": 0.9, "high": 0.8}, "low must be less than high, got 0.9"),
        ({"high": 1.1}, r"high must lie in \[0, 1\]"),
        ({"points": 1}, "points must lie in"),
        ({"direction": "left"}, "direction must be"),
    ],
)
def test_bad_input_of_a_diagram_is_refused(options, message):
    swept = {
        "parameter": "restitution",
        "low": 0.8,
        "high": 0.9,
        "initial_offset": 0.1,
        **options,
    }
    with pytest.raises(ValueError, match=message):
        bifurcation_diagram(TOY, toy_drive(2.4), **swept)


def test_an_impact_map_needs_walls():
    with pytest.raises(ValueError, match="needs walls, and Pendulum has none"):
        impact_map(SINGLE, TONGUE, initial_angle=0.1)


def test_sections_need_at_least_one_point():
    with pytest.raises(ValueError, match="periods must lie in"):
        poincare_section(SINGLE, TONGUE, initial_angle=0.1, periods=0)


def test_whether_two_chaotic_ways_differ_is_undecided():
    largest = np.array([[0.28, 0.5, 0.5, 0.5, 0.1], [3.04, 0.5, 0.7, 0.5, 0.1]])
    up = ["aperiodic", "periodic", "periodic", "not settled", "rest"]
    down = ["aperiodic", "aperiodic", "periodic", "periodic", "rest"]
    kept = {
        "status": np.array([up, down]),
        "largest_angle_watched": largest,
        "response_period": np.array([[math.nan, 1, 1, math.nan, 1], [math.nan, math.nan, 1, 1, 1]]),
    }
    np.testing.assert_array_equal(_differ(kept, 0.01), [math.nan, 1.0, 1.0, math.nan, 0.0])
