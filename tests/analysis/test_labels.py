"""Every analysis labels its dataset in the same way."""

from importlib.util import find_spec
from inspect import signature

import numpy as np
import pytest

import latolato as ll
from latolato.analysis.registry import analyses, labelled, recorded
from latolato.core.errors import InputError


def test_labels_carry_units_and_all_parameters() -> None:
    pair = ll.BallPair(
        right=ll.Ball(length=1.0, mass=0.8, radius=0.1),
        left=ll.Ball(length=1.0, mass=0.4, radius=0.1),
    )
    drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=3.0)
    found = labelled(
        {"growth_rate": ("frequency_ratio", np.array([0.1, 0.2])), "drive_amplitude": 0.1},
        system=pair,
        drive=drive,
        coordinates={"frequency_ratio": [1.0, 2.0]},
        settings={"order": 2, "is_stable": True, "left_out": None},
    )
    arguments = {"position": "hanging", "order": 1, "growth_rate": 3.0, "other": pair}
    found = recorded("growth_rate", found, arguments)
    assert found.growth_rate.attrs["units"] == "1/s"
    assert found.frequency_ratio.attrs["units"] == "1"
    assert found.drive_amplitude.shape == ()
    expected = {
        "analysis": "growth_rate",
        "position": "hanging",
        "system": "ballpair",
        "drive": "harmonic",
        "order": 2,
    }
    expected |= {"left_mass": 0.4, "drive_frequency": 3.0, "is_stable": 1}
    assert expected.items() <= found.attrs.items()
    assert not {"left_out", "other", "growth_rate"} & found.attrs.keys()


@pytest.mark.parametrize(
    "name, argument",
    [("tongue_edges", "drive_amplitude"), ("response_period", "tolerance"), ("basins", "longest")],
)
def test_none_is_an_argument_only_where_it_is_the_default(name, argument) -> None:
    rod = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
    with pytest.raises(InputError, match=f"{argument} must be a .*, got None"):
        analyses[name](rod, drive, **{argument: None})


@pytest.mark.parametrize(
    "name, arguments, options",
    [
        ("tongue_edges", 1, {}),
        ("tongue_edges", 4, {"drive_amplitude": 0.1}),
        ("growth_rate", 1, {"metod": "determinant"}),
    ],
)
def test_arguments_that_do_not_fit_are_refused_with_the_name_of_the_analysis(
    name, arguments, options
) -> None:
    rod = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    with pytest.raises(TypeError, match=f"{name}: .*argument"):
        analyses[name](*[rod, None, 1.0, 2.0][:arguments], **options)


def test_a_warning_of_an_analysis_points_at_its_caller() -> None:
    rod = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    with pytest.warns(RuntimeWarning, match="no drive up to 0.001 length") as warned:
        ll.analysis.threshold_amplitude(rod, largest_amplitude_ratio=0.001)
    assert warned[0].filename == __file__


def test_every_argument_of_an_analysis_becomes_an_attribute() -> None:
    drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
    rod = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    found = ll.analysis.bifurcation_diagram(
        rod, drive, parameter="drive_amplitude", low=0.01, high=0.02, points=2,
        initial_angle=np.float32(0.1), transient_periods=0,
    )  # fmt: skip
    names = signature(ll.analysis.bifurcation_diagram).parameters.keys() - {"system", "drive"}
    assert names - found.attrs.keys() == {"initial_offset", "direction"}  # None; a coordinate


def test_an_analysis_and_its_picture_are_in_modules_of_its_name() -> None:
    for name, function in analyses.items():
        if function.__module__.startswith("latolato."):
            assert function.__module__ == f"latolato.analysis.{name}"
            assert find_spec(f"latolato.figures.analyses.{name}") is not None
