"""Derivatives with respect to parameters beside differences of runs and beside closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.simulation.run import record

# Weights of the central difference of eighth order, at 1 to 4 widths.
_WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
TIMES = np.linspace(0.0, 6.0, 13)
ENOUGH = 1e-7

HARMONIC = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0, drive_phase=0.3)
STRONG = ll.Harmonic(drive_amplitude=0.5, drive_frequency=6.0)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.05, restitution=0.9)
PAIR = ll.BallPair(
    right=ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.05),
    left=ll.Ball(length=0.95, mass=0.5, radius=0.08, damping=0.02),
    restitution=0.9,
)
ON_STRINGS = replace(PAIR, restitution=0.8, suspension="string", string_restitution=0.2)
ONE, TWO = {"initial_angle": 0.8}, {"initial_angle": (0.8, -0.5)}


def varied(system, drive, start, name, value):
    """Return laws and start with another value of one parameter."""
    side, _, field = name.partition("_")
    start = dict(start)
    if name in start:
        start[name] = value
    elif side in ("right", "left"):
        system = replace(system, **{side: replace(getattr(system, side), **{field: value})})
    elif name.endswith(("_right", "_left")):
        stem, _, side = name.rpartition("_")
        numbers = list(start[stem])
        numbers[0 if side == "right" else 1] = value
        start[stem] = tuple(numbers)
    elif hasattr(system, name):
        system = replace(system, **{name: value})
    else:
        drive = replace(drive, **{name: value})
    return system, drive, start


def value_of(system, drive, start, name):
    """Return the value of a parameter."""
    side, _, field = name.partition("_")
    if name in start:
        return start[name]
    if side in ("right", "left"):
        return getattr(getattr(system, side), field)
    if name.endswith(("_right", "_left")):
        stem, _, side = name.rpartition("_")
        return start[stem][0 if side == "right" else 1]
    return getattr(system if hasattr(system, name) else drive, name)


def differences(system, drive, start, name, width, times):
    """Return the derivatives of angles, angular velocities and contact times, by runs."""
    value = value_of(system, drive, start, name)
    width *= abs(value) or 1.0
    total = {}
    for k, weight in enumerate(_WEIGHTS, 1):
        for sign in (1.0, -1.0):
            laws = varied(system, drive, start, name, value + sign * k * width)
            run = record(laws[0], laws[1], times=times, tolerance=1e-13, **laws[2])
            for key in ("angle", "angular_velocity", "contact_time"):
                total[key] = total.get(key, 0.0) + sign * weight * np.asarray(run[key]) / width
    return total


def worst(system, drive, start, names, width=2e-5, times=TIMES):
    """Return the largest error of any derivative, per largest derivative of its kind."""
    run = record(system, drive, times=times, tolerance=1e-13, sensitivity_to=names, **start)
    assert run.attrs["sensitivity_status"] == "known"
    result = 0.0
    for p, name in enumerate(names):
        expected = differences(system, drive, start, name, width, times)
        for key, wanted in expected.items():
            found = np.asarray(run[f"{key}_sensitivity"])[p]
            largest = np.max(abs(wanted), initial=0.0)
            if largest == 0.0:  # before the first impact nothing depends on the restitution
                assert not np.any(found)
            else:
                result = max(result, np.max(abs(found - wanted)) / largest)
    return result


@pytest.mark.parametrize(
    "system, drive, names",
    [
        (PENDULUM, None, ("length", "mass", "damping", "gravity", "initial_angle")),
        (PENDULUM, HARMONIC, ("drive_amplitude", "drive_frequency", "drive_phase")),
        (
            replace(PENDULUM, quadratic_damping=0.1, coulomb_damping=0.03),
            HARMONIC,
            ("length", "damping", "quadratic_damping", "coulomb_damping"),
        ),
        (ll.Mathieu(length=1.0, mass=0.8, damping=0.05), HARMONIC, ("length", "damping")),
        (replace(PENDULUM, damping=0.3, drag_frame="lab"), HARMONIC, ("length", "mass", "damping")),
    ],
)
def test_flights_without_walls(system, drive, names):
    assert worst(system, drive, ONE, names, 2e-4) < ENOUGH


@pytest.mark.parametrize(
    "drive, names",
    [
        (
            ll.Chirp(
                drive_amplitude=0.1, drive_frequency=4.0, drive_frequency_final=7.0, sweep_time=2.3
            ),
            ("drive_amplitude", "drive_frequency", "drive_frequency_final", "sweep_time"),
        ),
        (
            ll.Chirp(
                drive_amplitude=0.1, drive_frequency=6.0, drive_frequency_final=6.0, sweep_time=2.3
            ),
            ("drive_frequency", "drive_frequency_final"),
        ),
        (
            ll.CrankSlider(drive_amplitude=0.1, drive_frequency=6.0, connecting_rod_length=0.25),
            ("drive_amplitude", "connecting_rod_length", "drive_frequency"),
        ),
        (
            ll.PlanarHarmonic(
                vertical_amplitude=0.1, horizontal_amplitude=0.05, drive_frequency=6.0,
                vertical_phase=0.2, horizontal_phase=1.0,
            ),
            ("vertical_amplitude", "horizontal_amplitude", "horizontal_phase", "drive_frequency"),
        ),
        (
            ll.FrequencySchedule(
                drive_amplitude=0.1, times=[0, 1.7, 3.3], drive_frequencies=[5.0, 7.0, 4.0],
                drive_phase=0.2, step_impulse=True,
            ),
            ("drive_amplitude", "drive_phase"),
        ),
        (
            ll.FrequencySchedule(
                drive_amplitude=0.1, times=[0, 1.7, 3.3], drive_frequencies=[5.0, 7.0, 4.0],
                ramp=0.4,
            ),
            ("drive_amplitude", "ramp"),
        ),
        (
            ll.StagedHarmonic(
                times=[0, 1.7], drive_amplitudes=[0.1, 0.2], drive_frequencies=[5.0, 7.0],
                ramps=[0.1, 0.3], drive_phase=0.4,
            ),
            ("drive_phase",),
        ),
    ],
)  # fmt: skip
def test_every_drive(drive, names):
    system = PENDULUM if drive.moves_across else TOY
    assert worst(system, drive, ONE, (*names, "length"), 5e-5) < 3 * ENOUGH


@pytest.mark.parametrize("duration", [1.3, 6.0, 18.0])
def test_after_one_six_and_many_impacts(duration):
    times = np.linspace(0.0, duration, 14)
    names = ("length", "radius", "restitution", "damping", "drive_frequency", "initial_angle")
    width = 2e-5 if duration < 10.0 else 1e-7
    assert worst(TOY, HARMONIC, ONE, names, width, times) < (ENOUGH if duration < 10.0 else 1e-5)


def test_a_start_at_an_offset_moves_with_the_wall():
    start = {"initial_offset": 0.7}
    assert worst(TOY, HARMONIC, start, ("radius", "length", "initial_offset")) < ENOUGH


@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_rest_and_lift_off(restitution):
    system = replace(TOY, restitution=restitution)
    run = record(system, STRONG, times=TIMES, **ONE)
    if restitution == 0.0:
        assert list(run["contact_kind"][:3]) == ["bottom", "rest", "release"]
    assert worst(system, STRONG, ONE, ("length", "radius", "drive_amplitude")) < ENOUGH


@pytest.mark.parametrize("name", ["damping", "quadratic_damping", "coulomb_damping"])
@pytest.mark.parametrize("system", [PENDULUM, TOY])
def test_a_drag_that_is_not_there(system, name):
    """The drag would have the sign of the velocity, so turns count although nothing happens."""
    system, width, times = replace(system, damping=0.0), 1e-4, TIMES[:7]
    run = record(system, HARMONIC, times=times, tolerance=1e-13, sensitivity_to=name, **ONE)
    # A drag is not negative: the forward difference of sixth order.
    expected = np.zeros(len(times))
    for k, weight in enumerate((-49 / 20, 6, -15 / 2, 20 / 3, -15 / 4, 6 / 5, -1 / 6)):
        law = replace(system, **{name: k * width})
        other = record(law, HARMONIC, times=times, tolerance=1e-13, **ONE)
        expected += weight * np.asarray(other["angle"]) / width
    assert run.attrs["sensitivity_status"] == "known"
    # Differences at zero resolve less than those about a value.
    off = abs(np.asarray(run["angle_sensitivity"])[0] - expected)
    assert np.max(off) < 1e-6 * np.max(abs(expected))


def test_two_balls():
    names = ("right_length", "left_radius", "right_mass", "left_damping", "restitution")
    assert worst(PAIR, HARMONIC, TWO, (*names, "initial_angle_left")) < ENOUGH


@pytest.mark.parametrize("frame", ["pivot", "lab"])
def test_two_balls_in_sticking_contact(frame):
    system = replace(PAIR, restitution=0.0, drag_frame=frame)
    names = ("right_length", "left_radius", "right_mass", "left_damping", "drive_amplitude")
    assert "rest" in record(system, HARMONIC, times=TIMES, **TWO)["contact_kind"]
    assert worst(system, HARMONIC, TWO, names) < ENOUGH


def test_balls_that_an_inelastic_impact_brings_together_are_pressed_by_their_drag_afterwards():
    """Drag on their velocities before it would pull them apart."""
    system = replace(PAIR, restitution=0.0, left=replace(PAIR.left, damping=0.2))
    drive = replace(STRONG, drive_amplitude=0.4, drive_phase=4.0)
    run = record(system, drive, times=TIMES, sensitivity_to="right_mass", **TWO)
    assert list(run["contact_kind"][:2]) == ["bottom", "rest"]
    assert run["contact_time"][0] == run["contact_time"][1]
    assert run.attrs["sensitivity_status"] == "known"
    assert not np.any(run["capture_loss"])


def test_a_string_that_goes_slack_and_tightens():
    system = replace(PENDULUM, suspension="string")
    start = {"initial_angle": 2.2, "initial_angular_velocity": 0.5}
    names = ("length", "mass", "damping", "gravity", "initial_angle", "initial_angular_velocity")
    run = record(system, times=np.linspace(0.0, 3.0, 19), **start)
    assert list(run["contact_kind"]) == ["slack", "taut"]
    assert worst(system, None, start, names, times=np.linspace(0.0, 3.0, 19)) < ENOUGH


@pytest.mark.parametrize("velocities", [(3.0, -4.5), (0.0, 4.0), (5.0, -5.5)])
def test_two_balls_on_strings(velocities):
    """Through slack, impacts in the air, and a string that an impact loosens.

    Strings tighten in ever smaller bounces, whose last ones differences cannot follow: only the
    state is compared.
    """
    times = np.linspace(0.0, 2.0, 21)
    start = {"initial_angle": (1.2, -1.1), "initial_angular_velocity": velocities}
    names = ("right_length", "right_mass", "restitution", "drive_amplitude")
    run = record(ON_STRINGS, HARMONIC, times=times, tolerance=1e-13, sensitivity_to=names, **start)
    assert run.attrs["sensitivity_status"] == "known"
    for p, name in enumerate(names):
        expected = differences(ON_STRINGS, HARMONIC, start, name, 1e-6, times)
        for key in ("angle", "angular_velocity"):
            found = run[f"{key}_sensitivity"][p]
            assert found == pytest.approx(expected[key], abs=ENOUGH * np.max(abs(expected[key])))


def test_a_free_swing_is_that_of_elliptic_functions():
    amplitude, times = 2.0, np.linspace(0.1, 7.0, 12)
    system = ll.Pendulum(length=1.3, mass=1.0)
    names = ("initial_angle", "gravity", "length")
    run = record(
        system, initial_angle=amplitude, times=times, tolerance=1e-13, sensitivity_to=names
    )

    def angle(start, gravity, length, t):
        k = mpmath.sin(start / 2)
        phase = mpmath.ellipk(k * k) - mpmath.sqrt(gravity / length) * t
        return 2 * mpmath.asin(k * mpmath.ellipfun("sn", phase, m=k * k))

    point = (amplitude, system.gravity, system.length)
    for p in range(3):
        order = tuple(int(i == p) for i in range(3))
        wanted = [mpmath.diff(lambda *x, t=t: angle(*x, t), point, order) for t in times]
        assert run["angle_sensitivity"][p] == pytest.approx(np.array(wanted, float), rel=1e-8)


def test_a_bouncing_ball_is_elementary():
    """Close to its wall a ball falls as on a floor: t_n = t_1 (1 + 2 e + ... + 2 e^(n-1))."""
    offset, e = 1e-6, 0.7
    system = ll.LatoLato(length=1.0, mass=1.0, radius=0.5, restitution=e)
    pull = system.gravity * math.sin(system.contact_angle_low) / system.length
    first = math.sqrt(2.0 * offset / pull)
    n = np.arange(6)
    sums = 1.0 + 2.0 * np.array([sum(e**k for k in range(1, m + 1)) for m in n])
    slopes = 2.0 * np.array([sum(k * e ** (k - 1) for k in range(1, m + 1)) for m in n])
    run = record(
        system, initial_offset=offset, duration=first * 5.0, tolerance=1e-12,
        sensitivity_to=("restitution", "gravity", "initial_offset"),
    )  # fmt: skip
    late = run["contact_time_sensitivity"][:, :6]
    assert len(run["contact_time"]) >= 6
    assert late[0] == pytest.approx(first * slopes, rel=1e-5)
    assert late[1] == pytest.approx(-0.5 * first * sums / system.gravity, rel=1e-5)
    assert late[2] == pytest.approx(0.5 * first * sums / offset, rel=1e-5)


@pytest.mark.parametrize("phase, same", [(0.3 + 320.0 * math.pi, 0.3), (1e-13, 0.0)])
def test_a_phase_of_any_size_is_varied_by_a_part_of_a_turn(phase, same):
    drive = ll.PlanarHarmonic(
        vertical_amplitude=0.1, horizontal_amplitude=0.05, drive_frequency=6.0
    )
    one, other = (
        record(
            PENDULUM, replace(drive, vertical_phase=each), times=TIMES,
            sensitivity_to="vertical_phase", **ONE,
        )["angle_sensitivity"]
        for each in (phase, same)
    )  # fmt: skip
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)


def test_ratios_change_what_they_stand_for():
    def slopes(*names):
        run = record(TOY, HARMONIC, times=TIMES, sensitivity_to=names, **ONE)
        return run["angle_sensitivity"]

    frequency, amplitude = slopes("drive_frequency", "drive_amplitude")
    ratio, amplitude_ratio = slopes("frequency_ratio", "amplitude_ratio")
    (lift,) = slopes("drive_acceleration_ratio")
    assert ratio == pytest.approx(frequency * TOY.natural_frequency, rel=1e-9)
    assert amplitude_ratio == pytest.approx(amplitude * TOY.length, rel=1e-9)
    assert lift == pytest.approx(amplitude * TOY.gravity / HARMONIC.drive_frequency**2, rel=1e-9)


@pytest.mark.parametrize(
    "ratios",
    [
        ("frequency_ratio",),
        ("amplitude_ratio",),
        ("drive_acceleration_ratio",),
        ("frequency_ratio", "drive_acceleration_ratio"),
        ("frequency_ratio", "amplitude_ratio"),
    ],
)
@pytest.mark.parametrize(
    "system, start, length", [(TOY, ONE, "length"), (PAIR, TWO, "right_length")]
)
def test_ratios_that_are_named_are_held_as_along_the_axes_of_a_sweep(system, start, length, ratios):
    """The derivatives of a sweep's final angle along one axis, with the ratios as further ones."""
    rate = system.natural_frequency
    lift = HARMONIC.drive_amplitude * HARMONIC.drive_frequency**2 / system.gravity
    values = {
        "frequency_ratio": HARMONIC.drive_frequency / rate,
        "amplitude_ratio": HARMONIC.drive_amplitude / system.balls[0].length,
        "drive_acceleration_ratio": lift,
    }
    names = (length, "gravity", "drive_phase", *ratios)
    run = record(system, HARMONIC, duration=2.5, tolerance=1e-13, sensitivity_to=names, **start)
    found = run["angle_sensitivity"].reshape(len(names), system.angles, -1)[:, 0, -1]
    places = np.arange(-4, 5)
    for p, name in enumerate(names):
        middle = values.get(name) or value_of(system, HARMONIC, start, name)
        axes = {ratio: [values[ratio]] for ratio in ratios} | {name: middle * (1 + 2e-5 * places)}
        ends = ll.sweep(
            system, HARMONIC, axes=axes, observables="final_angle", duration=2.5, tolerance=1e-13,
            **start,
        ).final_angle  # fmt: skip
        right = ends.isel(ball=0) if "ball" in ends.dims else ends
        weights = np.array([-w for w in reversed(_WEIGHTS)] + [0.0, *_WEIGHTS])
        wanted = weights @ right.values.ravel() / (2e-5 * middle)
        assert found[p] == pytest.approx(wanted, rel=ENOUGH), name


