"""Subharmonic measures: exact signals, the tongue's answer, the pair's period 1, and noise."""

import math

import numpy as np
import pytest

import latolato as ll
from hanging import tongue_edges
from latolato.analysis import time_crystal
from latolato.analysis.time_crystal import (
    _HANN_WIDTH,
    _demodulated,
    _survival,
    sign_states,
    subharmonic_peak,
)
from latolato.figures.analyses.time_crystal import draw

PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1, restitution=0.9)
BALL = ll.Ball(length=1.0, mass=0.8, damping=0.02, radius=0.1)
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
W = 6.0


class TestSignals:
    @pytest.mark.parametrize("detuning", [-0.013, 0.0, 0.00731])
    def test_a_tone_is_found_where_it_is_with_its_height_and_no_width(self, detuning):
        count = 256
        t = np.arange(count) * math.tau / W
        rate = (0.5 + detuning) * W
        phase = rate * t + 0.4
        # velocity over w/2: an ellipse of axis ratio 1 + 2 detuning, whose mirror image is small
        found = subharmonic_peak(
            (0.2 + 0.7 * np.cos(phase))[None], (-0.7 * rate * np.sin(phase))[None], W
        )
        # the parabola on an eight times padded Hann line is off by less than 1e-3 bins
        assert found.frequency == pytest.approx(0.5 + detuning, abs=1e-3 / count)
        assert found.amplitude == pytest.approx(0.7 * (1.0 + detuning), rel=1e-3)
        assert found.width == pytest.approx(_HANN_WIDTH / count, rel=0.01)
        assert found.share > 0.99

    def test_white_noise_has_no_sharp_line(self):
        generator = np.random.default_rng(0)
        x, v = generator.standard_normal((2, 30, 256))
        found = subharmonic_peak(x, 0.5 * W * v, W)
        # the line counts 2 of 128 bins to each side: a share of 5/256, and 30 spectra scatter
        assert found.share < 0.05

    def test_slips_of_a_telegraph_give_its_lifetime_and_autocorrelation(self):
        generator = np.random.default_rng(4)
        rate, count, seen = 0.02, 300, 400
        flips = np.cumsum(generator.random((count, seen)) < rate, axis=1)
        signal = np.where(flips % 2 == 0, 1.0, -1.0) + 0.2 * generator.standard_normal(flips.shape)
        found = _survival(signal, 1.5)
        # 2400 slips: four standard errors of 2 %
        assert found["lifetime"] == pytest.approx(1.5 / rate, rel=0.08)
        assert found["lifetime_low"] < found["lifetime"] < found["lifetime_high"]
        exact = (1.0 - 2.0 * rate) ** np.arange(100)
        np.testing.assert_allclose(found["sign_autocorrelation"][:100], exact, atol=0.06)

    def test_small_wiggles_about_zero_are_no_slips(self):
        signal = np.array([[1.0, 0.1, -0.1, 0.1, 1.0, -1.0, -0.1, 0.1, -1.0]])
        assert sign_states(signal).tolist() == [[1, 1, 1, 1, 1, -1, -1, -1, -1]]

    def test_the_best_direction_shows_the_whole_answer(self):
        signs = np.where(np.arange(64) % 2 == 0, 1.0, -1.0)
        angles, velocities = 0.3 + 0.1 * signs[None], -0.8 * 0.5 * W * signs[None]
        found = _demodulated(signs, angles, velocities, W)
        np.testing.assert_allclose(found, math.hypot(0.1, 0.8), rtol=1e-12)


def test_a_pendulum_held_upright_has_no_motion_on_both_sides_of_the_upper_position():
    # The residual swing about upright, 0.05 rad e^(-20), must not be taken for turns of 2 pi.
    system = ll.Pendulum(length=0.2, mass=0.1, damping=0.02)
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=150.0)
    start = {"initial_angle": math.pi - 0.05, "transient_periods": 1000, "periods": 64}
    found = time_crystal(system, drive, **start)
    assert found.status.item() == "no motion"
    assert found.peak_amplitude.item() < 1e-3


