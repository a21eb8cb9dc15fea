"""Hanging under a cosine: Hill's determinant against monodromy, series, tables and the paper."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from hanging import growth_rate, threshold_amplitude, tongue_edges
from latolato.analysis import mathieu_parameters

G = 9.8
PAPER = {"length": 1.0, "mass": 0.8}


def multipliers(*, amplitude, frequency, gamma, length=1.0):
    """Floquet multipliers of eq14 over one drive period, by integrating both solutions."""

    def motion(t, y):
        weight = G / length - amplitude * frequency**2 / length * math.cos(frequency * t)
        return y[1], -weight * y[0] - gamma * y[1], y[3], -weight * y[2] - gamma * y[3]

    period = 2.0 * math.pi / frequency
    run = solve_ivp(motion, (0, period), (1, 0, 0, 1), method="DOP853", rtol=1e-13, atol=1e-14)
    return np.linalg.eigvals(run.y[:, -1].reshape(2, 2).T)


def test_parameters_of_the_standard_form():
    a, q, strength = mathieu_parameters(
        drive_amplitude=0.05, drive_frequency=6.0, length=0.5, gravity=G
    )
    assert a == pytest.approx((2.0 * math.sqrt(G / 0.5) / 6.0) ** 2, rel=1e-15, abs=0.0)
    assert q == pytest.approx(0.2, rel=1e-15, abs=0.0)
    assert strength == pytest.approx(0.05 * 36.0 / (2.0 * G), rel=1e-15, abs=0.0)
    # eq15's 2 gamma w0^2 is eq14's A0 w^2/l.
    assert 2.0 * strength * G / 0.5 == pytest.approx(0.05 * 36.0 / 0.5, rel=1e-15, abs=0.0)


@pytest.mark.parametrize("damping,low,rate", [(0.05, 1.909946, 0.12505), (0.0, 1.908023, 0.15630)])
def test_printed_edges_and_growth_rates(damping, low, rate):
    edges = tongue_edges(drive_amplitude=0.05, damping=damping, **PAPER)
    assert edges[0] == pytest.approx(low, abs=5e-7)  # half a unit of the printed digits
    growth = growth_rate(drive_amplitude=0.05, drive_frequency=6.26, damping=damping, **PAPER)
    assert growth == pytest.approx(rate, abs=5e-6)


@pytest.mark.parametrize(
    "order,amplitude,damping",
    [
        (1, 0.05, 0.0),
        (1, 0.05, 0.05),
        (1, 0.3, 0.4),
        (2, 0.2, 0.0),
        (2, 0.3, 0.05),
        (3, 0.4, 0.002),
    ],
)
def test_multiplier_on_an_edge_is_one_in_magnitude_and_real(order, amplitude, damping):
    edges = tongue_edges(drive_amplitude=amplitude, damping=damping, order=order, **PAPER)
    assert edges[0] < edges[1]
    expected = (-1.0) ** order
    gamma = damping / 0.8
    for ratio in edges:
        frequency = ratio * math.sqrt(G)
        result = multipliers(amplitude=amplitude, frequency=frequency, gamma=gamma)
        # The characteristic polynomial at the expected multiplier: unlike the multipliers, which
        # merge on an undamped edge, it feels the integrator's error (1e-12) only linearly.
        assert abs((result[0] - expected) * (result[1] - expected)) < 1e-10
        inside, outside = ratio * 1.0001, ratio * 0.9999
        if ratio == edges[1]:
            inside, outside = outside, inside
        rates = growth_rate(
            drive_amplitude=amplitude,
            drive_frequency=np.array([inside, outside]) * math.sqrt(G),
            damping=damping,
            **PAPER,
        )
        assert rates[0] > 0.0 >= rates[1]


@settings(deadline=None, max_examples=40)
@given(
    amplitude=st.floats(0.0, 0.6),
    ratio=st.floats(0.4, 4.0),
    damping=st.floats(0.0, 2.0),
    length=st.floats(0.2, 2.0),
)
def test_growth_rate_equals_the_monodromy_route(amplitude, ratio, damping, length):
    frequency = ratio * math.sqrt(G / length)
    gamma = damping / (0.8 * length)
    result = multipliers(
        amplitude=amplitude * length, frequency=frequency, gamma=gamma, length=length
    )
    period = 2.0 * math.pi / frequency
    growth = growth_rate(
        drive_amplitude=amplitude * length,
        drive_frequency=frequency,
        length=length,
        mass=0.8,
        damping=damping,
    )
    # Compared through cosh, which the integration gives to 1e-11 of itself: the rate alone has a
    # square-root singularity on the edges, where it magnifies any error without bound.
    trace = abs(result.sum().real) * math.exp(0.5 * gamma * period)
    expected = max(0.5 * trace, 1.0)
    assert math.cosh((growth + 0.5 * gamma) * period) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("frequency,amplitude", [(6.26, 0.05), (3.1, 0.4), (9.0, 0.5)])
def test_growth_rate_inside_a_tongue_equals_the_monodromy_route(frequency, amplitude):
    result = multipliers(amplitude=amplitude, frequency=frequency, gamma=0.0625)
    expected = math.log(np.max(np.abs(result))) * frequency / (2.0 * math.pi)
    growth = growth_rate(
        drive_amplitude=amplitude, drive_frequency=frequency, damping=0.05, **PAPER
    )
    assert growth == pytest.approx(expected, abs=1e-9)  # the integrator's error: 1e-12 to 1e-11


def test_undamped_edges_have_mathieus_series():
    q = 0.01
    low, high = tongue_edges(drive_amplitude=q / 2.0)
    # DLMF 28.6.2-3; the next term, 11 q^5/36864, is 3e-14.
    even = 1.0 + q - q**2 / 8.0 - q**3 / 64.0 - q**4 / 1536.0
    odd = 1.0 - q - q**2 / 8.0 + q**3 / 64.0 - q**4 / 1536.0
    assert 4.0 / low**2 == pytest.approx(even, abs=1e-13)
    assert 4.0 / high**2 == pytest.approx(odd, abs=1e-13)


@pytest.mark.parametrize(
    "order,q,even,odd",
    # Abramowitz & Stegun, table 20.1; the last is the value that scipy.special.mathieu_a misses.
    [
        (1, 5.0, 1.85818754, math.inf),  # b_1(5) < 0: unstable for every fast drive
        (2, 5.0, 7.44910974, 2.09946045),
        (5, 5.0, 25.54997175, 25.51081605),
        (5, 21.0, 37.46261, None),
    ],
)
def test_undamped_edges_equal_the_table(order, q, even, odd):
    low, high = tongue_edges(drive_amplitude=q / 2.0, order=order)
    tolerance = 6e-9 if q == 5.0 else 6e-6  # half a unit of the last printed digit
    assert 4.0 / low**2 == pytest.approx(even, abs=tolerance)
    if odd == math.inf:
        assert high == math.inf
    elif odd is not None:
        assert 4.0 / high**2 == pytest.approx(odd, abs=tolerance)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_tongues_start_from_two_over_n(order):
    low, high = tongue_edges(drive_amplitude=0.0, order=order)
    assert low == pytest.approx(2.0 / order, rel=1e-15, abs=0.0)
    assert high == pytest.approx(2.0 / order, rel=1e-15, abs=0.0)


def test_damping_closes_a_weakly_driven_tongue():
    opening = threshold_amplitude(damping=0.05, **PAPER)
    closed = tongue_edges(drive_amplitude=0.99 * opening, damping=0.05, **PAPER)
    opened = tongue_edges(drive_amplitude=1.01 * opening, damping=0.05, **PAPER)
    assert all(math.isnan(edge) for edge in closed)
    assert opened[0] < 2.0 < opened[1]
    nothing = tongue_edges(drive_amplitude=0.0, damping=0.05, **PAPER)
    assert all(math.isnan(edge) for edge in nothing)


def test_a_strong_drive_is_unstable_at_any_high_frequency():
    # Mathieu's b_1 vanishes at q = 0.9080, a_1 at q = 7.5137.
    assert tongue_edges(drive_amplitude=0.4539)[1] < math.inf
    for damping in (0.0, 0.05):
        edges = tongue_edges(drive_amplitude=0.4541, damping=damping, **PAPER)
        assert edges[1] == math.inf
        fast = growth_rate(drive_amplitude=0.6, drive_frequency=50.0, damping=damping, **PAPER)
        assert fast > 0.0
    assert tongue_edges(drive_amplitude=3.75)[0] < math.inf
    assert all(math.isnan(edge) for edge in tongue_edges(drive_amplitude=3.76))


def test_threshold_finds_a_tongue_that_damping_has_almost_closed():
    # At a fixed ratio the tongue of order 4 holds few amplitudes, and damping all but closes it.
    drive = {"drive_amplitude": 0.4, "order": 4, **PAPER}
    opened, closed = 0.0, 0.005
    while closed - opened > 1e-4 * closed:
        middle = 0.5 * (opened + closed)
        is_open = not math.isnan(tongue_edges(damping=middle, **drive)[0])
        opened, closed = (middle, closed) if is_open else (opened, middle)
    low, high = tongue_edges(damping=opened, **drive)
    threshold = threshold_amplitude(
        frequency_ratio=0.5 * (low + high), damping=opened, largest_amplitude_ratio=0.45, **PAPER
    )
    assert threshold == pytest.approx(0.4, rel=1e-3)  # the width of the opening


@pytest.mark.parametrize("ratio", np.linspace(1.05, 4.0, 12))
def test_damping_below_rounding_leaves_the_undamped_threshold(ratio):
    search = {"frequency_ratio": ratio, "largest_amplitude_ratio": 5.0}
    undamped = threshold_amplitude(**search)
    barely = threshold_amplitude(damping=1e-14, **search, **PAPER)
    assert barely == pytest.approx(undamped, rel=1e-12, abs=0.0)


def test_threshold_at_resonance_is_that_of_first_order():
    # l gamma/(2 w0), up to the relative order (gamma/w0)^2 = 4e-4.
    threshold = threshold_amplitude(damping=0.05, **PAPER)
    assert threshold == pytest.approx(0.0625 / (2.0 * math.sqrt(G)), rel=4e-4)
    assert threshold_amplitude(frequency_ratio=2.0) == 0.0


def test_threshold_of_paper_fig_8():
    ratio = 10.09 / math.sqrt(G / 0.363)
    threshold = threshold_amplitude(
        frequency_ratio=ratio, length=0.363, mass=0.10804, damping=0.00274
    )
    assert ratio == pytest.approx(1.94192, abs=5e-6)
    assert threshold == pytest.approx(11.39e-3, abs=5e-6)  # printed to 0.01 mm


@pytest.mark.parametrize("damping", [0.0, 0.05, 1.0, 7.0])
@pytest.mark.parametrize("ratio", [0.45, 0.67, 1.0, 1.01, 1.6, 1.95, 2.3, 4.0])
def test_growth_rate_vanishes_at_the_threshold(ratio, damping):
    threshold = threshold_amplitude(
        frequency_ratio=ratio, damping=damping, largest_amplitude_ratio=10.0, **PAPER
    )
    # 2 m l w0 = 5.0: the last damping is overcritical, and holds the slowest drives to the end.
    is_open = not math.isnan(threshold)
    assert is_open or (damping == 7.0 and ratio < 1.0)
    below = np.linspace(0.0, 0.999 * threshold if is_open else 10.0, 50)
    above = threshold * 1.0001 + 1e-6 if is_open else 10.0
    rates = growth_rate(
        drive_amplitude=np.append(below, above),
        drive_frequency=ratio * math.sqrt(G),
        damping=damping,
        **PAPER,
    )
    assert np.all(rates[:-1] <= 0.0)
    assert (rates[-1] > 0.0) == is_open


def test_threshold_and_edges_agree():
    low, high = tongue_edges(drive_amplitude=0.07, damping=0.05, **PAPER)
    for ratio in (low, high):
        threshold = threshold_amplitude(frequency_ratio=ratio, damping=0.05, **PAPER)
        assert threshold == pytest.approx(
            0.07, rel=1e-12, abs=0.0
        )  # 1e-15 over the slope of the edge


def test_threshold_out_of_reach_is_nan():
    threshold = threshold_amplitude(
        frequency_ratio=0.5, damping=0.5, largest_amplitude_ratio=0.1, **PAPER
    )
    assert math.isnan(threshold)


def test_without_drive_the_rate_is_that_of_the_damped_pendulum():
    weak = growth_rate(drive_amplitude=0.0, drive_frequency=[1.0, 6.0], damping=0.05, **PAPER)
    np.testing.assert_allclose(weak, -0.05 / (2.0 * 0.8), rtol=1e-14)
    k = 8.0 / (2.0 * 0.8)
    strong = growth_rate(drive_amplitude=0.0, drive_frequency=[2.0, 6.0], damping=8.0, **PAPER)
    np.testing.assert_allclose(strong, math.sqrt(k**2 - G) - k, rtol=1e-13)
