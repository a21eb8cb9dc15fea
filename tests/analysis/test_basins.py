"""Basins: attractors found without names, their shares and entropies, and the first push."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.analysis import basin_entropy, basins, first_push
from latolato.analysis.basins import UNRESOLVED, find_attractors

SINGLE = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, restitution=0.9, damping=0.00506)


def toy_drive(ratio, amplitude=0.03):
    return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * TOY.natural_frequency)


def test_figure_11_has_a_lower_and_an_upper_branch_at_a_ratio_between_its_peaks():
    found = basins(TOY, toy_drive(2.4), angle_points=20, velocity_points=20)
    rest = found.isel(attractor=np.flatnonzero(found.status == "rest"))
    assert rest.sizes["attractor"] == 1
    upper = found.sel(attractor=0)
    assert (upper.status, upper.response_period, upper.rotation_number) == ("periodic", 1.0, 1.0)
    # 41 degrees, from the single run of test_response_period.
    assert upper.largest_angle_watched.item() == pytest.approx(0.7168, abs=1e-3)
    total = found.basin_fraction.sum() + found.unresolved_fraction
    assert total.item() == pytest.approx(1.0, abs=1e-12)
    assert np.all(np.diff(found.basin_fraction) <= 0.0)
    assert np.all(found.basin_fraction_low <= found.basin_fraction)
    assert np.all(found.basin_fraction <= found.basin_fraction_high)
    for number in found.attractor.values:
        share = (found.basin == number).mean()
        assert share == found.basin_fraction.sel(attractor=number)
    assert found.basin_entropy > 0.0


def test_one_attractor_has_the_whole_basin_and_no_entropy():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=7.5)
    found = basins(
        SINGLE, drive, angle_points=6, velocity_points=6, velocity_low=-2.0, velocity_high=2.0
    )
    assert list(found.status.values) == ["rest"]
    assert found.basin_fraction.values == [1.0]
    assert found.basin_entropy == 0.0
    assert found.boundary_basin_entropy == 0.0


def test_rotations_both_ways_are_two_attractors_with_mirrored_basins():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
    found = basins(SINGLE, drive, angle_points=16, velocity_points=16)
    table = found.basin.values
    turning = {float(found.rotation_number[n]): n for n in found.attractor.values}
    one, other = turning[1.0], turning[-1.0]
    # (angle, velocity) -> (-angle, -velocity) turns the map by half a turn.
    np.testing.assert_array_equal(table[::-1, ::-1] == one, table == other)


def test_mirror_images_are_numbered_by_rotation_and_not_by_a_few_starts():
    # One start that rounding sends to the one or the other makes their basins unequal here.
    drive = ll.Harmonic(drive_amplitude=0.09, drive_frequency=6.26)
    found = basins(SINGLE, drive, angle_points=12, velocity_points=12)
    assert found.rotation_number.values.tolist() == [0.5, -1.0, 1.0, -1.0, 1.0]


# Driven pendulum of Leven & Koch (1981), x'' + 0.15 x' + (1 + p cos 1.56 t) sin x = 0, p = 0.7:
# gravity over length 1, and A0 w^2/g = p; the sign of p is a matter of the drive's phase.
LEVEN_KOCH = ll.Pendulum(length=1.0, mass=1.0, gravity=1.0, damping=0.15)
LEVEN_KOCH_DRIVE = ll.Harmonic(drive_amplitude=0.7 / 1.56**2, drive_frequency=1.56)


def leven_koch(points, drive=LEVEN_KOCH_DRIVE, **options):
    return basins(LEVEN_KOCH, drive, angle_points=points, velocity_points=points, **options)


def test_starts_that_another_tolerance_leads_elsewhere_are_uncertain():
    found = leven_koch(40)
    assert found.unresolved_fraction == 0.0
    # Between 1e-6 and 1e-12 11.6 % of the starts change in one map of this pendulum, 15 % here.
    share = found.uncertain_fraction.item()
    assert 0.08 < share < 0.2
    assert found.uncertain.dims == found.basin.dims
    assert found.uncertain.mean().item() == share
    assert f"{100.0 * share:.3g} % of the starts lead elsewhere" in found.attrs["message"]
    # The flags are those of the labels at the second tolerance.
    finer = leven_koch(40, tolerance=1e-7, known=found)
    np.testing.assert_array_equal(finer.attractor, found.attractor)
    np.testing.assert_array_equal(finer.basin != found.basin, found.uncertain == 1)


def test_starts_of_smooth_basins_are_certain():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=7.5)
    found = basins(
        SINGLE, drive, angle_points=6, velocity_points=6, velocity_low=-2.0, velocity_high=2.0
    )
    assert found.uncertain_fraction == 0.0
    assert not found.uncertain.values.any()
    assert "message" not in found.attrs


def test_attractors_keep_their_numbers_over_a_series_of_maps():
    first = leven_koch(20)
    assert list(first.attractor) == list(range(first.sizes["attractor"]))

    def told(result):
        return {
            int(n): (str(row.status.item()), row.rotation_number.item(), row.response_period.item())
            for n, row in ((n, result.sel(attractor=n)) for n in result.attractor.values)
        }

    # Numbers exchanged beforehand stay so: they come from `known`, not from the basins' sizes.
    exchanged = first.assign_coords(attractor=first.attractor.values[::-1])
    again = leven_koch(24, known=exchanged)
    assert told(again) == told(exchanged)
    faster = ll.Harmonic(drive_amplitude=0.7 / 1.56**2, drive_frequency=1.57)
    for number, row in told(leven_koch(20, drive=faster, known=exchanged)).items():
        if number in told(exchanged):
            assert row[:2] == told(exchanged)[number][:2]


def test_a_new_attractor_gets_a_number_that_no_map_has_used():
    first = leven_koch(20)
    rest = int(first.attractor[first.status == "rest"].item())
    turns = int(first.attractor[first.rotation_number == 1.0].item())
    known = first.sel(attractor=[n for n in first.attractor.values if n != turns])
    found = leven_koch(20, known=known)
    assert rest in found.attractor
    new = first.sizes["attractor"]
    assert found.rotation_number.sel(attractor=new) == 1.0
    assert turns not in found.attractor
    assert found.attrs["numbers_used"] == new + 1
    np.testing.assert_array_equal(found.basin == new, first.basin == turns)


def made(cycles, starts, samples=49, noise=0.0):
    """Samples of cycles, started at random places; shape (start, sample, 2)."""
    rng = np.random.default_rng(1)
    which = np.arange(starts) % len(cycles)
    found = np.zeros((starts, samples, 2))
    for row, cycle in enumerate(which):
        angles = np.roll(cycles[cycle], rng.integers(len(cycles[cycle])))
        found[row, :, 0] = np.resize(angles, samples) + math.tau * rng.integers(-3, 4)
    return found + noise * rng.standard_normal(found.shape), which


def test_cycles_are_one_attractor_whatever_their_phase_and_their_turns():
    cycles = [[0.1, 0.2, 0.5], [0.1, 0.5, 0.2], [0.3], [1.0, -1.0]]
    samples, which = made(cycles, 40, noise=1e-5)
    period = np.array([3.0, 3.0, 1.0, 2.0])[which]
    status = np.full(40, "periodic")
    labels, examples = find_attractors(samples, period, status, match_tolerance=0.01, chaos_box=0.1)
    assert len(examples) == 4
    for number in range(4):
        assert len(set(which[labels == number])) == 1


def test_chaotic_motions_are_one_if_they_visit_the_same_places():
    rng = np.random.default_rng(2)
    samples = np.zeros((30, 49, 2))
    samples[:, :, 0] = rng.uniform(0.0, 1.0, (30, 49))
    samples[20:, :, 0] += 1.5
    labels, _ = find_attractors(
        samples,
        np.full(30, math.nan),
        np.full(30, "aperiodic"),
        match_tolerance=0.01,
        chaos_box=0.1,
    )
    assert set(labels[:20]) == {0}
    assert set(labels[20:]) == {1}


def test_a_failed_start_and_a_lonely_chaotic_one_stay_unresolved():
    samples, _ = made([[0.3]], 10)
    samples[9] += np.random.default_rng(3).uniform(0.0, 1.0, (49, 2))
    status = np.array(["periodic"] * 8 + ["failed", "aperiodic"])
    labels, _ = find_attractors(samples, np.ones(10), status, match_tolerance=0.01, chaos_box=0.1)
    assert list(labels) == [0] * 8 + [UNRESOLVED] * 2


def test_the_entropy_of_labels_drawn_at_random_is_the_logarithm_of_their_number():
    labels = np.random.default_rng(4).integers(0, 3, (300, 300))
    found = basin_entropy(labels, 20)
    # A box of n labels falls short of ln k by (k - 1)/(2 n) on average.
    assert found.basin_entropy == pytest.approx(math.log(3) - 1.0 / 400.0, abs=5e-4)
    assert found.boundary_basin_entropy == found.basin_entropy
    assert found.boundary_share == 1.0


def test_the_entropy_of_a_straight_boundary_counts_its_boxes_only():
    labels = np.zeros((100, 100), dtype=int)
    labels[:, 52:] = 1  # two fifths of one column of boxes
    found = basin_entropy(labels, 5)
    shares = np.array([0.4, 0.6])
    entropy = -np.sum(shares * np.log(shares))
    assert found.boundary_basin_entropy == pytest.approx(entropy, abs=1e-15)
    assert found.boundary_share == pytest.approx(0.05, abs=1e-15)
    assert found.basin_entropy == pytest.approx(0.05 * entropy, abs=1e-15)


@pytest.mark.parametrize(
    "options, message",
    [
        ({"angle_low": 0.0}, "balls would overlap"),
        (
            {"velocity_low": 2.0, "velocity_high": 1.0},
            "velocity_low must be less than velocity_high",
        ),
        ({"entropy_box": 30}, "entropy_box must be at most"),
        ({"match_tolerance": 0.0}, "match_tolerance"),
        ({"check_tolerance": 1e-6}, "check_tolerance must be below the tolerance of 10⁻⁶ rad"),
        ({"known": 3}, "known must be a result of basins"),
        ({"angle_points": 1_000_000, "velocity_points": 100}, "exceed the limit"),
    ],
)
def test_bad_input_is_refused(options, message):
    given = {"angle_points": 20, "velocity_points": 20, **options}
    with pytest.raises(ValueError, match=message):
        basins(TOY, toy_drive(2.4), **given)


def test_a_push_is_needed_below_lift_off_and_none_above():
    found = first_push(TOY, toy_drive(2.4), frequency_ratio=[2.2, 2.4, 3.1, 3.4], scan_points=40)
    assert list(found.status.values[:, 0]) == ["push", "push", "self-start", "self-start"]
    assert np.all((found.drive_acceleration_ratio > 1.0) == [False, False, True, True])
    assert np.all(found.first_push[:2] > 0.0)
    assert np.all(found.first_push[2:] == 0.0)
    # Less push is needed the nearer lift-off is.
    assert found.first_push[0, 0] > found.first_push[1, 0]
    # Three refinements by eight.
    expected = found.attrs["scan_resolution"] / 8**3
    np.testing.assert_allclose(found.push_error[:2], expected, rtol=1e-9)


def test_the_first_push_is_a_border_between_rest_and_motion():
    drive = toy_drive(2.4)
    found = first_push(TOY, drive, frequency_ratio=[2.4], scan_points=40)
    push, error = found.first_push.item(), found.push_error.item()
    for size, status in ((push, "periodic"), (push - error, "rest")):
        run = ll.analysis.response_period(
            TOY, drive, initial_offset=0.0, initial_angular_velocity=size, tolerance=1e-6
        )
        assert run.status == status


def test_the_unstable_hanging_pendulum_needs_any_push_and_the_stable_one_a_large_one():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.0)
    found = first_push(SINGLE, drive, frequency_ratio=[1.8, 2.0], scan_points=40)
    assert list(found.status.values[:, 0]) == ["push", "any push"]
    assert found.first_push[0, 0] > 0.5  # the softening branch beside the tongue
    assert found.first_push[1, 0] == 0.0


def test_no_push_is_found_where_nothing_lasts():
    found = first_push(
        TOY, toy_drive(2.4, 0.0), frequency_ratio=[2.4], scan_points=5, transient_periods=600
    )
    assert found.status == "none"
    assert math.isnan(found.first_push.item())


@pytest.mark.parametrize(
    "options, message",
    [
        ({"push": "kick"}, "push must be 'initial_"),
        ({"largest_push": -1.0}, "largest_push"),
        ({"scan_points": 0}, "scan_points"),
        ({"sustained_angle": 0.0}, "sustained_angle"),
        ({"frequency_ratio": [0.0]}, "frequency_ratio"),
    ],
)
def test_bad_input_of_the_push_is_refused(options, message):
    given = {"frequency_ratio": [2.4], **options}
    with pytest.raises(ValueError, match=message):
        first_push(TOY, toy_drive(2.4), **given)


def test_motion_that_dies_down_slowly_is_no_attractor():
    slow = ll.Pendulum(length=0.25, mass=0.1, damping=0.0005)
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.4 * slow.natural_frequency)
    with pytest.warns(RuntimeWarning, match="has not settled after 500 drive periods"):
        found = basins(slow, drive, angle_points=20, velocity_points=20)
    assert found.sizes["attractor"] == 0
    assert found.unresolved_fraction.item() == 1.0
    assert found.not_settled_fraction.item() > 0.95
    assert math.isnan(found.basin_entropy.item())
