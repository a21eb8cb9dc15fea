"""The public entry point: the dataset's contract, defaults, bad input, extreme input."""

import functools
import json
import math
import resource
import sys

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES
from latolato.physics.contacts import CONTACT_KINDS

PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1, restitution=0.9)
MATHIEU = ll.Mathieu(length=1.0, mass=0.8, damping=0.05)
DRIVE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)


@functools.cache
def pair():
    return ll.BallPair(
        right=ll.Ball(length=1.0, mass=0.8, radius=0.1),
        left=ll.Ball(length=0.95, mass=0.5, radius=0.1),
        restitution=0.9,
    )


@pytest.fixture(scope="module")
def run():
    return ll.simulate(TOY, DRIVE, initial_angle=0.7, duration=10.0)


@pytest.fixture(scope="module")
def pair_run():
    return ll.simulate(pair(), DRIVE, initial_angle=(0.7, -0.6), duration=10.0)


ON_TIME = [
    "angle",
    "angular_velocity",
    "kinetic_energy",
    "potential_energy",
    "total_energy",
    "drive_power",
    "damping_power",
    "tension",
]
LEDGER = ["drive_work", "damping_loss", "impact_loss", "capture_loss"]
PIVOT = ["pivot_height", "pivot_velocity", "pivot_acceleration"]
CONTACT = ["contact_time", "contact_kind", "angular_velocity_before", "angular_velocity_after"]


