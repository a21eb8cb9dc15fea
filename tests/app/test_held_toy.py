"""The toy that a hand holds, moved by JavaScript, beside what Python computes."""

from __future__ import annotations

import numpy as np
import pytest

import latolato as ll
from latolato.app.run_request import RunRequest
from latolato.numerics.integrate import Start, integrate
from latolato.scenario.scenario import scenarios
from latolato.simulation.start import DEFAULT_REST_SPEED
from toys import TICKS_PER_SECOND, Job, move_toys

KEEP = (0, "keep", None)
STRING = {"suspension": "string", "drive_amplitude": "60 mm"}
STILL = {"drive": "harmonic", "drive_amplitude": "0 m", "drive_frequency": "6 rad/s"}
RUNS = [name for name, scenario in scenarios().items() if not scenario.varied]


def scenario_of(job):
    return RunRequest(job.scenario, job.options).to_scenario()


# Undriven, driven, colliding (rest and impacts), two balls, pushed.
@pytest.mark.parametrize(
    "job",
    [
        Job("fig02", 600, options={**STILL, "initial_angle": "40 deg"}),
        Job("fig03a", 600),
        Job("fig04b_push", 600, options={"drive": "harmonic"}),
        Job("toy", 200, options={"initial_angular_velocity": "25 rad/s"}),
        Job("ballpair_asymmetric", 120, options={"initial_angular_velocity": "9 rad/s, -9 rad/s"}),
        Job("fig02", 300, [(50, "push", 1.0), (200, "push", -2.0)], options=STILL),
        Job("toy", 120, options=STRING),
    ],
    ids=lambda job: f"{job.scenario}, {len(job.options)} options, {len(job.actions)} pushes",
)
def test_a_toy_moves_as_the_same_steps_in_python(tmp_path, job):
    (done,) = move_toys(tmp_path, job)
    scenario = scenario_of(job)
    system, (step, *steps) = scenario.system, done["steps"]
    assert set(steps) <= {step}  # as long as the toy is not faster than it was allowed for
    run = scenario.run
    start = Start(*(tuple(np.atleast_1d(value)) for value in beginning(scenario)))
    instants = np.arange(job.ticks + 1) / TICKS_PER_SECOND
    sizes = np.zeros((system.angles, job.ticks))
    for tick, _, speed in job.actions:
        sizes[:, tick] += np.array([speed, -speed])[: system.angles]
    # Kicks end a step, even those that change nothing: as a toy does at each tick.
    result = integrate(
        system, scenario.drive, start, instants[1:], instants[-1], step=step,
        rest_speed=run.get("rest_speed", DEFAULT_REST_SPEED), kick_times=instants[:-1],
        kick_sizes=sizes,
    )  # fmt: skip
    angles = np.array(done["angles"]).T
    np.testing.assert_allclose(angles, result.samples[: 2 * system.angles : 2], rtol=0, atol=1e-12)


def beginning(scenario):
    """Angles and velocities at time zero."""
    run = scenario.run
    angle = run.get("initial_angle")
    if angle is None:
        angle = scenario.system.contact_angle_low + run["initial_offset"]
    return angle, run.get("initial_angular_velocity") or np.zeros(scenario.system.angles)


CHANGES = [
    (300, "keep", None),
    (360, "set", {"drive_frequency": 15.1}),
    (364, "set", {"drive_amplitude": 0.04}),
    (480, "set", {"drive_amplitude": 0.02, "drive_frequency": 20.0}),
]


@pytest.mark.parametrize(
    "job",
    [
        Job("fig12", 720, [KEEP]),
        Job("fig04b_push", 720, [KEEP]),
        Job("fig02", 720, [KEEP]),
        Job("ballpair_asymmetric", 180, [KEEP]),  # it is chaotic
        Job("fig12", 720, CHANGES, options={"drive_amplitude": "34 mm"}),
        Job("toy", 180, [KEEP], options=STRING),
    ],
    ids=lambda job: f"{job.scenario}, {len(job.actions)} actions",
)
def test_what_is_kept_is_the_run_of_its_options(tmp_path, job):
    (done,) = move_toys(tmp_path, job)
    kept, dataset = done["kept"], done["dataset"]
    assert kept["deviation"] < 1e-6
    assert not kept["byHand"]
    again = RunRequest(None, kept["options"]).to_scenario()
    run = again.simulate(times=dataset["time"].values)
    # Both aim at 1e-10; the motion is regular or short.
    np.testing.assert_allclose(dataset["angle"], run["angle"], rtol=0, atol=1e-7)
    assert list(dataset["contact_kind"].values) == list(run["contact_kind"].values)
    np.testing.assert_allclose(dataset["contact_time"], run["contact_time"], rtol=0, atol=1e-7)
    scale = float(run["total_energy"].max())
    for part in ("drive_work", "damping_loss", "impact_loss", "capture_loss"):
        np.testing.assert_allclose(dataset[part], run[part], rtol=0, atol=1e-6 * scale)


