"""Measured angles give back the parameters of the model that made them."""

import numpy as np
import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.experiment.fits.decay import fit_decay
from latolato.experiment.fits.model import fit_model
from track_tables import PLACE, motion_table

PENDULUM = ll.Pendulum(length=0.363, mass=0.108, damping=0.00274)
TOY = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.9)
BALL = ll.Ball(length=0.245, mass=0.106, damping=0.005, radius=0.02)
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
SLOW = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.09)
FAST = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.1)


def near(result, **truths):
    for name, truth in truths.items():
        assert abs(result[name].value - truth) < 4.0 * result[name].sigma, (name, str(result[name]))


def test_a_driven_pendulum_is_found_within_its_sigma_with_the_measured_pivot():
    guess = ll.Pendulum(length=0.35, mass=0.108, damping=0.004)
    misses = []
    for seed in range(8):
        noise = {"seed": seed, "correlation": (0.0, 0.7)[seed % 2]}
        table = motion_table(PENDULUM, SLOW, initial_angle=0.3, duration=6.0, **noise)
        fit = fit_model(table, guess)
        truths = {"length": 0.363, "damping": 0.00274}
        misses += [(fit[name].value - x) / fit[name].sigma for name, x in truths.items()]
        assert fit["length"].value == pytest.approx(0.363, rel=1e-3)
    assert np.mean(np.abs(misses) < 2.0) > 0.75  # 16 numbers
    assert "in one piece" in fit.verdict
    assert isinstance(fit.drive, ll.Harmonic)


def test_parameters_that_no_sample_tells_apart_are_named():
    # On a pivot at rest the motion depends on g/l and, with all of it, on the damping over l.
    table = motion_table(PENDULUM, initial_angle=0.5, duration=4.0)
    with pytest.raises(InputError, match="do not tell gravity and length apart"):
        fit_model(table, PENDULUM, vary=["gravity", "length", "damping"])


def test_a_pivot_seen_aside_is_within_the_deviations():
    guess = ll.Pendulum(length=0.35, mass=0.108, damping=0.004)
    misses, driven = [], []
    for seed in range(6):
        aside = {"size": 1.2e-4, "pivot_error": np.random.default_rng(seed).normal(0.0, PLACE, 2)}
        still = motion_table(PENDULUM, initial_angle=0.7, seed=seed, duration=6.0, **aside)
        fit = fit_model(still, guess)
        misses += [(fit["length"].value - 0.363) / fit["length"].sigma]
        misses += [(fit["damping"].value - 0.00274) / fit["damping"].sigma]
        moved = motion_table(PENDULUM, SLOW, initial_angle=0.3, seed=seed, duration=5.0, **aside)
        fit = fit_model(moved, guess)
        driven += [(fit["length"].value - 0.363) / fit["length"].sigma]
    # Without the pivot's error half of them miss by more.
    assert np.mean(np.abs(misses) < 2.0) > 0.8
    assert np.mean(np.abs(driven) < 2.0) > 0.8


def test_a_pivot_far_from_its_place_in_the_table_is_doubted():
    # Three pixels above a pivot that the table knows to 0.15 pixels.
    table = motion_table(
        PENDULUM, initial_angle=0.9, duration=8.0, size=1.2e-4, pivot_error=(0.0, 3.0)
    )
    fits = fit_decay(table, mass=0.108, compare=False, profile=False), fit_model(table, PENDULUM)
    for fit in fits:
        assert not fit.describes
        assert fit.dataset.attrs["break"] == "pivot"
        assert "of the arm above where the table has it" in fit.doubt


def test_the_scale_that_a_misplaced_pivot_gives_widens_what_a_drive_tells():
    sure = motion_table(PENDULUM, SLOW, initial_angle=0.3, duration=5.0, pivot_error=(0.0, 0.0))
    vague = sure.copy()
    vague.attrs = {**sure.attrs, "pivot_offset_y_sigma": 3.0}
    one, other = (fit_model(table, PENDULUM, "measured") for table in (sure, vague))
    assert other["damping"].sigma > 1.5 * one["damping"].sigma


