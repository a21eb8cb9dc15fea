"""Impacts in a track table give back the coefficient of restitution, or say why not."""

import dataclasses

import numpy as np
import pytest

import latolato as ll
from latolato.experiment.fits.restitution import _Impact, _pooled, _shift
from track_tables import motion_table

BALL = ll.Ball(length=0.245, mass=0.106, damping=0.005, radius=0.02)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.1)


def pair(restitution):
    return ll.BallPair(right=BALL, left=BALL, restitution=restitution)


@pytest.mark.parametrize("restitution, drive", [(0.9, DRIVE), (0.9, None), (0.6, DRIVE)])
def test_two_balls_give_their_restitution_impact_by_impact(restitution, drive):
    table = motion_table(pair(restitution), drive, initial_angle=(0.6, -0.4), duration=5.0)
    fit = ll.fit_restitution(table, length=0.245, radius=0.02)
    assert fit.describes
    pooled = fit["restitution"]
    assert abs(pooled.value - restitution) < 3.0 * pooled.sigma
    assert pooled.sigma < 0.01
    misses = (fit.dataset.restitution_each - restitution) / fit.dataset.restitution_each_sigma
    assert np.mean(np.abs(misses) < 3.0) > 0.9
    assert (fit.dataset.angular_velocity_before * fit.dataset.angular_velocity_after < 0).all()
    theta = 2.0 * np.arcsin(0.02 / 0.245)
    assert np.median(fit.dataset.separation_at_contact) == pytest.approx(theta, abs=5e-3)


@pytest.mark.parametrize(
    "restitution, clock, length, share",
    [(0.75, 1.0, 0.245, None), (0.6, 1.03, 0.245, "slower"), (0.75, 1.0, 0.257, "faster")],
)
def test_flights_of_another_length_are_doubted(restitution, clock, length, share):
    table = motion_table(pair(restitution), DRIVE, initial_angle=(0.6, -0.4), duration=5.0)
    fit = ll.fit_restitution(table.assign_coords(time=clock * table.time), length=length)
    assert fit.describes is (share is None)
    if share is not None:
        assert fit.verdict.startswith("Between impacts the balls swing ")
        assert (
            f"% {share} than a pendulum of {length:g} m does: its length, the clock" in fit.verdict
        )


def test_a_known_pivot_that_ends_before_the_record_is_refused_by_the_end():
    table = motion_table(pair(0.9), DRIVE, initial_angle=(0.6, -0.4), duration=2.0)
    times = np.linspace(0.0, 1.5, 60)
    short = ll.MeasuredPivot(times=times, pivot_heights=0.03 * np.cos(15.1 * times))
    with pytest.raises(ll.InputError, match=r"^end must be at most 1\.5 s, where the samples"):
        ll.fit_restitution(table, length=0.245, drive=short)


def test_one_ball_and_a_wall_give_it_too():
    toy = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.9)
    table = motion_table(toy, DRIVE, initial_angle=0.5, duration=5.0)
    table = table.drop_vars(["ball_2_x", "ball_2_y", "angle_2", "angle_sigma_2", "flag_2"])
    fit = ll.fit_restitution(table, length=0.245)
    assert abs(fit["restitution"].value - 0.9) < 3.0 * fit["restitution"].sigma
    assert "one ball and a wall" in fit.verdict


def test_impacts_that_differ_widen_the_pooled_sigma_also_when_few_are_precise():
    each = np.array([0.600, 0.604, 0.6, 0.6, 0.6])
    sigmas = np.array([0.0003, 0.0003, 0.02, 0.02, 0.02])
    pooled, words, _ = _pooled(each, sigmas, np.ones(5))
    assert pooled.sigma > 0.0009  # 0.00021 by the two precise ones alone
    assert "they differ by 0.00" in words
    assert "by 0," not in words


def test_an_impact_that_another_drag_moves_is_still_the_same():
    one = _Impact(time=1.0, before=-2.0, after=1.0, gap=0.16, gap_sigma=1e-3, sigma=0.02)
    moved = dataclasses.replace(one, time=1.05, after=1.2)
    assert _shift({0.98: one}, {0.98: moved, 3.0: one}) == pytest.approx(0.1)
    assert _shift({0.98: one}, {3.0: one}) == 0.0


def test_what_cannot_be_seen_is_refused():
    swing = motion_table(ll.Pendulum(length=0.245, mass=0.1), initial_angle=0.5, duration=3.0)
    with pytest.raises(ValueError, match="no impact was seen well enough"):
        ll.fit_restitution(swing, length=0.245)
    with pytest.raises(ValueError, match="restitution needs length"):
        ll.fit_restitution(swing)
    still = swing.copy(deep=True)
    still["flag_1"].values[:] = "occluded"
    with pytest.raises(ValueError, match="fewer than 10 samples flagged ok"):
        ll.fit_restitution(still, length=0.245)
    slow = motion_table(pair(0.9), initial_angle=(0.6, -0.4), duration=5.0, fps=8.0)
    with pytest.raises(ValueError, match="faster camera"):
        ll.fit_restitution(slow, length=0.245, radius=0.02)