@pytest.mark.parametrize(
    "names, words",
    [
        (["length"], "name frequency_ratio too to keep the ratio, or drive_frequency to keep"),
        (["gravity", "damping"], "names gravity, which sets the natural frequency"),
        (["length", "frequency_ratio"], ""),
        (["length", "drive_frequency"], ""),
        (["damping"], ""),
    ],
)
def test_a_scenario_given_by_a_ratio_says_what_is_held(names, words):
    tables = {
        "system": {"kind": "pendulum", "length": 1.0, "mass": 1.0, "damping": 0.1},
        "drive": {"kind": "harmonic", "drive_amplitude": 0.1, "frequency_ratio": 2.0},
        "run": {"initial_angle": 0.1, "duration": 0.5, "sensitivity_to": names},
    }
    if words:
        with pytest.raises(InputError, match=words):
            ll.Scenario.from_dict(tables)
    else:
        run = ll.Scenario.from_dict(tables).simulate()
        assert run.attrs["sensitivity_status"] == "known"


def test_ten_parameters_are_carried_by_two_runs():
    names = [
        "length", "mass", "radius", "damping", "restitution", "gravity", "drive_amplitude",
        "drive_frequency", "drive_phase", "initial_angle",
    ]  # fmt: skip
    together = ll.simulate(TOY, HARMONIC, times=TIMES, sensitivity_to=names, **ONE)
    assert list(together.parameter.values) == names
    for name in ("length", "initial_angle"):
        alone = ll.simulate(TOY, HARMONIC, times=TIMES, sensitivity_to=name, **ONE)
        for variable in ("angle_sensitivity", "contact_time_sensitivity"):
            of_all = together[variable].sel(parameter=name)
            np.testing.assert_allclose(of_all, alone[variable][0], rtol=1e-12, atol=1e-12)


