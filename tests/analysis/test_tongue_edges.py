"""Tongues of hanging and standing: three routes, known digits, limits and bad input."""

import math

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

import latolato as ll
from latolato.core.errors import InputError
from latolato.figures.analyses import tongue_edges as picture

PAPER = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
FREE = ll.Pendulum(length=1.0, mass=0.8)
LINEAR = ll.Mathieu(length=1.0, mass=0.8, damping=0.05)
DRIVES = {
    "cosine": None,
    "below": ll.CrankSlider(drive_amplitude=0, drive_frequency=1, connecting_rod_length=0.3),
    "above": ll.CrankSlider(
        drive_amplitude=0, drive_frequency=1, connecting_rod_length=0.3, guide="above"
    ),
}


def edges(system, drive=None, **options):
    found = ll.analysis.tongue_edges(system, drive, **options)
    return np.array([float(found.low), float(found.high)])


@pytest.mark.parametrize(
    "system,low,high", [(FREE, 1.90802320, 2.10963239), (PAPER, 1.909946298, 2.107508172)]
)
def test_the_known_edges_hold_to_their_digits(system, low, high):
    # half of the last digit given
    found = edges(system, drive_amplitude=0.05)
    np.testing.assert_allclose(found, [low, high], rtol=0, atol=6e-9 if system is FREE else 6e-10)


@pytest.mark.parametrize("amplitude,order", [(0.05, 1), (0.2, 1), (0.6, 2), (1.0, 3), (2.0, 21)])
def test_undamped_edges_under_a_cosine_are_mathieus_characteristic_values(amplitude, order):
    found = edges(FREE, drive_amplitude=amplitude, order=order)
    # The even solutions' value is the larger one, so the slower drive's.
    values = [float(value(order, 2.0 * amplitude)) for value in (mathieu_a, mathieu_b)]
    # SciPy's own error: 1e-11 at these orders
    np.testing.assert_allclose(4.0 / found**2, values, rtol=1e-10)


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("amplitude,order", [(0.05, 1), (0.2, 1), (0.2, 2)])
@pytest.mark.filterwarnings("ignore:the tongue of order 2 is closed:RuntimeWarning")
def test_determinant_and_monodromy_agree(name, amplitude, order):
    for system in (FREE, PAPER):
        options = {"drive_amplitude": amplitude, "order": order}
        hill = edges(system, DRIVES[name], **options)
        map_ = edges(system, DRIVES[name], method="monodromy", **options)
        # the quadrature's 1e-13 over the slope of the trace at the edge of a narrow tongue
        np.testing.assert_allclose(map_, hill, rtol=1e-11)


def step_map(drive, tolerance=1e-13):
    """The one-period map of production runs: the equation is linear, so unit starts suffice."""
    period = 2.0 * math.pi / drive.drive_frequency
    ends = []
    for start in ((1.0, 0.0), (0.0, 1.0)):
        run = ll.simulate(
            LINEAR,
            drive,
            initial_angle=start[0],
            initial_angular_velocity=start[1],
            times=[period],
            tolerance=tolerance,
        )
        ends.append([float(run.angle[-1]), float(run.angular_velocity[-1])])
    return np.array(ends).T


@pytest.mark.parametrize("name", DRIVES)
def test_the_runs_map_has_a_multiplier_minus_one_at_both_edges(name):
    w0 = LINEAR.natural_frequency
    template = DRIVES[name] or ll.Harmonic(drive_amplitude=0.0, drive_frequency=1.0)
    for ratio in edges(LINEAR, DRIVES[name], drive_amplitude=0.1):
        about = {"drive_amplitude": 0.1, "drive_frequency": ratio * w0}
        drive = type(template)(
            **about,
            **({} if name == "cosine" else {"connecting_rod_length": 0.3, "guide": template.guide}),
        )
        found = np.linalg.eigvals(step_map(drive))
        # the acceptance figure of three routes; the map itself is better than 1e-11
        assert np.min(np.abs(found + 1.0)) < 1e-9
        decay = math.exp(-2.0 * math.pi * 0.05 / 0.8 / drive.drive_frequency)
        assert np.prod(found).real == pytest.approx(decay, rel=1e-11, abs=0.0)


@pytest.mark.parametrize("guide", ["below", "above"])
def test_a_long_connecting_rod_moves_the_tongue_like_a_cosine(guide):
    cosine = edges(PAPER, drive_amplitude=0.1)
    gaps = []
    for rod in (1e3, 1e4):
        crank = ll.CrankSlider(
            drive_amplitude=0, drive_frequency=1, connecting_rod_length=rod, guide=guide
        )
        gaps.append(np.abs(edges(PAPER, crank, drive_amplitude=0.1) - cosine).max())
    # the second harmonic, A0/L of the first, shifts the edges in proportion
    assert gaps[0] < 1e-4
    assert gaps[1] == pytest.approx(0.1 * gaps[0], rel=0.05)


def test_the_drive_s_own_amplitude_frequency_and_phase_do_not_matter():
    one = ll.CrankSlider(drive_amplitude=0.1, drive_frequency=9, connecting_rod_length=0.3)
    other = ll.CrankSlider(
        drive_amplitude=0.2, drive_frequency=3, drive_phase=1.2, connecting_rod_length=0.3
    )
    assert (
        edges(PAPER, one, drive_amplitude=0.1) == edges(PAPER, other, drive_amplitude=0.1)
    ).all()


