"""What analyses call the values along their axes."""

import inspect

import pint
import pytest

import latolato as ll
from latolato.analysis.registry import analyses
from latolato.core.errors import InputError

TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, restitution=0.9, damping=0.00506)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0)


def sequences(name):
    """Return the parameters of an analysis that take several values, not several names."""
    parameters = inspect.signature(analyses[name]).parameters
    return [n for n, p in parameters.items() if str(p.annotation).startswith("Sequence[float")]


@pytest.mark.parametrize("name", sorted(analyses))
def test_values_along_an_axis_have_its_name(name):
    plurals = [each for each in sequences(name) if each.removesuffix("s") != each]
    assert plurals == []


def test_one_number_is_an_axis_of_one_value():
    result = ll.analysis.first_push(
        TOY, DRIVE, frequency_ratio=2.4, drive_phase=0.0, scan_points=2, refinements=0,
        transient_periods=1,
    )  # fmt: skip
    assert result.first_push.dims == ("frequency_ratio", "drive_phase")
    assert result.first_push.shape == (1, 1)


NEEDED = {
    "frequency_ratio": 2.4, "drive_amplitude": 0.03, "parameter": "frequency_ratio", "low": 1.0,
    "high": 2.0, "noise_strength": 0.1,
}  # fmt: skip
BALL = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)


DRIVEN = sorted(n for n in analyses if "drive" in inspect.signature(analyses[n]).parameters)


@pytest.mark.parametrize("name", DRIVEN)
@pytest.mark.parametrize("drive", [5, "harmonic"])
def test_something_that_is_no_drive_is_a_wrong_type(name, drive):
    parameters = inspect.signature(analyses[name]).parameters
    system = TOY if name in ("self_start", "pair_symmetry", "impact_map") else BALL
    settings = {n: v for n, v in NEEDED.items() if n in parameters}
    settings = {n: v for n, v in settings.items() if parameters[n].default is parameters[n].empty}
    if "initial_angle" in parameters:
        settings["initial_angle"] = 0.2
    with pytest.raises(InputError, match="drive must be None or one of"):
        analyses[name](system, drive=drive, **settings)


def test_the_public_names_are_listed_and_nothing_else():
    assert set(dir(ll.analysis)) == {*ll.analysis.__all__, *analyses}


def test_an_end_is_in_the_unit_of_the_parameter_that_is_named():
    unit = pint.UnitRegistry()
    settings = {"points": 2, "transient_periods": 1, "initial_angle": 20 * unit.deg}
    ends = {"low": 20 * unit.mm, "high": 2.1 * unit.cm}
    found = ll.analysis.bifurcation_diagram(
        TOY, DRIVE, parameter="drive_amplitude", **ends, **settings
    )
    assert found.drive_amplitude.values == pytest.approx([0.02, 0.021])
    with pytest.raises(InputError, match=r"low must be given in rad/s .* got 20 milli"):
        ll.analysis.bifurcation_diagram(TOY, DRIVE, parameter="drive_frequency", **ends, **settings)
