"""The kernels: plain Python equals compiled code, and cutting the work changes no bit."""

import itertools

import numpy as np
import pytest

import latolato as ll
from latolato.numerics import integrate as module
from latolato.numerics.integrate import Start, choose_step, integrate

DRIVE = ll.Harmonic(drive_amplitude=0.25, drive_frequency=7.5, drive_phase=0.4)


def start_of(system):
    return Start((0.8, -0.5), (0.3, -0.2)) if system.angles == 2 else Start((0.8,), (0.3,))


def run(system, drive=DRIVE, end=4.0, times=None, *, start=None, **options):
    times = np.linspace(0.0, end, 41) if times is None else times
    return integrate(
        system, drive, start or start_of(system), times, end, step=0.02,
        rest_speed=1e-6, **options,
    )  # fmt: skip


def assert_close(a, b):
    # A kernel that goes on computes the force afresh, where fused multiply-adds may round in
    # another way; some dozen impacts amplify that by less than a thousand.
    for name in ("samples", "contact_times", "contact_values"):
        np.testing.assert_allclose(
            getattr(a, name), getattr(b, name), rtol=0, atol=1e-11, err_msg=name
        )
    for name in set(a.state.dtype.names) - {"t_base", "steps", "total_steps", "held_until"}:
        np.testing.assert_allclose(a.state[name], b.state[name], rtol=0, atol=1e-11, err_msg=name)
    np.testing.assert_array_equal(a.contact_kinds, b.contact_kinds)


def test_plain_python_equals_compiled(laws):
    # The same scalar source; fused multiply-adds may differ in the last digits, which contacts
    # amplify a little, and strings up to 1e-13 s: their tensions pass slowly through zero.
    system, drive, _ = laws
    times = np.linspace(0.0, 2.0, 21)
    fast = run(system, drive, 2.0, times)
    plain = run(system, drive, 2.0, times, compiled=False)
    np.testing.assert_array_equal(plain.contact_kinds, fast.contact_kinds)
    np.testing.assert_allclose(plain.contact_times, fast.contact_times, rtol=0, atol=1e-12)
    np.testing.assert_allclose(plain.samples, fast.samples, rtol=0, atol=1e-11)


def test_roundings_do_not_choose_the_steps(laws):
    # Else results would differ between machines by the errors of the steps, here up to 1e-9.
    system, drive, _ = laws
    start, counts = start_of(system), set()
    for ulps in (-3, -1, 0, 2, 4):
        angles = tuple(angle * (1.0 + ulps * 2.0**-52) for angle in start.angles)
        begun = Start(angles, start.velocities)
        counts.add(int(run(system, drive, 2.0, start=begun).state["total_steps"]))
    assert len(counts) == 1


