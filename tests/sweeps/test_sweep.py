"""A sweep's numbers depend on nothing but its points, and its dataset says what they are."""

import functools

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES
from latolato.sweeps.plan import make_plan
from latolato.sweeps.statuses import codes_of
from watched import IN_LANES

TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
# Long and strong enough that some points are chaotic: the least difference would show.
SETTINGS = {
    "duration": 30.0,
    "transient_periods": 2.0,
    "observables": IN_LANES,
    "initial_offset": 0.3,
}
AXES = {
    "drive_amplitude": list(np.linspace(0.01, 0.4, 9)),
    "frequency_ratio": list(np.linspace(0.7, 4.3, 17)),
}


@functools.cache
def whole():
    """The map, all points in one chunk."""
    return ll.sweep(TOY, DRIVE, axes=AXES, chunk_size=1000, **SETTINGS)


def assert_same_numbers(result, expected):
    """Every variable has the same bytes."""
    assert set(result.data_vars) == set(expected.data_vars)
    for name in expected.data_vars:
        one, other = result[name], expected[name]
        assert one.dims == other.dims, name
        assert one.values.tobytes() == other.values.tobytes(), name


@pytest.mark.parametrize("chunk_size", [1, 7, 64, None])
@pytest.mark.parametrize("workers", [1, 2])
def test_chunks_and_workers_change_nothing(chunk_size, workers):
    result = ll.sweep(TOY, DRIVE, axes=AXES, chunk_size=chunk_size, workers=workers, **SETTINGS)
    assert_same_numbers(result, whole())


def test_the_order_of_axes_and_values_changes_nothing():
    turned = dict(reversed(AXES.items()))
    turned["frequency_ratio"] = turned["frequency_ratio"][::-1]
    result = ll.sweep(TOY, DRIVE, axes=turned, **SETTINGS)
    assert result.largest_angle.dims == ("frequency_ratio", "drive_amplitude")
    again = result.isel(frequency_ratio=slice(None, None, -1))
    expected = whole()
    assert_same_numbers(again.transpose(*expected.status.dims, "sample"), expected)


@pytest.mark.parametrize("place", [(0, 0), (4, 6), (8, 16), (8, 11)])
def test_a_point_alone_is_the_point_of_the_map(place):
    axes = {name: [values[i]] for (name, values), i in zip(AXES.items(), place, strict=True)}
    alone = ll.sweep(TOY, DRIVE, axes=axes, **SETTINGS)
    at = {name: [i] for name, i in zip(AXES, place, strict=True)}
    assert_same_numbers(alone, whole().isel(at))


def test_a_point_is_the_same_as_a_value_and_on_an_axis():
    drive = ll.Harmonic(drive_amplitude=AXES["drive_amplitude"][5], drive_frequency=6.0)
    axes = {"frequency_ratio": AXES["frequency_ratio"]}
    assert_same_numbers(
        ll.sweep(TOY, drive, axes=axes, **SETTINGS), whole().isel(drive_amplitude=5)
    )


def test_parameters_that_vary_together_are_the_diagonal():
    together = {name: values[:9] for name, values in AXES.items()}
    result = ll.sweep(TOY, DRIVE, axes={"case": together}, **SETTINGS)
    assert result.largest_angle.dims == ("case",)
    for name in AXES:
        assert result[name].dims == ("case",)
        np.testing.assert_array_equal(result[name], together[name])
    for i in range(9):
        assert_same_numbers(result.isel(case=i), whole().isel(drive_amplitude=i, frequency_ratio=i))


def test_the_map_has_chaos_to_show_a_difference():
    result = ll.sweep(TOY, DRIVE, axes=AXES, **SETTINGS, tolerance=1.0001e-6)
    assert float(abs(result.final_angle - whole().final_angle).max()) > 0.1


def test_plain_python_agrees():
    axes = {"drive_amplitude": [0.02, 0.2], "frequency_ratio": [1.9, 2.5]}
    settings = SETTINGS | {"duration": 4.0, "tolerance": 1e-9}
    plain, compiled = (
        ll.sweep(TOY, DRIVE, axes=axes, executor=e, **settings) for e in ("reference", "threads")
    )
    assert (compiled.status == plain.status).all()
    for name in plain.drop_vars("status").data_vars:
        # Rounding, grown by a handful of impacts; the energy's quadrature near walls differs, see
        # test_lanes.py.
        atol = 1e-7 if name == "mean_energy" else 1e-9
        np.testing.assert_allclose(compiled[name], plain[name], rtol=0.0, atol=atol, err_msg=name)