class TestDataset:
    def test_variables_of_one_angle_lie_on_time_and_contact(self, run):
        for name in [*ON_TIME, *LEDGER, *PIVOT]:
            assert run[name].dims == ("time",), name
            assert run[name].dtype == np.float64
        for name in CONTACT:
            assert run[name].dims == ("contact",), name

    def test_variables_of_two_angles_have_a_ball_dimension(self, pair_run):
        for name in ON_TIME:
            assert pair_run[name].dims == ("ball", "time"), name
        for name in [*LEDGER, *PIVOT]:
            assert pair_run[name].dims == ("time",), name
        for name in ("angular_velocity_before", "angular_velocity_after"):
            assert pair_run[name].dims == ("ball", "contact"), name
        assert pair_run.contact_time.dims == ("contact",)
        assert list(pair_run.ball.values) == ["right", "left"]
        assert float(pair_run.angle.sel(ball="right")[0]) == 0.7
        assert float(pair_run.angle.sel(ball="left")[0]) == -0.6

    def test_every_variable_has_unit_name_and_symbol(self, run):
        for name, variable in run.variables.items():
            quantity = QUANTITIES[name]
            assert variable.attrs["units"] == quantity.unit
            assert variable.attrs["symbol"] == quantity.symbol
            assert variable.attrs["long_name"].startswith(quantity.long_name)

    def test_the_balls_are_described_too(self, pair_run):
        for name, variable in pair_run.variables.items():
            assert {"units", "long_name", "symbol"} <= set(variable.attrs), name
        assert pair_run.ball.attrs["long_name"] == "ball"

    def test_energies_of_a_mirror_symmetric_pair_say_per_ball(self, run):
        for name in ["total_energy", "drive_work", "impact_loss", "drive_power", "tension"]:
            assert "per ball" in run[name].attrs["long_name"]

    def test_ledger_of_two_balls_says_both(self, pair_run):
        for name in LEDGER:
            assert "both balls" in pair_run[name].attrs["long_name"]

    def test_lab_frame_comes_on_request(self, run):
        assert "lab_energy" not in run
        both = ll.simulate(TOY, DRIVE, initial_angle=0.7, duration=1.0, frame="both")
        assert both.lab_energy.dims == both.rod_power.dims == ("time",)

    def test_small_angle_model_has_no_tension(self):
        result = ll.simulate(MATHIEU, DRIVE, initial_angle=0.1, duration=1.0, frame="both")
        for name in ("tension", "lab_energy", "rod_power"):
            assert name not in result
        assert "compression_time" not in result.attrs

    def test_total_is_kinetic_plus_potential(self, run):
        np.testing.assert_array_equal(run.total_energy, run.kinetic_energy + run.potential_energy)

    def test_pivot_moves_as_the_drive_says(self, run):
        t = run.time.values
        np.testing.assert_allclose(run.pivot_height, 0.05 * np.cos(6.26 * t), rtol=0, atol=1e-15)
        np.testing.assert_allclose(
            run.pivot_acceleration, -0.05 * 6.26**2 * np.cos(6.26 * t), rtol=0, atol=1e-13
        )

    def test_contact_kinds_are_the_known_words(self, run):
        assert run.sizes["contact"] > 3
        assert set(run.contact_kind.values) <= set(CONTACT_KINDS)

    def test_attributes_carry_all_parameters(self, run):
        expected = {
            "system": "latolato",
            "drive": "harmonic",
            "length": 1.0,
            "mass": 0.8,
            "damping": 0.02,
            "quadratic_damping": 0.0,
            "coulomb_damping": 0.0,
            "radius": 0.1,
            "restitution": 0.9,
            "gravity": 9.8,
            "drive_amplitude": 0.05,
            "drive_frequency": 6.26,
            "drive_phase": 0.0,
            "initial_angle": 0.7,
            "initial_angular_velocity": 0.0,
            "duration": 10.0,
            "tolerance": 1e-10,
            "contact": "exact",
            "status": "complete",
            "latolato_version": ll.__version__,
        }
        for name, value in expected.items():
            assert run.attrs[name] == value, name
        assert run.attrs["contact_angle_low"] == math.asin(0.1)
        assert run.attrs["rest_speed"] <= 1e-5
        assert 0.0 <= run.attrs["energy_residual"] < 1e-9
        assert run.attrs["contacts"] == run.sizes["contact"]

    def test_attribute_scenario_names_the_same_parameters(self, run):
        scenario = json.loads(run.attrs["scenario"])
        assert scenario["system"]["kind"] == "latolato"
        assert scenario["drive"]["drive_frequency"] == 6.26
        assert scenario["run"]["duration"] == 10.0

    @pytest.mark.parametrize("ending", ["driven", "still", "pair", "measured", "clamp", "no rows"])
    def test_netcdf_keeps_values_and_attributes(self, ending, tmp_path, run, request):
        if ending == "driven":
            result = run
        elif ending == "still":
            result = ll.simulate(TOY, initial_angle=0.7, duration=3.0)
        elif ending == "pair":
            result = request.getfixturevalue("pair_run")
        elif ending == "measured":
            # Longer than the 64 KiB that HDF5 allows in an object header.
            t = np.arange(0.0, 60.0, 1.0 / 240.0)
            pivot = ll.MeasuredPivot(times=t, pivot_heights=0.02 * np.cos(5.0 * t))
            result = ll.simulate(PENDULUM, pivot, initial_angle=0.2, duration=2.0)
        elif ending == "clamp":
            result = ll.simulate(
                TOY, DRIVE, initial_angle=0.7, duration=2.0, contact=ll.ClampContact()
            )
        else:
            result = ll.simulate(TOY, initial_angle=0.7, duration=0.1)
            assert result.sizes["contact"] == 0
        file = tmp_path / "run.nc"
        result.to_netcdf(file, engine="h5netcdf")
        with xr.open_dataset(file, engine="h5netcdf") as read:
            read.load()
        xr.testing.assert_equal(result, read)
        assert set(read.attrs) == set(result.attrs)
        for name, value in result.attrs.items():
            if isinstance(value, str):
                assert read.attrs[name] == value
            else:
                np.testing.assert_array_equal(read.attrs[name], value, err_msg=name)

    def test_initial_offset_is_an_angle_above_the_wall(self):
        arguments = {"duration": 2.0, "tolerance": 1e-10}
        a = ll.simulate(TOY, DRIVE, initial_offset=0.3, **arguments)
        b = ll.simulate(TOY, DRIVE, initial_angle=math.asin(0.1) + 0.3, **arguments)
        xr.testing.assert_equal(a, b)

    def test_start_within_1e_12_of_a_wall_is_on_it(self):
        low = math.asin(0.1)
        for offset in (0.0, 9e-13, -9e-13):
            result = ll.simulate(TOY, initial_angle=low + offset, duration=1.0)
            assert np.all(result.angle.values == low)
        assert float(ll.simulate(TOY, initial_offset=1e-11, duration=1.0).angle[0]) > low