HUNG = {"suspension": "string", "drag_frame": "lab"}


@pytest.mark.parametrize(
    "name, options",
    [
        ("fig12", {}), ("ballpair_asymmetric", {}), ("fig02", {}), ("fig02_mathieu", {}),
        ("fig12", HUNG), ("ballpair_asymmetric", HUNG),
    ],
)  # fmt: skip
def test_a_file_of_what_is_kept_has_the_columns_of_python(tmp_path, name, options):
    (done,) = move_toys(tmp_path, Job(name, 60, [KEEP], options))
    dataset = done["dataset"]
    run = RunRequest(None, done["kept"]["options"]).to_scenario().simulate(
        times=dataset["time"].values
    )  # fmt: skip
    path = ll.save(run, tmp_path / "python.csv")
    expected = ll.load(path)
    assert list(dataset.variables) == list(expected.variables)
    for variable in expected.variables:
        assert dataset[variable].dims == expected[variable].dims
        about = expected[variable].attrs
        assert {key: dataset[variable].attrs.get(key) for key in about} == about
    assert dataset.attrs["note"]
    known = expected.attrs.keys() & dataset.attrs.keys()
    assert {key: dataset.attrs[key] for key in known} == {key: expected.attrs[key] for key in known}
    assert "scenario" not in dataset.attrs
    assert {"system", "drive", "latolato_version", "duration", "contact"} <= known


def test_the_work_of_a_hand_is_a_column(tmp_path):
    (done,) = move_toys(tmp_path, Job("fig12", 120, [KEEP, (60, "push", 2.0)]))
    assert done["kept"]["byHand"]
    dataset = done["dataset"]
    assert float(dataset["noise_work"][-1]) > 0.0
    assert "hand" in dataset.attrs["note"]


def test_the_heights_of_a_shaken_pivot_make_the_same_motion_in_python(tmp_path):
    shake = (60, "shake", {"amplitude": 0.02, "frequency": 12.0})
    job = Job("fig02", 360, [(60, "keep", None), shake], options={"initial_angle": "40 deg"})
    (done,) = move_toys(tmp_path, job)
    kept, dataset = done["kept"], done["dataset"]
    assert kept["deviation"] is None
    assert dataset.attrs["drive"] == kept["options"]["drive"] == "measured_pivot"
    assert "pivot_height is its motion" in dataset.attrs["note"]
    time = dataset["time"].values
    scenario = scenario_of(Job("fig02", 0, options=STILL))
    run = ll.simulate(
        scenario.system,
        ll.MeasuredPivot(times=time, pivot_heights=dataset["pivot_height"].values),
        initial_angle=float(dataset["angle"][0]),
        initial_angular_velocity=float(dataset["angular_velocity"][0]),
        duration=time[-1], times=time,
    )  # fmt: skip
    # Between samples the spline rounds off the kinks of the acceleration, sixty a second.
    np.testing.assert_allclose(dataset["angle"], run["angle"], rtol=0, atol=5e-4)
    np.testing.assert_allclose(dataset["pivot_velocity"], run["pivot_velocity"], rtol=0, atol=1e-3)


def test_every_scenario_makes_a_toy(tmp_path):
    done = move_toys(tmp_path, *(Job(name, 2) for name in RUNS))
    assert [name for name, each in zip(RUNS, done, strict=True) if not each["isSinusoidal"]] == [
        "crank_slider"
    ]
    for name, each in zip(RUNS, done, strict=True):
        scenario = scenarios()[name]
        for control in ("drive_amplitude", "drive_frequency"):
            if hasattr(scenario.drive, control):
                assert each["controls"][control] == getattr(scenario.drive, control)
        assert each["controls"]["damping"] == scenario.system.balls[0].damping