def test_hanging_and_standing_share_the_edge_of_kapitza():
    for system in (FREE, PAPER):
        found = ll.analysis.tongue_edges(system, drive_amplitude=0.3, order=0, position="inverted")
        limits = ll.analysis.inverted_limits(system, frequency_ratio=float(found.high))
        # both are roots of one determinant
        assert float(limits.low) == pytest.approx(0.3, rel=1e-11)


def test_the_inverted_tongue_of_order_one_has_no_upper_edge():
    found = ll.analysis.tongue_edges(PAPER, drive_amplitude=0.7, position="inverted")
    assert str(found.status.values) == "no upper edge"
    limits = ll.analysis.inverted_limits(PAPER, frequency_ratio=float(found.low))
    assert float(limits.high) == pytest.approx(0.7, rel=1e-11)


def test_analyses_are_reached_without_an_import_of_their_own():
    found = ll.__getattr__("analysis")
    assert found.__name__ == "latolato.analysis"
    assert found is ll.analysis


def test_a_closed_tongue_is_told():
    with pytest.warns(RuntimeWarning, match="order 2 is closed at drive_amplitude 0.05 m"):
        found = ll.analysis.tongue_edges(PAPER, drive_amplitude=0.05, order=2)
    assert str(found.status.values) == "closed"
    assert math.isnan(found.low)
    assert math.isnan(found.high)


def test_without_drive_the_tip_is_all():
    for name in ("cosine", "below"):
        np.testing.assert_allclose(edges(FREE, DRIVES[name], drive_amplitude=0.0), 2.0, rtol=1e-15)


def test_balls_without_radius_that_bounce_elastically_are_like_one_pendulum():
    toy = ll.LatoLato(length=1.0, mass=0.8, damping=0.05, radius=0.0)
    ball = ll.Ball(length=1.0, mass=0.8, damping=0.05)
    pair = ll.BallPair(right=ball, left=ball)
    expected = edges(PAPER, drive_amplitude=0.05)
    for system in (toy, pair, LINEAR):
        assert (edges(system, drive_amplitude=0.05) == expected).all()


def test_what_has_no_linear_stability_is_refused():
    ball = ll.Ball(length=1.0, mass=0.8, radius=0.1)
    refused = {
        r"must be 0, got .* touch before they hang straight down: choose": ll.LatoLato(
            length=1.0, mass=0.8, radius=0.1
        ),
        "radius must be 0, got 0.1; balls with a radius touch before they hang": ll.BallPair(
            right=ball, left=ball
        ),
        "restitution must be 1, got 0.9": ll.LatoLato(
            length=1.0, mass=0.8, radius=0.0, restitution=0.9
        ),
        "coulomb_damping must be 0, got 0.01": ll.Pendulum(
            length=1.0, mass=0.8, coulomb_damping=0.01
        ),
        "damping must be below 2 m l w0": ll.Pendulum(length=1.0, mass=0.8, damping=6.0),
    }
    for message, system in refused.items():
        with pytest.raises(ValueError, match=message):
            ll.analysis.tongue_edges(system, drive_amplitude=0.05)


def test_bad_input_is_refused():
    tongue_edges = ll.analysis.tongue_edges
    chirp = ll.Chirp(drive_amplitude=0.1, drive_frequency=1, drive_frequency_final=2, sweep_time=10)
    with pytest.raises(ValueError, match="drive must repeat itself"):
        tongue_edges(PAPER, chirp, drive_amplitude=0.1)
    with pytest.raises(ValueError, match="the crank would jam"):
        tongue_edges(PAPER, DRIVES["below"], drive_amplitude=0.5)
    with pytest.raises(ValueError, match="order must lie in"):
        tongue_edges(PAPER, drive_amplitude=0.1, order=0)
    with pytest.raises(ValueError, match="order must lie in"):
        tongue_edges(PAPER, drive_amplitude=0.1, order=101)
    with pytest.raises(ValueError, match="position must be 'hanging' or 'inverted'"):
        tongue_edges(PAPER, drive_amplitude=0.1, position="up")
    with pytest.raises(ValueError, match="method must be 'determinant' or"):
        tongue_edges(PAPER, drive_amplitude=0.1, method="guess")
    with pytest.raises(ValueError, match="has no inverted position"):
        tongue_edges(LINEAR, drive_amplitude=0.1, position="inverted")
    with pytest.raises(ValueError, match=r"drive_amplitude must lie in \[0, inf\) m, got -0\.1"):
        tongue_edges(PAPER, drive_amplitude=-0.1)
    with pytest.raises(InputError, match="system must be one of"):
        tongue_edges("pendulum", drive_amplitude=0.1)


def test_the_picture_shows_the_edges():
    found = ll.analysis.tongue_edges(PAPER, drive_amplitude=0.05)
    texts = [text.get_text() for text in picture.draw(found).axes[0].texts]
    assert {"1.909946", "2.107508"} <= set(texts)


@pytest.mark.parametrize("order", [20, 30, 40, 60])
def test_a_tongue_narrower_than_a_rounding_is_closed_by_any_damping(order):
    system = ll.Pendulum(length=0.25, mass=0.1, damping=0.005)
    with pytest.warns(RuntimeWarning, match="closed"):
        found = ll.analysis.tongue_edges(system, drive_amplitude=0.02, order=order)
    assert found.status.item() == "closed"


@pytest.mark.parametrize("order", [20, 40, 60])
def test_edges_that_cannot_be_told_apart_are_in_order(order):
    free = ll.Pendulum(length=1.0, mass=0.8)
    edges = ll.analysis.tongue_edges(free, drive_amplitude=0.1, order=order)
    assert 0.0 <= edges.high.item() - edges.low.item() < 1e-14
