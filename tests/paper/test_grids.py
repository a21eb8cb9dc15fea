"""Sweeps brought together for a figure, and the numbers that are read off their maps."""

import json

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from latolato.io.files import load, save
from latolato.paper import fig03cd, fig09, fig11, grids, page
from latolato.paper import systems as paper


def a_map(values, amplitudes, ratios):
    axes = {"drive_amplitude": amplitudes, "frequency_ratio": ratios}
    return xr.DataArray(values, axes, tuple(axes), name="mean_energy")


@pytest.fixture(scope="module")
def tiny():
    """Two sweeps of the pendulum over one grid and a coarser one apart."""

    def run(count, damping=0.0):
        return ll.sweep(
            ll.Pendulum(length=1.0, mass=0.8, damping=damping),
            axes={
                "drive_amplitude": grids.even(0.5, count),
                "frequency_ratio": grids.even(5.0, count),
            },
            duration=20.0,
            initial_angle=0.1,
            observables=grids.PENDULUM_OBSERVABLES,
        )

    return grids.gather(
        {"undamped": run(5), "damped": run(5, 0.05)},
        title="tiny",
        keep=("mean_energy", "crossings", "largest_angle"),
        apart={"coarse": run(3)},
    )


def test_sweeps_are_stacked_and_those_apart_keep_their_own_axes(tiny):
    assert tiny.mean_energy.dims == ("case", "drive_amplitude", "frequency_ratio")
    assert tiny.coarse_mean_energy.dims == ("coarse_drive_amplitude", "coarse_frequency_ratio")
    assert list(tiny.points.values) == [25, 25, 9]
    assert (tiny.unanswered == 0).all()
    plan = json.loads(str(tiny.plan.sel(sweep="damped").item()))
    assert plan["system"]["damping"] == 0.05


def test_gathered_sweeps_survive_a_file(tiny, tmp_path):
    assert load(save(tiny, tmp_path / "tiny.nc")).identical(tiny)


def test_the_report_tells_the_parameters_of_sweeps(tiny):
    text = str(page._parameters(tiny))
    assert "5 from 0.1 to 0.5, 3 from 0.1667 to 0.5 m" in text
    assert "0, 0.05 kg m/s" in text
    assert page._ledger_sentence(tiny) == "59 runs, of which none ended without an answer."


def test_the_band_is_compared_with_what_lies_beside_it():
    ratios = np.linspace(0.1, 2.0, 39)
    flat = a_map(np.full((2, 39), 2.0), [0.1, 0.2], ratios)
    assert grids.band_gain(flat) == pytest.approx(1.0, rel=1e-12)
    peaked = flat.copy()
    peaked[1, int(np.argmin(abs(ratios - 1.0)))] = 14.0
    assert grids.band_gain(peaked) == pytest.approx(7.0, rel=1e-12)
    assert grids.in_band(peaked) == 14.0


def test_the_smallest_amplitude_is_that_of_the_lowest_active_row():
    active = np.zeros((3, 4), dtype=bool)
    active[1, 2:] = active[2] = True
    tip = grids.smallest_amplitude(a_map(active, [0.1, 0.2, 0.3], [1.0, 2.0, 3.0, 4.0]))
    assert tip == (0.2, 3.0)
    assert np.isnan(
        grids.smallest_amplitude(a_map(~active & active, [1, 2, 3], [1, 2, 3, 4]))
    ).all()


def test_outliers_are_points_unlike_their_surroundings():
    active = np.zeros((12, 12), dtype=bool)
    active[:, 6:] = True
    assert grids.outliers(active) == 0.0
    active[5, 2] = True
    assert grids.outliers(active) == pytest.approx(1 / 100)


def test_the_acceleration_is_one_on_the_lift_off_curve():
    dataset = xr.Dataset(coords={"drive_amplitude": [0.25], "frequency_ratio": [1.0, 2.0]})
    assert grids.acceleration_ratio(dataset) == pytest.approx(np.array([[0.25, 1.0]]))


def test_flanks_are_measured_from_the_peak_to_half_its_height():
    ratio, rest = np.arange(2.0, 3.01, 0.1), paper.COUPLED.contact_angle_low
    angle = rest + np.array([0, 0, 0, 1.0, 0.9, 0.8, 0.6, 0.4, 0.2, 0, 0])
    peak, height, left, right = fig11._flanks(ratio, angle)
    assert (peak, height) == pytest.approx((2.3, rest + 1.0))
    assert (left, right) == pytest.approx((0.1, 0.4))


@pytest.mark.parametrize("module", [fig03cd, fig09])
def test_a_full_grid_holds_the_ratios_that_matter(module):
    count = module.POINTS if module is fig03cd else module.POINTS[1]
    ratios = grids.even(5.0, count) if module is fig03cd else np.linspace(*module.RATIOS, count)
    assert np.abs(ratios - 2.0).min() < 1e-9
