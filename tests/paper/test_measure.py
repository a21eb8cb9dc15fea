"""Numbers read off a motion, against motions whose numbers are known."""

import numpy as np
import pytest

from latolato.paper import measure


@pytest.mark.parametrize("samples", [25, 50, 100])
def test_peaks_of_a_decaying_swing_are_found_with_fourth_order(samples):
    k, w = 0.1, 2.0
    time = np.arange(0.0, 40.0, 2 * np.pi / w / samples)
    angle = np.exp(-k * time) * np.cos(w * time)
    velocity = -np.exp(-k * time) * (w * np.sin(w * time) + k * np.cos(w * time))
    when, sizes = measure.peaks(time, angle, velocity)
    exact = (np.arange(1, len(when) + 1) * np.pi - np.arctan(k / w)) / w
    # The cubic's error is h^4/384 of the fourth derivative w^4 angle.
    bound = 1.2 * (2 * np.pi / samples) ** 4 / 384
    assert np.abs(when - exact).max() < 0.1 / samples
    relative = np.abs(sizes / (np.exp(-k * exact) * np.cos(np.arctan(k / w))) - 1)
    assert relative.max() < bound


def test_beats_are_the_largest_of_three_peaks():
    times, sizes = measure.beats(np.arange(7.0), np.array([1, 3, 2, 2, 5, 4, 6.0]))
    assert times.tolist() == [1.0, 4.0]
    assert sizes.tolist() == [3.0, 5.0]


def test_first_crossing_is_interpolated():
    x, values = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 3.0])
    assert measure.first_above(x, values, 2.0) == 1.5
    assert measure.first_above(x, values, -1.0) == 0.0
    assert np.isnan(measure.first_above(x, values, 3.0))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_growth_per_period_is_that_of_an_exponential(sign):
    time = np.arange(0.0, 50.0, 0.1)
    periods = np.arange(0, len(time), 10)
    angle = np.zeros_like(time)
    angle[periods] = 1e-3 * sign ** np.arange(len(periods)) * np.exp(0.125 * time[periods])
    rate, growth_sign = measure.growth_per_period(
        time, angle, samples_per_period=10, first=5.0, last=45.0
    )
    assert rate == pytest.approx(0.125, rel=1e-12)
    assert growth_sign == sign