def test_a_run_is_the_same_with_its_derivatives():
    plain = record(PAIR, HARMONIC, times=TIMES, **TWO)
    differentiated = record(PAIR, HARMONIC, times=TIMES, sensitivity_to="restitution", **TWO)
    np.testing.assert_allclose(differentiated["angle"], plain["angle"], rtol=1e-11, atol=1e-11)


class TestEventsTogether:
    """Events that one guard brings about at one instant, whatever the parameters are."""

    def test_an_impact_without_rebound_lets_a_string_go(self):
        toy = replace(
            TOY, damping=0.07, restitution=0.0, suspension="string", string_restitution=0.3
        )
        drive = ll.Harmonic(drive_amplitude=0.24, drive_frequency=5.0, drive_phase=-0.7)
        start = {"initial_angle": 2.75, "initial_angular_velocity": 2.9}
        times = np.linspace(0.0, 0.6, 7)
        run = record(toy, drive, times=times, **start)
        assert list(run["contact_kind"]) == ["top", "slack"]
        names = ("length", "gravity", "drive_phase", "initial_angular_velocity")
        assert worst(toy, drive, start, names, times=times) < ENOUGH

    def test_a_string_tightens_on_the_plane_between_both_and_goes_slack_again(self):
        toy = ll.LatoLato(
            length=0.5886096404897327, mass=0.89, radius=0.042759520846914215, restitution=0.0,
            suspension="string", string_restitution=0.0,
        )  # fmt: skip
        drive = ll.StagedHarmonic(
            times=(0.0, 0.6325329198614633),
            drive_amplitudes=(0.13612753445015488, 0.2041913016752323),
            drive_frequencies=(11.618714239687911, 13.942457087625494), ramps=(0.1, 0.3),
            drive_phase=1.5829258260291281,
        )  # fmt: skip
        start = {
            "initial_angle": 1.3932969576944934, "initial_angular_velocity": -0.8642364150419134,
        }  # fmt: skip
        times = np.array([1.18, 1.4, 1.6, 1.85])
        run = record(toy, drive, times=times, tolerance=1e-13, **start)
        kinds, instants = list(run["contact_kind"]), run["contact_time"]
        assert kinds[-3:] == ["taut", "bottom", "slack"]
        assert instants[-3] == pytest.approx(instants[-1], abs=1e-9)
        assert worst(toy, drive, start, ["gravity"], times=times) < ENOUGH

    def test_balls_part_as_their_friction_turns(self):
        right = ll.Ball(
            length=0.6717865270562917, mass=0.9766933198476325, damping=0.0636201753339558,
            quadratic_damping=0.09680607454076284, coulomb_damping=0.033011729872992626,
            radius=0.03930395699440607,
        )  # fmt: skip
        left = ll.Ball(
            length=0.6608095312501593, mass=0.30560105716019065, damping=0.031593143515339976,
            quadratic_damping=0.09008952154158421, coulomb_damping=0.03501590694553288,
            radius=0.06399483238959035,
        )  # fmt: skip
        drive = ll.PlanarHarmonic(
            vertical_amplitude=0.12069031971855945, horizontal_amplitude=0.11145358153047663,
            drive_frequency=10.017292667260271, vertical_phase=0.5336439129632193,
            horizontal_phase=0.6427742152127212,
        )  # fmt: skip
        start = {
            "initial_angle": (-0.0371694448866563, -0.6629406922048592),
            "initial_angular_velocity": (-2.3464004284966986, -0.20139801349099645),
        }
        pair = ll.BallPair(right=right, left=left, restitution=0.0)
        times = np.array([3.6, 3.65, 3.7])
        run = record(pair, drive, times=times, tolerance=1e-13, **start)
        assert run["contact_kind"][-1] == "release"
        assert run["contact_time"][-1] < times[1]
        assert np.max(np.abs(run["angular_velocity_before"][:, -1])) < 1e-12
        names = ("horizontal_phase", "right_coulomb_damping", "initial_angle_left")
        assert worst(pair, drive, start, names, times=times) < ENOUGH


