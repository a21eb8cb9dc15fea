"""Maps that workers of a page compute, beside those of `latolato.sweep`."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import latolato as ll
from in_node import read_layout
from latolato.sweeps.batches import run_fastest
from latolato.sweeps.chunk import run_chunk
from latolato.sweeps.plan import make_plan
from latolato.sweeps.points import make_batch
from map_in_node import maps_in_node

BALL = {"length": 1.0, "mass": 0.8, "radius": 0.1, "damping": 0.02}
# The rest speed is larger than usual for a reason that `REST_SPEED` of `test_wasm.py` gives.
USUAL = {"gravity": 9.8, "restitution": 0.9, "rest_speed": 1e-4, "tolerance": 1e-8, "collides": 1}
GENTLE = {"drive_amplitude": 0.01, "drive_frequency": 7.0, "drive_phase": 0.4}
OBSERVABLES = ("mean_energy", "largest_angle", "lyapunov_exponent")
HARMONIC = ll.Harmonic(**GENTLE)
TOY = ll.LatoLato(**BALL, restitution=0.9)
PAIR = ll.BallPair(right=ll.Ball(**BALL), left=ll.Ball(**BALL), restitution=0.9)
BALLS = {f"{side}_{name}": value for side in ("right", "left") for name, value in BALL.items()}
SEVEN = np.linspace(0.0, 1.0, 7)
CHIRP = ll.Chirp(**GENTLE, drive_frequency_final=5.0, sweep_time=6.0)

# System, drive, what a page calls them, the start, x, y and further options of the sweep.
MAPS = {
    "ratios": (
        TOY, HARMONIC, {"drive": "harmonic", "parameters": BALL | GENTLE}, {"initial_offset": 0.3},
        ("frequency_ratio", 0.5 + SEVEN), ("drive_acceleration_ratio", 0.1 * SEVEN),
        {"transient_periods": 2.0},
    ),
    "start and rod": (
        TOY, HARMONIC, {"drive": "harmonic", "parameters": BALL | GENTLE | {"initial_offset": 1.0}},
        {}, ("initial_angle", 0.05 + SEVEN), ("length", 0.06 + SEVEN), {},
    ),
    "chirp": (
        TOY, CHIRP,
        {
            "drive": "chirp",
            "parameters": BALL | GENTLE | {"drive_frequency_final": 5.0, "sweep_time": 6.0},
        },
        {"initial_angle": 0.4}, ("sweep_time", 4.0 + SEVEN), ("amplitude_ratio", 0.01 * SEVEN), {},
    ),
    "noise": (
        TOY, HARMONIC,
        {"drive": "harmonic", "parameters": BALL | GENTLE | {"noise_strength": 0.02}},
        {"initial_angle": 0.4}, ("noise_strength", 0.02 * SEVEN), ("damping", 0.01 + SEVEN),
        {"noise": ll.VelocityKicks(noise_strength=0.02)},
    ),
    "two balls": (
        PAIR, HARMONIC, {"angles": 2, "drive": "harmonic", "parameters": BALLS | GENTLE},
        {"initial_angle": (0.4, -0.3)}, ("left_mass", 0.5 + SEVEN),
        ("initial_angular_velocity_left", SEVEN), {},
    ),
}  # fmt: skip


def page_plan(name):
    """Return a map as pages plan it."""
    system, _, about, start, x, y, how = MAPS[name]
    parameters = USUAL | about["parameters"]
    for quantity, value in start.items():
        sides = {"": value} if system.angles == 1 else {"_right": value[0], "_left": value[1]}
        parameters |= {quantity + side: each for side, each in sides.items()}
    axes = {key: {"name": axis, "values": list(v)} for key, (axis, v) in (("x", x), ("y", y))}
    observables = [{"name": each} for each in OBSERVABLES]
    more = {k: v for k, v in how.items() if k != "noise"}
    return {**about, "parameters": parameters, **axes, "observables": observables,
            "duration": 6.0, "transient": 1.0, **more}  # fmt: skip


@pytest.fixture(scope="module")
def in_pages():
    """All maps of this file by name."""
    read_layout()
    return dict(zip(MAPS, maps_in_node([page_plan(name) for name in MAPS]), strict=True))


def sweep_plan(name, gravity=9.8):
    """Return the same map as Python plans it."""
    system, drive, _, start, x, y, how = MAPS[name]
    return make_plan(
        dataclasses.replace(system, gravity=gravity), drive, axes=dict((y, x)),
        observables=OBSERVABLES, duration=6.0, transient=1.0, tolerance=USUAL["tolerance"],
        rest_speed=USUAL["rest_speed"], **start, **how,
    )  # fmt: skip


@pytest.mark.parametrize("name", MAPS)
def test_pages_compute_the_map_that_python_computes(name, in_pages):
    page = in_pages[name]
    native, *moved = (
        run_chunk(sweep_plan(name, 9.8 * (1.0 + share)), 0, run_fastest)[0]
        for share in (0.0, 1e-13, -1e-13)
    )
    assert np.array_equal(page["status"], native["status"].ravel())
    compared = 0
    for variable, row in zip(page["variables"], page["values"], strict=True):
        one, *others = (
            values[variable["name"]].reshape(49, -1)[:, variable["ball"] or 0]
            for values in (native, *moved)
        )
        result = np.array(row, dtype=float)
        assert np.array_equal(np.isnan(result), np.isnan(one)), variable
        with np.errstate(invalid="ignore"):  # infinite ones
            apart = np.max([np.abs(other - one) for other in others], axis=0)
            regular = apart < 1e-11 * (1.0 + np.abs(one))
        np.testing.assert_allclose(result[regular], one[regular], rtol=1e-10, atol=1e-10)
        compared += np.count_nonzero(regular)
    assert compared >= 25 * len(page["variables"])


def test_every_picture_has_more_points(in_pages):
    for page in in_pages.values():
        points = [picture["points"] for picture in page["pictures"]]
        assert points == sorted(set(points))
        assert points[-1] == 49


def test_steps_are_counted_before_a_map_begins(in_pages):
    for name, page in in_pages.items():  # whose points are counted one by one
        plan = sweep_plan(name)
        batch = make_batch(plan, np.arange(plan.size))
        steps = plan.duration / batch.points.settings["step"][batch.valid]
        assert page["estimate"]["steps"] == pytest.approx(steps.sum(), rel=1e-12), name