class TestSampling:
    def test_default_gives_100_samples_in_the_shorter_period(self):
        for drive in (None, DRIVE, ll.Harmonic(drive_amplitude=0.01, drive_frequency=40.0)):
            result = ll.simulate(PENDULUM, drive, initial_angle=0.2, duration=7.0)
            fastest = max(PENDULUM.natural_frequency, getattr(drive, "drive_frequency", 0.0))
            period = 2.0 * math.pi / fastest
            spacing = np.diff(result.time.values)
            assert spacing.max() <= period / 100.0 * (1.0 + 1e-12)
            assert result.time.values[0] == 0.0
            assert result.time.values[-1] == 7.0
            np.testing.assert_allclose(spacing, spacing.mean(), rtol=1e-9)

    def test_default_sampling_of_every_drive_is_dense(self, drive):
        result = ll.simulate(PENDULUM, drive, initial_angle=0.2, duration=6.0)
        t, y = result.time.values, result.pivot_height.values
        assert np.diff(t).max() <= 2.0 * math.pi / PENDULUM.natural_frequency / 100.0
        if np.ptp(y) > 0.0:
            # 100 samples in a period: neighbours differ by at most 2 pi/100 of the amplitude.
            rate = np.abs(result.pivot_velocity.values).max()
            assert rate * np.diff(t).max() < 0.07 * np.ptp(y)

    def test_requested_times_are_the_coordinate(self):
        times = [0.0, 0.1, 1.0 / 3.0, 2.5]
        result = ll.simulate(PENDULUM, DRIVE, initial_angle=0.2, times=times)
        np.testing.assert_array_equal(result.time, times)
        assert result.attrs["duration"] == 2.5

    def test_run_may_last_longer_than_the_requested_times(self):
        result = ll.simulate(TOY, initial_angle=0.7, times=[0.2], duration=3.0)
        assert result.sizes["time"] == 1
        assert result.contact_time.values.max() > 1.0

    def test_progress_ends_at_one(self):
        seen = []
        ll.simulate(PENDULUM, DRIVE, initial_angle=0.2, duration=2.0, progress=seen.append)
        assert seen[-1] == 1.0
        assert seen == sorted(seen)


ranges = {
    "length": (0.0, -1.0, math.nan, math.inf, 10**400),
    "mass": (0.0, -1.0, math.nan, math.inf),
    "damping": (-1e-9, math.nan, math.inf),
    "quadratic_damping": (-1.0, math.nan),
    "coulomb_damping": (-1.0, math.nan),
    "radius": (-0.1, 1.0, 1.5, math.nan),
    "restitution": (-0.1, 1.1, math.nan),
    "gravity": (0.0, -9.8, math.nan, -math.inf),
}


