"""Growth of small motion: Hill's matrix, monodromy, closed forms and runs agree."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.analysis.linear import linearised
from latolato.figures.analyses import growth_rate as picture

PAPER = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)


def rate(drive=None, system=PAPER, **options):
    return float(ll.analysis.growth_rate(system, drive, **options).growth_rate)


def crank(ratio, amplitude=0.1, guide="below"):
    w = ratio * PAPER.natural_frequency
    return ll.CrankSlider(
        drive_amplitude=amplitude, drive_frequency=w, connecting_rod_length=0.2, guide=guide
    )


@pytest.mark.parametrize("ratio", [0.3, 0.67, 1.0, 1.5, 2.0, 2.2, 5.0])
@pytest.mark.parametrize("position", ["hanging", "inverted"])
def test_determinant_and_monodromy_agree(ratio, position):
    w = ratio * PAPER.natural_frequency
    for drive in (crank(ratio), ll.Harmonic(drive_amplitude=0.3, drive_frequency=w)):
        hill = rate(drive, position=position)
        # the acceptance figure; measured 1e-12
        assert rate(drive, position=position, method="monodromy") == pytest.approx(hill, abs=1e-9)


def test_hill_s_matrix_gives_the_closed_form_of_the_cosine():
    problem = linearised(PAPER, None)
    for w in (2.0, 3.13, 6.0, 6.26, 9.0):
        drive = ll.Harmonic(drive_amplitude=0.2, drive_frequency=w)
        result = problem.growth(w, 0.2, "determinant")
        assert result == pytest.approx(rate(drive), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("guide", ["below", "above"])
def test_a_run_grows_at_this_rate(guide):
    drive = crank(2.0, guide=guide)
    period = 2.0 * math.pi / drive.drive_frequency
    linear = ll.Mathieu(length=1.0, mass=0.8, damping=0.05)
    times = period * np.array([40.0, 60.0])  # even counts: the multiplier is negative
    run = ll.simulate(linear, drive, initial_angle=1e-6, times=times, tolerance=1e-13)
    measured = math.log(float(run.angle[1] / run.angle[0])) / (times[1] - times[0])
    # the other multiplier is smaller by exp(-40 periods * twice the rate)
    assert measured == pytest.approx(rate(drive), rel=1e-9)


def test_the_largest_multiplier_is_one_on_an_edge():
    edges = ll.analysis.tongue_edges(PAPER, crank(2.0), drive_amplitude=0.1)
    for ratio in (float(edges.low), float(edges.high)):
        result = ll.analysis.growth_rate(PAPER, crank(ratio))
        # edge and rate are each good to 1e-12, and the rate is steep here
        assert float(result.largest_multiplier) == pytest.approx(1.0, abs=1e-10)


def test_without_drive_it_is_the_root_of_the_plain_equation():
    gamma, w0 = 0.05 / 0.8, PAPER.natural_frequency
    assert rate() == pytest.approx(-gamma / 2.0, rel=1e-14)
    falls = -gamma / 2.0 + math.sqrt(gamma**2 / 4.0 + w0**2)
    assert rate(position="inverted") == pytest.approx(falls, rel=1e-14)
    still = ll.Harmonic(drive_amplitude=0.0, drive_frequency=3.0)
    assert rate(still, position="inverted") == pytest.approx(falls, rel=1e-14)


def test_a_drive_too_slow_is_refused():
    with pytest.raises(ValueError, match=r"drive_frequency must be at least 0\.01"):
        rate(crank(1e-3))


def test_the_picture_shows_the_rate():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
    axes = picture.draw(ll.analysis.growth_rate(PAPER, drive)).axes[0]
    assert axes.texts[0].get_text() == "0.12505 1/s"
