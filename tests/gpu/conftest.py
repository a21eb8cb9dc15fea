"""Small plans over every trajectory kernel, several drives and all observables."""

from dataclasses import replace

import numpy as np
import pytest

import latolato as ll
from latolato.observables import observables
from latolato.sweeps.plan import make_plan

BALL = ll.Ball(length=0.9, mass=0.5, radius=0.09, damping=0.01)
LEFT = ll.Ball(length=0.85, mass=0.3, radius=0.09, damping=0.01)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
MATHIEU = ll.Mathieu(length=1.0, mass=0.8, damping=0.05)
ROUGH = ll.LatoLato(
    length=1.0, mass=0.8, damping=0.02, coulomb_damping=0.01, radius=0.1, restitution=0.9
)
TOY = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1, restitution=0.9)
PAIR = ll.BallPair(right=BALL, left=LEFT, restitution=0.9)
STRINGS = replace(TOY, suspension="string", string_restitution=0.5)
STRING_PAIR = replace(PAIR, suspension="string", drag_frame="lab")
HARMONIC = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
SCHEDULE = ll.FrequencySchedule(
    drive_amplitude=0.03, times=[0.0, 0.4], drive_frequencies=[6.0, 5.0], ramp=0.2
)
CRANK = ll.CrankSlider(drive_amplitude=0.02, drive_frequency=15.0, connecting_rod_length=0.2)
HAND = ll.PlanarHarmonic(
    vertical_amplitude=0.5, horizontal_amplitude=0.2, drive_frequency=6.0, horizontal_phase=1.0
)
ONE = {"initial_angle": [0.3, 0.5], "initial_angular_velocity": [0.0, -1.0]}
TWO = {"initial_angle_right": [0.3, 0.5], "initial_angle_left": [-0.3, -0.5]}
# What looks once per drive period needs one; a schedule has none.
# What response_samples gives too would be given twice, and two balls have one of their own.
ELSEWHERE = ("poincare_section", "response_period", "transverse_exponent")
ALL = [name for name, kind in observables.items() if name not in ELSEWHERE and not kind.of_strings]
UNMARKED = [name for name in ALL if name not in ("response_samples", "contact_word")]

CASES = {
    "pendulum-harmonic": (PENDULUM, HARMONIC, ONE, ALL, {}),
    "mathieu-schedule": (MATHIEU, SCHEDULE, ONE, UNMARKED, {}),
    "latolato-crank": (TOY, CRANK, ONE, ["largest_angle", "bottom_contacts"], {}),
    "latolato-friction": (ROUGH, HARMONIC, ONE, ["rest_fraction", "impact_speed"], {}),
    "latolato-clamp": (
        TOY, HARMONIC, ONE, ["crossings"], {"contact": ll.ClampContact(clamp_step=5e-3)}
    ),
    "ballpair-harmonic": (PAIR, HARMONIC, TWO, ["mean_energy", "lyapunov_exponent"], {}),
    "latolato-strings": (
        STRINGS, ll.Harmonic(drive_amplitude=0.5, drive_frequency=6.0), ONE,
        ["slack_fraction", "largest_string_impulse", "energy_ledger", "lyapunov_exponent"], {},
    ),
    "ballpair-strings": (
        STRING_PAIR, HAND, TWO, ["slack_fraction", "first_slack", "lyapunov_exponent"], {}
    ),
    "ballpair-kicks": (
        PAIR, HARMONIC, TWO, ["energy_ledger"],
        {"noise": ll.VelocityKicks(noise_strength=0.01, noise_seed=1)},
    ),
}  # fmt: skip


# All observables, and both engines; `make test-all` compiles the others as well.
SHORT = ("pendulum-harmonic", "ballpair-strings")


@pytest.fixture(
    params=[pytest.param(name, marks=[] if name in SHORT else [pytest.mark.slow]) for name in CASES]
)
def plan(request):
    """A plan of 2 x 2 points for 1 s."""
    system, drive, axes, watched, more = CASES[request.param]
    axes = {name: np.array(values) for name, values in axes.items()}
    return make_plan(
        system, drive, axes=axes, duration=1.0, transient=0.2, observables=watched, **more
    )