class TestPendulum:
    def test_it_answers_at_half_the_frequency_inside_its_tongue_only(self):
        low, high = tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
        ratios = [low - 0.03, low + 0.01, 2.0, high - 0.01, high + 0.03]
        found = time_crystal(
            PENDULUM, DRIVE, frequency_ratio=ratios, drive_amplitude=[0.01, 0.05],
            transient_periods=600, periods=64, initial_angle=0.01,
        )  # fmt: skip
        assert found.peak_amplitude.dims == ("drive_amplitude", "frequency_ratio")
        assert found.status.values[1].tolist() == [
            "no motion", "locked", "locked", "locked", "no motion"
        ]  # fmt: skip
        # the amplitude falls with the detuning along the softening branch
        assert np.all(np.diff(found.peak_amplitude.values[1, 1:4]) < 0.0)
        locked = found.isel(drive_amplitude=1, frequency_ratio=slice(1, 4))
        assert np.all(locked.order_parameter_best > np.abs(locked.order_parameter))
        assert "Rigidity" in found.attrs["caution"]
        assert draw(found).axes

    def test_the_sign_tells_which_of_two_motions_one_period_apart_is_chosen(self):
        one, other = (
            time_crystal(PENDULUM, DRIVE, periods=64, initial_angle=a).order_parameter.item()
            for a in (0.1, -0.1)
        )
        # mirror images of each other, to rounding
        assert one == pytest.approx(-other, rel=1e-9)
        assert abs(one) > 0.05

    def test_noise_makes_the_phase_slip_and_the_order_decay(self):
        asked = {"trajectories": 32, "periods": 300, "transient_periods": 200}
        quiet, loud = (
            time_crystal(PENDULUM, DRIVE, noise_strength=s, **asked) for s in (0.02, 0.25)
        )
        assert quiet.phase_slips.item() == 0.0
        assert math.isnan(quiet.lifetime.item())
        assert quiet.lifetime_low.item() > 1000.0
        assert loud.phase_slips.item() > 10.0
        assert loud.order_parameter_best.item() < 0.3 * quiet.order_parameter_best.item()
        period = math.tau / 6.26
        lag = loud.lag.values[:50]
        expected = np.exp(-2.0 * lag * period / loud.lifetime.item())
        # slips come in bursts while the amplitude is small, which independent ones do not
        np.testing.assert_allclose(
            loud.sign_autocorrelation.values.ravel()[:50], expected, atol=0.1
        )
        assert draw(loud).axes


class TestPairs:
    def test_the_usual_answer_of_the_colliding_pair_has_period_one(self):
        found = time_crystal(
            TOY, ll.Harmonic(drive_amplitude=0.2, drive_frequency=8.0), initial_offset=0.3,
            frequency_ratio=[2.4, 3.0, 3.6], periods=64,
        )  # fmt: skip
        assert found.status.values.ravel().tolist() == ["no subharmonic"] * 3
        assert found.peak_frequency.isnull().all()
        assert draw(found).axes

    def test_where_its_period_doubles_it_is_locked_for_one_ball_and_for_two(self):
        drive = ll.Harmonic(drive_amplitude=0.12, drive_frequency=4.8 * TOY.natural_frequency)
        one = time_crystal(TOY, drive, initial_offset=0.3, periods=64)
        start = TOY.contact_angle_low + 0.3
        two = time_crystal(PAIR, drive, initial_angle=(start, -start), periods=64)
        for found in (one, two):
            assert found.status.item() == "locked"
            # the same attractor: the tolerance of either run
            assert found.peak_amplitude.item() == pytest.approx(one.peak_amplitude.item(), rel=1e-3)


@pytest.mark.parametrize(
    "drive, changed, message",
    [
        (None, {}, "single period, got 'none'"),
        (ll.Chirp(drive_amplitude=0.1, drive_frequency=1.0, drive_frequency_final=2.0,
                  sweep_time=3.0), {}, "single period, got 'chirp'"),
        (DRIVE, {"periods": 8}, r"periods must lie in \[16"),
        (DRIVE, {"trajectories": 5}, "5 trajectories without noise are all the same"),
        (DRIVE, {"frequency_ratio": [0.0]}, r"frequency_ratio\[0\] must lie in"),
        (DRIVE, {"frequency_ratio": []}, "frequency_ratio must hold at least 1 value"),
        (DRIVE, {"noise_strength": -1.0}, "noise_strength must lie in"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(drive, changed, message):
    with pytest.raises(ValueError, match=message):
        time_crystal(PENDULUM, drive, **changed)
