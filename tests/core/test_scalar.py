"""Formulas of numbers that every backend computes alike."""

import math

import numpy as np
import pytest

from latolato.core.scalar import cosine, floor, sine


def test_floor_is_that_of_the_library():
    random = np.random.default_rng(1)
    whole = random.integers(-(2**50), 2**50, 2000).astype(float)
    for x in [*whole, *random.normal(scale=1e3, size=2000), -0.0, 1e-300, -1e-300, 0.5, -0.5]:
        for near in (x, np.nextafter(x, math.inf), np.nextafter(x, -math.inf)):
            assert floor(float(near)) == math.floor(near)


def test_floor_of_a_row_is_as_exact_around_small_whole_numbers():
    for n in range(-40, 41):
        for x in (n, math.nextafter(n, 100.0), math.nextafter(n, -100.0), n + 0.5, n - 0.5):
            assert floor(float(x)) == math.floor(x)


@pytest.mark.parametrize("own, known", [(sine, math.sin), (cosine, math.cos)])
def test_sine_and_cosine_keep_their_bound(own, known):
    for x in np.random.default_rng(2).uniform(-1e6, 1e6, 5000):
        assert abs(own(float(x)) - known(x)) <= 2.3e-16 * (1.0 + 1e-7 * abs(x)) + 6e-17