class TestDataset:
    SETTINGS = SETTINGS | {"duration": 2.0, "executor": "reference", "transient_periods": 0.5}

    def found(self, system=TOY, **changed):
        settings = {"axes": {"case": {"mass": [0.8, 0.9], "length": [1.0, 0.9]}}} | self.SETTINGS
        return ll.sweep(system, DRIVE, **(settings | changed))

    def pair(self):
        ball = ll.Ball(length=1.0, mass=0.8, radius=0.1)
        return self.found(
            ll.BallPair(right=ball, left=ball, restitution=0.9),
            axes={"left_mass": [0.8, 0.4]}, initial_offset=None, initial_angle=(0.5, -0.4),
        )  # fmt: skip

    def test_everything_has_unit_name_and_symbol(self):
        for result in (self.found(), self.pair()):
            for name, variable in result.variables.items():
                if name == "ball":
                    continue
                assert {"units", "long_name", "symbol"} <= set(variable.attrs), name
                assert variable.attrs["units"], name
                assert variable.attrs["long_name"], name

    def test_known_quantities_are_called_what_they_are_called_elsewhere(self):
        for name, variable in self.found().variables.items():
            if name in QUANTITIES:
                known = QUANTITIES[name]
                assert variable.attrs["units"] == known.unit
                assert variable.attrs["symbol"] == known.symbol
                assert variable.attrs["long_name"].startswith(known.long_name)

    def test_energies_say_whose_they_are(self):
        one, two = self.found(), self.pair()
        assert one.mean_energy.attrs["long_name"].endswith(", per ball")
        assert one.drive_work.attrs["long_name"].endswith(", per ball")
        assert two.mean_energy.attrs["long_name"].endswith(", per ball")
        assert two.drive_work.attrs["long_name"].endswith(", both balls")

    def test_two_balls_have_a_dimension(self):
        result = self.pair()
        assert result.largest_angle.dims == ("left_mass", "ball")
        assert result.section_angle.dims == ("left_mass", "ball", "sample")
        assert result.drive_work.dims == result.status.dims == ("left_mass",)
        assert list(result.ball.values) == ["right", "left"]

    def test_coordinates_are_the_values_of_the_axes(self):
        result = self.found()
        np.testing.assert_array_equal(result.mass, [0.8, 0.9])
        np.testing.assert_array_equal(result.length, [1.0, 0.9])
        assert result.length.attrs["units"] == "m"

    def test_status_is_explained(self):
        status = self.found().status
        assert (status == "converged").all()
        assert status.attrs["long_name"] == "status of the point"
        with pytest.raises(InputError, match=r"must be one of converged, .* got 'fine'"):
            codes_of(["converged", "fine"])

    def test_attributes_hold_every_parameter_that_does_not_vary(self):
        result = self.found(transient=0.1, rest_speed=1e-6)
        expected = {
            "system": "latolato", "drive": "harmonic", "radius": 0.1, "restitution": 0.9,
            "gravity": 9.8, "damping": 0.02, "drive_amplitude": 0.1, "drive_frequency": 6.0,
            "drive_phase": 0.0, "initial_offset": 0.3, "initial_angular_velocity": 0.0,
            "duration": 2.0, "transient": 0.1, "transient_periods": 0.5, "tolerance": 1e-6,
            "rest_speed": 1e-6, "contact": "exact", "crossing_angle": 2.0, "periods": 4,
        }  # fmt: skip
        assert {name: result.attrs.get(name) for name in expected} == expected
        assert not {"mass", "length"} & set(result.attrs)
        assert result.attrs["latolato_version"]
        settings = {k: v for k, v in self.SETTINGS.items() if k != "executor"}
        plan = make_plan(
            TOY, DRIVE, axes={"case": {"mass": [0.8, 0.9], "length": [1.0, 0.9]}}, **settings,
            transient=0.1, rest_speed=1e-6,
        )  # fmt: skip
        assert result.attrs["plan_hash"] == plan.hash

    @pytest.mark.parametrize("which", ["one ball", "two balls"])
    def test_it_comes_back_from_netcdf(self, which, tmp_path):
        result = self.found() if which == "one ball" else self.pair()
        ll.save(result, tmp_path / "map.nc")
        again = ll.load(tmp_path / "map.nc")
        xr.testing.assert_identical(result, again)

    def test_progress_counts_points_up_to_the_whole(self):
        seen = []
        self.found(chunk_size=1, progress=lambda done, total: seen.append((done, total)))
        assert seen == [(0, 2), (1, 2), (2, 2)]
