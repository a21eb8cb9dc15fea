"""Waiting times under noise: estimator, an exact mean first-passage time, and bad input."""

import math

import numpy as np
import pytest
from scipy.special import expi

import latolato as ll
from latolato.analysis import first_passage_time
from latolato.analysis.first_passage_time import censored_mean
from latolato.analysis.starts import hanging_angles
from latolato.figures.analyses.first_passage_time import draw

TOY = ll.LatoLato(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196, restitution=0.9)
BALL = ll.Ball(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196)
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.389 * TOY.natural_frequency)


def test_the_mean_of_censored_waiting_times_is_unbiased_and_its_interval_covers():
    generator = np.random.default_rng(1)
    waits = generator.exponential(3.0, size=(2000, 40))
    result = [censored_mean(float(np.minimum(w, 2.0).sum()), int((w < 2.0).sum())) for w in waits]
    # 1/mean is unbiased to 1/events (20 of 40 are seen), 2000 samples scatter by 0.5 %
    assert np.mean([1.0 / f.mean for f in result]) == pytest.approx(1.0 / 3.0, rel=0.05)
    inside = np.mean([f.low <= 3.0 <= f.high for f in result])
    assert 0.94 <= inside <= 0.985  # the interval of a Poisson count covers at least 95 %


def test_a_warm_oscillator_reaches_an_energy_as_the_averaged_equation_says():
    # Weak damping: dE = -gamma (E - kT) dt + (2 gamma E kT)^(1/2) dW, so the mean time from 0 to
    # b kT is (Ei(b) - ln b - 0.5772)/gamma.
    length, mass, gamma, b = 1.0, 0.8, 2e-3, 2.0
    system = ll.Mathieu(length=length, mass=mass, damping=gamma * mass * length)
    heat = 1e-3
    w0 = system.natural_frequency
    strength = math.sqrt(2.0 * gamma * heat / (mass * length**2))
    threshold = math.sqrt(2.0 * b * heat / (mass * 9.8 * length))
    result = first_passage_time(
        system, noise_strength=strength, threshold_angle=threshold, duration=6000.0,
        trajectories=300, noise_interval=0.3, noise_seed=3,
    )  # fmt: skip
    mean = (expi(b) - math.log(b) - np.euler_gamma) / gamma
    # |angle| tests the energy twice a period only, which lifts the barrier by 0.58 of the
    # diffusion between tests (Chernoff; Siegmund): E by 0.58 (2 gamma b (kT)^2 pi/w0)^(1/2)
    lift = 0.5826 * math.sqrt(2.0 * gamma * b * math.pi / w0)
    mean *= 1.0 + lift * math.expm1(b) / b / (expi(b) - math.log(b) - np.euler_gamma)
    assert result.passage_fraction > 0.9
    # four standard errors; the waiting times here are narrower than exponential, as it says
    assert result.status.item() == "not exponential"
    error = result.mean_first_passage_time_error.item()
    assert result.mean_first_passage_time.item() == pytest.approx(mean, abs=4.0 * error)


def test_the_error_of_times_that_are_not_exponential_is_that_of_their_scatter():
    times = toy_times(noise_strength=3.0, duration=60.0)
    assert times.status.item() == "not exponential"
    assert times.passage_fraction == 1.0
    passed = times.first_passage.values
    error = times.mean_first_passage_time_error.item()
    assert times.mean_first_passage_time.item() == pytest.approx(passed.mean())
    assert error == pytest.approx(passed.std(ddof=1) / math.sqrt(40))
    # Student's t of 39 degrees of freedom.
    half = times.mean_first_passage_time_high.item() - passed.mean()
    assert half == pytest.approx(2.0227 * error, rel=1e-4)
    assert passed.mean() - times.mean_first_passage_time_low.item() == pytest.approx(half)


def toy_times(system=TOY, **changed):
    settings = {"noise_strength": 2.0, "threshold_angle": 0.5, "duration": 40.0, "trajectories": 40}
    return first_passage_time(system, DRIVE, **(settings | changed))


def test_more_noise_starts_the_toy_sooner_and_a_trajectory_is_a_run():
    # rare passages: the waiting is long beside the dead time of a few seconds
    rare = toy_times(noise_strength=0.2, duration=60.0, trajectories=200)
    assert rare.status.item() == "passed"
    assert 0.0 < rare.passage_fraction < 0.1
    weak, strong = (toy_times(noise_strength=s) for s in (1.2, 3.0))
    assert strong.mean_first_passage_time < weak.mean_first_passage_time
    stream = int(np.nanargmin(strong.first_passage))
    passed = strong.first_passage.values[stream]
    noise = ll.VelocityKicks(noise_strength=3.0, noise_stream=stream)
    run = ll.simulate(
        TOY, DRIVE, initial_offset=0.0, duration=40.0, tolerance=1e-6, noise=noise,
        times=np.linspace(0.0, passed, 4001),
    )  # fmt: skip
    # other step ends: the tolerance, over seconds of chaotic hops
    assert run.angle.values[-1] == pytest.approx(0.5, abs=1e-3)
    assert run.angle.values[:-1].max() < 0.5 + 1e-3
    assert draw(strong).axes


def test_both_balls_of_a_pair_start_as_one_of_the_mirror_pair_does():
    assert hanging_angles(PAIR) == pytest.approx((TOY.contact_angle_low, -TOY.contact_angle_low))
    result = toy_times(PAIR, noise_strength=3.0, trajectories=10)
    assert result.first_passage.shape == (10,)
    assert result.passage_fraction > 0.0


def test_unequal_balls_hang_where_their_torques_balance():
    pair = ll.BallPair(right=ll.Ball(length=0.26, mass=0.3, radius=0.02), left=BALL)
    right, left = hanging_angles(pair)
    assert right - left == pytest.approx(pair.contact_separation, rel=1e-15)
    torque = 0.3 * 0.26 * math.sin(right) + 0.10644 * 0.245 * math.sin(left)
    assert torque == pytest.approx(0.0, abs=1e-17)  # rounding of two terms of 1e-3


def test_weak_noise_starts_nothing_and_says_so():
    with pytest.warns(RuntimeWarning, match="no trajectory of 5 reached 0.5 rad within 2 s"):
        result = toy_times(noise_strength=1e-6, duration=2.0, trajectories=5)
    assert result.status.item() == "none passed"
    assert math.isnan(result.mean_first_passage_time.item())
    # exp(-waited/mean) = 5 % at the bound
    assert result.mean_first_passage_time_low.item() == pytest.approx(
        10.0 / math.log(20.0), rel=1e-12
    )
    assert result.passage_fraction == 0.0
    assert draw(result).axes


def test_drift_is_not_taken_for_activation():
    pendulum = ll.Pendulum(length=1.0, mass=0.8)
    result = first_passage_time(
        pendulum, noise_strength=1e-6, threshold_angle=0.1, initial_angular_velocity=1.0,
        duration=2.0, trajectories=5,
    )  # fmt: skip
    assert result.status.item() == "all at once"
    assert math.isnan(result.mean_first_passage_time.item())


@pytest.mark.parametrize(
    "changed, message",
    [
        ({"noise_strength": 0.0}, r"noise_strength must lie in \(0, inf\)"),
        ({"threshold_angle": 0.05}, "the start must lie below threshold_angle 0.05 rad"),
        ({"trajectories": 0}, "trajectories must lie in"),
        ({"duration": -1.0}, r"duration must lie in \(0, inf\)"),
    ],
)
def test_bad_input_is_refused(changed, message):
    with pytest.raises(ValueError, match=message):
        toy_times(**({"trajectories": 5, "duration": 2.0} | changed))