class TestBadInput:
    @pytest.mark.parametrize(
        "name,value",
        [(name, value) for name, values in ranges.items() for value in values],
        ids=lambda x: x if isinstance(x, str) else "huge" if x == 10**400 else f"{x:g}",
    )
    def test_parameters_outside_their_range(self, name, value):
        arguments = {"length": 1.0, "mass": 0.8, "radius": 0.1, name: value}
        with pytest.raises(ValueError, match=rf"^{name} must") as caught:
            ll.LatoLato(**arguments)
        assert "\n" not in str(caught.value)
        if name != "length" or value < 1e300:
            assert f"{value:g}" in str(caught.value)

    @pytest.mark.parametrize(
        "name, value, rule",
        [
            (
                "mass",
                1e31,
                r"must lie in \[0, 1e\+30\] kg, got 1e\+31; check its order of magnitude",
            ),
            ("mass", 1e-31, r"must be at least 1e-30 kg, got 1e-31; check its order of magnitude"),
            ("initial_angle", -2e6, r"must lie in \[-1e\+06, 1e\+06\] rad, .*whole turns"),
            ("initial_angular_velocity", -1e31, r"must lie in \[-1e\+30, 1e\+30\] rad/s"),
        ],
    )
    def test_numbers_of_a_size_that_cannot_be_computed_with(self, name, value, rule):
        body = {"length": 1.0, "mass": 0.8}
        start = {"initial_angle": 0.1, "duration": 1.0}
        (body if name in body else start)[name] = value
        with pytest.raises(InputError, match=f"^{name} {rule}"):
            ll.simulate(ll.Pendulum(**body), **start)

    @pytest.mark.parametrize("value", ["1.0", None, True, [1.0], 1j, b"1"])
    @pytest.mark.parametrize("name", ["length", "mass", "damping", "radius", "gravity"])
    def test_parameters_of_a_wrong_type(self, name, value):
        arguments = {"length": 1.0, "mass": 0.8, "radius": 0.1, name: value}
        with pytest.raises(InputError, match=rf"^{name} must be a number"):
            ll.LatoLato(**arguments)

    @pytest.mark.parametrize(
        "kind,arguments,rule",
        [
            (ll.Harmonic, {"drive_amplitude": -0.1}, r"drive_amplitude must lie in \[0, inf\)"),
            (ll.Harmonic, {"drive_frequency": -1.0}, r"drive_frequency must lie in \[0, inf\)"),
            (ll.Harmonic, {"drive_phase": math.inf}, "drive_phase must be a number"),
            (ll.Harmonic, {"drive_frequency": math.nan}, "drive_frequency must be a number"),
            (ll.CrankSlider, {"connecting_rod_length": 0.0}, "connecting_rod_length must lie"),
            (ll.CrankSlider, {"connecting_rod_length": 0.02}, "drive_amplitude must be less than"),
            (ll.CrankSlider, {"guide": "left"}, "guide must be 'below' or 'above', got 'left'"),
            (ll.Chirp, {"sweep_time": 0.0}, r"sweep_time must lie in \(0, inf\)"),
            (ll.Chirp, {"drive_frequency_final": -2.0}, "drive_frequency_final must lie"),
            (ll.FrequencySchedule, {"times": [0.0, 2.0, 1.0]}, "increase strictly, got 1 after 2"),
            (ll.FrequencySchedule, {"times": [0.0, 1.0, 1.0]}, "increase strictly, got 1 after 1"),
            (
                ll.FrequencySchedule,
                {"times": [1.0, 2.0, 3.0]},
                "must begin with 0, the start of the first stage, got 1",
            ),
            (ll.FrequencySchedule, {"times": [0.0, 1.0]}, "of one length, got 2 and 3"),
            (ll.FrequencySchedule, {"times": []}, "at least 1 value, got 0"),
            (ll.FrequencySchedule, {"times": [0.0, math.nan, 3.0]}, r"times\[1\] must be a number"),
            (ll.FrequencySchedule, {"drive_frequencies": [1.0, -1.0, 2.0]}, "must lie"),
            (ll.FrequencySchedule, {"ramp": 1.5}, "ramp must not exceed the shortest stage 1"),
            (ll.FrequencySchedule, {"ramp": -1.0}, "ramp must lie"),
            (ll.MeasuredPivot, {"times": []}, "times must hold at least 6 values, got 0"),
            (ll.MeasuredPivot, {"times": [0, 1, 2, 4, 3, 5, 6]}, "increase strictly"),
            (ll.MeasuredPivot, {"times": [0, 1, 2, 3, 3, 5, 6]}, "increase strictly"),
            (ll.MeasuredPivot, {"pivot_heights": [0.0] * 6}, "of one length, got 7 and 6"),
            (ll.StagedHarmonic, {"ramps": [1.0, 0.0]}, r"ramps\[\d\] must lie"),
            (ll.StagedHarmonic, {"ramps": [1.0]}, "of one length, got 2, 2, 2, 1"),
            (
                ll.StagedHarmonic,
                {"times": [1.0, 2.0]},
                "must begin with 0, the start of the first stage, got 1",
            ),
            (ll.StagedHarmonic, {"times": [0.0, 0.0]}, "increase strictly, got 0 after 0"),
            (ll.StagedHarmonic, {"drive_amplitudes": [1.0, math.inf]}, "must be a number|must lie"),
            (
                ll.MeasuredPivot,
                {"pivot_heights": [0.0] * 6 + [math.nan]},
                r"\[6\] must be a number",
            ),
            (ll.MeasuredPivot, {"pivot_heights": []}, "heights must hold at least 6 values"),
            (ll.MeasuredPivot, {"height_sigma": -1.0}, "height_sigma must lie"),
        ],
    )
    def test_drives_refuse(self, kind, arguments, rule):
        fine = {
            ll.Harmonic: {"drive_amplitude": 0.1, "drive_frequency": 6.0},
            ll.CrankSlider: {
                "drive_amplitude": 0.02,
                "drive_frequency": 6.0,
                "connecting_rod_length": 0.1,
            },
            ll.Chirp: {
                "drive_amplitude": 0.02,
                "drive_frequency": 6.0,
                "drive_frequency_final": 8.0,
                "sweep_time": 5.0,
            },
            ll.FrequencySchedule: {
                "drive_amplitude": 0.02,
                "times": [0.0, 1.0, 2.0],
                "drive_frequencies": [5.0, 6.0, 7.0],
            },
            ll.StagedHarmonic: {
                "times": [0.0, 1.0],
                "drive_amplitudes": [0.02, 0.03],
                "drive_frequencies": [5.0, 6.0],
                "ramps": [0.1, 0.1],
            },
            ll.MeasuredPivot: {"times": range(7), "pivot_heights": [0.0] * 7},
        }[kind]
        kind(**fine)
        with pytest.raises(ValueError, match=rule):
            kind(**{**fine, **arguments})

    @pytest.mark.parametrize(
        "kind,arguments",
        [
            (ll.FrequencySchedule, {"drive_amplitude": 0.1, "times": 0, "drive_frequencies": [1]}),
            (
                ll.FrequencySchedule,
                {"drive_amplitude": 0.1, "times": "0", "drive_frequencies": [1]},
            ),
            (ll.MeasuredPivot, {"times": range(7), "pivot_heights": "abcdefg"}),
            (ll.MeasuredPivot, {"times": range(7), "pivot_heights": [None] * 7}),
        ],
    )
    def test_drives_refuse_wrong_types(self, kind, arguments):
        with pytest.raises(InputError, match="must be a"):
            kind(**arguments)

    @pytest.mark.parametrize(
        "arguments,rule",
        [
            ({"initial_angle": math.nan}, "initial_angle must be a number"),
            ({"initial_angle": math.inf}, "initial_angle must be a number"),
            ({"initial_angle": "20 deg"}, "initial_angle must be a number in rad"),
            ({"initial_angle": (0.5, -0.5)}, "initial_angle must be one number"),
            ({"initial_angle": 0.05}, "initial_angle must lie between .* got 0.05"),
            ({"initial_angle": 3.1}, "initial_angle must lie between .* got 3.1"),
            ({"initial_angle": -0.5}, "initial_angle must lie between .* got -0.5"),
            ({"initial_angle": None}, "initial_angle is needed"),
            ({"initial_offset": 0.1}, "only one of initial_angle"),
            (
                {"initial_angle": None, "initial_offset": -0.1},
                r"initial_offset must lie in \[0, inf\)",
            ),
            (
                {"initial_angle": None, "initial_offset": 3.0},
                "initial_offset counts from the lower contact angle and must lie in",
            ),
            ({"initial_angular_velocity": math.nan}, "velocity must be a number"),
            ({"initial_angular_velocity": "fast"}, "velocity must be a number"),
            ({"duration": 0.0}, r"duration must lie in \(0, inf\) s, got 0"),
            ({"duration": -1.0}, "duration must lie"),
            ({"duration": math.nan}, "duration must be a number"),
            ({"duration": math.inf}, "duration must be a number"),
            ({"duration": "60 s"}, "duration must be a number in s"),
            ({"duration": None}, "duration is needed"),
            ({"duration": 1e9}, "default samples exceed the limit"),
            ({"times": []}, "times must hold at least 1 value, got 0"),
            (
                {"times": [0.0], "duration": None},
                "times must reach beyond 0 s, .* got 0 as the last",
            ),
            ({"times": [0.5, 0.4]}, "increase strictly, got 0.4 after 0.5 at pos"),
            ({"times": [0.5, 0.5]}, "increase strictly, got 0.5 after 0.5"),
            ({"times": [0.5, math.nan]}, r"times\[1\] must be a number in s, got nan"),
            ({"times": [-0.5, 0.5]}, r"times\[0\] must lie in \[0, .* got -0.5"),
            ({"times": [0.5, 2.5]}, r"times must lie in \[0, .* got 2.5"),
            ({"times": [[0.1, 0.2]]}, r"times\[0\] must be a number"),
            ({"times": "abc"}, "times must be a sequence"),
            ({"times": [0.1, 1j]}, r"times\[1\] must be a number in s"),
            ({"times": [0.1, True]}, r"times\[1\] must be a number in s, got True"),
            ({"times": ["0", "1"]}, r"times\[0\] must be a number in s, got '0'"),
            ({"times": np.ma.array([0.1, 9.0], mask=[0, 1])}, r"times\[1\] must be .* got None"),
            (
                {"times": np.array([0, 100], "m8[ms]")},
                "type timedelta64.ms.; divide",
            ),
            ({"times": np.array([0, 100], "M8[s]")}, "got values of type datetime64"),
            ({"times": np.array([0.1, 0.2 + 1j])}, "got values of type complex128"),
            ({"times": np.array([False, True])}, "got values of type bool"),
            ({"times": {0.1, 0.2}}, "times must be a sequence"),
            ({"times": xr.DataArray([0, 100], attrs={"units": "ms"})}, "its attribute units is"),
            ({"times": np.zeros((2, 2))}, r"must be one-dimensional, got shape \(2, 2\)"),
            ({"duration": np.timedelta64(1, "ns")}, "duration must be a number in s"),
            ({"duration": np.complex128(1.0)}, "duration must be a number in s"),
            ({"tolerance": 0.0}, "tolerance must lie"),
            ({"tolerance": 1.0}, "tolerance must lie"),
            ({"tolerance": "tight"}, "tolerance must be a number"),
            ({"rest_speed": -1.0}, "rest_speed must lie"),
            ({"frame": "moon"}, "frame must be 'pivot' or 'both', got 'moon'"),
            ({"contact": "exakt"}, "unknown contact law 'exakt': did you mean 'exact'"),
            ({"contact": 3}, "contact must be"),
            ({"contact_limit": 0}, "contact_limit must lie in"),
            ({"contact_limit": 0.5}, "contact_limit must"),
            ({"contact_limit": -5}, "contact_limit must lie in"),
            ({"noise": 3}, "noise must be VelocityKicks or None, got 3"),
        ],
    )
    def test_simulate_refuses(self, arguments, rule):
        fine = {"initial_angle": 0.5, "duration": 2.0}
        with pytest.raises(InputError, match=rule) as caught:
            ll.simulate(TOY, DRIVE, **{**fine, **arguments})
        assert "\n" not in str(caught.value)

    @pytest.mark.parametrize("contact", ["exakt", 3])
    def test_unknown_contact_law_is_refused_where_no_wall_is_met_too(self, contact):
        with pytest.raises(InputError, match="contact"):
            ll.simulate(PENDULUM, DRIVE, initial_angle=0.5, duration=1.0, contact=contact)

    def test_offset_of_a_system_without_walls_is_refused(self):
        with pytest.raises(ValueError, match="initial_offset counts from the low contact angle"):
            ll.simulate(PENDULUM, DRIVE, initial_offset=0.5, duration=1.0)

    @pytest.mark.parametrize("system", [None, "latolato", ll.LatoLato, 3])
    def test_system_that_is_none(self, system):
        with pytest.raises(InputError, match="system must be one of pendulum, mathieu"):
            ll.simulate(system, DRIVE, initial_angle=0.5, duration=1.0)

    @pytest.mark.parametrize("drive", ["harmonic", ll.Harmonic, 3])
    def test_drive_that_is_none(self, drive):
        with pytest.raises(InputError, match=r"drive must be None or one of .*harmonic"):
            ll.simulate(TOY, drive, initial_angle=0.5, duration=1.0)

    def test_clamp_of_two_balls_is_refused(self):
        with pytest.raises(ValueError, match="'clamp' exists for the mirror-symmetric LatoLato"):
            ll.simulate(pair(), initial_angle=(0.5, -0.5), duration=1.0, contact="clamp")

    @pytest.mark.parametrize(
        "angle,rule",
        [
            ((-0.5, 0.5), "separation .* must lie between .* got -1"),
            ((0.05, -0.05), "separation .* got 0.1"),
            ((3.5, -3.0), "separation .* got 6.5"),
            (0.5, r"must be two numbers \(right, left\), got 0.5"),
            ((0.5,), "must be two numbers"),
            ((0.5, math.nan), r"initial_angle\[1\] must be a number"),
            (("a", "b"), r"initial_angle\[0\] must be a number"),
        ],
    )
    def test_starts_of_two_balls(self, angle, rule):
        with pytest.raises(InputError, match=rule):
            ll.simulate(pair(), initial_angle=angle, duration=1.0)

    def test_clamp_step_is_checked(self):
        for step in (0.0, -1.0, math.nan):
            with pytest.raises(ValueError, match="step must"):
                ll.ClampContact(clamp_step=step)

    def test_clamp_step_beyond_the_run_is_refused(self):
        with pytest.raises(
            ValueError, match="clamp_step must not exceed the duration 1 s, got 100"
        ):
            ll.simulate(
                TOY,
                DRIVE,
                initial_angle=0.5,
                duration=1.0,
                contact=ll.ClampContact(clamp_step=100.0),
            )  # fmt: skip

    def test_ramp_as_long_as_a_stage_of_decimal_times_is_accepted(self):
        # 0.3 - 0.2 is 0.09999999999999998. The ramps meet: one segment each, in order.
        drive = ll.FrequencySchedule(
            drive_amplitude=0.1, times=[0.0, 0.2, 0.3], drive_frequencies=[1.0, 2.0, 3.0], ramp=0.1
        )
        starts = [segment.start for segment in drive.segments(1.0)]
        np.testing.assert_allclose(starts, [0.0, 0.2, 0.3, 0.4], rtol=1e-15)

    def test_run_outside_measured_samples_is_refused(self):
        pivot = ll.MeasuredPivot(times=range(1, 9), pivot_heights=[0.0] * 8)
        with pytest.raises(ValueError, match="cover 1 to 8 s, but the run goes from 0 to 5 s"):
            ll.simulate(PENDULUM, pivot, initial_angle=0.5, duration=5.0)

    def test_mistyped_parameter_is_answered_with_the_right_one(self):
        with pytest.raises(
            InputError, match=r"unknown parameter 'lenght' .* did you mean 'length'"
        ):
            ll.Pendulum(lenght=1.0, mass=1.0)
        with pytest.raises(InputError, match=r"Pendulum needs 'mass' \[kg\]"):
            ll.Pendulum(length=1.0)


