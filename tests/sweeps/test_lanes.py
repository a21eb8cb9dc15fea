"""Points that run together in SIMD lanes give what they give alone."""

import functools

import numpy as np
import pytest

import latolato as ll
from latolato.sweeps import batches as kernels
from watched import IN_LANES, WITHOUT_PERIODS

TOLERANCE = 1e-8
# Rounding alone, which bouncing amplifies a thousandfold within seconds and the tables of contacts
# do not hide; impacts end in a glide whose velocity is wrong by 1e-3 of the tolerance at most.
AGREE = 0.1 * TOLERANCE
# Mean energy is a quadrature of order 4. Near a wall single trajectories take a step in parts where
# the force changes sign, lanes only if that may turn the ball twice: (2 rate step)^4/720 = 6e-5.
AGREE_ENERGY = 1e-6
COUNTS = (
    "status",
    "crossings",
    "rotations",
    "motion_class",
    "self_start",
    "bottom_contacts",
    "top_contacts",
)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
MATHIEU = ll.Mathieu(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
DAMPED = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
PHASES = list(np.linspace(0.0, 6.0, 7))
# More points than lanes, so that lanes take up further points.
OFFSETS = list(np.linspace(0.0, 1.5, 31))
MAP = {"drive_amplitude": [0.02, 0.1, 0.2], "frequency_ratio": list(np.linspace(1.2, 3.0, 7))}

CASES = {
    "free": (PENDULUM, DRIVE, {**MAP, "initial_angle": [0.1, 1.0, 2.0, 3.0]}, {}),
    "free and whirling": (
        PENDULUM,
        DRIVE,
        {"initial_angular_velocity": list(np.linspace(-12.0, 12.0, 25)), "drive_phase": PHASES},
        {"initial_angle": 0.3},
    ),
    "linear": (MATHIEU, DRIVE, {**MAP, "initial_angle": [0.1, 1.0]}, {}),
    "elastic walls": (TOY, DRIVE, {"initial_offset": OFFSETS, "drive_phase": PHASES}, {}),
    "elastic walls at a point": (
        ll.LatoLato(length=1.0, mass=0.8, radius=0.0),
        DRIVE,
        {"initial_offset": OFFSETS, "drive_phase": PHASES},
        {},
    ),
    "drag and rest": (DAMPED, DRIVE, {"initial_offset": OFFSETS, "drive_phase": PHASES}, {}),
    "drag at a point": (
        ll.LatoLato(length=1.0, mass=0.8, radius=0.0, damping=0.02, restitution=0.8),
        DRIVE,
        {"initial_offset": OFFSETS, "drive_phase": PHASES},
        {},
    ),
    "no rebound": (
        ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.0),
        ll.Harmonic(drive_amplitude=0.1, drive_frequency=12.0),
        {"initial_offset": OFFSETS, "drive_phase": PHASES},
        {},
    ),
    "cascades": (
        ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.5),
        ll.Harmonic(drive_amplitude=0.1, drive_frequency=12.0),
        {"initial_offset": OFFSETS, "drive_phase": PHASES},
        {},
    ),
    "strong drive": (
        DAMPED,
        ll.Harmonic(drive_amplitude=0.2, drive_frequency=31.3),  # 20 g
        {"initial_offset": OFFSETS, "drive_phase": PHASES},
        {"duration": 0.8, "transient": 0.2},
    ),
    "pivot at rest": (
        DAMPED,
        None,
        {"initial_offset": OFFSETS, "restitution": [0.0, 0.3, 0.6, 0.9, 1.0]},
        {},
    ),
}


@functools.cache
def both(name):
    """The same sweep in lanes and by single trajectories."""
    system, drive, axes, options = CASES[name]
    settings = {
        "axes": axes,
        "duration": 4.0,
        "transient": 1.0,
        "tolerance": TOLERANCE,
        "observables": WITHOUT_PERIODS if drive is None else IN_LANES,
        **options,
    }
    lanes = ll.sweep(system, drive, **settings)
    has_lanes = kernels.has_lanes
    try:
        kernels.has_lanes = lambda plan: False
        alone = ll.sweep(system, drive, **settings)
    finally:
        kernels.has_lanes = has_lanes
    return lanes, alone


@pytest.mark.parametrize("name", CASES)
def test_lanes_count_what_single_trajectories_count(name):
    lanes, alone = both(name)
    for variable in COUNTS:
        np.testing.assert_array_equal(lanes[variable], alone[variable], err_msg=variable)


@pytest.mark.parametrize("name", CASES)
def test_lanes_measure_what_single_trajectories_measure(name):
    lanes, alone = both(name)
    for variable in set(lanes.data_vars) - set(COUNTS):
        scale = max(1.0, float(np.nanmax(np.abs(alone[variable].values), initial=0.0)))
        atol = scale * (AGREE_ENERGY if variable == "mean_energy" else AGREE)
        np.testing.assert_allclose(
            lanes[variable], alone[variable], rtol=0.0, atol=atol, err_msg=variable
        )


def test_the_cases_bounce_rest_and_whirl():
    seen = {name: both(name)[1] for name in CASES}
    assert seen["cascades"].bottom_contacts.max() > 100
    assert seen["elastic walls"].top_contacts.max() > 0
    assert seen["free and whirling"].rotations.max() > 3
    assert 0.1 < seen["no rebound"].rest_fraction.max() < 1.0
    assert (seen["drag and rest"].status == "rest").any()
