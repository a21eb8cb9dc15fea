"""Random streams of a sweep: one for each point, whatever the chunks and whoever runs them."""

import math
import re

import numpy as np
import pytest

import latolato as ll
from latolato.physics.noise import BOLTZMANN
from latolato.scenario.variation import known_quantities, merged_axes
from latolato.simulation.start import kicks_of
from latolato.sweeps.plan import make_plan

TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.16)
DRIVE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.0)
KICKS = ll.VelocityKicks(noise_strength=0.3, noise_seed=11, noise_stream=5)
FINAL = ["final_angle", "final_angular_velocity"]
SETTINGS = {"initial_offset": 0.3, "duration": 2.0, "observables": FINAL}


def kicks(**changed):
    return kicks_of(
        ll.VelocityKicks(**({"noise_strength": 1.0, "noise_seed": 3} | changed)), TOY, 10.0
    )[1]


class TestStreams:
    def test_the_kicks_of_a_seed_and_stream_are_those_of_philox(self):
        # From the published algorithm by hand: Philox4x64-10, then NumPy's own normal deviates.
        generator = np.random.Generator(np.random.Philox(key=3 + (2 << 64)))
        count = kicks(noise_stream=2).shape[1]
        spacing = ll.VelocityKicks(noise_strength=1.0).spacing(TOY)
        expected = generator.standard_normal(count) * math.sqrt(spacing)
        np.testing.assert_array_equal(kicks(noise_stream=2)[0], expected)

    def test_a_longer_run_begins_with_the_kicks_of_a_shorter_one(self):
        pair = ll.BallPair(
            right=ll.Ball(length=1.0, mass=0.8, radius=0.1),
            left=ll.Ball(length=1.0, mass=0.8, radius=0.1),
        )
        short, long = (kicks_of(KICKS, pair, end)[1] for end in (3.0, 10.0))
        np.testing.assert_array_equal(long[:, : short.shape[1]], short)

    def test_seeds_and_streams_are_uncorrelated(self):
        columns = [
            kicks(noise_seed=s, noise_stream=k)[0]
            for s in (0, 1, 2**63 - 1)
            for k in (0, 1, 2**53 - 1)
        ]
        result = np.corrcoef(columns)[np.triu_indices(len(columns), 1)]
        # 36 correlations of n = 250 numbers: standard deviation n^(-1/2) = 0.063, four of them
        assert np.abs(result).max() < 4.0 / math.sqrt(len(columns[0]))


def swept(axes, **changed):
    return ll.sweep(TOY, DRIVE, axes=axes, **({"noise": KICKS} | SETTINGS | changed))


AXES = {"drive_amplitude": [0.02, 0.05, 0.2], "initial_offset": [0.1, 0.3]}


