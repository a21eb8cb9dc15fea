"""What hosts without Python call: it gives what Python's own way gives."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.numerics.abi import words_of
from latolato.numerics.engine.samples import allowed_error
from latolato.numerics.host_entry import (
    WRITTEN,
    Beginning,
    DriveParameters,
    Shaking,
    empty_beginning,
    empty_shaking,
)
from latolato.numerics.integrate import prepared_runs
from latolato.numerics.kernels import ALLOWED_ERROR, BEGIN, SHAKE, kernel_of
from latolato.numerics.prepare import cases_of, choose_stepper
from latolato.numerics.records import PROBLEM, segment_dtype, segment_records
from latolato.physics.contacts import ExactContact
from latolato.physics.problems import FINE

BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.02)
ROUGH = ll.Ball(length=0.95, mass=0.5, radius=0.08, quadratic_damping=0.1)
SYSTEMS = {
    "pendulum": ll.Pendulum(length=0.7, mass=0.3, damping=0.1),
    "mathieu": ll.Mathieu(length=0.7, mass=0.3),
    "toy": ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.9, coulomb_damping=0.01),
    "pair": ll.BallPair(right=BALL, left=ROUGH, restitution=0.8),
}


def shaken(drive):
    """The segments that the compiled formula writes for a drive of the package."""
    numbers = {
        name: np.array(value) if isinstance(value, tuple) else value
        for name, value in vars(drive.numbers).items()
    }
    numbers |= {"kind": list(WRITTEN.values()).index(type(drive))}
    example, number = empty_shaking(), np.zeros(1, dtype=np.int64)
    out = np.zeros(2 * len(getattr(drive, "times", ())) + 2, dtype=segment_dtype())
    given = DriveParameters(**example.drive._asdict() | numbers)
    words = np.array(words_of(Shaking(given, out, number), example))
    kernel_of(SHAKE).call(words.ctypes.data)
    return out[: number[0]]


def test_every_drive_is_written_as_python_writes_it(drive):
    if type(drive) not in WRITTEN.values():
        assert isinstance(drive, ll.MeasuredPivot)  # a host gives its segments
        return
    found, expected = shaken(drive), segment_records(drive, math.inf)
    assert len(found) == len(expected)
    for name in found.dtype.names:  # to rounding: compiled code may fuse multiply-adds
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-14, atol=1e-14)


def test_steps_that_are_blows_are_written_with_their_jumps():
    drive = ll.FrequencySchedule(
        drive_amplitude=0.03, times=[0.0, 2.0], drive_frequencies=[9, 5], step_impulse=True
    )
    found = shaken(drive)
    assert found["jump"][1] == pytest.approx(drive.segments(math.inf)[1].jump, rel=1e-14)
    assert found["jump"][1] != 0.0


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_run_begins_as_pythons_does(name):
    system, drive = SYSTEMS[name], ll.Harmonic(drive_amplitude=0.1, drive_frequency=7.0)
    angles = (0.8, -0.5)[: system.angles]
    given = {"angles": angles, "velocities": (0.3, -0.2), "duration": 10.0, "tolerance": 1e-10}
    case = cases_of(system, ExactContact(), **given)
    segments, problem = segment_records(drive, 10.0), np.zeros(1, dtype=PROBLEM)
    bounds = drive.largest_acceleration, drive.fastest_frequency
    expected = prepared_runs(cases_of(system, ExactContact(), bounds=bounds, **given),
                             choose_stepper(system))  # fmt: skip
    run = np.zeros_like(expected)
    words = np.array(words_of(Beginning(case, segments, run, problem), empty_beginning()))
    kernel_of(BEGIN).call(words.ctypes.data)
    assert problem["number"] == FINE
    assert run.tobytes() == expected.tobytes()


@pytest.mark.parametrize("change, said", [
    ({"radius": 1.0}, r"radius must lie in \[0, length\), got 1"),
    ({"radius": 0.5}, r"initial_angle must lie between the contact angles \[0\.52.*, got 0\.4"),
    ({"damping": math.inf}, "leave the range of floats"),
    ({"damping": 1e12}, "would take 4.97 . 10¹³ steps of 2.01 . 10⁻¹³ s"),
])  # fmt: skip
@pytest.mark.parametrize("compiled", [True, False])
def test_what_makes_no_sense_is_refused(change, said, compiled):
    case = cases_of(SYSTEMS["toy"], ExactContact(), angles=(0.4,), duration=10.0, tolerance=1e-10,
                    bounds=(0.0, 0.0))  # fmt: skip
    for name, value in change.items():
        case["balls"][name][0, 0] = value
    with pytest.raises(ll.InputError, match=said):
        prepared_runs(case, choose_stepper(SYSTEMS["toy"]), compiled=compiled)


def test_the_ledgers_allowance_is_that_of_a_run():
    run = np.zeros(1, dtype=empty_beginning().run.dtype)
    state = run["state"].view(np.recarray)[0]
    for energy, loss, tolerance in ((2.0, 0.1, 1e-6), (1e-3, 50.0, 1e-14), (0.0, 0.0, 1e-3)):
        state.largest_energy, state.impact_loss = energy, loss
        found = kernel_of(ALLOWED_ERROR).call(run.ctypes.data, tolerance)
        assert found == pytest.approx(allowed_error(state, tolerance), rel=1e-15)
