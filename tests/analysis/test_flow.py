"""The matrix of small perturbations is that of the motion itself, through all events."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.analysis.flow import Flow
from latolato.observables import observables

SHAKE = ll.Harmonic(drive_amplitude=0.15, drive_frequency=6.0)
TOY = {"length": 1.0, "mass": 0.8, "radius": 0.1}
RIGHT = ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.05)
LEFT = ll.Ball(length=1.05, mass=0.4, radius=0.1, damping=0.02)
RUBBED = ll.Ball(
    length=1.0, mass=0.8, radius=0.1, damping=0.05, quadratic_damping=0.1, coulomb_damping=0.05
)
PLANAR = ll.PlanarHarmonic(
    vertical_amplitude=0.1, horizontal_amplitude=0.1, drive_frequency=6.0, horizontal_phase=1.0
)
STEPPED = ll.FrequencySchedule(
    drive_amplitude=0.1, times=[0.0, 1.3], drive_frequencies=[6.0, 4.0], step_impulse=True
)
DRAGS = {"damping": 0.05, "quadratic_damping": 0.1, "coulomb_damping": 0.05}
TOYS = {
    "free": (ll.Pendulum(length=1.0, mass=0.8, damping=0.05), SHAKE, (0.3, 0.2), 5.0, ()),
    "linear": (ll.Mathieu(length=1.0, mass=0.8, damping=0.05), SHAKE, (0.3, 0.2), 5.0, ()),
    "drags": (ll.Pendulum(length=1.0, mass=0.8, **DRAGS), SHAKE, (1.3, 0.2), 5.0, ()),
    "sticks": (
        ll.Pendulum(length=1.0, mass=0.8, coulomb_damping=1.0), SHAKE, (1.3, 0.2), 5.0, ()
    ),
    "bounces": (ll.LatoLato(**TOY, damping=0.05, restitution=0.9), SHAKE, (0.6, 0.2), 3.0, (0,)),
    "rubbed": (ll.LatoLato(**TOY, **DRAGS, restitution=0.8), SHAKE, (0.9, 0.2), 3.0, (0,)),
    "top": (ll.LatoLato(**TOY, damping=0.05, restitution=0.9), SHAKE, (1.6, 6.2), 3.0, (0, 1)),
    "jump": (ll.LatoLato(**TOY, restitution=0.9), STEPPED, (0.6, 0.2), 3.0, (0,)),
    "crank": (
        ll.LatoLato(**TOY, restitution=0.9),
        ll.CrankSlider(drive_amplitude=0.1, drive_frequency=6.0, connecting_rod_length=0.3),
        (0.6, 0.2), 3.0, (0,),
    ),
    "pair": (
        ll.BallPair(right=RIGHT, left=LEFT, restitution=0.9),
        SHAKE, (0.6, 0.2, -0.5, 0.1), 3.0, (0,),
    ),
    "rubbed pair": (
        ll.BallPair(right=RUBBED, left=LEFT, restitution=0.9),
        SHAKE, (0.6, 0.2, -0.5, 0.1), 3.0, (0,),
    ),
    "pair at rest": (
        ll.BallPair(right=RIGHT, left=LEFT, restitution=0.3),
        SHAKE, (0.4, 0.2, -0.2, 0.1), 5.0, (0, 2),
    ),
    "plastic pair": (
        ll.BallPair(right=RIGHT, left=LEFT, restitution=0.0),
        SHAKE, (0.4, -3.0, -0.1, -1.0), 0.3, (0, 2),
    ),
    "jumping pair": (
        ll.BallPair(right=RIGHT, left=LEFT, restitution=0.9),
        STEPPED, (0.6, 0.2, -0.5, 0.1), 3.0, (0,),
    ),
    "lab": (
        ll.LatoLato(**TOY, damping=0.3, restitution=0.9, drag_frame="lab"),
        SHAKE, (0.6, 0.2), 3.0, (0,),
    ),
    "lab pair": (
        ll.BallPair(right=RIGHT, left=LEFT, restitution=0.9, drag_frame="lab"),
        SHAKE, (0.6, 0.2, -0.5, 0.1), 3.0, (0,),
    ),
    "planar": (ll.Pendulum(length=1.0, mass=0.8, damping=0.05), PLANAR, (0.3, 0.2), 5.0, ()),
    "planar pair": (
        ll.BallPair(right=RIGHT, left=LEFT, restitution=0.9),
        PLANAR, (0.6, 0.2, -0.5, 0.1), 3.0, (0,),
    ),
    "planar pair at rest": (
        ll.BallPair(right=RIGHT, left=LEFT, restitution=0.3),
        PLANAR, (0.4, 0.2, -0.2, 0.1), 5.0, (0, 2),
    ),
}  # fmt: skip


def assert_matrix_is_that_of_differences(flow, start, duration, kinds):
    middle = np.array(start)
    result = flow.follow(middle, duration)
    assert set(result.contact_kinds) == set(kinds)
    columns = []
    for unit in np.eye(len(start)) * 1e-6:
        ahead, behind = (flow.follow(middle + s * unit, duration).end for s in (1.0, -1.0))
        columns.append((ahead - behind) / 2e-6)
    differences = np.array(columns).T
    # Central differences of 1e-6 err by about 1e-6^2 |M|^3 and the run's 1e-12 over 1e-6.
    scale = np.max(np.abs(result.matrix)) ** 2
    assert np.max(np.abs(result.matrix - differences)) < 1e-7 * max(scale, 1.0)


@pytest.mark.parametrize("name", TOYS)
def test_the_matrix_is_that_of_finite_differences(name):
    system, drive, start, duration, kinds = TOYS[name]
    assert_matrix_is_that_of_differences(Flow(system, drive, speed=20.0), start, duration, kinds)


@pytest.mark.parametrize("name, start, kinds", [
    ("bounces", (0.4, -3.0), (0,)), ("rubbed", (0.4, -3.0), (0,)),
    ("pair", (0.4, -3.0, -0.1, -1.0), (0,)), ("rubbed pair", (0.4, -3.0, -0.1, -1.0), (0,)),
    ("plastic pair", (0.4, -3.0, -0.1, -1.0), (0, 2)),
])  # fmt: skip
def test_the_matrix_of_one_impact_is_that_of_finite_differences(name, start, kinds):
    flow = Flow(*TOYS[name][:2], speed=20.0, compiled=False)
    assert_matrix_is_that_of_differences(flow, start, 0.2, kinds)


@pytest.mark.parametrize(
    "name",
    [name for name in TOYS if not (name.endswith("rest") or name in ("sticks", "plastic pair"))],
)
def test_the_determinant_is_that_of_the_laws_of_motion(name):
    system, drive, start, duration, _ = TOYS[name]
    result = Flow(system, drive).follow(np.array(start), duration)
    expected = result.spread
    assert np.linalg.slogdet(result.matrix)[1] == pytest.approx(expected, abs=1e-11)
    linear = [b.damping / (b.mass * b.length) for b in system.balls]
    if not any(b.quadratic_damping + b.coulomb_damping for b in system.balls):
        bounces = 2.0 * result.impacts * math.log(getattr(system, "restitution", 1.0))
        assert expected == pytest.approx(-sum(linear) * duration + bounces, abs=1e-12)


def test_rest_on_a_wall_forgets_the_start():
    toy = ll.LatoLato(**TOY, damping=0.05, restitution=0.3)
    strong = ll.Harmonic(drive_amplitude=0.3, drive_frequency=6.0)
    result = Flow(toy, strong).follow(np.array([0.3, 0.0]), 6.0)
    assert 2 in result.contact_kinds
    assert not result.matrix.any()


def test_the_matrix_is_the_same_in_plain_python():
    names = ("bounces", "pair at rest")
    for name in names:
        system, drive, start, _, _ = TOYS[name]
        compiled = Flow(system, drive, tolerance=1e-6).follow(np.array(start), 1.5)
        plain = Flow(system, drive, tolerance=1e-6, compiled=False).follow(np.array(start), 1.5)
        # Compiled code fuses multiply-adds; the last of the bounces before rest, of 1e-7 rad/s,
        # magnify a rounding of 1e-16 by its inverse.
        assert plain.matrix == pytest.approx(compiled.matrix, abs=3e-9)


def test_clamped_contact_is_refused():
    toy = ll.LatoLato(**TOY)
    with pytest.raises(ValueError, match="exact or none"):
        Flow(toy, SHAKE, contact=ll.ClampContact(clamp_step=1e-3))
    with pytest.raises(ValueError, match="lyapunov_exponent needs exact contact"):
        ll.sweep(
            toy, SHAKE, axes={"initial_angle": [0.5]}, duration=5.0,
            contact=ll.ClampContact(clamp_step=1e-3), observables=["lyapunov_exponent"],
        )  # fmt: skip


def test_exponents_obey_the_sum_rule_and_are_sorted():
    settings = {"duration": 200.0, "transient": 20.0, "tolerance": 1e-9}
    watched = ["lyapunov_spectrum", "lyapunov_exponent", "sum_rule_residual", "bottom_contacts"]
    cases = (
        (TOYS["free"][0], {"initial_angle": [0.3]}, -0.0625),
        (ll.LatoLato(**TOY, restitution=0.99), {"initial_angle": [0.6]}, None),
        (ll.LatoLato(**TOY), {"initial_angle": [0.6, 0.9]}, 0.0),
    )
    for system, axes, total in cases:
        grid = ll.sweep(system, SHAKE, axes=axes, observables=watched, **settings)
        exponents = grid.lyapunov_exponents.values
        assert grid.lyapunov_exponents.dims[-1] == "exponent"
        assert np.all(exponents[:, 0] >= exponents[:, 1])
        assert np.array_equal(exponents[:, 0], grid.lyapunov_exponent.values)
        assert np.max(np.abs(grid.sum_rule_residual)) < 1e-12  # rounding of sums of logarithms
        if total is not None:
            assert exponents.sum(axis=1) == pytest.approx(total, abs=1e-12)


def test_a_pair_has_four_exponents_without_a_ball():
    pair = ll.BallPair(right=RIGHT, left=RIGHT, restitution=0.9)
    grid = ll.sweep(
        pair, SHAKE, axes={"initial_angle_right": [0.6]}, initial_angle=(0.6, -0.6),
        duration=50.0, observables=["lyapunov_spectrum", "sum_rule_residual"], tolerance=1e-9,
    )  # fmt: skip
    assert grid.lyapunov_exponents.dims == ("initial_angle_right", "exponent")
    assert grid.sizes["exponent"] == 4
    assert grid.sum_rule_residual.dims == ("initial_angle_right",)


def test_motion_with_rest_has_exponents_of_minus_infinity():
    toy = ll.LatoLato(**TOY, damping=0.05, restitution=0.5)
    grid = ll.sweep(
        toy, SHAKE, axes={"initial_offset": [0.3]}, duration=60.0, transient=30.0,
        observables=["lyapunov_spectrum", "sum_rule_residual"],
    )  # fmt: skip
    assert np.all(grid.lyapunov_exponents == -math.inf)
    assert np.isnan(grid.sum_rule_residual).all()  # minus infinity on both sides


def test_every_kind_of_deviation_is_registered_but_the_matrix():
    assert {"lyapunov_exponent", "lyapunov_spectrum", "sum_rule_residual"} <= set(observables)
    assert "deviations" not in observables


def test_lanes_stretch_deviations_like_single_trajectories():
    toy = ll.LatoLato(**TOY, damping=0.02, restitution=0.6)
    settings = {
        "axes": {"drive_amplitude": [0.05, 0.2, 0.4], "frequency_ratio": [0.5, 1.8, 3.0, 4.5]},
        "duration": 6.0, "transient": 1.0, "initial_offset": 0.2, "tolerance": 1e-8,
        "observables": ["lyapunov_spectrum", "sum_rule_residual", "bottom_contacts"],
    }  # fmt: skip
    lanes = ll.sweep(toy, executor="threads", **settings)
    plain = ll.sweep(toy, executor="reference", **settings)
    assert float(lanes.bottom_contacts.max()) > 3
    resting = np.isinf(plain.lyapunov_exponents.values)
    assert np.array_equal(np.isinf(lanes.lyapunov_exponents.values), resting)
    assert 0 < resting.sum() < resting.size
    # The tolerance, magnified by the impacts of a few seconds.
    assert lanes.lyapunov_exponents.values[~resting] == pytest.approx(
        plain.lyapunov_exponents.values[~resting], abs=1e-5
    )
    assert np.nanmax(np.abs(lanes.sum_rule_residual)) < 1e-12
