"""A continuation: each point starts where its neighbour ended, with the drive going on."""

import functools
import math

import numpy as np
import pytest

import latolato as ll
from latolato.numerics.records import CONVERGED, INVALID
from latolato.sweeps.statuses import codes_of

PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.1)
DRIVE = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0, drive_phase=0.2)
RATIOS = list(np.linspace(1.6, 2.2, 13))
# Both ways over the resonance, of which the upper edge is at ratio 2.1: hysteresis below it.
SWEEP = {
    "axes": {"frequency_ratio": RATIOS},
    "initial_angle": 0.05,
    "duration": 60.0,
    "transient": 40.0,
    "observables": ["largest_angle_after_transient", "final_angle", "final_angular_velocity"],
    "continuation": "frequency_ratio",
}


@functools.cache
def swept(direction):
    return ll.sweep(PENDULUM, DRIVE, **SWEEP, direction=direction)


def assert_same_numbers(result, expected):
    for name in expected.data_vars:
        assert result[name].values.tobytes() == expected[name].values.tobytes(), name


class TestHysteresis:
    def test_a_softening_branch_is_followed_further_downwards(self):
        both = swept("both").largest_angle_after_transient
        up, down = (both.sel(direction=d) for d in ("up", "down"))
        below = both.frequency_ratio < 1.85
        # a start near rest stays there, the large motion stays large and grows (softening)
        assert float(up[below].max()) < 0.01
        assert float(down[below].min()) > 1.5
        assert (np.diff(down) < 0.0).all()
        above = both.frequency_ratio > 2.0
        assert float(abs(up - down)[above].max()) < 0.05

    @pytest.mark.parametrize("direction", ["up", "down"])
    def test_both_branches_are_real(self, direction):
        place = {"frequency_ratio": 2, "direction": 0 if direction == "up" else 1}
        point = swept("both").isel(place)
        frequency = RATIOS[2] * math.sqrt(9.8)
        passed = RATIOS[:3] if direction == "up" else RATIOS[2:]
        turned = sum(passed) * math.sqrt(9.8) * 60.0
        drive = ll.Harmonic(
            drive_amplitude=0.1, drive_frequency=frequency, drive_phase=0.2 + turned
        )
        run = ll.simulate(
            PENDULUM, drive, initial_angle=float(point.final_angle),
            initial_angular_velocity=float(point.final_angular_velocity), duration=300.0,
        )  # fmt: skip
        late = run.angle.values[run.time.values > 250.0]
        expected = float(point.largest_angle_after_transient)
        # 40 s leave exp(-2.5) of the beats of an attractor that is a few hundredths wide
        assert np.abs(late).max() == pytest.approx(expected, abs=0.03)


class TestChain:
    """The same by hand: single runs, one after the other."""

    CASES = (
        ("pendulum", PENDULUM, "frequency_ratio", [1.8, 1.9, 2.0], {"initial_angle": 0.8}),
        (
            "toy",
            ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.05, restitution=0.9),
            "frequency_ratio",
            [1.9, 2.0, 2.1],
            {"initial_angle": 0.8},
        ),
        ("drive_amplitude", PENDULUM, "drive_amplitude", [0.05, 0.1, 0.2], {"initial_angle": 0.8}),
        (
            "radius",
            ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.05, restitution=0.0),
            "radius",
            [0.05, 0.1, 0.3],  # the wall moves beyond where the ball rests or swings
            {"initial_angle": 0.4},
        ),
        (
            "two balls",
            ll.BallPair(
                right=ll.Ball(length=1.0, mass=0.8, radius=0.05, damping=0.02),
                left=ll.Ball(length=1.0, mass=0.8, radius=0.05, damping=0.02),
                restitution=0.9,
            ),
            "frequency_ratio",
            [1.9, 2.0],
            {"initial_angle": (0.8, -0.7)},
        ),
    )

    @pytest.mark.parametrize("direction", ["up", "down"])
    @pytest.mark.parametrize("case", CASES, ids=lambda case: case[0])
    def test_each_point_starts_where_its_neighbour_ended(self, case, direction):
        _, system, axis, values, start = case
        duration = 4.0
        result = ll.sweep(
            system, DRIVE, axes={axis: values}, duration=duration, continuation=axis,
            direction=direction, observables=["final_angle", "final_angular_velocity"],
            tolerance=1e-10, executor="reference", **start,
        )  # fmt: skip
        phase, angle, velocity = 0.2, start["initial_angle"], 0.0
        for value in values if direction == "up" else values[::-1]:
            frequency = value * math.sqrt(9.8) if axis == "frequency_ratio" else 6.0
            amplitude = value if axis == "drive_amplitude" else 0.1
            law = system
            if axis == "radius":
                law = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=value, restitution=0.0)
                angle = min(max(angle, math.asin(value)), math.pi - math.asin(value))
            drive = ll.Harmonic(
                drive_amplitude=amplitude, drive_frequency=frequency, drive_phase=phase
            )
            run = ll.simulate(
                law, drive, initial_angle=angle, initial_angular_velocity=velocity,
                times=[duration], tolerance=1e-10,
            )  # fmt: skip
            phase += frequency * duration
            angle, velocity = run.angle.values[..., -1], run.angular_velocity.values[..., -1]
            point = result.sel({axis: value})
            # a hundred tolerances: regular motion that a few impacts and beats amplify
            np.testing.assert_allclose(point.final_angle, angle, rtol=0.0, atol=1e-8)
            np.testing.assert_allclose(point.final_angular_velocity, velocity, rtol=0.0, atol=1e-8)
            if system.angles == 1:
                angle, velocity = float(angle), float(velocity)