def test_the_mirrored_pair_knows_its_pivot_by_one_part():
    table = motion_table(TOY, FAST, initial_angle=0.5, pivot_error=(0.5, 0.3), duration=5.0)
    near(fit_model(table, TOY, FAST), length=0.245, damping=0.005, restitution=0.9)


def test_the_spline_of_a_measured_pivot_may_be_the_drive():
    table = motion_table(PENDULUM, SLOW, initial_angle=0.3, duration=4.0)
    fit = fit_model(table, PENDULUM, "measured", vary=["length"])
    assert fit.dataset.attrs["drive"] == "measured_pivot"
    assert fit["length"].value == pytest.approx(0.363, rel=2e-3)


def test_a_known_pivot_that_ends_before_the_record_is_refused_and_its_part_is_fitted():
    table = motion_table(PENDULUM, SLOW, initial_angle=0.3, duration=4.0)
    times = np.linspace(0.0, 3.0, 120)
    short = ll.MeasuredPivot(times=times, pivot_heights=0.02 * np.cos(10.09 * times))
    with pytest.raises(InputError, match=r"^end must be at most 3 s, where the samples"):
        fit_model(table, PENDULUM, short, vary=["length"])
    fit = fit_model(table, PENDULUM, short, vary=["length"], end=3.0)
    assert fit["length"].value == pytest.approx(0.363, rel=2e-3)


def test_a_colliding_pair_gives_its_restitution():
    table = motion_table(TOY, FAST, initial_angle=0.5, duration=8.0)
    guess = ll.LatoLato(length=0.25, mass=0.106, damping=0.004, radius=0.02, restitution=0.8)
    fit = fit_model(table, guess)
    near(fit, length=0.245, damping=0.005, restitution=0.9)
    assert fit["restitution"].sigma < 5e-3


def test_two_balls_give_a_value_each():
    table = motion_table(PAIR, FAST, initial_angle=(0.5, -0.3), duration=6.0)
    fit = fit_model(table, PAIR, FAST)
    near(fit, right_length=0.245, left_length=0.245, right_damping=0.005, restitution=0.9)
    assert fit.dataset["right_length"].attrs["long_name"].endswith("right ball")


def test_parameters_of_the_drive_and_the_direction_of_gravity_may_vary():
    table = motion_table(PENDULUM, SLOW, initial_angle=0.3, duration=6.0)
    table["angle_1"].values[:] += 0.01
    fit = fit_model(table, PENDULUM, SLOW, vary=["drive_amplitude", "angle_offset"], profile=True)
    near(fit, drive_amplitude=0.02, angle_offset=0.01)
    assert fit["angle_offset"].low < 0.01 < fit["angle_offset"].high


def test_chaotic_motion_is_cut_into_pieces():
    wild = ll.Harmonic(drive_amplitude=0.2, drive_frequency=9.0)
    table = motion_table(PENDULUM, wild, initial_angle=1.5, duration=12.0)
    fit = fit_model(table, PENDULUM, wild)
    assert fit.dataset.attrs["windows"] > 1
    assert fit.dataset.attrs["scatter"] < 2e-3
    near(fit, length=0.363)


@pytest.mark.parametrize(
    "arguments, said",
    [
        ({"vary": ["mass"]}, "only through damping/mass"),
        ({"vary": ["lenght"]}, "nothing called 'lenght'"),
        ({"vary": []}, "at least one name"),
        ({"ball": 3}, "ball must be 1"),
    ],
)
def test_what_cannot_vary_is_refused(arguments, said):
    table = motion_table(PENDULUM, duration=2.0, initial_angle=0.3)
    with pytest.raises(ValueError, match=said):
        fit_model(table, PENDULUM, **arguments)


def test_a_pair_needs_two_balls_and_a_system_is_a_system():
    table = motion_table(PENDULUM, duration=2.0, initial_angle=0.3)
    with pytest.raises(ValueError, match="a table of two balls"):
        fit_model(table, PAIR)
    with pytest.raises(InputError, match="system must be one of"):
        fit_model(table, "pendulum")