SYSTEMS = {
    "smooth": ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1, restitution=0.8),
    "rough": ll.LatoLato(
        length=1.0, mass=0.8, coulomb_damping=0.15, quadratic_damping=0.05, radius=0.1,
        restitution=0.6,
    ),
    "plastic": ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.0),
    "pair": ll.BallPair(
        right=ll.Ball(length=0.9, mass=0.5, radius=0.09, damping=0.01),
        left=ll.Ball(length=0.85, mass=0.3, radius=0.09, coulomb_damping=0.02),
        restitution=0.7,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("most_steps", [1, 2, 7, 100])
def test_resuming_in_small_chunks_changes_roundings_only(name, most_steps, monkeypatch):
    # The pair whirls later on and multiplies a rounding by a million within seconds.
    end = 5.0 if name == "pair" else 12.0
    whole = run(SYSTEMS[name], end=end)
    assert len(whole.contact_times) > (2 if name == "pair" else 5)
    monkeypatch.setattr(module, "STEPS_PER_CALL", most_steps)
    assert_close(whole, run(SYSTEMS[name], end=end))


@pytest.mark.parametrize("name", SYSTEMS)
def test_dense_samples_do_not_change_the_motion(name):
    few = run(SYSTEMS[name], end=12.0, times=np.array([12.0]))
    many = run(SYSTEMS[name], end=12.0, times=np.linspace(0.0, 12.0, 20_001))
    np.testing.assert_array_equal(few.contact_times, many.contact_times)
    for name in few.state.dtype.names:
        if name != "sample":  # how many were written
            np.testing.assert_array_equal(few.state[name], many.state[name])
    np.testing.assert_array_equal(few.samples[:, -1], many.samples[:, -1])


@pytest.mark.parametrize("name", ["smooth", "rough", "plastic"])
def test_sample_at_a_contact_is_the_state_after_it(name):
    system = SYSTEMS[name]
    first = run(system, end=12.0)
    at = np.unique(first.contact_times)
    again = run(system, end=12.0, times=at)
    last = np.searchsorted(first.contact_times, at, side="right") - 1
    np.testing.assert_array_equal(again.samples[1], first.contact_values[1][last])
    assert set(again.samples[0]) <= {system.contact_angle_low, system.contact_angle_high}


def test_dense_output_is_as_good_as_the_steps():
    # A sample inside a step is a shorter step from its beginning, not an interpolation.
    system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    times = np.linspace(0.0, 5.0, 997)
    rough = integrate(system, DRIVE, Start((0.8,), (0.0,)), times, 5.0, step=0.03)
    fine = integrate(system, DRIVE, Start((0.8,), (0.0,)), times, 5.0, step=0.003)
    error = np.abs(rough.samples[0] - fine.samples[0])
    on_step = np.abs(times / 0.03 - np.round(times / 0.03)) < 0.05
    assert error[~on_step].max() <= 1.5 * error[on_step].max() + 1e-13


def test_steps_end_where_a_drive_is_not_smooth():
    # A step over a stage's start would lose the order: compare with a run stopped there.
    drive = ll.FrequencySchedule(
        drive_amplitude=0.2, times=[0.0, 1.2345], drive_frequencies=[9.0, 4.0]
    )
    system = ll.Pendulum(length=1.0, mass=0.8)
    times = np.array([1.2345, 3.0])
    rough, fine = (
        integrate(system, drive, Start((0.8,), (0.0,)), times, 3.0, step=step)
        for step in (0.03, 0.003)
    )
    np.testing.assert_allclose(rough.samples[:2], fine.samples[:2], rtol=0, atol=1e-8)


class TestStrongDrag:
    """The step follows the rate of the drag once that is faster than the motion."""

    @pytest.mark.parametrize("tolerance", [1e-2, 1e-6, 1e-10])
    @pytest.mark.parametrize("speed", [0.0, 20.0])
    @pytest.mark.parametrize(
        "drag",
        [("damping", 50.0), ("damping", 500.0), ("damping", 1e4), ("quadratic_damping", 1e3)],
    )
    def test_creeping_motion_keeps_its_tolerance_at_the_first_try(self, drag, speed, tolerance):
        system = ll.Pendulum(length=1.0, mass=1.0, **dict([drag]))
        drive = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
        run, fine = (
            ll.simulate(
                system, drive, initial_angle=1.0, initial_angular_velocity=speed,
                times=np.linspace(0.0, 5.0, 101), tolerance=aim,
            )
            for aim in (tolerance, 1e-3 * tolerance)
        )  # fmt: skip
        assert run.attrs["status"] == "complete"
        assert run.attrs["step_halvings"] == 0
        assert run.attrs["energy_residual"] <= 5.0 * tolerance * float(run.total_energy.max())
        # Rounding of 1e6 steps beside the tolerance.
        assert float(abs(run.angle - fine.angle).max()) <= tolerance + 1e-11

    @pytest.mark.parametrize("executor", ["threads", "reference"])
    def test_a_turn_is_found_that_a_step_leaves_so_far_behind_that_there_is_no_number(
        self, executor
    ):
        # Friction stops the ball in 3 ms; against its sign quadratic drag would speed it up.
        light = ll.Pendulum(length=1.0, mass=0.01, quadratic_damping=1.0, coulomb_damping=20.0)
        result = ll.sweep(
            light, axes={"initial_angular_velocity": [5.0, -5.0]}, initial_angle=1.0, duration=0.5,
            tolerance=1e-3, observables=["final_angle"], executor=executor,
        )  # fmt: skip
        fine = ll.simulate(
            light, initial_angle=1.0, initial_angular_velocity=5.0, duration=0.5, tolerance=1e-10
        )
        assert result.final_angle[0] == pytest.approx(float(fine.angle[-1]), abs=1e-3)
        assert result.final_angle[1] < 1.0

    def test_weak_drag_changes_no_step(self):
        start = Start((1.0,), (0.0,))
        free = ll.Pendulum(length=1.0, mass=1.0, quadratic_damping=1e-12)
        for drag in (0.1, 1.0, free.natural_frequency):
            for drags in ({"damping": drag}, {"quadratic_damping": 0.8 * drag}):
                rough = {"quadratic_damping": 1e-12} | drags
                system = ll.Pendulum(length=1.0, mass=1.0, **rough)
                for drive in (ll.Harmonic(drive_amplitude=0.1, drive_frequency=2.0), DRIVE):
                    steps = (choose_step(s, drive, start, 1e-10) for s in (free, system))
                    assert next(steps) == next(steps)

    def test_more_steps_than_hours_allow_are_refused(self):
        system = ll.Pendulum(length=1.0, mass=1.0, damping=1e12)
        with pytest.raises(ValueError, match=r"steps of .* limit is 10¹⁰"):
            ll.simulate(system, initial_angle=1.0, duration=10.0)


def test_elapsed_time_is_not_a_sum_of_rounded_steps():
    system = ll.Pendulum(length=1.0, mass=0.8)
    result = integrate(system, DRIVE, Start((0.1,), (0.0,)), np.array([3000.0]), 3000.0, step=0.1)
    assert result.reached == 3000.0
    assert result.state.total_steps == 30_000


@pytest.mark.parametrize("compiled", [False, True])
def test_a_run_stops_within_a_hop_too_small_to_be_seen(compiled):
    """The last hops of a cascade are taken whole, but never beyond the end of a run."""
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.5)
    start = Start((toy.contact_angle_low + 0.2,), (0.0,))

    def until(end):
        return integrate(
            toy, ll.FixedPivot(), start, np.array([0.0, end]), end, step=0.02,
            rest_speed=0.0, compiled=compiled,
        )  # fmt: skip

    times = until(2.0).contact_times
    hops = [(a, b) for a, b in itertools.pairwise(times) if 1e-9 < b - a < 1e-6]
    assert len(hops) > 3
    for a, b in hops:
        middle = 0.5 * (a + b)
        state = until(middle).state
        assert state.t_base + state.steps * 0.02 == middle
