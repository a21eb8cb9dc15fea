"""The smallest drive that makes hanging unstable, against growth, edges and first order."""

import math

import pytest

import latolato as ll
from latolato.figures.analyses import threshold_amplitude as picture

PAPER = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
FREE = ll.Pendulum(length=1.0, mass=0.8)
CRANK = ll.CrankSlider(drive_amplitude=0, drive_frequency=1, connecting_rod_length=0.2)


def threshold(system, drive=None, **options):
    return float(ll.analysis.threshold_amplitude(system, drive, **options).drive_amplitude)


def test_at_twice_the_natural_frequency_it_is_the_first_order_value():
    # the next term is of relative order (gamma/w0)^2
    gamma, w0 = 0.05 / 0.8, PAPER.natural_frequency
    assert threshold(PAPER) == pytest.approx(gamma / (2.0 * w0), rel=(gamma / w0) ** 2)


@pytest.mark.parametrize("ratio", [1.93, 2.0, 2.1])
def test_following_the_bands_gives_the_closed_form_of_the_cosine(ratio):
    expected = threshold(PAPER, frequency_ratio=ratio)
    found = threshold(PAPER, frequency_ratio=ratio, order=1)
    assert found == pytest.approx(expected, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("ratio,order", [(2.1, 1), (1.01, 2)])
def test_a_crank_s_threshold_lies_on_the_edge_of_its_tongue(ratio, order):
    found = threshold(PAPER, CRANK, frequency_ratio=ratio)
    edges = ll.analysis.tongue_edges(PAPER, CRANK, drive_amplitude=found, order=order)
    # both are roots of one determinant
    assert min(abs(float(edges.low) - ratio), abs(float(edges.high) - ratio)) < 1e-11
    w = ratio * PAPER.natural_frequency
    drive = ll.CrankSlider(drive_amplitude=found, drive_frequency=w, connecting_rod_length=0.2)
    rate = ll.analysis.growth_rate(PAPER, drive, method="monodromy").growth_rate
    assert abs(float(rate)) < 1e-9


def test_without_drag_the_tip_of_a_tongue_needs_no_amplitude():
    assert threshold(FREE) == 0.0
    assert threshold(FREE, CRANK) == 0.0
    assert threshold(FREE, frequency_ratio=1.0, order=2) == 0.0
    # Both edges of the third tongue bend the same way: its tip is left at once.
    with pytest.warns(RuntimeWarning, match="no drive up to 0.1 length"):
        assert math.isnan(
            threshold(FREE, frequency_ratio=2 / 3, order=3, largest_amplitude_ratio=0.1)
        )


def test_no_threshold_is_told():
    with pytest.warns(RuntimeWarning, match="no drive up to 0.2 length makes hanging unstable"):
        found = ll.analysis.threshold_amplitude(
            PAPER, frequency_ratio=1.5, largest_amplitude_ratio=0.2
        )
    assert str(found.status.values) == "none"
    assert math.isnan(found.drive_amplitude)


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match=r"frequency_ratio must lie in \[0\.01"):
        threshold(PAPER, frequency_ratio=1e-3)
    with pytest.raises(ValueError, match="order must lie in"):
        threshold(PAPER, order=0)
    with pytest.raises(
        ValueError, match="balls with a radius touch before they hang straight down"
    ):
        threshold(ll.LatoLato(length=1.0, mass=0.8, radius=0.1))


def test_the_picture_shows_the_threshold():
    found = ll.analysis.threshold_amplitude(PAPER, frequency_ratio=2.1)
    texts = [text.get_text() for text in picture.draw(found).axes[0].texts]
    assert "46.92 mm" in texts