class TestSweep:
    def test_points_have_their_own_streams_whatever_the_chunks(self):
        one = swept(AXES, chunk_size=6, initial_offset=None)
        for size in (1, 4):
            other = swept(AXES, chunk_size=size, initial_offset=None)
            for name in FINAL:
                np.testing.assert_array_equal(other[name], one[name])

    def test_the_executors_draw_the_same_kicks(self):
        one = swept(AXES, initial_offset=None)
        other = swept(AXES, initial_offset=None, executor="reference", chunk_size=4)
        for name in FINAL:
            # the compiled sine differs from math.sin in the last digits; two seconds amplify little
            np.testing.assert_allclose(other[name], one[name], rtol=0.0, atol=1e-9)

    def test_a_run_with_its_stream_is_a_point_of_the_sweep_bit_for_bit(self):
        grid = swept(AXES, initial_offset=None)
        assert grid.attrs["noise_streams"] == "noise_stream + number of the point in C order"
        first = grid.attrs["noise_stream"]
        for number in (0, 3, 5):
            i, j = divmod(number, 2)
            run = ll.simulate(
                TOY,
                ll.Harmonic(drive_amplitude=AXES["drive_amplitude"][i], drive_frequency=6.0),
                initial_offset=AXES["initial_offset"][j],
                times=[SETTINGS["duration"]],
                tolerance=1e-6,
                noise=ll.VelocityKicks(
                    noise_strength=0.3, noise_seed=11, noise_stream=first + number
                ),
            )
            assert run.attrs["noise_stream"] == first + number
            assert run.angle.item() == grid.final_angle.values[i, j]
            assert run.angular_velocity.item() == grid.final_angular_velocity.values[i, j]

    def test_points_of_equal_parameters_differ_by_their_noise(self):
        result = swept({"gravity": [9.8, 9.8 + 1e-14]}).final_angle.values
        assert abs(result[0] - result[1]) > 1e-3

    def test_stream_as_an_axis_gives_an_ensemble_that_other_points_share(self):
        axes = {"gravity": [9.8, 9.8 + 1e-14], "noise_stream": range(5, 8)}
        result = swept(axes)
        assert result.final_angle.dims == ("gravity", "noise_stream")
        assert "noise_streams" not in result.attrs
        # equal kicks: the points along gravity differ by rounding, those along the stream do not
        np.testing.assert_allclose(
            result.final_angle[0], result.final_angle[1], rtol=0.0, atol=1e-9
        )
        assert np.ptp(result.final_angle.values, axis=1).min() > 1e-3
        own = swept({"gravity": [9.8]}).final_angle.item()
        assert result.final_angle.values[0, 0] == own

    def test_strength_seed_and_interval_are_axes(self):
        grid = swept({"noise_strength": [0.0, 0.3], "noise_seed": [11, 12]}, noise=None)
        still = swept(
            {"gravity": [9.8]}, noise=ll.VelocityKicks(noise_strength=0.0)
        ).final_angle.item()
        np.testing.assert_array_equal(grid.final_angle[0], [still, still])
        assert grid.noise_strength.attrs["units"] == "rad/s^(3/2)"
        assert grid.final_angle[1, 0] != grid.final_angle[1, 1]
        rare = swept({"noise_interval": [0.02, 5.0]}).final_angle.values
        # no kick falls into two seconds, and none of size zero cuts a step: the tolerance is 1e-6
        assert rare[1] == pytest.approx(still, abs=1e-6)
        assert abs(rare[0] - still) > 1e-3

    def test_the_plan_comes_back_and_its_chunks_fit_the_memory(self):
        settings = SETTINGS | {"duration": 2000.0, "noise": KICKS}
        plan = make_plan(TOY, DRIVE, axes={"noise_stream": range(5000)}, **settings)
        assert type(plan).from_description(plan.describe()) == plan
        # 2000 s hold 49,824 kicks
        assert plan.chunk_size == 80


@pytest.mark.parametrize(
    "axes, changed, message",
    [
        ({"noise_stream": [0, 0.5]}, {}, "noise_stream must be a whole number, got 0.5"),
        ({"noise_seed": [-1]}, {}, "noise_seed[0] must lie in [0, 2^53), got -1"),
        ({"noise_stream": [1]}, {"noise": None}, "axis noise_stream needs noise: give Velocity"),
        (
            {"gravity": [9.8, 9.9]},
            {"noise": ll.VelocityKicks(noise_strength=0.1, noise_stream=2**53 - 2)},
            "2 points need as many streams from 9007199254740990 on",
        ),
        ({"noise_streams": [1]}, {}, "did you mean 'noise_stream'?"),
    ],
)
def test_wrong_streams_are_refused(axes, changed, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        swept(axes, **changed)


def test_thermal_kicks_give_each_square_half_of_the_heat():
    # Equipartition: <m l^2 th'^2/2> = k_B T/2 and, at small angles, <m g l th^2/2> = k_B T/2.
    heat = 1e-3  # J, so small an angle (0.01 rad) that the restoring force is linear
    noise = ll.VelocityKicks.thermal(PENDULUM, temperature=heat / BOLTZMANN, noise_seed=2)
    count = 1500
    result = ll.sweep(
        PENDULUM,
        axes={"noise_stream": range(count)},
        initial_angle=0.0,
        duration=40.0,  # 8 decay times of the energy: exp(-8) of the start is left
        observables=FINAL,
        noise=noise,
    )
    mass, length, gravity = PENDULUM.mass, PENDULUM.length, PENDULUM.gravity
    kinetic = 0.5 * mass * length**2 * result.final_angular_velocity.values**2
    potential = mass * gravity * length * (1.0 - np.cos(result.final_angle.values))
    for energy in (kinetic, potential):
        # the square of a normal number scatters by 2^(1/2) of its mean; four standard errors
        assert energy.mean() == pytest.approx(0.5 * heat, rel=4.0 * math.sqrt(2.0 / count))


def test_scenarios_and_options_know_the_noise_axes():
    for name in ("noise_strength", "noise_seed", "noise_stream", "noise_interval"):
        assert name in known_quantities("pendulum", None)
    with pytest.raises(ValueError, match="noise_stream is given as a value and varied along axis"):
        merged_axes({}, {"noise_stream": (0.0, 1.0)}, {"noise": {"noise_stream": 3}})
