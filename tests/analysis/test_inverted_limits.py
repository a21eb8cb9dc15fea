"""The upright position: Kapitza's limit, Mathieu's characteristic values and runs."""

import math

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

import latolato as ll
from latolato.analysis.roots import find_root
from latolato.figures.analyses import inverted_limits as picture

FREE = ll.Pendulum(length=0.5, mass=0.8)
DAMPED = ll.Pendulum(length=0.5, mass=0.8, damping=0.05)


def limits(system, ratio, drive=None):
    found = ll.analysis.inverted_limits(system, drive, frequency_ratio=ratio)
    return np.array([float(found.low), float(found.high)])


@pytest.mark.parametrize("ratio", [2.0, 4.0, 20.0])
def test_without_drag_they_are_mathieu_s_characteristic_values(ratio):
    a = -4.0 / ratio**2
    low = find_root(lambda q: float(mathieu_a(0, q)) - a, 1e-3, 6.0)
    # of order 1 the lower one: that of even solutions at -q, of odd ones at q
    high = find_root(lambda q: float(mathieu_b(1, q)) - a, 0.5, 8.0)
    # q = 2 A0/l; SciPy is good to 1e-11, times the slope
    np.testing.assert_allclose(limits(FREE, ratio), [0.25 * low, 0.25 * high], rtol=1e-10)


def test_the_lower_limit_tends_to_kapitza_s():
    gaps = [limits(FREE, r)[0] * r / (math.sqrt(2.0) * 0.5) - 1.0 for r in (20.0, 40.0)]
    # the next term is of second order in the inverse ratio
    assert gaps[0] == pytest.approx(4.0 * gaps[1], rel=0.01)
    assert 0.0 < gaps[1] < 1e-3


@pytest.mark.parametrize("rod", [None, 0.6])
def test_multipliers_are_one_and_minus_one_at_the_limits(rod):
    drive = None
    if rod:
        drive = ll.CrankSlider(drive_amplitude=0, drive_frequency=1, connecting_rod_length=rod)
    w = 8.0 * DAMPED.natural_frequency
    for amplitude in limits(DAMPED, 8.0, drive):
        about = {"drive_amplitude": amplitude, "drive_frequency": w}
        at = ll.CrankSlider(connecting_rod_length=rod, **about) if rod else ll.Harmonic(**about)
        rate = ll.analysis.growth_rate(DAMPED, at, position="inverted", method="monodromy")
        # the rate is good to 1e-12 of w
        assert abs(float(rate.growth_rate)) < 1e-9


def test_a_run_stands_within_the_limits_and_falls_below():
    low, high = limits(DAMPED, 10.0)
    w = 10.0 * DAMPED.natural_frequency
    for amplitude, stands in ((0.97 * low, False), (1.03 * low, True), (1.03 * high, False)):
        drive = ll.Harmonic(drive_amplitude=amplitude, drive_frequency=w)
        run = ll.simulate(DAMPED, drive, initial_angle=math.pi - 0.01, duration=30.0)
        assert (abs(float(run.angle[-1]) - math.pi) < 0.02) is stands


def test_no_limit_is_told():
    with pytest.warns(RuntimeWarning, match="no upper limit was found up to drive_amplitude 0.1 m"):
        found = ll.analysis.inverted_limits(FREE, frequency_ratio=20.0, largest_amplitude_ratio=0.2)
    assert str(found.status.values) == "no upper limit"
    with pytest.warns(RuntimeWarning, match="no lower limit"):
        found = ll.analysis.inverted_limits(
            FREE, frequency_ratio=20.0, largest_amplitude_ratio=0.02
        )
    assert str(found.status.values) == "never stable"


def test_systems_without_an_upright_position_are_refused():
    with pytest.raises(ValueError, match="touch before they stand upright: choose"):
        limits(ll.LatoLato(length=1.0, mass=0.8, radius=0.1), 10.0)
    with pytest.raises(ValueError, match="has no inverted position"):
        limits(ll.Mathieu(length=1.0, mass=0.8), 10.0)


def test_the_picture_shows_both_limits():
    found = ll.analysis.inverted_limits(FREE, frequency_ratio=5.0)
    texts = [text.get_text() for text in picture.draw(found).axes[0].texts]
    assert f"{float(found.low):.5g} m" in texts
    assert f"{float(found.high):.5g} m" in texts