class TestLimits:
    def test_contact_limit_stops_the_run_and_says_so(self):
        toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
        with pytest.warns(
            RuntimeWarning, match="contact_limit = 10; there are no values after that"
        ):
            result = ll.simulate(toy, initial_angle=0.5, duration=60.0, contact_limit=10)
        assert "contact_limit = 10" in result.attrs["status"]
        assert result.sizes["contact"] == 10  # each of these impacts is one row
        last = float(result.contact_time[-1])
        assert np.all(np.isfinite(result.angle.values[result.time.values < last]))
        assert np.isnan(result.angle.values[-1])

    @pytest.mark.parametrize("suspension", ["rod", "string"])
    def test_a_run_that_stops_where_it_begins_has_no_share_of_its_time(self, suspension):
        toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, suspension=suspension)
        start = {"initial_offset": 0.0, "initial_angular_velocity": -1.0}
        with pytest.warns(RuntimeWarning, match="stopped at t = 0 s by contact_limit = 1"):
            result = ll.simulate(toy, **start, duration=1.0, contact_limit=1)
        share = "slack_fraction" if suspension == "string" else "compression_fraction"
        assert np.isnan(result.attrs[share])

    def test_contact_limit_above_the_contacts_changes_nothing(self):
        toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
        free = ll.simulate(toy, initial_angle=0.5, duration=20.0)
        limited = ll.simulate(
            toy, initial_angle=0.5, duration=20.0, contact_limit=free.sizes["contact"] + 1
        )
        xr.testing.assert_equal(free, limited)

    def test_overflow_of_the_linear_model_is_reported(self):
        # An unstable Mathieu equation leaves the range of doubles: growth 1.4/s for 2000 s.
        drive = ll.Harmonic(drive_amplitude=0.5, drive_frequency=6.26)
        with pytest.warns(RuntimeWarning, match="left the range of numbers"):
            result = ll.simulate(
                ll.Mathieu(length=1.0, mass=1.0),
                drive,
                initial_angle=0.1,
                times=np.linspace(0.0, 2000.0, 100),
            )
        assert "failed" in result.attrs["status"]

    def test_samples_before_an_overflow_are_kept(self):
        drive = ll.Harmonic(drive_amplitude=3.0, drive_frequency=40.0)
        arguments = {"initial_angle": 0.1, "times": [0.1, 0.5]}
        with pytest.warns(RuntimeWarning, match="failed at t = 12 s"):
            result = ll.simulate(
                ll.Mathieu(length=1.0, mass=0.8), drive, duration=12.0, **arguments
            )
        whole = ll.simulate(ll.Mathieu(length=1.0, mass=0.8), drive, **arguments)
        assert np.array_equal(result.angle.values, whole.angle.values)