class TestDoubt:
    def test_after_a_graze(self):
        """A ball whose turning point, without the drive, lies just behind the top wall."""
        system = ll.LatoLato(length=1.0, mass=1.0, radius=0.1, restitution=0.9)
        height = math.cos(0.5) - math.cos(system.contact_angle_high + 1e-10)
        speed = math.sqrt(2.0 * system.gravity / system.length * height)
        start = {"initial_angle": 0.5, "initial_angular_velocity": speed}
        run = record(system, duration=4.0, sensitivity_to="length", **start)
        assert "grazed" in run.attrs["sensitivity_status"]
        assert np.isfinite(run["angle_sensitivity"][0, 0])
        assert np.isnan(run["angle_sensitivity"][0, -1])

    def test_after_a_capture_of_two_balls(self):
        system = replace(PAIR, restitution=0.3)
        run = record(system, times=np.linspace(0.0, 20.0, 41), sensitivity_to="right_mass", **TWO)
        status = run.attrs["sensitivity_status"]
        assert status.startswith("unknown from")
        assert "capture" in status
        since = float(status.split()[2])
        known = np.isfinite(run["angle_sensitivity"][0, 0])
        np.testing.assert_array_equal(known, run["time"] < since)

    def test_at_a_start_on_a_wall_that_moves_away(self):
        start = {"initial_angle": TOY.contact_angle_low}
        run = record(TOY, duration=1.0, sensitivity_to="radius", **start)
        assert "at the start" in run.attrs["sensitivity_status"]
        run = record(TOY, duration=1.0, sensitivity_to="radius", initial_offset=0.0)
        assert run.attrs["sensitivity_status"] == "known"
        wall = math.cos(TOY.contact_angle_low) ** -1 / TOY.length
        assert run["angle_sensitivity"][0] == pytest.approx(wall, rel=1e-10)

    def test_the_capture_of_one_ball_hides_its_time_alone(self):
        system = replace(TOY, restitution=0.3)
        run = record(system, duration=20.0, sensitivity_to="length", **ONE)
        captured = run["contact_kind"] == "rest"
        assert captured.any()
        assert np.isnan(run["contact_time_sensitivity"][0][captured]).all()
        assert np.isfinite(run["angle_sensitivity"]).all()


