"""What analyses call the values along their axes."""

import inspect

import pytest

import latolato as ll
from latolato.analysis.registry import analyses

TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, restitution=0.9, damping=0.00506)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0)


def sequences(name):
    """Return the parameters of an analysis that take several values."""
    parameters = inspect.signature(analyses[name]).parameters
    return [n for n, p in parameters.items() if str(p.annotation).startswith("Sequence[")]


@pytest.mark.parametrize("name", sorted(analyses))
def test_values_along_an_axis_have_its_name(name):
    plurals = [each for each in sequences(name) if each.removesuffix("s") != each]
    assert plurals == []


def test_one_number_is_an_axis_of_one_value():
    found = ll.analysis.first_push(
        TOY, DRIVE, frequency_ratio=2.4, drive_phase=0.0, scan_points=2, refinements=0,
        transient_periods=1,
    )  # fmt: skip
    assert found.first_push.dims == ("frequency_ratio", "drive_phase")
    assert found.first_push.shape == (1, 1)