class TestExtremeInput:
    @pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
    @pytest.mark.parametrize("share", [0.1, 0.99])
    def test_pivot_acceleration_of_1000_g(self, restitution, share):
        toy = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=share, restitution=restitution)
        drive = ll.Harmonic(drive_amplitude=0.5, drive_frequency=math.sqrt(1000.0 * 9.8 / 0.5))
        result = ll.simulate(toy, drive, initial_offset=0.1, duration=20.0)
        assert result.attrs["status"] == "complete"
        scale = float(result.total_energy.max())
        assert result.attrs["energy_residual"] <= 1e-9 * scale
        assert float(result.angle.min()) >= toy.contact_angle_low - 1e-12
        assert float(result.angle.max()) <= toy.contact_angle_high + 1e-12

    def test_radius_of_099_lengths(self):
        toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.99, restitution=1.0)
        result = ll.simulate(toy, DRIVE, initial_angle=1.55, duration=60.0)
        assert result.attrs["status"] == "complete"
        assert set(result.contact_kind.values) <= {"bottom", "top"}
        assert result.sizes["contact"] > 50

    @pytest.mark.parametrize("scale", [1e-6, 1e6])
    def test_tiny_and_huge_bodies_move_alike(self, scale):
        # Lengths by s and times by sqrt(s): the same angles.
        arguments = {"initial_angle": 0.7, "tolerance": 1e-11}
        small = ll.simulate(
            ll.LatoLato(length=scale, mass=1e-9, radius=0.1 * scale, restitution=0.9),
            ll.Harmonic(drive_amplitude=0.1 * scale, drive_frequency=6.0 / math.sqrt(scale)),
            times=np.linspace(0.0, 5.0, 51) * math.sqrt(scale),
            **arguments,
        )
        same = ll.simulate(
            ll.LatoLato(length=1.0, mass=1.0, radius=0.1, restitution=0.9),
            ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0),
            times=np.linspace(0.0, 5.0, 51),
            **arguments,
        )
        np.testing.assert_allclose(small.angle, same.angle, rtol=0, atol=1e-9)

    def test_plastic_impacts_under_a_hard_drive(self):
        toy = ll.LatoLato(length=0.245, mass=0.1, radius=0.02, restitution=0.0, damping=0.005)
        drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=40.0)
        result = ll.simulate(toy, drive, initial_angle=0.7, duration=60.0)
        assert result.attrs["status"] == "complete"
        bottom = result.contact_kind.values == "bottom"
        assert np.all(result.angular_velocity_after.values[bottom] == 0.0)

    @pytest.mark.slow
    def test_run_of_1e5_seconds(self):
        times = np.linspace(0.0, 1e5, 1001)
        result = ll.simulate(TOY, DRIVE, initial_angle=0.7, times=times, tolerance=1e-8)
        assert result.attrs["status"] == "complete"
        assert np.all(np.isfinite(result.angle.values))

    @pytest.mark.slow
    def test_1e7_requested_times_stay_below_6_gigabytes(self):
        times = np.linspace(0.0, 300.0, 10_000_000)
        result = ll.simulate(TOY, DRIVE, initial_angle=0.7, times=times, tolerance=1e-8)
        assert result.sizes["time"] == 10_000_000
        assert np.all(np.isfinite(result.angle.values))
        unit = 1 if sys.platform == "darwin" else 1024
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit < 6e9