class TestRefusals:
    @pytest.mark.parametrize(
        "names, system, more, words",
        [
            ("lenght", TOY, {}, "length"),
            (["length", "length"], TOY, {}, "twice"),
            ("mass", ll.Pendulum(length=1.0, mass=1.0), {}, "does not act on this run, as it does"),
            ("restitution", TOY, {"contact": None}, "does not act on this run; leave it out"),
            ("string_restitution", TOY, {}, "no room to change: .* a rod never goes slack; leave"),
            ("initial_angular_velocity", replace(TOY, coulomb_damping=0.1), {}, "dry friction"),
            (["frequency_ratio", "drive_frequency"], TOY, {}, "both set drive_frequency"),
            (["amplitude_ratio", "drive_acceleration_ratio"], TOY, {}, "both set drive_amplitude"),
            ("length", TOY, {"contact": "clamp"}, "exact contact"),
            ("length", TOY, {"noise": ll.VelocityKicks(noise_strength=1e-3)}, "noise"),
            (3, TOY, {}, "no parameter 3"),
            ([["length"]], TOY, {}, "no parameter"),
        ],
    )
    def test_say_what_is_wrong(self, names, system, more, words):
        with pytest.raises(InputError, match=words):
            ll.simulate(system, HARMONIC, duration=1.0, sensitivity_to=names, **ONE, **more)

    def test_a_ball_that_hangs_at_rest_has_no_derivative_by_dry_friction(self):
        swing = ll.Pendulum(length=1.0, mass=1.0)
        with pytest.raises(InputError, match="names coulomb_damping, and a ball that hangs at"):
            ll.simulate(swing, duration=1.0, initial_angle=0.0, sensitivity_to="coulomb_damping")

    def test_an_acceleration_of_a_drive_at_frequency_zero_is_no_parameter(self):
        drive = replace(HARMONIC, drive_frequency=0.0)
        with pytest.raises(InputError, match="sets no amplitude at frequency 0"):
            ll.simulate(TOY, drive, duration=1.0, sensitivity_to="drive_acceleration_ratio", **ONE)

    @pytest.mark.parametrize(
        "drive, name",
        [
            (
                ll.FrequencySchedule(
                    drive_amplitude=0.1, times=[0, 0.5], drive_frequencies=[5.0, 7.0]
                ),
                "ramp",
            ),
            (
                ll.PlanarHarmonic(
                    vertical_amplitude=0.1, horizontal_amplitude=0.0, drive_frequency=6.0
                ),
                "horizontal_amplitude",
            ),
        ],
    )
    def test_a_value_with_a_formula_of_its_own_has_no_derivative(self, drive, name):
        with pytest.raises(InputError, match=f"{name}, whose value 0 .* a formula of its own"):
            ll.simulate(PENDULUM, drive, duration=1.0, sensitivity_to=name, **ONE)

    def test_the_sigma_of_a_table_is_no_parameter_of_a_motion(self):
        times = np.linspace(0.0, 2.0, 41)
        heights = 0.1 * np.sin(6.0 * times)
        drive = ll.MeasuredPivot(times=times, pivot_heights=heights, height_sigma=1e-3)
        with pytest.raises(InputError, match="no parameter 'height_sigma'"):
            ll.simulate(TOY, drive, duration=1.0, sensitivity_to="height_sigma", **ONE)