def test_both_ways_are_a_dimension_and_equal_each_way_alone():
    both = swept("both")
    assert both.final_angle.dims == ("direction", "frequency_ratio")
    assert list(both.direction.values) == ["up", "down"]
    for direction in ("up", "down"):
        assert_same_numbers(both.sel(direction=direction, drop=True), swept(direction))


@pytest.mark.parametrize("chunk_size", [1, 30, 1000])
def test_lines_of_a_map_do_not_touch_each_other(chunk_size):
    axes = {"mass": [0.4, 0.8, 1.2], "frequency_ratio": RATIOS, "damping": [0.1, 0.2]}
    for turned in (axes, dict(reversed(axes.items()))):
        result = ll.sweep(
            PENDULUM, DRIVE, **(SWEEP | {"axes": turned, "chunk_size": chunk_size}), direction="up"
        )
        assert_same_numbers(result.sel(mass=0.8, damping=0.1, drop=True), swept("up"))


def test_it_begins_like_any_sweep():
    first = ll.sweep(
        PENDULUM, DRIVE, **(SWEEP | {"axes": {"frequency_ratio": RATIOS[:1]}, "continuation": None})
    )
    assert_same_numbers(first, swept("up").isel(frequency_ratio=[0]))


def test_a_point_without_an_answer_hands_on_its_start():
    axes = {"radius": [0.05, 1.5, 2.0]}
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.05)
    settings = {"initial_angle": 0.9, "duration": 3.0, "executor": "reference"}
    settings |= {"observables": ["final_angle"], "continuation": "radius"}
    with pytest.warns(RuntimeWarning, match="2 invalid"):
        result = ll.sweep(toy, DRIVE, axes=axes, **settings, direction="down")
    assert codes_of(result.status).tolist() == [CONVERGED, INVALID, INVALID]
    # nothing has moved before the first good point
    alone = ll.sweep(toy, DRIVE, axes={"radius": [0.05]}, **settings)
    assert float(result.final_angle[0]) == float(alone.final_angle[0])


def test_a_fast_end_makes_the_steps_of_the_next_point_shorter():
    # Free fall from the top: the next point starts at 6 rad/s under weak gravity, where the swing
    # alone would allow steps three times as long.
    pendulum = ll.Pendulum(length=1.0, mass=0.8)
    result = ll.sweep(
        pendulum, axes={"gravity": [9.8, 0.5]}, initial_angle=3.0, duration=1.16,
        continuation="gravity", direction="down", executor="reference", tolerance=1e-6,
        observables=["final_angle", "final_angular_velocity"],
    )  # fmt: skip
    start = {
        "initial_angle": float(result.final_angle[0]),
        "initial_angular_velocity": float(result.final_angular_velocity[0]),
    }
    assert abs(start["initial_angular_velocity"]) > 5.0
    alone = ll.sweep(
        pendulum, axes={"gravity": [0.5]}, duration=1.16, executor="reference",
        observables=["final_angle", "final_angular_velocity"], **start,
    )  # fmt: skip
    assert float(result.final_angle[1]) == float(alone.final_angle[0])


def test_up_is_towards_larger_values_in_whatever_order_they_stand():
    backwards = {"frequency_ratio": RATIOS[::-1]}
    result = ll.sweep(PENDULUM, DRIVE, **{**SWEEP, "axes": backwards}, direction="up")
    assert_same_numbers(result.sortby("frequency_ratio"), swept("up"))


def test_every_parameter_of_a_followed_zip_moves_steadily():
    axes = {"case": {"length": [0.9, 1.0, 1.1], "mass": [1.0, 3.0, 2.0]}}
    with pytest.raises(ValueError, match="sort the values of mass"):
        ll.sweep(PENDULUM, DRIVE, **{**SWEEP, "axes": axes, "continuation": "case"})


def test_an_invalid_point_hands_on_the_start_above_its_wall():
    toy = ll.LatoLato(length=0.245, mass=0.1, damping=0.005, radius=0.02, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.01, drive_frequency=15.1)
    settings = {"transient_periods": 1.0, "duration": 4.0, "observables": ["final_angle"]}
    axes = {"drive_frequency": [1e-3, 2.0]}  # the first one's transient takes hours
    settings |= {"axes": axes, "initial_offset": 0.5}
    with pytest.warns(RuntimeWarning, match="transient must be shorter"):
        result = ll.sweep(toy, drive, continuation="drive_frequency", **settings)
    with pytest.warns(RuntimeWarning, match="transient must be shorter"):
        alone = ll.sweep(toy, drive, **settings)
    assert float(result.final_angle[1]) == float(alone.final_angle[1])
