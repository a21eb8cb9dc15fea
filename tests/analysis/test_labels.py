"""Every analysis labels its dataset in the same way."""

import numpy as np

import latolato as ll
from latolato.analysis.registry import labelled


def test_labels_carry_units_and_all_parameters() -> None:
    pair = ll.BallPair(
        right=ll.Ball(length=1.0, mass=0.8, radius=0.1),
        left=ll.Ball(length=1.0, mass=0.4, radius=0.1),
    )
    drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=3.0)
    found = labelled(
        "example",
        {"growth_rate": ("frequency_ratio", np.array([0.1, 0.2])), "drive_amplitude": 0.1},
        coordinates={"frequency_ratio": ("frequency_ratio", np.array([1.0, 2.0]))},
        system=pair,
        drive=drive,
        settings={"order": 2, "is_stable": True, "left_out": None},
    )
    assert found.growth_rate.attrs["units"] == "1/s"
    assert found.frequency_ratio.attrs["units"] == "1"
    assert found.drive_amplitude.shape == ()
    expected = {"analysis": "example", "system": "ballpair", "drive": "harmonic", "order": 2}
    expected |= {"left_mass": 0.4, "drive_frequency": 3.0, "is_stable": 1}
    assert expected.items() <= found.attrs.items()
    assert "left_out" not in found.attrs
