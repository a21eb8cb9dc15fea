"""Points of a plan as arrays, and points that make no sense."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.numerics.integrate import choose_step, prepared_runs
from latolato.numerics.prepare import cases_of
from latolato.numerics.records import AT_REST, CONVERGED, EVENT_LIMIT, INVALID, segment_records
from latolato.observables import PoincareSection
from latolato.simulation.run import simulate
from latolato.simulation.start import between_walls, checked_start, walls_of
from latolato.sweeps.plan import make_plan
from latolato.sweeps.points import (
    Previous,
    _follows_tension,
    _law_at,
    arguments_of,
    columns_of,
    is_smooth,
    make_batch,
    stepper_of,
)
from latolato.sweeps.statuses import codes_of

PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
MATHIEU = ll.Mathieu(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.9, damping=0.02)
DRIVE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.0, drive_phase=0.3)
# Plain Python: nothing is compiled for a handful of short runs.
SHORT = {"duration": 1.0, "observables": ["largest_angle", "mean_energy"], "executor": "reference"}

PLANS = {
    "pendulum and ratios": (
        PENDULUM,
        DRIVE,
        {
            "axes": {
                "length": [0.3, 1.0, 1.7],
                "frequency_ratio": [0.0, 1.9, 2.1],
                "amplitude_ratio": [0.0, 0.1],
            },
            "initial_angle": 0.3,
            "transient_periods": 1.5,
        },
    ),
    "pendulum and lift": (
        PENDULUM,
        DRIVE,
        {
            "axes": {
                "gravity": [1.6, 9.8],
                "drive_acceleration_ratio": [0.0, 0.7, 1.3],
                "drive_frequency": [3.0, 11.0],
            },
            "initial_angle": 0.3,
            "initial_angular_velocity": -21.0,
        },
    ),
    "pendulum with every drag": (
        ll.Pendulum(length=1.0, mass=0.8, quadratic_damping=0.02),
        DRIVE,
        {
            "axes": {
                "damping": [0.0, 0.3, 90.0],
                "coulomb_damping": [0.0, 0.2],
                "mass": [0.1, 2.0],
            },
            "initial_angle": -1.3,
            "observables": ["compression_fraction"],
        },
    ),
    "pivot at rest": (
        PENDULUM,
        None,
        {
            "axes": {"initial_angle": [-4.0, 0.2], "initial_angular_velocity": [-9.0, 0.0, 0.4]},
            "transient": 0.25,
            "transient_periods": 1.0,
            "duration": 9.0,
        },
    ),
    "linear": (
        MATHIEU,
        DRIVE,
        {
            "axes": {"length": [0.4, 0.9], "drive_phase": [-1.0, 0.0, 9.0]},
            "initial_angle": 0.1,
            "observables": ["compression_fraction"],
        },
    ),
    "toy and offsets": (
        TOY,
        DRIVE,
        {
            "axes": {
                "radius": [0.0, 0.03, 0.2, 0.9],
                "initial_offset": [0.0, 0.5],
                "restitution": [0.0, 0.5, 1.0],
            },
            "rest_speed": 1e-5,
        },
    ),
    "toy on its walls": (
        TOY,
        None,
        {
            "axes": {
                "initial_angle": [math.asin(0.1), math.asin(0.1) + 5e-13, math.pi - math.asin(0.1)]
            }
        },
    ),
    "toy and marks": (
        TOY,
        DRIVE,
        {
            "axes": {"case": {"drive_frequency": [4.0, 6.0, 7.0], "length": [1.0, 0.8, 0.7]}},
            "initial_angle": 0.6,
            "observables": [PoincareSection(periods=5), "compression_fraction"],
            "transient": 1.0,
            "duration": 5.0,
        },
    ),
    "toy that passes through itself": (
        TOY,
        DRIVE,
        {"axes": {"initial_offset": [0.0, 4.0]}, "contact": None},
    ),
    "clamped toy": (
        TOY,
        DRIVE,
        {"axes": {"drive_amplitude": [0.0, 0.2]}, "initial_offset": 0.1, "contact": "clamp"},
    ),
    "pair": (
        ll.BallPair(
            right=ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.02),
            left=ll.Ball(length=0.95, mass=0.5, radius=0.1, quadratic_damping=0.1),
            restitution=0.8,
        ),
        DRIVE,
        {
            "axes": {
                "left_length": [0.7, 0.9, 1.0, 1.3],
                "right_radius": [0.02, 0.1, 0.4],
                "initial_angle_left": [-0.8, 0.75],
            },
            "initial_angle": (0.8, -0.8),
            "initial_angular_velocity": (0.3, -0.1),
        },
    ),
    "crank": (
        TOY,
        ll.CrankSlider(drive_amplitude=0.05, drive_frequency=6.0, connecting_rod_length=0.2),
        {
            "axes": {"drive_amplitude": [0.01, 0.1, 0.2], "drive_frequency": [3.0, 7.0]},
            "initial_offset": 0.2,
        },
    ),
    "chirp of a pendulum": (
        PENDULUM,
        ll.Chirp(
            drive_amplitude=0.05, drive_frequency=6.0, drive_frequency_final=9.0, sweep_time=2.0
        ),
        {"axes": {"sweep_time": [0.5, 3.0], "length": [0.5, 1.0]}, "initial_angle": 0.3},
    ),
    "steps that are blows": (
        PENDULUM,
        ll.FrequencySchedule(
            drive_amplitude=0.05, times=[0.0, 1.0], drive_frequencies=[6.0, 9.0], step_impulse=True
        ),
        {"axes": {"drive_amplitude": [0.0, 0.05]}, "initial_angle": 0.3},
    ),
    "toy, some of it impossible": (
        TOY,
        DRIVE,
        {
            "axes": {"radius": [0.05, 0.8, 1.0, 1.3], "length": [0.9, 1.1]},
            "initial_angle": 0.6,
        },
    ),
}


def plan_of(name):
    system, drive, settings = PLANS[name]
    return make_plan(
        system, drive, **({"duration": 4.0, "observables": ["largest_angle"]} | settings)
    )


def previous_of(plan, count, phase):
    """Ends of earlier points, some of them beyond walls."""
    spread = np.linspace(0.0, 3.1, count)
    velocities = np.linspace(-14.0, 14.0, count)
    angles = np.array([spread, -0.3 * spread])[: plan.system.angles]
    both = np.array([velocities, velocities[::-1]])[: plan.system.angles]
    return Previous(angles, both, spread if phase else None)


def alone(plan, columns, k, previous):
    """The system, the drive and the start of a point, made like those of a single run."""
    system, drive = (_law_at(plan, columns, k, owner) for owner in ("system", "drive"))
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    offset = float(columns["initial_offset"][k]) if "initial_offset" in columns else None
    if previous is not None:
        given = [float(angle[k]) for angle in previous.angles]
        angles = between_walls(given, walls_of(system, plan.contact)).tolist()
        velocities, offset = [float(velocity[k]) for velocity in previous.velocities], None
    else:
        angles = [float(columns["initial_angle" + s][k]) for s in sides if offset is None]
        velocities = [float(columns["initial_angular_velocity" + s][k]) for s in sides]
    if system.angles == 1:
        (velocities,), (angles,) = velocities, angles or [None]
    start = checked_start(system, plan.contact, angles, velocities, offset)
    choose_step(system, drive, start, plan.tolerance, duration=plan.duration)
    return system, drive, start


@pytest.mark.parametrize("follows", [False, True], ids=["start", "continuation"])
@pytest.mark.parametrize("name", PLANS)
def test_points_begin_as_single_runs_do(name, follows):
    """What columns become is what a system, a drive and a start of the same numbers become."""
    plan = plan_of(name)
    stepper, index = stepper_of(plan), np.arange(plan.size)
    previous = previous_of(plan, plan.size, hasattr(plan.drive, "drive_phase")) if follows else None
    batch = make_batch(plan, index, previous)
    assert batch.valid.any()
    for k in index:
        if not batch.valid[k]:
            with pytest.raises(InputError) as refused:
                alone(plan, batch.columns, k, previous)
            assert k != np.argmin(batch.valid) or str(refused.value) == batch.reason
            continue
        system, drive, start = alone(plan, batch.columns, k, previous)
        case = cases_of(
            system, plan.contact, angles=start.angles, velocities=start.velocities,
            bounds=(drive.largest_acceleration, drive.fastest_frequency), is_exact=1,
            tolerance=plan.tolerance, rest_speed=plan.rest_speed, is_nonsmooth=not is_smooth(plan),
            follows_tension=_follows_tension(plan),
        )  # fmt: skip
        run = prepared_runs(case, stepper)
        assert batch.points.settings[k].tobytes() == run["settings"].tobytes()
        bodies = batch.points.bodies[k]
        assert bodies.tobytes() == run["bodies"][0, : len(bodies)].tobytes()
        assert batch.states[k].tobytes() == run["state"].tobytes()
        first, last = batch.points.firsts[k : k + 2]
        own = segment_records(drive, plan.duration)
        np.testing.assert_array_equal(batch.points.segments[first:last], own)


def test_points_step_like_single_runs():
    plan = plan_of("pendulum and ratios")
    batch = make_batch(plan, np.arange(plan.size))
    columns = batch.columns
    for k in range(plan.size):
        drive = ll.Harmonic(
            drive_amplitude=columns["drive_amplitude"][k],
            drive_frequency=columns["drive_frequency"][k],
        )
        system = ll.Pendulum(length=columns["length"][k], mass=0.8, damping=0.05)
        start = checked_start(system, plan.contact, 0.3, 0.0, None)
        step = choose_step(system, drive, start, plan.tolerance)
        assert batch.points.settings["step"][k] == step


def test_ratios_are_those_of_each_point():
    plan = plan_of("pendulum and ratios")
    columns = columns_of(plan, np.arange(plan.size))
    length = np.repeat([0.3, 1.0, 1.7], 6)
    ratio = np.tile(np.repeat([0.0, 1.9, 2.1], 2), 3)
    # rounding of one square root and one product
    np.testing.assert_allclose(
        columns["drive_frequency"], ratio * np.sqrt(9.8 / length), rtol=1e-15
    )
    np.testing.assert_allclose(
        columns["drive_amplitude"], np.tile([0.0, 0.1], 9) * length, rtol=1e-15
    )
    lifted = columns_of(plan_of("pendulum and lift"), np.arange(12))
    lift = lifted["drive_amplitude"] * lifted["drive_frequency"] ** 2 / lifted["gravity"]
    np.testing.assert_allclose(lift, np.tile(np.repeat([0.0, 0.7, 1.3], 2), 2), rtol=1e-14)


class TestPointsThatMakeNoSense:
    def swept(self, system, drive, reason, **settings):
        """A sweep that must warn, with this reason."""
        with pytest.warns(RuntimeWarning, match=reason) as caught:
            result = ll.sweep(system, drive, **(SHORT | settings))
        assert len(caught) == 1
        return result

    def assert_as_without(self, result, name, values, system, drive, **settings):
        """The points at these values are what a sweep of them only gives."""
        good = ll.sweep(system, drive, **(SHORT | settings | {"axes": {name: values}}))
        for variable in good.data_vars:
            np.testing.assert_array_equal(result[variable].sel({name: values}), good[variable])

    def test_a_radius_beyond_the_length_is_invalid_there_only(self):
        settings = {"axes": {"radius": [0.05, 1.0, 0.1, 1.5]}, "initial_offset": 0.4}
        reason = (
            r"2 of 4 points have no answer: 2 invalid \(radius must lie in \[0, length\), got 1"
        )
        result = self.swept(TOY, DRIVE, reason, **settings)
        assert codes_of(result.status).tolist() == [CONVERGED, INVALID, CONVERGED, INVALID]
        for name in ("largest_angle", "mean_energy"):
            np.testing.assert_array_equal(np.isnan(result[name]), [False, True, False, True])
        self.assert_as_without(result, "radius", [0.05, 0.1], TOY, DRIVE, **settings)
        assert result.attrs["first_invalid"].startswith("radius must lie in [0, length), got 1;")

    def test_a_start_inside_a_wall_is_invalid_there_only(self):
        settings = {"axes": {"radius": [0.1, 0.5, 0.7]}, "initial_angle": 0.6}
        result = self.swept(TOY, DRIVE, "1 invalid .initial_angle must lie between", **settings)
        assert codes_of(result.status).tolist() == [CONVERGED, CONVERGED, INVALID]
        self.assert_as_without(result, "radius", [0.1, 0.5], TOY, DRIVE, **settings)

    def test_balls_that_never_meet_are_invalid_there_only(self):
        pair = ll.BallPair(
            right=ll.Ball(length=1.0, mass=0.8, radius=0.1),
            left=ll.Ball(length=0.9, mass=0.8, radius=0.1),
        )
        settings = {"axes": {"left_length": [0.9, 0.2, 0.95]}, "initial_angle": (0.8, -0.8)}
        result = self.swept(pair, DRIVE, "the balls never meet", **settings)
        assert codes_of(result.status).tolist() == [CONVERGED, INVALID, CONVERGED]
        assert np.isnan(result.largest_angle.values[1]).all()
        self.assert_as_without(result, "left_length", [0.9, 0.95], pair, DRIVE, **settings)

    def test_a_transient_of_periods_beyond_the_end_is_invalid_there_only(self):
        settings = {
            "axes": {"drive_frequency": [6.0, 1.0]},
            "initial_angle": 0.4,
            "transient_periods": 0.5,
        }
        result = self.swept(PENDULUM, DRIVE, "transient must be shorter", **settings)
        assert codes_of(result.status).tolist() == [CONVERGED, INVALID]

    @pytest.mark.parametrize("executor", ["reference", "threads"])
    @pytest.mark.parametrize(
        "name, value",
        [
            ("length", 1e-29),
            ("length", 1e29),
            ("gravity", 1e29),
            ("mass", 1e-29),
            ("mass", 1e29),
            ("damping", 1e29),
            ("drive_frequency", 1e29),
            ("drive_amplitude", 1e29),
            ("initial_angular_velocity", 1e29),
            ("initial_angular_velocity", -1e29),
        ],
    )
    def test_numbers_beyond_reason_end_without_an_answer(self, name, value, executor):
        usual = {"length": 1.0, "gravity": 9.8, "mass": 0.8, "damping": 0.05}
        usual |= {"drive_frequency": 6.0, "drive_amplitude": 0.05, "initial_angular_velocity": 0.0}
        axes = {name: [usual[name], value]}
        settings = {"axes": axes, "initial_angle": 0.4, "executor": executor}
        if name in ("mass", "length") and value > 1.0:  # such a pendulum hardly moves
            result = ll.sweep(PENDULUM, DRIVE, **(SHORT | settings))
            assert codes_of(result.status).tolist() == [CONVERGED, CONVERGED]
            return
        result = self.swept(PENDULUM, DRIVE, "1 of 2 points have no answer: 1 invalid", **settings)
        assert codes_of(result.status).tolist() == [CONVERGED, INVALID]
        np.testing.assert_array_equal(np.isnan(result.largest_angle), [False, True])
        self.assert_as_without(result, name, [usual[name]], PENDULUM, DRIVE, **settings)

    @pytest.mark.parametrize("name, value", [("length", 1e-31), ("damping", 1e31)])
    def test_an_axis_of_numbers_that_cannot_be_computed_with_is_refused(self, name, value):
        with pytest.raises(InputError, match=rf"{name}.*check its order of magnitude"):
            ll.sweep(PENDULUM, DRIVE, **SHORT, axes={name: [1.0, value]}, initial_angle=0.4)

    def test_a_ratio_may_lead_beyond_what_can_be_computed_with(self):
        settings = {"axes": {"amplitude_ratio": [0.1, 1e20]}, "initial_angle": 0.4}
        long = ll.Pendulum(length=1e20, mass=0.8)
        result = self.swept(long, DRIVE, r"drive_amplitude must lie in \[0, 1e\+30\]", **settings)
        assert codes_of(result.status).tolist() == [CONVERGED, INVALID]

    def test_motion_beyond_all_numbers_has_failed(self):
        # in resonance the linear motion grows by exp(0.75 t): it leaves the numbers in 950 s
        settings = {
            "axes": {"drive_amplitude": [0.0, 0.5]},
            "initial_angle": 0.1,
            "duration": 1000.0,
            "tolerance": 1e-3,
        }
        drive = ll.Harmonic(drive_amplitude=0.3, drive_frequency=6.26)
        result = self.swept(ll.Mathieu(length=1.0, mass=0.8), drive, "1 failed", **settings)
        assert codes_of(result.status).tolist() == [CONVERGED, INVALID - 1]
        np.testing.assert_array_equal(np.isnan(result.largest_angle), [False, True])

    def test_too_many_contacts_end_without_an_answer(self):
        toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.9)
        settings = {
            "axes": {
                "initial_offset": [0.0, 0.01, 1.5]
            },  # rests, bounces low and often, high and rarely
            "contact_limit": 3,
            "duration": 1.6,
            "initial_angular_velocity": 0.0,
        }
        result = self.swept(toy, None, "1 of 3 points have no answer: 1 event_limit", **settings)
        assert codes_of(result.status).tolist() == [AT_REST, EVENT_LIMIT, CONVERGED]
        np.testing.assert_array_equal(np.isnan(result.largest_angle), [False, True, False])

    def test_zero_over_zero_is_invalid(self):
        # no acceleration at frequency zero: the amplitude is not determined
        settings = {
            "axes": {"drive_acceleration_ratio": [0.0, 0.5], "drive_frequency": [0.0, 6.0]},
            "initial_angle": 0.4,
        }
        result = self.swept(PENDULUM, DRIVE, "2 of 4 points have no answer: 2 invalid", **settings)
        np.testing.assert_array_equal(
            codes_of(result.status), [[INVALID, CONVERGED], [INVALID, CONVERGED]]
        )


@pytest.mark.parametrize("name", PLANS)
def test_the_arguments_of_a_point_simulate_that_point(name):
    plan = plan_of(name)
    _, _, settings = PLANS[name]
    number = plan.size // 2
    try:
        result = arguments_of(plan, number)
    except ValueError:
        assert not make_batch(plan, np.array([number])).valid[0]
        return
    expected = make_batch(plan, np.array([number])).states[0]
    run = simulate(**result | {"duration": 1e-3})
    angle = np.atleast_2d(run["angle"].values)[:, 0]
    assert angle[0] == expected["angle"][0]
    assert result["duration"] == settings.get("duration", 4.0)
    place = dict(zip(plan.dims, np.unravel_index(number, plan.shape), strict=True))
    for axis in plan.axes:
        for parameter, values in zip(axis.parameters, axis.values, strict=True):
            for law in (result["system"], result["drive"]):
                if hasattr(law, parameter) and parameter != "natural_frequency":
                    assert getattr(law, parameter) == values[place[axis.name]], parameter


def test_a_point_that_goes_on_from_another_cannot_run_alone():
    plan = make_plan(
        TOY,
        DRIVE,
        axes={"drive_frequency": [5.0, 6.0]},
        initial_offset=0.2,
        duration=4.0,
        continuation="drive_frequency",
    )
    with pytest.raises(ValueError, match="cannot run alone"):
        arguments_of(plan, 1)


def test_a_point_with_too_many_steps_is_named_whatever_its_drag():
    fast = 0.85e10 * 5.0 * 1e-6 ** (1.0 / 6.0) / 5.0  # too fast for the step of drag alone
    axes = {"quadratic_damping": [0.0, 1e-12], "drive_frequency": [fast]}
    settings = {"duration": 5.0, "initial_angle": 1.0, "observables": ["largest_angle"]}
    drive = ll.Harmonic(drive_amplitude=0.0, drive_frequency=1.0)
    plan = make_plan(PENDULUM, drive, axes=axes, tolerance=1e-6, **settings)
    batch = make_batch(plan, np.arange(2))
    assert not batch.valid.any()
    assert batch.reason.endswith(
        "the limit is 10¹⁰; shorten it, loosen tolerance (with contact 'clamp': enlarge "
        "clamp_step), or choose less damping, a slower start or a slower drive"
    )