class TestClamp:
    def test_clamp_is_labelled(self):
        result = ll.simulate(
            TOY, DRIVE, initial_angle=0.7, duration=2.0, contact=ll.ClampContact(clamp_step=2e-3)
        )
        assert result.attrs["contact"] == "clamp"
        assert result.attrs["clamp_step"] == 2e-3
        assert result.attrs["stepper"] == "classical Runge-Kutta"

    def test_clamp_moves_what_exact_contact_leaves_at_rest(self):
        # Paper Fig. 4 as printed: its integrator's noise, not physics. The pivot decelerates by
        # less than g, but reflections on overlap keep and change the energy.
        toy = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1)
        drive = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
        arguments = {"initial_offset": 0.0, "duration": 30.0}
        exact = ll.simulate(toy, drive, **arguments)
        assert np.all(exact.angle.values == toy.contact_angle_low)
        coarse, fine = (
            ll.simulate(
                toy, drive, **arguments, contact=ll.ClampContact(clamp_step=step)
            ).angle.values
            for step in (1e-2, 1e-3)
        )
        assert np.ptp(coarse) > 1e-4
        assert not np.allclose(coarse, fine, atol=1e-6)

    def test_without_contact_the_walls_are_not_there(self):
        arguments = {"initial_angle": 0.7, "duration": 5.0}
        toy = ll.LatoLato(length=1.0, mass=0.8, damping=0.05, radius=0.1)
        passing = ll.simulate(toy, DRIVE, **arguments, contact=None)
        free = ll.simulate(PENDULUM, DRIVE, **arguments)
        np.testing.assert_array_equal(passing.angle, free.angle)
        assert passing.sizes["contact"] == 0


@pytest.mark.parametrize(
    "drive, speed, contact",
    [
        (ll.Harmonic(drive_amplitude=1e30, drive_frequency=1.0), 0.0, "exact"),
        (None, 1e30, "exact"),
        (None, 0.0, ll.ClampContact(clamp_step=1e-30)),
    ],
)
def test_a_run_of_endless_steps_is_refused(drive, speed, contact):
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    with pytest.raises(ValueError, match=r"steps of .* limit is 10¹⁰"):
        ll.simulate(
            toy, drive, initial_angle=0.5, initial_angular_velocity=speed, times=[1.0],
            contact=contact,
        )  # fmt: skip


@pytest.mark.parametrize("duration", [0.1, 10.0])  # without contacts, and with some
def test_a_run_comes_back_from_zarr_and_netcdf_without_a_warning(tmp_path, duration):
    made = ll.simulate(pair(), DRIVE, initial_angle=(0.7, -0.6), duration=duration)
    made.to_zarr(tmp_path / "run.zarr", consolidated=False)
    made.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with (
        xr.open_zarr(tmp_path / "run.zarr", consolidated=False) as one,
        xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as other,
    ):
        xr.testing.assert_equal(one.load(), made)
        xr.testing.assert_equal(other.load(), made)
